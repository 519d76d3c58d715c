// Bodies that expand: free, confined, and the energy that enters; every law with every treatment of the volume.
#include "energy/equation/mixed_equation.hpp"
#include "energy/solid.hpp"
#include "material/volume_split.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <ostream>

namespace pliant::test_expansion {
namespace {

using test::BodySpec;
using test::Dilatation;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double youngs_modulus = 1000.0;
constexpr double time = 0.3;

enum class Treatment { pointwise, mean, mixed, incompressible };
constexpr const char* treatment_names[] = {"", "Mean", "Mixed", "Incompressible"};

struct Case {
  ElasticLawSpec law;
  int order;
  Treatment treatment;
  bool has_pressures() const { return treatment == Treatment::mixed || treatment == Treatment::incompressible; }
};

std::string name_of(const Case& c) {
  return test::name_of(c.law) + treatment_names[static_cast<int>(c.treatment)] + (c.order == 1 ? "P1" : "P2");
}
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << name_of(c);
}

std::vector<Case> every_case() {
  std::vector<Case> cases;
  for (const int order : {1, 2}) {
    for (const auto& law : test::every_law(youngs_modulus)) {
      for (const Dilatation dilatation : test::every_dilatation(law, order)) {
        cases.push_back({law, order, dilatation == Dilatation::mean ? Treatment::mean : Treatment::pointwise});
      }
      if (!split_volume(law)) continue;
      cases.push_back({law, order, Treatment::mixed});
      cases.push_back({law, order, Treatment::incompressible});
    }
  }
  return cases;
}

/// u = (a Q - I) x, with a rotation Q, or without one.
test::Field similarity(double a, bool rotates) {
  const double c = rotates ? 0.6 : 1.0, s = rotates ? 0.8 : 0.0;
  return [=](const Point& x) {
    return Point{a * (c * x[0] - s * x[1]) - x[0], a * (s * x[0] + c * x[1]) - x[1], (a - 1.0) * x[2]};
  };
}

class Expanding : public ::testing::TestWithParam<Case> {
 protected:
  FreeShape shape(const Expression& stretch) const { return {nullptr, solid_.expansion(stretch)}; }
  /// A stretch that varies in place and time, and fibres that shorten.
  FreeShape varied() const {
    return {solid_.activation(Expression("0.1*sin(2*t)+0.05*x"), FibreField::Kind::varying),
            solid_.expansion(Expression("1.05+0.2*sin(2*t)*(1+0.3*x)+0.1*y*t"))};
  }

  /// Also sets `mixed_`, if the case has pressures.
  std::unique_ptr<ElasticTerm> make(FreeShape shape) {
    const Case& c = GetParam();
    if (!c.has_pressures()) {
      return solid_.elastic(c.law, c.treatment == Treatment::mean ? Dilatation::mean : Dilatation::pointwise, shape);
    }
    VolumeSplit split = *split_volume(c.law);
    if (c.treatment == Treatment::incompressible) split.kappa = std::numeric_limits<double>::infinity();
    auto term = solid_.mixed(make_mixed_law(split), *field_, std::move(shape));
    mixed_ = term.get();
    return term;
  }

  void set_rough_pressures() {
    if (!field_) return;
    {
      const ArrayView p(field_->values());
      for (PetscInt n = 0; n < solid_.layout().num_owned_nodes; ++n) {
        const PetscInt number = field_->layout().of_node[0][static_cast<std::size_t>(n)];
        if (number >= 0) p[number] = 100.0 * (1.0 + test::rough(solid_.layout().position(n), 0, 5));
      }
    }
    update_ghosts(field_->values());
  }

  /// The largest number, over all ranks.
  static double largest(const std::vector<double>& values, PetscInt num_owned) {
    double result = 0.0;
    for (PetscInt i = 0; i < num_owned; ++i) result = std::max(result, std::abs(values[static_cast<std::size_t>(i)]));
    return maximum(comm, result);
  }

  std::vector<double> volume_defects(const Instant& at, const std::vector<double>& q) const {
    std::vector<double> r(static_cast<std::size_t>(field_->layout().num_local), 0.0);
    mixed_->add_pressure_gradient(at, q, r);
    return r;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, BodySpec{GetParam().order, Shape::jittered, 2});
  });
  Solid solid_{comm, file_, GetParam().order, elastic_quadrature_degree(GetParam().law.traits(), GetParam().order)};
  std::unique_ptr<PressureField> field_ = GetParam().has_pressures() ? solid_.pressure_field() : nullptr;
  MixedTerm* mixed_ = nullptr;
  LocalStage stage_{.time = time, .dt = 0.1};
};

INSTANTIATE_TEST_SUITE_P(Laws, Expanding, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

TEST_P(Expanding, AFreeBodyGrowsWithoutStress) {
  const double s = 1.0 + 0.4 * time;
  const auto term = make(shape(Expression("1+0.4*t")));
  const auto q = test::local_values(solid_.vector(similarity(s, !test::is_linear(GetParam().law))).get());
  const PetscInt num_rows = 3 * solid_.layout().num_owned_nodes;
  std::vector<double> r(q.size(), 0.0);
  term->add_gradient(stage_, q, r);
  EXPECT_LE(largest(r, num_rows), 1e-12 * youngs_modulus);
  EXPECT_LE(std::abs(sum(comm, term->energy_at({time}, q, {}))), 1e-13 * youngs_modulus);
  term->stresses({.at = {time}, .q = q}, [&](PetscInt, const CellStress& stress) {
    for (const double component : stress.cauchy) EXPECT_NEAR(component, 0.0, 3e-12 * youngs_modulus);
    EXPECT_NEAR(stress.volume_ratio, s * s * s, 1e-13);
  });
  if (!mixed_) return;
  EXPECT_LE(largest(volume_defects({time}, q), field_->layout().num_owned), 1e-14);
  EXPECT_GT(largest(volume_defects({0.0}, q), field_->layout().num_owned), 1e-4);
}

// The Cauchy stress of the law at F/s; here that of a body compressed to 1/s of its size.
TEST_P(Expanding, AConfinedBodyHasTheStressOfItsLaw) {
  if (GetParam().treatment == Treatment::incompressible) return;  // it cannot be confined
  const double s = 1.0 + 0.4 * time;
  const auto term = make(shape(Expression("1+0.4*t")));
  const auto rest = solid_.vector(test::at_rest);
  if (mixed_) {
    IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, solid_.nothing_prescribed());
    MixedEquation(potential, solid_.layout(), {mixed_}, *field_).settle(rest.get(), {time});
  }
  const auto like = solid_.elastic(GetParam().law);
  const bool is_linear = test::is_linear(GetParam().law);
  const double size = is_linear ? 2.0 - s : 1.0 / s;
  std::vector<CellStress> expected;
  like->stresses({.q = test::local_values(solid_.vector(similarity(size, false)).get())},
                 [&](PetscInt, const CellStress& stress) { expected.push_back(stress); });
  std::size_t n = 0;
  term->stresses({.at = {time}, .q = test::local_values(rest.get())}, [&](PetscInt, const CellStress& stress) {
    const auto& of_law = expected.at(n++).cauchy;
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(stress.cauchy[i], (is_linear ? size * size : 1.0) * of_law[i], 1e-10 * youngs_modulus);
    }
    EXPECT_NEAR(stress.volume_ratio, 1.0, 1e-14);
    EXPECT_LT(stress.cauchy[0], -0.01 * youngs_modulus);
  });
  EXPECT_EQ(n, expected.size());
}

TEST_P(Expanding, SupplyIsTheRateOfTheEnergy) {
  const auto term = make(varied());
  ASSERT_TRUE(term->declaration().depends_on_time);
  set_rough_pressures();
  const auto q = test::local_values(solid_.vector(test::strained).get());
  const auto energy = [&](double t) { return sum(comm, term->energy_at({t}, q, {})); };
  constexpr double h = 1e-4;  // so short that no fibre becomes slack in between
  const double slope =
      (8.0 * (energy(time + h) - energy(time - h)) - (energy(time + 2.0 * h) - energy(time - 2.0 * h))) / (12.0 * h);
  ASSERT_GT(std::abs(slope), 1.0);
  EXPECT_NEAR(sum(comm, term->supply(stage_, q)), slope, 1e-9 * std::max(std::abs(slope), energy(time)));
}

TEST_P(Expanding, DerivativesAreThoseOfTheEnergy) {
  const auto term = make(varied());
  set_rough_pressures();
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, solid_.nothing_prescribed());
  std::unique_ptr<MixedEquation> mixed;
  if (mixed_) {
    mixed = std::make_unique<MixedEquation>(potential, solid_.layout(), std::vector<const MixedTerm*>{mixed_}, *field_);
  }
  StageEquation& equation = mixed ? static_cast<StageEquation&>(*mixed) : potential;
  const TestStage stage(solid_, time, 0.1);
  const auto q = solid_.vector(test::strained), d_of_q = solid_.vector(test::rough_field(0.05, 11));
  Handle<Vec> x = equation.make_vector(), d = equation.make_vector();
  equation.enter(stage.point, q.get(), x.get());
  {
    const ConstArrayView from(d_of_q.get());
    const ArrayView to(d.get());
    const auto num_displacements = static_cast<std::size_t>(3 * solid_.layout().num_owned_nodes);
    for (std::size_t i = 0; i < to.span().size(); ++i) {
      to.span()[i] = i < num_displacements ? from.span()[i] : 0.05 * std::sin(3.0 * static_cast<double>(i));
    }
  }
  const auto moved = [&](double a) {
    Handle<Vec> to;
    check(VecDuplicate(x.get(), to.out()));
    check(VecWAXPY(to.get(), a, d.get(), x.get()));
    return to;
  };
  const auto gradient = [&](double a) {
    Handle<Vec> r = equation.make_vector();
    equation.gradient(moved(a).get(), r.get());
    return r;
  };
  constexpr double h = 1e-3;
  if (!mixed_) {
    const auto value = [&](double a) { return equation.value(moved(a).get()); };
    const double slope = (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
    const auto g = gradient(0.0);
    EXPECT_NEAR(test::dot(g.get(), d.get()), slope, 1e-9 * test::norm(g.get()) * test::norm(d.get()));
  }
  const Handle<Mat> K = equation.make_hessian();
  equation.hessian(x.get(), K.get(), Projection::none);
  const Handle<Vec> Kd = equation.make_vector();
  check(MatMult(K.get(), d.get(), Kd.get()));
  const auto difference = gradient(h);
  check(VecAXPY(difference.get(), -1.0, gradient(-h).get()));
  check(VecScale(difference.get(), 8.0));
  check(VecAXPY(difference.get(), -1.0, gradient(2.0 * h).get()));
  check(VecAXPY(difference.get(), 1.0, gradient(-2.0 * h).get()));
  check(VecScale(difference.get(), 1.0 / (12.0 * h)));
  ASSERT_GT(test::norm(Kd.get()), 1e-2);
  EXPECT_LE(test::distance(Kd.get(), difference.get()), 1e-8 * test::norm(Kd.get()));
}

struct ViscousCase {
  std::string name;
  std::function<std::unique_ptr<EnergyTerm>(const Solid&, std::shared_ptr<const FreeExpansion>)> make;
  bool is_potential = true, has_energy = false, is_exact = false;
};
std::ostream& operator<<(std::ostream& out, const ViscousCase& c) {
  return out << c.name;
}

std::vector<ViscousCase> every_viscous_case() {
  std::vector<ViscousCase> cases;
  for (const auto& law : test::every_viscosity()) {
    const bool has_spring = std::holds_alternative<Maxwell>(law);
    cases.push_back({test::name_of(law), [=](const Solid& solid, auto s) { return solid.viscous(law, s); },
                     test::is_potential(law), has_spring, test::rate_of(law) == StrainRate::exact});
  }
  for (const char* law : {"linear", "neo-hookean"}) {
    cases.push_back({std::string("prony") + (law[0] == 'l' ? "Linear" : "NeoHookean"),
                     [=](const Solid& solid, auto s) {
                       return solid.prony({{0.5, 0.1}, {2.0, 0.02}}, make_law(law, youngs_modulus, 0.3), s);
                     },
                     true, true});
  }
  cases.push_back({"pronyWithoutVolume",
                   [](const Solid& solid, auto s) {
                     return solid.prony({{0.5, 0.1}, {2.0, 0.02}}, test::without_volume("neo-hookean-isochoric"), s);
                   },
                   true, true});
  return cases;
}

/// A viscous body that expands from step to step.
class ViscousExpanding : public ::testing::TestWithParam<ViscousCase> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, BodySpec{2, Shape::jittered, 2});
  });
  Solid solid_{comm, file_, 2, 2};
};

INSTANTIATE_TEST_SUITE_P(Laws, ViscousExpanding, ::testing::ValuesIn(every_viscous_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(ViscousExpanding, DerivativesAndPowers) {
  const auto term = GetParam().make(solid_, solid_.expansion(Expression("1.05+0.2*sin(2*t)*(1+0.3*x)+0.1*y*t")));
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, solid_.nothing_prescribed());
  constexpr double dt = 0.05, h = 1e-3;
  TestStage stage(solid_, time, dt, test::rough_field(0.01, 3), test::rough_field(0.3, 4));
  stage.set_internal(solid_, potential, test::rough_field(0.02, 6));
  potential.begin_stage(stage.point);
  const auto q = solid_.vector(test::strained), d = solid_.vector(test::rough_field(0.05, 11));
  const auto r = potential.make_vector();
  potential.gradient(q.get(), r.get());
  ASSERT_GT(test::norm(r.get()), 1.0);
  const auto gradient = [&](double a) {
    auto g = potential.make_vector();
    potential.gradient(test::moved(q.get(), a, d.get()).get(), g.get());
    return g;
  };
  if (GetParam().is_potential) {
    const auto value = [&](double a) { return potential.value(test::moved(q.get(), a, d.get()).get()); };
    const double slope = (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
    EXPECT_NEAR(test::dot(r.get(), d.get()), slope, 1e-9 * test::norm(r.get()) * test::norm(d.get()));
    const Handle<Mat> K = potential.make_hessian();
    potential.hessian(q.get(), K.get(), Projection::none);
    const auto Kd = potential.make_vector(), difference = gradient(h);
    check(MatMult(K.get(), d.get(), Kd.get()));
    check(VecAXPY(difference.get(), -1.0, gradient(-h).get()));
    check(VecScale(difference.get(), 8.0));
    check(VecAXPY(difference.get(), -1.0, gradient(2.0 * h).get()));
    check(VecAXPY(difference.get(), 1.0, gradient(-2.0 * h).get()));
    check(VecScale(difference.get(), 1.0 / (12.0 * h)));
    EXPECT_LE(test::distance(Kd.get(), difference.get()), 1e-8 * test::norm(Kd.get()));
  }
  const auto at = test::local_values(q.get()), q0 = test::local_values(stage.q0.get()),
             v0 = test::local_values(stage.v0.get());
  const auto num_internal = term->num_internal();
  std::vector<double> z0(num_internal), z(num_internal);
  if (num_internal > 0) {
    const ConstArrayView view(stage.z0.get());
    std::copy(view.span().begin(), view.span().end(), z0.begin());
  }
  const LocalStage local{.time = time, .dt = dt, .q0 = q0, .v0 = v0, .z0 = z0};
  const double supplied = sum(comm, term->supply(local, at));
  ASSERT_GT(std::abs(supplied), 1.0);
  if (GetParam().has_energy) {
    term->end_stage(local, at, z);
    const auto energy = [&](double t) { return sum(comm, term->energy_at({t}, at, z)); };
    const double slope =
        (8.0 * (energy(time + h) - energy(time - h)) - (energy(time + 2.0 * h) - energy(time - 2.0 * h))) / (12.0 * h);
    EXPECT_NEAR(supplied, slope, 1e-8 * std::max(std::abs(slope), energy(time)));
  }
  if (GetParam().is_exact) {  // all power of the forces is lost, or supplied
    auto v = solid_.vector(test::strained);
    check(VecAXPY(v.get(), -1.0, stage.q0.get()));
    check(VecScale(v.get(), 1.0 / dt));
    const double lost = sum(comm, term->dissipation(local, at));
    EXPECT_NEAR(test::dot(r.get(), v.get()) + supplied, lost, 1e-10 * lost);
  }
}

// A stage of backward Euler from one free size to the next: a stress that vanishes as dt^2, or none.
TEST_P(ViscousExpanding, AFreeBodyGrowsWithoutStress) {
  const auto term = GetParam().make(solid_, solid_.expansion(Expression("1+0.4*t")));
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {term.get()}, solid_.nothing_prescribed());
  const auto force = [&](double dt) {
    const auto size = [](double t) { return similarity(1.0 + 0.4 * t, false); };
    TestStage stage(solid_, time, dt, size(time - dt));
    if (Handle<Vec> start = potential.make_internal()) {
      stage.z0 = potential.make_internal();
      potential.internal_variables().complete_step(nullptr, stage.q0.get(), start.get());
      check(VecCopy(start.get(), stage.z0.get()));
      stage.point.z0 = stage.z0.get();
    }
    potential.begin_stage(stage.point);
    const auto r = potential.make_vector();
    potential.gradient(solid_.vector(size(time)).get(), r.get());
    return test::norm(r.get()) * dt;  // a stress over a rate is over dt
  };
  const double far = force(0.02), near = force(0.01);
  EXPECT_LE(far, 1e-2);
  EXPECT_LE(near, std::max(0.26 * far, 1e-11 * youngs_modulus));
}

}  // namespace
}  // namespace pliant::test_expansion
