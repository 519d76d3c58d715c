// The transposed derivatives of every term that has an adjoint, against differences of what a stage computes.
#include "energy/equation/stage_adjoint.hpp"
#include "energy/solid.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <ostream>

#include <gtest/gtest.h>

namespace pliant::test_stage_adjoint {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
/// df/dx at 0, of fourth order.
template <class Function>
double difference(const Function& f) {
  constexpr double h = 2e-4;
  return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
}

struct TermCase {
  std::string name;
  BodySpec body;
  std::function<std::unique_ptr<EnergyTerm>(const Solid&)> make;
};

std::ostream& operator<<(std::ostream& out, const TermCase& c) {
  return out << c.name << c.body;
}

std::vector<TermCase> every_case() {
  std::vector<TermCase> cases;
  const Expression stretch("1.1 + 0.05*x + 0.1*t");
  for (const BodySpec body : {BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}}) {
    for (const auto& law : test::every_viscosity()) {
      cases.push_back({test::name_of(law), body, [=](const Solid& s) { return s.viscous(law); }});
      cases.push_back({test::name_of(law) + "Expanded", body,
                       [=](const Solid& s) { return s.viscous(law, s.expansion(stretch)); }});
    }
    const std::vector<Prony> branches{{0.5, 0.1}, {2.0, 0.02}};
    for (const auto& law : test::every_law()) {
      const std::string_view name = law.info().name;
      if (name != "linear" && name != "neo-hookean" && name != "ogden") continue;
      cases.push_back({"prony" + test::name_of(law), body, [=](const Solid& s) { return s.prony(branches, law); }});
    }
    const auto rest = test::without_volume("ogden");
    cases.push_back({"pronyIsochoric", body, [=](const Solid& s) { return s.prony(branches, rest); }});
    cases.push_back(
        {"pronyExpanded", body, [=](const Solid& s) { return s.prony(branches, rest, s.expansion(stretch)); }});
    cases.push_back({"inertia", body, [](const Solid& s) { return s.inertia(3.0, Mass::consistent); }});
    cases.push_back({"damping", body, [](const Solid& s) { return s.mass_damping(3.0, Mass::lumped); }});
    cases.push_back({"foundation", body, [](const Solid& s) {
                       return s.foundation({30.0, 2.0}, FoundationDirection::normal);
                     }});
    cases.push_back({"elastic", body, [](const Solid& s) { return s.elastic(test::every_law().front()); }});
    if (body.order == 2) {
      cases.push_back({"meanDilatation", body,
                       [](const Solid& s) { return s.elastic(test::every_law().back(), test::Dilatation::mean); }});
    }
    cases.push_back({"traction", body, [](const Solid& s) {
                       return s.traction({Expression("x*t"), Expression("cos(t+y)"), Expression(1.0)});
                     }});
  }
  return cases;
}

Point internal_end(const Point& x) {
  const Point u = test::strained(x), w = test::rough_field(0.01, 6)(x);
  return {0.6 * u[0] + w[0], 0.6 * u[1] + w[1], 0.6 * u[2] + w[2]};
}

class Adjoints : public ::testing::TestWithParam<TermCase> {
 protected:
  Adjoints() {
    stage_.set_internal(solid_, potential_, internal_end);
    internal_ = internal_like(21);
    if (!internal_) return;
    // Each variable once, over all ranks.
    std::vector<InternalPlace> places(term_->num_internal() / static_cast<std::size_t>(term_->internal_components()));
    term_->place_internal(places);
    for (const InternalPlace& place : places) {
      is_owned_.insert(is_owned_.end(), static_cast<std::size_t>(term_->internal_components()),
                       place.cell < solid_.layout().num_owned_cells ? 1.0 : 0.0);
    }
  }

  /// Internal variables that are the same on all ranks.
  Handle<Vec> internal_like(int seed) {
    TestStage stage(solid_, 0.7, 0.05);
    stage.set_internal(solid_, potential_, [seed](const Point& x) {
      const Point u = test::strained(x), w = test::rough_field(0.01, seed)(x);
      const double part = 0.1 * static_cast<double>(seed % 7);
      return Point{part * u[0] + w[0], part * u[1] + w[1], part * u[2] + w[2]};
    });
    return std::move(stage.z0);
  }

  /// J = l . r + m . z of a stage.
  double number(const StagePoint& point, Vec q) {
    potential_.begin_stage(point);
    const Handle<Vec> r = potential_.make_vector(), z = potential_.make_internal();
    potential_.gradient(q, r.get());
    double result = test::dot(residual_.get(), r.get());
    if (!z) return result;
    potential_.internal_variables().end_stage(point, q, z.get());
    return result + internal_dot(internal_.get(), z.get());
  }
  double internal_dot(Vec a, Vec b) const {
    const ConstArrayView x(a), y(b);
    double mine = 0.0;
    for (std::size_t i = 0; i < is_owned_.size(); ++i) mine += is_owned_[i] * x.span()[i] * y.span()[i];
    return sum(comm, mine);
  }
  /// Its derivative along a change of one of the vectors of the stage.
  double slope(Vec StagePoint::*what, Vec d) {
    return difference([&](double way) {
      Handle<Vec> y;
      check(VecDuplicate(d, y.out()));
      check(VecWAXPY(y.get(), way, d, stage_.point.*what));
      StagePoint point = stage_.point;
      point.*what = y.get();
      return number(point, q_.get());
    });
  }
  /// Likewise, along a change of q.
  double slope_by_q(Vec d) {
    return difference([&](double way) { return number(stage_.point, test::moved(q_.get(), way, d).get()); });
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, 2 * (GetParam().body.order - 1)};
  std::unique_ptr<EnergyTerm> term_ = GetParam().make(solid_);
  IncrementalPotential potential_{solid_.layout(), solid_.pattern(), {term_.get()}, solid_.nothing_prescribed()};
  TestStage stage_{solid_, 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4)};
  Handle<Vec> q_ = solid_.vector(test::strained);
  Handle<Vec> residual_ = solid_.vector(test::rough_field(0.5, 22)), internal_;
  std::vector<double> is_owned_;
};

INSTANTIATE_TEST_SUITE_P(Terms, Adjoints, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name + test::name_of(of.param.body); });

TEST_P(Adjoints, AreTransposedDerivativesByTheStart) {
  const Handle<Vec> q = potential_.make_vector(), q0 = potential_.make_vector(), v0 = potential_.make_vector(),
                    z0 = potential_.make_internal();
  StageAdjoint adjoint = potential_.adjoint();
  EXPECT_TRUE(adjoint.missing().empty());
  const double size = std::abs(number(stage_.point, q_.get()));
  potential_.begin_stage(stage_.point);
  adjoint.pull_back(q_.get(), residual_.get(), internal_.get(), {q.get(), q0.get(), v0.get(), z0.get()});
  const Handle<Vec> d = solid_.vector(test::rough_field(0.3, 23));
  const double rounding = 1e-11 * size + 1e-12;
  const auto expect = [&](double found, double expected) {
    EXPECT_NEAR(found, expected, 1e-7 * (std::abs(found) + std::abs(expected)) + rounding);
  };
  expect(test::dot(q0.get(), d.get()), slope(&StagePoint::q0, d.get()));
  expect(test::dot(v0.get(), d.get()), slope(&StagePoint::v0, d.get()));
  if (!z0) return;
  const Handle<Vec> dz = internal_like(24);
  expect(internal_dot(z0.get(), dz.get()), slope(&StagePoint::z0, dz.get()));
  // By q: that of the internal variables alone.
  check(VecZeroEntries(residual_.get()));
  update_ghosts(residual_.get());
  expect(test::dot(q.get(), d.get()), slope_by_q(d.get()));
}

TEST_P(Adjoints, CompleteSteps) {
  const Handle<Vec> z = potential_.make_internal(), r = potential_.make_vector();
  if (!z) return;
  const Handle<Vec> formula = internal_like(25), d = solid_.vector(test::rough_field(0.3, 26)), dz = internal_like(27);
  const auto number_at = [&](double way) {
    check(VecWAXPY(z.get(), way, dz.get(), formula.get()));
    const auto q = test::moved(q_.get(), way, d.get());
    potential_.internal_variables().complete_step(nullptr, q.get(), z.get());
    return internal_dot(internal_.get(), z.get());
  };
  const double expected = difference(number_at);
  check(VecCopy(internal_.get(), z.get()));
  potential_.adjoint().pull_back_completion(q_.get(), z.get(), r.get());
  EXPECT_NEAR(test::dot(r.get(), d.get()) + internal_dot(z.get(), dz.get()), expected,
              1e-7 * std::abs(expected) + 1e-12);
}

TEST_P(Adjoints, HaveTheRestOfTheTangent) {
  const Handle<Vec> d = solid_.vector(test::rough_field(0.3, 28)), y = potential_.make_vector();
  potential_.begin_stage(stage_.point);
  const Handle<Mat> K = potential_.make_hessian();
  potential_.hessian(q_.get(), K.get(), Projection::none);
  check(MatMult(K.get(), residual_.get(), y.get()));
  if (potential_.adjoint().has_rest()) {
    const double without = test::dot(y.get(), d.get());
    potential_.adjoint().add_transposed_rest(q_.get(), residual_.get(), y.get());
    EXPECT_GT(std::abs(test::dot(y.get(), d.get()) - without), 1e-6 * std::abs(without));
  }
  if (internal_) check(VecZeroEntries(internal_.get()));
  const double expected = slope_by_q(d.get());
  EXPECT_NEAR(test::dot(y.get(), d.get()), expected, 1e-6 * std::abs(expected) + 1e-12);
}

TEST_P(Adjoints, DivideWorkAmongCells) {
  std::vector<double> works(static_cast<std::size_t>(solid_.layout().num_local_cells), 0.0);
  potential_.begin_stage(stage_.point);
  potential_.adjoint().add_cell_works(q_.get(), residual_.get(), works);
  double mine = 0.0;
  for (PetscInt c = 0; c < solid_.layout().num_owned_cells; ++c) mine += works[static_cast<std::size_t>(c)];
  const double total = sum(comm, mine);
  if (total == 0.0) return;  // it does not depend on the law of the body
  const Handle<Vec> r = potential_.make_vector();
  potential_.gradient(q_.get(), r.get());
  const double expected = test::dot(r.get(), residual_.get());
  EXPECT_NEAR(total, expected, 1e-11 * test::norm(r.get()) * test::norm(residual_.get()));
}

}  // namespace
}  // namespace pliant::test_stage_adjoint
