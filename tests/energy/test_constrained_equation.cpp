// The equation in the unknowns that constraints leave: its derivatives, and that its configurations fulfil them.
#include "energy/constrained_equation.hpp"
#include "energy/tied_body.hpp"
#include "petsc/session.hpp"

#include <cmath>

namespace pliant {
namespace {

using testing::Point;
using testing::Scratch;
using testing::Shape;
using testing::TestStage;
using testing::TiedBody;
using testing::TiedSpec;

const MPI_Comm comm = MPI_COMM_WORLD;

Region at(int axis, double value) {
  return [=](const Point& x) { return std::abs(x[axis] - value) < 1e-9; };
}

/// Every kind of tie at once; they share nodes, and some share them with what is prescribed.
TiedSpec everything(int order) {
  TiedSpec spec;
  spec.order = order;
  spec.law = make_law("neo-hookean", 1000.0, 0.3);
  spec.density = 3.0;
  spec.constraints.push_back({testing::vector("0.01*t", "0", "0"), [](const Point& x) { return dot(x, x) < 1e-12; }});
  spec.constraints.push_back(testing::slide(at(0, 0.0), {0.8, 0.6, 0.0}, "0.008*t"));
  spec.constraints.push_back(
      testing::repeat(at(2, 0.0), at(2, 1.0), {{Expression(0.02), std::nullopt, Expression("0.01*t")}}));
  RigidMotion turn{{std::nullopt, Expression("0.02*t"), std::nullopt}, {0.0, 1.0, 0.0}, Expression("0.3*t"), {}};
  turn.centre = {1.0, 0.5, 0.5};
  spec.constraints.push_back(
      testing::grip([](const Point& x) { return x[0] > 1.0 - 1e-9 && x[2] > 0.2 && x[2] < 0.8; }, turn));
  spec.constraints.push_back(
      {testing::scalar("0.05*t"), nullptr, [](const NodeLayout& layout, std::size_t source) {
         const auto is_inside = [](double x) { return x > 0.3 && x < 0.7; };
         const auto inner = [=](const Point& x) { return is_inside(x[0]) && is_inside(x[1]) && is_inside(x[2]); };
         const auto on_side = [=](const Point& x) { return is_inside(x[0]) && x[1] > 1.0 - 1e-9 && is_inside(x[2]); };
         const std::array terms{testing::mean(layout, inner, 2, 2.0), testing::mean(layout, on_side, 0, -1.0)};
         const auto tie = equation(layout, terms, source);
         return rank(layout.comm) == 0 ? std::vector{tie} : std::vector<LinearConstraint>();
       }});
  spec.surroundings = Gas{3.0, 50.0, 400.0, 1.4, Expression(1.0)};
  return spec;
}

class Constrained : public ::testing::TestWithParam<int> {
 protected:
  Constrained() { equation_.begin_stage(stage_.point); }

  double value(double alpha, Vec d) { return equation_.value(testing::moved(y_.get(), alpha, d).get()); }
  Handle<Vec> gradient(double alpha, Vec d) {
    Handle<Vec> r = equation_.make_vector();
    equation_.gradient(testing::moved(y_.get(), alpha, d).get(), r.get());
    return r;
  }
  /// A direction in which only unknowns change.
  Handle<Vec> direction(int seed) const {
    auto d = body_.solid().vector(testing::rough_field(0.02, seed));
    {
      const ArrayView entries(d.get());
      for (std::size_t i = 0; i < entries.span().size(); ++i) {
        if (equation_.prescribed()[i]) entries.span()[i] = 0.0;
      }
    }
    return d;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    testing::write_body(f, {1, Shape::straight, GetParam() == 1 ? 3 : 2});
  });
  TiedBody body_{comm, file_, everything(GetParam())};
  ConstrainedEquation equation_{body_.potential(), body_.map()};
  TestStage stage_{body_.solid(), 0.7, 0.05, testing::rough_field(0.01, 3), testing::rough_field(0.3, 4)};
  Handle<Vec> y_ = body_.solid().vector([](const Point& x) { return 0.1 * testing::strained(x); });
};

INSTANTIATE_TEST_SUITE_P(Orders, Constrained, ::testing::Values(1, 2),
                         [](const auto& of) { return "P" + std::to_string(of.param); });

TEST_P(Constrained, ConfigurationsFulfilAllConstraints) {
  // Entries of slaves have no meaning in y, those of prescribed ones are at their values.
  const auto q = body_.solid().vector(testing::at_rest), v = body_.solid().vector(testing::at_rest);
  check(VecCopy(y_.get(), q.get()));
  body_.motion().complete_step({0.7, 0.05}, q.get(), v.get());
  EXPECT_LE(body_.violation(q.get(), 0.7), 1e-14);
  EXPECT_GT(body_.violation(y_.get(), 0.7), 1e-3);
  const auto expanded = body_.solid().vector(testing::at_rest);
  body_.map().set_time(0.7, 1.0);
  body_.map().expand(q.get(), expanded.get());
  EXPECT_LE(testing::distance(q.get(), expanded.get()), 1e-14);
}

// The stage's differences are exact where the constraints move.
TEST_P(Constrained, RatesOfAStageFulfilAllConstraints) {
  const double dt = 0.05, h = 1e-4;
  body_.motion().start_stage(stage_.point, y_.get());
  EXPECT_LE(body_.violation(y_.get(), 0.7), 1e-13);
  const auto v = testing::moved(y_.get(), -1.0, stage_.q0.get());
  check(VecScale(v.get(), 1.0 / dt));
  // Their constraints have the rates of what is given: q(0.7) + h v fulfils those at 0.7 + h, to h^2.
  EXPECT_LE(body_.violation(testing::moved(y_.get(), h, v.get()).get(), 0.7 + h), 0.1 * h * h);
  EXPECT_GT(body_.violation(y_.get(), 0.7 + h), 0.005 * h);
}

// Differences of fourth order: their error is some 1e-12, their rounding some 1e-12, of the derivative.
constexpr double h = 1e-3;

TEST_P(Constrained, GradientIsThatOfTheValue) {
  const auto g = gradient(0.0, y_.get());
  ASSERT_GT(testing::norm(g.get()), 1e-3);
  for (const int seed : {11, 12}) {
    const auto d = direction(seed);
    const double expected =
        (8.0 * (value(h, d.get()) - value(-h, d.get())) - (value(2.0 * h, d.get()) - value(-2.0 * h, d.get()))) /
        (12.0 * h);
    EXPECT_NEAR(testing::dot(g.get(), d.get()), expected, 1e-9 * testing::norm(g.get()) * testing::norm(d.get()));
  }
}

TEST_P(Constrained, HessianIsThatOfTheGradient) {
  const Handle<Mat> K = equation_.make_hessian();
  equation_.hessian(testing::moved(y_.get(), 0.3, y_.get()).get(), K.get(), Projection::none);  // the pattern is reused
  equation_.hessian(y_.get(), K.get(), Projection::none);
  std::vector<RankOne> parts(equation_.num_rank_one());
  ASSERT_EQ(parts.size(), 1u);  // of the gas around the body
  parts[0].g = equation_.make_vector();
  equation_.rank_one_parts(y_.get(), parts);
  EXPECT_GT(parts[0].c, 0.0);
  const Handle<Vec> Kd = equation_.make_vector(), difference = equation_.make_vector();
  for (const int seed : {11, 12}) {
    const auto d = direction(seed);
    check(MatMult(K.get(), d.get(), Kd.get()));
    check(VecAXPY(Kd.get(), parts[0].c * testing::dot(parts[0].g.get(), d.get()), parts[0].g.get()));
    const auto ahead = gradient(h, d.get()), behind = gradient(-h, d.get());
    const auto far_ahead = gradient(2.0 * h, d.get()), far_behind = gradient(-2.0 * h, d.get());
    check(VecWAXPY(difference.get(), -1.0, behind.get(), ahead.get()));
    check(VecScale(difference.get(), 8.0));
    check(VecAXPY(difference.get(), -1.0, far_ahead.get()));
    check(VecAXPY(difference.get(), 1.0, far_behind.get()));
    check(VecScale(difference.get(), 1.0 / (12.0 * h)));
    ASSERT_GT(testing::norm(Kd.get()), 1e-3);
    EXPECT_LE(testing::distance(Kd.get(), difference.get()), 1e-8 * testing::norm(Kd.get()));
  }
}

// Rows and columns of slaves hold the diagonal alone; what slaves have in y changes nothing.
TEST_P(Constrained, SlavesAreOutOfTheEquation) {
  const auto slaves = body_.solid().vector(testing::at_rest);
  {
    const ArrayView entries(slaves.get());
    for (std::size_t i = 0; i < entries.span().size(); ++i) {
      entries.span()[i] = body_.map().is_slave()[i] ? 1.0 : 0.0;
    }
  }
  ASSERT_GT(testing::norm(slaves.get()), 5.0);
  EXPECT_EQ(value(0.0, slaves.get()), value(1.0, slaves.get()));
  EXPECT_EQ(testing::dot(gradient(0.0, slaves.get()).get(), slaves.get()), 0.0);
  const Handle<Mat> K = equation_.make_hessian();
  equation_.hessian(y_.get(), K.get(), Projection::none);
  const Handle<Vec> column = equation_.make_vector();
  check(MatMult(K.get(), slaves.get(), column.get()));
  const ConstArrayView k(column.get()), s(slaves.get());
  double diagonal = 0.0;
  for (std::size_t i = 0; i < k.span().size(); ++i) {
    if (s.span()[i] == 0.0) {
      EXPECT_EQ(k.span()[i], 0.0);
    } else {
      diagonal = k.span()[i];
      EXPECT_GT(diagonal, 0.0);
    }
  }
}

TEST_P(Constrained, NearNullSpaceHoldsWhatIsFree) {
  const Handle<Mat> K = equation_.make_hessian();
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(K.get(), &space));
  ASSERT_NE(space, nullptr);
  PetscInt num_modes = 0;
  const Vec* modes = nullptr;
  check(MatNullSpaceGetVecs(space, nullptr, &num_modes, &modes));
  EXPECT_EQ(num_modes, 6);
  for (PetscInt m = 0; m < num_modes; ++m) {
    const ConstArrayView mode(modes[m]);
    for (std::size_t i = 0; i < mode.span().size(); ++i) {
      const bool is_out = equation_.prescribed()[i] != 0;
      EXPECT_TRUE(!is_out || mode.span()[i] == 0.0);
    }
  }
}

}  // namespace
}  // namespace pliant
