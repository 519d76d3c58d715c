// Every term: its gradient is that of its value, its Hessian that of its gradient; over the registry of laws.
#include "energy/solid.hpp"

#include <ostream>

namespace pliant::test_derivatives {
namespace {

using test::BodySpec;
using test::Dilatation;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double density = 3.0;

struct TermCase {
  std::string name;
  BodySpec body;
  int degree;
  std::function<std::unique_ptr<EnergyTerm>(const Solid&)> make;
  bool has_hessian = true;
};

std::ostream& operator<<(std::ostream& out, const TermCase& c) {
  return out << c.name << c.body;
}

std::vector<TermCase> every_case() {
  std::vector<TermCase> cases;
  for (const BodySpec body :
       {BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}}) {
    for (const auto& law : test::every_law()) {
      for (const auto dilatation : test::every_dilatation(law, body.order)) {
        cases.push_back({test::name_of(law) + test::name_of(dilatation), body,
                         elastic_quadrature_degree(law.traits(), body.order),
                         [=](const Solid& solid) { return solid.elastic(law, dilatation); }});
      }
    }
    for (const auto& law : test::every_law()) {
      if (law.info().name != "neo-hookean" && law.info().name != "guccione") continue;
      for (const auto& [name, amount] : {std::pair{"Uniform", "0.1*sin(2*t)"}, {"Varied", "0.1*(1-x)+0.05*z*t"}}) {
        const Expression shortening(amount);
        cases.push_back({test::name_of(law) + "Shortened" + name, body,
                         elastic_quadrature_degree(law.traits(), body.order), [=](const Solid& solid) {
                           const FreeShape shape{solid.activation(shortening, FibreField::Kind::varying), nullptr};
                           return solid.elastic(law, Dilatation::pointwise, shape);
                         }});
      }
    }
    for (const auto& law : test::every_law()) {
      // The stiffness of fibres that resist tension alone jumps where they become slack, as they do on some side.
      if (law.info().name.starts_with("holzapfel")) continue;
      cases.push_back({"membrane" + test::name_of(law), body, 1,
                       [=](const Solid& solid) { return std::move(solid.membrane(law).elasticity); }});
    }
    cases.push_back({"membraneViscosity", body, 1, [](const Solid& solid) {
                       return std::move(solid.membrane(test::every_law().front()).viscosity);
                     }});
    cases.push_back({"activeStressUniform", body, 2 * (body.order - 1), [](const Solid& solid) {
                       return solid.active_stress(Expression("300*sin(2*t)"), FibreField::Kind::parallel);
                     }});
    cases.push_back({"activeStressVaried", body, 2 * (body.order - 1), [](const Solid& solid) {
                       return solid.active_stress(Expression("300*x-100*y*t"), FibreField::Kind::varying);
                     }});
    for (const auto& law : test::every_viscosity()) {
      if (!test::is_potential(law)) continue;
      cases.push_back(
          {test::name_of(law), body, 2 * (body.order - 1), [=](const Solid& solid) { return solid.viscous(law); }});
    }
    for (const char* law : {"linear", "saint-venant-kirchhoff", "neo-hookean", "neo-hookean-isochoric"}) {
      std::string name = std::string("prony") + law;
      std::erase(name, '-');
      cases.push_back({name, body, 2 * (body.order - 1), [=](const Solid& solid) {
                         return solid.prony({{0.5, 0.1}, {2.0, 0.02}}, law);
                       }});
    }
    for (const char* law : {"neo-hookean", "neo-hookean-isochoric", "ogden"}) {
      const auto rest = test::without_volume(law);
      cases.push_back({"pronyWithoutVolume" + test::name_of(rest), body, 2 * (body.order - 1), [=](const Solid& solid) {
                         return solid.prony({{0.5, 0.1}, {2.0, 0.02}}, rest);
                       }});
    }
    for (const auto& [name, mass] : {std::pair{"consistent", Mass::consistent}, {"lumped", Mass::lumped}}) {
      const Mass of = mass;
      cases.push_back({name, body, 2, [=](const Solid& solid) { return solid.inertia(density, of); }});
      cases.push_back({std::string("damping") + name, body, 2,
                       [=](const Solid& solid) { return solid.mass_damping(density, of); }});
    }
    const auto load = [&](const std::string& name, const std::array<Expression, 3>& value) {
      cases.push_back({"gravity" + name, body, 1, [=](const Solid& s) { return s.gravity(density, value); }, false});
      cases.push_back({"traction" + name, body, 1, [=](const Solid& s) { return s.traction(value); }, false});
    };
    load("Constant", {Expression(2.0), Expression(), Expression(-9.81)});
    load("InSpace", {Expression("x*y"), Expression("3*z"), Expression("-9.81*sin(pi*y)")});
    load("InTime", {Expression("sin(4*t)"), Expression(), Expression(-9.81)});
    cases.push_back({"lineForce", body, 1,
                     [](const Solid& s) {
                       return s.line_force({Expression("x*t"), Expression("cos(t+x)"), Expression(1.0)});
                     },
                     false});
    load("InBoth", {Expression("x*t"), Expression("cos(t+y)"), Expression(1.0)});
    for (const auto& [name, direction] :
         {std::pair{"All", FoundationDirection::all}, {"Normal", FoundationDirection::normal}}) {
      const FoundationDirection of = direction;
      cases.push_back({std::string("foundation") + name, body, 1, [=](const Solid& s) {
                         return s.foundation({30.0, 2.0}, of);
                       }});
    }
    cases.push_back({"nodalFoundation", body, 1, [=](const Solid& s) {
                       const auto nodes = nodes_of_group(s.mesh(), s.layout(), test::group_named(s.mesh(), "edge"));
                       return std::make_unique<Foundation>(nodal_foundation(s.pattern(), nodes, 0.5),
                                                           FoundationStiffness{30.0, 2.0});
                     }});
    for (const auto& [name, content] : {std::pair{"Given", CavityContent(GivenPressure{Expression("2+t")})},
                                        {"Gas", CavityContent(Gas{3.0, 0.5, 4.0, 1.4, Expression("1+t")})},
                                        {"Liquid", CavityContent(Liquid{3.0, 0.5, 9.0, Expression("t")})}}) {
      const CavityContent of = content;
      cases.push_back({std::string("cavity") + name, body, 1, [=](const Solid& s) { return s.cavity_around(of); }});
    }
    for (const auto& [name, value] : {std::pair{"Uniform", "2+t"}, {"Varied", "1+x*y+z*t"}}) {
      const Expression pressure(value);
      cases.push_back({std::string("pressure") + name, body, 1, [=](const Solid& s) { return s.pressure(pressure); }});
    }
  }
  return cases;
}

/// Where internal variables come from: strains like those of the stage, but not the same.
Point internal_end(const Point& x) {
  const Point u = test::strained(x), w = test::rough_field(0.01, 6)(x);
  return {0.6 * u[0] + w[0], 0.6 * u[1] + w[1], 0.6 * u[2] + w[2]};
}

class Terms : public ::testing::TestWithParam<TermCase> {
 protected:
  Terms() {
    for (int i = 0; i < 3; ++i) directions_.push_back(solid_.vector(test::rough_field(0.05, 11 + i)));
    stage_.set_internal(solid_, potential_, internal_end);
    potential_.begin_stage(stage_.point);
  }

  double value(double alpha, Vec d) { return potential_.value(test::moved(q_.get(), alpha, d).get()); }
  Handle<Vec> gradient(double alpha, Vec d) {
    Handle<Vec> r = potential_.make_vector();
    potential_.gradient(test::moved(q_.get(), alpha, d).get(), r.get());
    return r;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, GetParam().degree};
  std::unique_ptr<EnergyTerm> term_ = GetParam().make(solid_);
  IncrementalPotential potential_{solid_.layout(), solid_.pattern(), {term_.get()}, solid_.nothing_prescribed()};
  TestStage stage_{solid_, 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4)};
  Handle<Vec> q_ = solid_.vector(test::strained);
  std::vector<Handle<Vec>> directions_;
};

INSTANTIATE_TEST_SUITE_P(Registry, Terms, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name + test::name_of(of.param.body); });

// Differences of fourth order: their error is some 1e-12, their rounding some 1e-12, of the derivative.
constexpr double h = 1e-3;

TEST_P(Terms, GradientIsThatOfTheValue) {
  if (!term_->declaration().is_potential) return;
  const auto g = gradient(0.0, directions_[0].get());
  ASSERT_GT(test::norm(g.get()), 1e-3);
  for (const auto& d : directions_) {
    const double expected =
        (8.0 * (value(h, d.get()) - value(-h, d.get())) - (value(2.0 * h, d.get()) - value(-2.0 * h, d.get()))) /
        (12.0 * h);
    const double slope = test::dot(g.get(), d.get());
    EXPECT_GT(std::abs(slope), 1e-4 * test::norm(g.get()) * test::norm(d.get()));
    EXPECT_NEAR(slope, expected, 1e-9 * test::norm(g.get()) * test::norm(d.get()));
  }
}

TEST_P(Terms, HessianIsThatOfTheGradient) {
  const Handle<Mat> K = potential_.make_hessian();
  potential_.hessian(q_.get(), K.get(), Projection::none);
  std::vector<RankOne> parts;
  for (std::size_t k = 0; k < potential_.num_rank_one(); ++k) parts.push_back({0.0, potential_.make_vector()});
  potential_.rank_one_parts(q_.get(), parts);
  const Handle<Vec> Kd = potential_.make_vector(), difference = potential_.make_vector();
  for (const auto& d : directions_) {
    check(MatMult(K.get(), d.get(), Kd.get()));
    for (const auto& [c, g] : parts) check(VecAXPY(Kd.get(), c * test::dot(g.get(), d.get()), g.get()));
    const auto ahead = gradient(h, d.get()), behind = gradient(-h, d.get());
    const auto far_ahead = gradient(2.0 * h, d.get()), far_behind = gradient(-2.0 * h, d.get());
    check(VecWAXPY(difference.get(), -1.0, behind.get(), ahead.get()));
    check(VecScale(difference.get(), 8.0));
    check(VecAXPY(difference.get(), -1.0, far_ahead.get()));
    check(VecAXPY(difference.get(), 1.0, far_behind.get()));
    check(VecScale(difference.get(), 1.0 / (12.0 * h)));
    if (GetParam().has_hessian) {
      ASSERT_GT(test::norm(Kd.get()), 1e-3);
      EXPECT_LE(test::distance(Kd.get(), difference.get()), 1e-8 * test::norm(Kd.get()));
    } else {
      EXPECT_EQ(test::norm(Kd.get()), 0.0);
      EXPECT_EQ(test::norm(difference.get()), 0.0);
    }
  }
}

// With stresses extrapolated from a state nearby: off by the square of the way from there, and by nothing else.
TEST_P(Terms, ExtrapolatedHessianMeetsTheExactOne) {
  const Handle<Mat> exact = potential_.make_hessian(), K = potential_.make_hessian();
  potential_.hessian(q_.get(), exact.get(), Projection::none);
  PetscReal size = 0.0;
  check(MatNorm(exact.get(), NORM_FROBENIUS, &size));
  const auto error = [&](double way) {
    const auto previous = test::moved(q_.get(), -way, directions_[0].get());
    potential_.extrapolate_from(previous.get());
    potential_.hessian(q_.get(), K.get(), Projection::none);
    potential_.extrapolate_from(nullptr);
    check(MatAXPY(K.get(), -1.0, exact.get(), SAME_NONZERO_PATTERN));
    PetscReal norm = 0.0;
    check(MatNorm(K.get(), NORM_FROBENIUS, &norm));
    return norm;
  };
  const double far = error(0.1), near = error(0.05);
  EXPECT_LE(far, 0.1 * size);
  if (far > 1e-10 * size) {
    EXPECT_NEAR(std::log2(far / near), 2.0, 0.4);
  }
}

TEST_P(Terms, HessianIsAsSymmetricAsDeclared) {
  const Handle<Mat> K = potential_.make_hessian();
  potential_.hessian(q_.get(), K.get(), Projection::none);
  PetscBool is_known = PETSC_FALSE, claims_symmetry = PETSC_FALSE;
  check(MatIsSymmetricKnown(K.get(), &is_known, &claims_symmetry));
  EXPECT_EQ(is_known && claims_symmetry, term_->declaration().symmetry == Symmetry::symmetric);
  Handle<Mat> D;
  check(MatTranspose(K.get(), MAT_INITIAL_MATRIX, D.out()));
  check(MatAXPY(D.get(), -1.0, K.get(), DIFFERENT_NONZERO_PATTERN));
  PetscReal size = 0.0, asymmetry = 0.0;
  check(MatNorm(K.get(), NORM_FROBENIUS, &size));
  check(MatNorm(D.get(), NORM_FROBENIUS, &asymmetry));
  if (term_->declaration().symmetry == Symmetry::symmetric) {
    EXPECT_LE(asymmetry, 1e-15 * size);
  } else {
    EXPECT_GT(asymmetry, 0.01 * size);
  }
}

// The same numbers as on one rank, and zero at the stage's start.
TEST_P(Terms, NothingDependsOnTheNumberOfRanks) {
  const Solid whole(MPI_COMM_SELF, file_, GetParam().body.order, GetParam().degree);
  const auto term = GetParam().make(whole);
  IncrementalPotential alone(whole.layout(), whole.pattern(), {term.get()}, whole.nothing_prescribed());
  TestStage stage(whole, 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4));
  stage.set_internal(whole, alone, internal_end);
  alone.begin_stage(stage.point);
  const Handle<Vec> q = whole.vector(test::strained), r = alone.make_vector();
  alone.gradient(q.get(), r.get());
  const double expected = alone.value(q.get());
  EXPECT_NEAR(potential_.value(q_.get()), expected, 1e-12 * std::abs(expected));
  const auto g = gradient(0.0, directions_[0].get());
  EXPECT_NEAR(test::norm(g.get()), test::norm(r.get()), 1e-12 * test::norm(r.get()));
  alone.gradient_with_reactions(q.get(), r.get());
  EXPECT_NEAR(potential_.force_scale(q_.get()), test::norm(r.get()), 1e-12 * test::norm(r.get()));
  EXPECT_EQ(potential_.value(stage_.q0.get()), 0.0);
}

TEST_P(Terms, PrescribedEntriesHaveNoGradientAndAnIdleRow) {
  std::vector<char> flags;
  for (PetscInt a = 0; a < solid_.layout().num_local_nodes; ++a) {
    const bool is_held = solid_.layout().position(a)[0] < 0.3;
    for (int i = 0; i < 3; ++i) flags.push_back(is_held && i != 1);
  }
  IncrementalPotential held(solid_.layout(), solid_.pattern(), {term_.get()}, flags);
  held.begin_stage(stage_.point);
  const Handle<Vec> r = held.make_vector(), reactions = held.make_vector(), d = held.make_vector();
  held.gradient(q_.get(), r.get());
  held.gradient_with_reactions(q_.get(), reactions.get());
  const auto free = gradient(0.0, directions_[0].get());
  EXPECT_EQ(test::distance(reactions.get(), free.get()), 0.0);
  const Handle<Mat> K = held.make_hessian();
  held.hessian(q_.get(), K.get(), Projection::none);
  check(MatMult(K.get(), directions_[0].get(), d.get()));
  const ConstArrayView gradient(r.get()), all(free.get()), product(d.get()), direction(directions_[0].get());
  const Handle<Vec> diagonal = held.make_vector();
  check(MatGetDiagonal(K.get(), diagonal.get()));
  const ConstArrayView k(diagonal.get());
  for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) {
    if (flags[static_cast<std::size_t>(i)]) {
      EXPECT_EQ(gradient[i], 0.0);
      EXPECT_EQ(product[i], k[i] * direction[i]);
      EXPECT_GT(k[i], 0.0);
    } else {
      EXPECT_EQ(gradient[i], all[i]);
    }
  }
}

}  // namespace
}  // namespace pliant::test_derivatives
