// Displacements and pressures: the derivatives of their potential, and the equation of a stage made of them.
#include "energy/equation/mixed_equation.hpp"
#include "energy/solid.hpp"
#include "energy/volume/mixed.hpp"
#include "material/kinematics.hpp"
#include "material/volume_split.hpp"

#include <eigen3/Eigen/Eigenvalues>
#include <limits>
#include <optional>
#include <ostream>

namespace pliant::test_mixed {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

struct Case {
  ElasticLawSpec law;
  BodySpec body;
};

std::string name_of(const Case& c) {
  return test::name_of(c.law) + std::string(volumetric_form_names[static_cast<std::size_t>(c.law.volumetric)]) +
         test::name_of(c.body);
}
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << name_of(c);
}

std::vector<Case> every_case() {
  std::vector<Case> cases;
  for (const BodySpec body :
       {BodySpec{1, Shape::jittered, 2}, BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}}) {
    for (auto law : test::every_law(1000.0, 0.45)) {
      if (!split_volume(law)) continue;
      for (const auto form : {VolumetricForm::log, VolumetricForm::quadratic, VolumetricForm::mixed}) {
        law.volumetric = form;
        if (law.traits().takes_volumetric_form || form == VolumetricForm::mixed) cases.push_back({law, body});
      }
    }
  }
  return cases;
}

class Mixed : public ::testing::TestWithParam<Case> {
 protected:
  Mixed() {
    for (PetscInt n = 0; n < solid_.layout().num_local_nodes; ++n) {
      if (solid_.layout().global_node(n) == 0) prescribed_[3 * n] = 1;  // one entry, as all ranks see it
    }
    potential_.emplace(solid_.layout(), solid_.pattern(), std::vector<const EnergyTerm*>{term_.get()}, prescribed_);
    equation_.emplace(*potential_, solid_.layout(), std::vector<const MixedTerm*>{term_.get()}, field_);
    x0_ = unknowns(test::at_rest, 0.0);
    q0_ = solid_.vector(test::at_rest);
    v0_ = solid_.vector(test::at_rest);
    at_rest_ = {.time = stage_.point.time, .dt = stage_.point.dt, .q0 = q0_.get(), .v0 = v0_.get()};
    equation_->enter(at_rest_, q0_.get(), x0_.get());
  }

  int degree() const { return elastic_quadrature_degree(GetParam().law.traits(), GetParam().body.order); }

  /// Displacements by the field, pressures that differ from vertex to vertex.
  Handle<Vec> unknowns(const test::Field& displacement, double pressure) const {
    Handle<Vec> x = equation_->make_vector();
    const auto q = solid_.vector(displacement);
    const ArrayView values(x.get());
    const ConstArrayView from(q.get());
    const auto num_q = static_cast<PetscInt>(from.span().size());
    std::copy(from.span().begin(), from.span().end(), values.span().begin());
    for (PetscInt n = 0; n < solid_.layout().num_owned_nodes; ++n) {
      const PetscInt p = field_.layout().of_node[0][static_cast<std::size_t>(n)];
      if (p >= 0) values[num_q + p] = pressure * (1.0 + test::rough(solid_.layout().position(n), 0, 5));
    }
    return x;
  }
  Handle<Vec> gradient(Vec x) {
    Handle<Vec> r = equation_->make_vector();
    equation_->gradient(x, r.get());
    return r;
  }
  static Handle<Vec> shifted(Vec x, double s, Vec d) {
    Handle<Vec> y;
    check(VecDuplicate(x, y.out()));
    check(VecWAXPY(y.get(), s, d, x));
    return y;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, degree()};
  std::unique_ptr<PressureField> pressures_ = solid_.pressure_field();
  PressureField& field_ = *pressures_;
  std::unique_ptr<MixedTerm> term_ = solid_.mixed(make_mixed_law(*split_volume(GetParam().law)), field_);
  TestStage stage_{solid_, 0.0, 1.0};
  std::vector<char> prescribed_ = solid_.nothing_prescribed();
  std::optional<IncrementalPotential> potential_;
  std::optional<MixedEquation> equation_;
  StagePoint at_rest_;
  Handle<Vec> x0_, q0_, v0_;
};

INSTANTIATE_TEST_SUITE_P(Registry, Mixed, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

// Differences of fourth order: their error is some 1e-12, their rounding some 1e-12, of the derivative.
constexpr double h = 1e-3;

TEST_P(Mixed, MatrixIsTheDerivativeOfTheResidual) {
  const auto x = unknowns(test::strained, 0.05);
  const Handle<Mat> A = equation_->make_hessian();
  equation_->hessian(x.get(), A.get(), Projection::none);
  const auto Ad = equation_->make_vector();
  for (int seed : {11, 12}) {
    auto d = unknowns(test::rough_field(0.05, seed), 0.03);
    {
      const ArrayView direction(d.get());
      for (std::size_t i = 0; i < equation_->prescribed().size(); ++i) {
        if (equation_->prescribed()[i]) direction[static_cast<PetscInt>(i)] = 0.0;
      }
    }
    check(MatMult(A.get(), d.get(), Ad.get()));
    const auto ahead = gradient(shifted(x.get(), h, d.get()).get());
    const auto behind = gradient(shifted(x.get(), -h, d.get()).get());
    const auto far_ahead = gradient(shifted(x.get(), 2.0 * h, d.get()).get());
    const auto far_behind = gradient(shifted(x.get(), -2.0 * h, d.get()).get());
    auto difference = shifted(ahead.get(), -1.0, behind.get());
    check(VecScale(difference.get(), 8.0));
    check(VecAXPY(difference.get(), -1.0, far_ahead.get()));
    check(VecAXPY(difference.get(), 1.0, far_behind.get()));
    check(VecScale(difference.get(), 1.0 / (12.0 * h)));
    ASSERT_GT(test::norm(Ad.get()), 1e-2);
    EXPECT_LE(test::distance(Ad.get(), difference.get()), 1e-9 * test::norm(Ad.get()));
  }
  // Symmetry, as seen by two directions.
  const auto d = unknowns(test::rough_field(0.05, 13), 0.03), e = unknowns(test::rough_field(0.05, 14), 0.02);
  const auto Ae = equation_->make_vector();
  check(MatMult(A.get(), d.get(), Ad.get()));
  check(MatMult(A.get(), e.get(), Ae.get()));
  EXPECT_NEAR(test::dot(e.get(), Ad.get()), test::dot(d.get(), Ae.get()),
              1e-13 * test::norm(Ad.get()) * test::norm(e.get()));
}

TEST_P(Mixed, DisplacementsFeelTheGradientOfTheEnergyAtGivenPressures) {
  const auto x = unknowns(test::strained, 0.05), d = unknowns(test::rough_field(0.05, 11), 0.0);
  const auto value = [&](double s) { return equation_->value(shifted(x.get(), s, d.get()).get()); };
  const double expected = (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
  equation_->value(x.get());  // sets the pressures
  const auto q = solid_.vector(test::strained), direction = solid_.vector(test::rough_field(0.05, 11));
  const auto forces = potential_->make_vector();
  potential_->gradient_with_reactions(q.get(), forces.get());
  const double slope = test::dot(forces.get(), direction.get());
  ASSERT_GT(std::abs(slope), 1e-3);
  EXPECT_NEAR(slope, expected, 1e-9 * test::norm(forces.get()) * test::norm(direction.get()));
}

// Where p = kappa g(J) at every point the mixed body is the law's own.
TEST_P(Mixed, UniformStrainsAreTheLaws) {
  const Tensor3<double> H{{0.1, 0.05, 0.0, -0.02, 0.08, 0.03, 0.0, 0.01, -0.06}};
  const auto split = *split_volume(GetParam().law);
  const double j = volume_change(H), p = split.kappa * volume_measure(split.form, j).g;
  check(VecSet(field_.values(), p));
  update_ghosts(field_.values());
  const auto q = solid_.vector([&](const Point& x) {
    Point u{};
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) u[i] += H(i, k) * x[k];
    }
    return u;
  });
  const auto local = test::local_values(q.get());
  const auto like = solid_.elastic(GetParam().law);
  const double energy = sum(comm, like->energy(local, {}));
  EXPECT_NEAR(sum(comm, term_->energy(local, {})), energy, 1e-12 * energy);
  std::vector<double> r(local.size(), 0.0), expected(local.size(), 0.0), volume(local.size(), 0.0);
  const LocalStage stage{0.0, 1.0, 1.0, {}, {}, {}};
  term_->add_gradient(stage, local, r);
  like->add_gradient(stage, local, expected);
  for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) EXPECT_NEAR(r[i], expected[i], 1e-10);
  term_->add_pressure_gradient({}, local, volume);
  for (PetscInt i = 0; i < field_.layout().num_owned; ++i) EXPECT_NEAR(volume[i], 0.0, 1e-15);
  std::vector<CellStress> stresses;
  like->stresses({.q = local}, [&](PetscInt, const CellStress& s) { stresses.push_back(s); });
  std::size_t n = 0;
  term_->stresses({.q = local}, [&](PetscInt, const CellStress& s) {
    const CellStress& of_law = stresses[n++];
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(s.cauchy[i], of_law.cauchy[i], 1e-10);
    EXPECT_NEAR(s.energy_density, of_law.energy_density, 1e-12 * of_law.energy_density);
    EXPECT_NEAR(s.volume_ratio, of_law.volume_ratio, 1e-13);
  });
  EXPECT_EQ(n, stresses.size());
}

// The matrix of a body at rest that is held in one place and cannot be compressed: as many negative eigenvalues as
// pressures.
TEST_P(Mixed, NegativeEigenvaluesAreThoseOfThePressures) {
  if (sum(comm, 1.0) > 1.0) return;                                                // a dense problem of one rank
  for (PetscInt i = 0; i < 12; ++i) prescribed_[static_cast<std::size_t>(i)] = 1;  // four nodes, not all on a line
  VolumeSplit law = *split_volume(GetParam().law);
  law.kappa = std::numeric_limits<double>::infinity();
  const auto term = solid_.mixed(make_mixed_law(law), field_);
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, prescribed_);
  MixedEquation equation(potential, solid_.layout(), {term.get()}, field_);
  equation.enter(at_rest_, q0_.get(), x0_.get());
  const Handle<Mat> A = equation.make_hessian();
  equation.hessian(x0_.get(), A.get(), Projection::none);
  const PetscInt size = equation.num_unknowns();
  Eigen::MatrixXd dense(size, size);
  std::vector<PetscInt> all(static_cast<std::size_t>(size));
  for (PetscInt i = 0; i < size; ++i) all[static_cast<std::size_t>(i)] = i;
  check(MatGetValues(A.get(), size, all.data(), size, all.data(), dense.data()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(dense, Eigen::EigenvaluesOnly);
  EXPECT_EQ((solver.eigenvalues().array() < 0.0).count(), equation.num_negative_pivots());
}

// Pressures that follow from the displacements are where the derivative by them vanishes.
TEST_P(Mixed, SettledPressuresAreThoseOfTheDisplacements) {
  const auto q = solid_.vector(test::strained);
  equation_->settle(q.get(), {});
  std::vector<double> r(static_cast<std::size_t>(field_.layout().num_local), 0.0), m(r.size(), 0.0);
  term_->add_pressure_gradient({}, test::local_values(q.get()), r);
  term_->add_pressure_volumes(m);
  for (PetscInt i = 0; i < field_.layout().num_owned; ++i) EXPECT_LE(std::abs(r[i]), 1e-11 * m[i]);
  PetscReal largest = 0.0;
  check(VecNorm(field_.values(), NORM_INFINITY, &largest));
  EXPECT_GT(largest, 1.0);
}

/// A cube whose constants vary, or whose fibres shorten: its derivatives.
class MixedVariant : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, MixedVariant, ::testing::Values(1, 2));

void expect_derivatives(const Solid& solid, MixedTerm& term, PressureField& field) {
  {
    const ArrayView p(field.values());
    for (PetscInt n = 0; n < solid.layout().num_owned_nodes; ++n) {
      const PetscInt number = field.layout().of_node[0][static_cast<std::size_t>(n)];
      if (number >= 0) p[number] = 100.0 * (1.0 + test::rough(solid.layout().position(n), 0, 5));
    }
  }
  update_ghosts(field.values());
  IncrementalPotential potential(solid.layout(), solid.pattern(), {&term}, solid.nothing_prescribed());
  const TestStage stage(solid, 0.3, 0.1);
  potential.begin_stage(stage.point);
  const auto q = solid.vector(test::strained), d = solid.vector(test::rough_field(0.05, 11));
  const auto at = [&](double s) { return test::moved(q.get(), s, d.get()); };
  const auto r = potential.make_vector(), Kd = potential.make_vector();
  potential.gradient(q.get(), r.get());
  const auto value = [&](double s) { return potential.value(at(s).get()); };
  const double slope = (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
  EXPECT_NEAR(test::dot(r.get(), d.get()), slope, 1e-9 * test::norm(r.get()) * test::norm(d.get()));
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::none);
  check(MatMult(K.get(), d.get(), Kd.get()));
  const auto gradient = [&](double s) {
    auto g = potential.make_vector();
    potential.gradient(at(s).get(), g.get());
    return g;
  };
  const auto difference = gradient(h);
  check(VecAXPY(difference.get(), -1.0, gradient(-h).get()));
  check(VecScale(difference.get(), 8.0));
  check(VecAXPY(difference.get(), -1.0, gradient(2.0 * h).get()));
  check(VecAXPY(difference.get(), 1.0, gradient(-2.0 * h).get()));
  check(VecScale(difference.get(), 1.0 / (12.0 * h)));
  ASSERT_GT(test::norm(Kd.get()), 1e-2);
  EXPECT_LE(test::distance(Kd.get(), difference.get()), 1e-9 * test::norm(Kd.get()));
}

TEST_P(MixedVariant, DerivativesWithShortenedFibres) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [&](const std::string& f) {
    test::write_body(f, {GetParam(), Shape::jittered, 2});
  });
  const auto law = make_law("neo-hookean-isochoric", 1000.0, 0.45);
  const Solid solid(comm, file, GetParam(), elastic_quadrature_degree(law.traits(), GetParam()));
  const auto field = solid.pressure_field();
  const FreeShape shape{solid.activation(Expression("0.2*sin(2*t)+0.05*x"), FibreField::Kind::varying), nullptr};
  const auto term = solid.mixed(make_mixed_law(*split_volume(law)), *field, shape);
  EXPECT_TRUE(term->declaration().depends_on_time);
  expect_derivatives(solid, *term, *field);
}

TEST_P(MixedVariant, ConstantsThatVaryAreThoseOfTheirPlace) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [&](const std::string& f) {
    test::write_body(f, {GetParam(), Shape::jittered, 2});
  });
  const auto law_at = [](const Point& X) { return make_law("neo-hookean-isochoric", 1000.0 * (1.0 + X[0]), 0.45); };
  const auto common = law_at({});
  const Solid solid(comm, file, GetParam(), elastic_quadrature_degree(common.traits(), GetParam()));
  const auto field = solid.pressure_field();
  const auto law = std::visit(
      [&]<int Order>(const CellGroups<Order>& groups) {
        return make_varying_mixed_law<Order>(common, *volumetric_form_of(common), solid.layout(), groups, 0,
                                             [&](PetscInt, const Point& X) { return *split_volume(law_at(X)); });
      },
      solid.groups());
  const auto term = solid.mixed(law, *field);
  EXPECT_NEAR(maximum(comm, term->shear_modulus()), 2000.0 / 2.9, 200.0);
  expect_derivatives(solid, *term, *field);
  // The energy of a stretch is the integral of 1 + x, as the pressures settle: twice 3/4 of that at x = 0.
  const auto q = solid.vector([](const Point& x) { return Point{1e-4 * x[0], 1e-4 * x[1], 1e-4 * x[2]}; });
  IncrementalPotential potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed());
  MixedEquation equation(potential, solid.layout(), {term.get()}, *field);
  equation.settle(q.get(), {});
  const double volume = 3e-4, kappa = split_volume(common)->kappa;
  const double energy = sum(comm, term->energy(test::local_values(q.get()), {}));
  EXPECT_NEAR(energy, 0.5 * kappa * volume * volume * 1.5, 2e-2 * energy);
}

// Against the energy and its derivatives, which have tests of their own.
TEST(VolumeMeasure, IsTheRootOfTwiceTheEnergy) {
  for (const auto form : {VolumetricForm::log, VolumetricForm::quadratic, VolumetricForm::mixed}) {
    for (const double size : {1e-9, 1e-4, 0.0099, 0.0101, 0.1, 0.7}) {
      for (const double j : {size, -size}) {
        const auto at = volume_measure(form, j);
        const Volumetric<double> unit{1.0, form};
        EXPECT_NEAR(0.5 * at.g * at.g, unit.energy(j), 1e-14 * unit.energy(j));
        EXPECT_GT(at.g * j, 0.0);
        EXPECT_NEAR(at.g * at.slope * (1.0 + j), unit.stress(j).value, 1e-14 * std::abs(unit.stress(j).value));
        // (J U')' = U' + J U'' = g g' + J (g'^2 + g g'')
        const double slope = at.g * at.slope + (1.0 + j) * (at.slope * at.slope + at.g * at.curvature);
        EXPECT_NEAR((1.0 + j) * slope, unit.stress(j).slope, 1e-14 * std::abs(unit.stress(j).slope));
      }
    }
    EXPECT_EQ(volume_measure(form, 0.0).g, 0.0);
    EXPECT_EQ(volume_measure(form, 0.0).slope, 1.0);
  }
}

}  // namespace
}  // namespace pliant::test_mixed
