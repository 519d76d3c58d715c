// Fibres: derivatives, digits, objectivity, masses, and the same numbers on every number of ranks.
#include "energy/rod/fibres.hpp"
#include "energy/rod/term_on_rod.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_fibres {
namespace {

using namespace on_rod;  // NOLINT(google-build-using-namespace)

constexpr double mass_of_segment = 2.0;

/// Fibres along the axis of a rod, whose cells have its segments as edges.
class FibresOnCells : public TermOnRod {
 public:
  explicit FibresOnCells(MPI_Comm comm, int order = 1, Acts acts = Acts::elasticity) : TermOnRod(comm, order, rod()) {
    std::vector<FibreSegment> segments;
    for (std::size_t s = 1; s < bent_curve.size(); ++s) {
      const Vector3<double> a = bent_curve[s - 1], b = bent_curve[s];
      segments.push_back({{a, b}, norm(b - a), 50.0 + static_cast<double>(s), mass_of_segment, 0.02});
    }
    term_ = std::make_unique<Fibres>(layout(), segments);
    viscosity_ = std::make_unique<FibreViscosity>(layout(), *term_);
    act(acts == Acts::elasticity ? static_cast<const EnergyTerm&>(*term_) : *viscosity_, acts);
  }
  const Fibres& term() const { return *term_; }

 private:
  std::unique_ptr<Fibres> term_;
  std::unique_ptr<FibreViscosity> viscosity_;
};

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
    expect_hessian_of_differences(potential, q.get(), d.get(), 0.1);
  }
}

TEST_P(FibreTerm, ViscosityHasTheHessianOfItsForcesAndDissipatesTheirPower) {
  FibresOnCells fibres(MPI_COMM_WORLD, GetParam(), Acts::viscosity);
  expect_dissipation(fibres);
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
  const double total = mass_of_segment * static_cast<double>(bent_curve.size() - 1);
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
    for (std::size_t s = 1; s < bent_curve.size(); ++s) {
      const Vector3<double> a = cross(omega, Vector3<double>(bent_curve[s - 1])),
                            b = cross(omega, Vector3<double>(bent_curve[s]));
      const double of_bar = (dot(a, a) + dot(a, b) + dot(b, b)) / 3.0, of_points = (dot(a, a) + dot(b, b)) / 2.0;
      expected += 0.5 * mass_of_segment * (kind == Mass::lumped ? of_points : of_bar);
    }
    EXPECT_NEAR(sum(MPI_COMM_WORLD, 0.5 * mass.product(v, v)), expected, 1e-12 * expected);
  }
  double weight = 0.0;
  for (const MassAtNode& at : fibres.term().masses(std::vector<char>(bent_curve.size() - 1, 1))) weight += at.mass;
  EXPECT_NEAR(sum(MPI_COMM_WORLD, weight), total, 1e-12 * total);
}

TEST_P(FibreTerm, NumbersAreThoseOfOneRank) {
  FibresOnCells here(MPI_COMM_WORLD, GetParam()), alone(MPI_COMM_SELF, GetParam());
  const std::vector<double> numbers = numbers_of(here), expected = numbers_of(alone);
  for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_NEAR(numbers[k], expected[k], 1e-12 * std::abs(expected[k]));
}

}  // namespace
}  // namespace pliant::test_fibres
