// Fibres: derivatives, digits, objectivity, masses, and the same numbers on every number of ranks.
#include "energy/equation/incremental_potential.hpp"
#include "energy/rod/fibres.hpp"
#include "fem/cells.hpp"
#include "mesh/mesh.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_fibres {
namespace {

const std::vector<std::array<double, 3>> curve{{0.0, 0.0, 0.0}, {0.3, 0.0, 0.1}, {0.5, 0.2, 0.0},
                                               {0.6, 0.5, 0.1}, {0.4, 0.7, 0.3}, {0.1, 0.8, 0.2}};
constexpr double mass_of_segment = 2.0;

enum class Acts { elasticity, viscosity };

/// Fibres along the axis of a rod, whose cells have its segments as edges.
class FibresOnCells {
 public:
  explicit FibresOnCells(MPI_Comm comm, int order = 1, Acts acts = Acts::elasticity) {
    AddedRod rod;
    rod.name = "rod";
    rod.points = curve;
    rod.arms = {0.05, 0.03};
    MeshSource source;
    source.added_rods = {rod};
    const Mesh mesh = read_mesh(comm, source);
    layout_ = make_layout(mesh, order);
    pattern_ = std::make_unique<BlockPattern>(layout_);
    std::vector<FibreSegment> segments;
    for (std::size_t s = 1; s < curve.size(); ++s) {
      const Vector3<double> a = curve[s - 1], b = curve[s];
      segments.push_back({{a, b}, norm(b - a), 50.0 + static_cast<double>(s), mass_of_segment, 0.02});
    }
    term_ = std::make_unique<Fibres>(layout_, segments);
    viscosity_ = std::make_unique<FibreViscosity>(layout_, *term_);
    const std::vector<char> prescribed(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0);
    const EnergyTerm* acting =
        acts == Acts::elasticity ? static_cast<const EnergyTerm*>(term_.get()) : viscosity_.get();
    potential_ =
        std::make_unique<IncrementalPotential>(layout_, *pattern_, std::vector<const EnergyTerm*>{acting}, prescribed);
    q0_ = potential_->make_vector();
    v0_ = potential_->make_vector();
    if (acts == Acts::viscosity) check(VecCopy(rough(0.03, 2.2).get(), q0_.get()));
    stage_.dt = 0.1;
    stage_.q0 = q0_.get();
    stage_.v0 = v0_.get();
    potential_->begin_stage(stage_);
  }

  template <class Field>
  Handle<Vec> vector(Field field) const {
    Handle<Vec> x = potential_->make_vector();
    const ArrayView entries(x.get());
    for (PetscInt n = 0; n < layout_.num_owned_nodes; ++n) {
      const Vector3<double> u = field(Vector3<double>(layout_.position(n)));
      for (std::size_t i = 0; i < 3; ++i) entries[3 * n + static_cast<PetscInt>(i)] = u[i];
    }
    return x;
  }
  Handle<Vec> rough(double amount, double phase) const {
    return vector([&](const Vector3<double>& X) {
      return Vector3<double>{amount * std::sin(5.0 * X[0] + 3.0 * X[1] + phase), amount * std::cos(7.0 * X[2] - phase),
                             amount * std::sin(4.0 * X[1] - 6.0 * X[2] + 2.0 * phase)};
    });
  }
  IncrementalPotential& potential() { return *potential_; }
  Vec start() const { return q0_.get(); }
  double dt() const { return stage_.dt; }
  const Fibres& term() const { return *term_; }
  const NodeLayout& layout() const { return layout_; }
  const BlockPattern& pattern() const { return *pattern_; }
  double energy(Vec q) { return potential_->accounts().energies({0.0, 1.0, nullptr}, q, nullptr).front(); }

 private:
  NodeLayout layout_;
  std::unique_ptr<BlockPattern> pattern_;
  std::unique_ptr<Fibres> term_;
  std::unique_ptr<FibreViscosity> viscosity_;
  std::unique_ptr<IncrementalPotential> potential_;
  Handle<Vec> q0_, v0_;
  StagePoint stage_;
};

Handle<Vec> moved(Vec q, double h, Vec d) {
  Handle<Vec> x;
  check(VecDuplicate(q, x.out()));
  check(VecWAXPY(x.get(), h, d, q));
  return x;
}

double size(Vec x) {
  double result = 0.0;
  check(VecNorm(x, NORM_2, &result));
  return result;
}

double product(Vec x, Vec y) {
  double result = 0.0;
  check(VecDot(x, y, &result));
  return result;
}

void expect_hessian_of_differences(IncrementalPotential& potential, Vec q, Vec d) {
  constexpr double h = 1e-6;
  const Handle<Vec> ahead = moved(q, h, d), behind = moved(q, -h, d);
  const Handle<Vec> before = potential.make_vector(), after = potential.make_vector(), y = potential.make_vector();
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q, K.get(), Projection::none);
  check(MatMult(K.get(), d, y.get()));
  potential.gradient(ahead.get(), after.get());
  potential.gradient(behind.get(), before.get());
  check(VecAXPY(after.get(), -1.0, before.get()));
  check(VecScale(after.get(), 0.5 / h));
  ASSERT_GT(size(y.get()), 0.1);
  check(VecAXPY(after.get(), -1.0, y.get()));
  EXPECT_LT(size(after.get()), 1e-7 * size(y.get()));
}

class FibreTerm : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Elements, FibreTerm, ::testing::Values(1, 2),
                         [](const auto& order) { return "P" + std::to_string(order.param); });

TEST_P(FibreTerm, DerivativesAreThoseOfDifferences) {
  FibresOnCells fibres(MPI_COMM_WORLD, GetParam());
  IncrementalPotential& potential = fibres.potential();
  constexpr double h = 1e-6;
  for (const double amount : {0.0, 0.08}) {
    const Handle<Vec> q = fibres.rough(amount, 0.3), d = fibres.rough(1.0, 1.1), r = potential.make_vector();
    const Handle<Vec> ahead = moved(q.get(), h, d.get()), behind = moved(q.get(), -h, d.get());
    potential.gradient(q.get(), r.get());
    if (amount > 0.0) {
      ASSERT_GT(size(r.get()), 1.0);
      const double slope = (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h);
      EXPECT_NEAR(product(r.get(), d.get()), slope, 1e-7 * size(r.get()));
    } else {
      EXPECT_EQ(size(r.get()), 0.0);
    }
    expect_hessian_of_differences(potential, q.get(), d.get());
  }
}

TEST_P(FibreTerm, ViscosityHasTheHessianOfItsForcesAndDissipatesTheirPower) {
  FibresOnCells fibres(MPI_COMM_WORLD, GetParam(), Acts::viscosity);
  IncrementalPotential& potential = fibres.potential();
  const Handle<Vec> q = fibres.rough(0.06, 0.3), d = fibres.rough(1.0, 1.1), r = potential.make_vector();
  expect_hessian_of_differences(potential, q.get(), d.get());
  const Handle<Vec> v = moved(q.get(), -1.0, fibres.start());
  check(VecScale(v.get(), 1.0 / fibres.dt()));
  const TermPower power = potential.accounts().powers(q.get(), v.get(), r.get()).back();
  EXPECT_GT(power.dissipated, 0.01);
  EXPECT_NEAR(-power.exerted, power.dissipated, 1e-11 * power.dissipated);
}

TEST_P(FibreTerm, ProjectedHessianIsPositiveSemidefinite) {
  FibresOnCells fibres(MPI_COMM_WORLD, GetParam());
  const Handle<Vec> q = fibres.vector([](const Vector3<double>& X) { return -0.3 * X; });  // compressed
  const Handle<Vec> y = fibres.potential().make_vector();
  const Handle<Mat> K = fibres.potential().make_hessian();
  const auto lowest = [&](Projection projection) {
    fibres.potential().hessian(q.get(), K.get(), projection);
    double result = 0.0;
    for (int phase = 0; phase < 50; ++phase) {
      const Handle<Vec> d = fibres.rough(1.0, 0.7 * phase);
      check(MatMult(K.get(), d.get(), y.get()));
      result = std::min(result, product(d.get(), y.get()) / product(d.get(), d.get()));
    }
    return result;
  };
  EXPECT_LT(lowest(Projection::none), -0.5);
  EXPECT_GE(lowest(Projection::positive_semidefinite), -1e-9);
}

TEST_P(FibreTerm, RigidMotionsCostNothingAndSmallChangesKeepTheirDigits) {
  FibresOnCells fibres(MPI_COMM_WORLD, GetParam());
  const double angle = 2.5;
  const Vector3<double> axis = unit(Vector3<double>{1.0, -2.0, 0.5}), shift{0.3, -0.2, 4.0};
  const Handle<Vec> turned = fibres.vector([&](const Vector3<double>& X) {
    const Vector3<double> along = dot(axis, X) * axis, across = X - along;
    return along + std::cos(angle) * across + std::sin(angle) * cross(axis, X) + shift - X;
  });
  EXPECT_LT(fibres.energy(turned.get()), 1e-26);
  const Handle<Vec> q = fibres.rough(1e-9, 0.3), less = fibres.rough(1e-10, 0.3);
  ASSERT_GT(fibres.potential().value(q.get()), 0.0);
  EXPECT_NEAR(fibres.potential().value(q.get()) / fibres.potential().value(less.get()), 100.0, 1e-4);
}

TEST(FibreMass, IsThatOfBars) {
  FibresOnCells fibres(MPI_COMM_WORLD);
  const auto& [layout, pattern] = std::pair<const NodeLayout&, const BlockPattern&>(fibres.layout(), fibres.pattern());
  const double total = mass_of_segment * static_cast<double>(curve.size() - 1);
  // A turn about an axis: of bars, and of points at their ends.
  const Vector3<double> omega{0.3, -0.2, 0.5};
  std::vector<double> v;
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    for (const double x : cross(omega, Vector3<double>(layout.position(n)))) v.push_back(x);
  }
  for (const Mass kind : {Mass::consistent, Mass::lumped}) {
    CellGroups<1> none;
    MassMatrix mass = make_mass_matrix<1>(layout, pattern, none, {}, Mass::consistent);
    fibres.term().add_masses(pattern, kind, mass);
    EXPECT_NEAR(sum(MPI_COMM_WORLD, mass.total()), total, 1e-12 * total);
    double expected = 0.0;
    for (std::size_t s = 1; s < curve.size(); ++s) {
      const Vector3<double> a = cross(omega, Vector3<double>(curve[s - 1])),
                            b = cross(omega, Vector3<double>(curve[s]));
      const double of_bar = (dot(a, a) + dot(a, b) + dot(b, b)) / 3.0, of_points = (dot(a, a) + dot(b, b)) / 2.0;
      expected += 0.5 * mass_of_segment * (kind == Mass::lumped ? of_points : of_bar);
    }
    EXPECT_NEAR(sum(MPI_COMM_WORLD, 0.5 * mass.product(v, v)), expected, 1e-12 * expected);
  }
  double weight = 0.0;
  for (const MassAtNode& at : fibres.term().masses(std::vector<char>(curve.size() - 1, 1))) weight += at.mass;
  EXPECT_NEAR(sum(MPI_COMM_WORLD, weight), total, 1e-12 * total);
}

TEST_P(FibreTerm, NumbersAreThoseOfOneRank) {
  const auto numbers = [](MPI_Comm comm) {
    FibresOnCells fibres(comm, GetParam());
    const Handle<Vec> q = fibres.rough(0.08, 0.3), d = fibres.rough(1.0, 1.1), r = fibres.potential().make_vector(),
                      y = fibres.potential().make_vector();
    fibres.potential().gradient(q.get(), r.get());
    const Handle<Mat> K = fibres.potential().make_hessian();
    fibres.potential().hessian(q.get(), K.get(), Projection::positive_semidefinite);
    check(MatMult(K.get(), d.get(), y.get()));
    return std::vector{fibres.potential().value(q.get()), fibres.energy(q.get()), size(r.get()),
                       product(r.get(), d.get()), size(y.get())};
  };
  const auto here = numbers(MPI_COMM_WORLD), alone = numbers(MPI_COMM_SELF);
  for (std::size_t k = 0; k < here.size(); ++k) EXPECT_NEAR(here[k], alone[k], 1e-12 * std::abs(alone[k])) << k;
}

}  // namespace
}  // namespace pliant::test_fibres
