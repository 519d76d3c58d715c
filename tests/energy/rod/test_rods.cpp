// Rods: derivatives, digits, objectivity, masses, and the same numbers on every number of ranks.
#include "energy/rod/rod_viscosity.hpp"
#include "energy/rod/term_on_rod.hpp"
#include "energy/solid.hpp"
#include "mesh/rod_chain.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_rods {
namespace {

using namespace on_rod;  // NOLINT(google-build-using-namespace)

constexpr double mass_of_segment = 2.0;

/// A bent rod whose first section is held: segment 0 is that section.
class BentRod : public TermOnRod {
 public:
  explicit BentRod(MPI_Comm comm, int order = 1, Acts acts = Acts::elasticity) : BentRod(comm, order, acts, held()) {}
  const Rods& term() const { return *term_; }

 private:
  static AddedRod held() {
    AddedRod result = rod();
    result.up = {0.1, 0.2, 1.0};
    result.has_end = {true, false};
    return result;
  }
  BentRod(MPI_Comm comm, int order, Acts acts, const AddedRod& rod) : TermOnRod(comm, order, rod) {
    const RodChain chain = rod_chain(rod, rod.points);
    std::vector<RodSegment> segments;
    std::vector<RodVertex> vertices;
    const auto add = [&](const CornerPlaces& corners, double length) {
      RodSegment& segment = segments.emplace_back();
      std::ranges::copy(corners, segment.corners.begin());
      segment.length = length;
      if (length == 0.0) return;
      segment.axial = 50.0;
      segment.distortion = 20.0;
      segment.mass = mass_of_segment;
      segment.second_moments = {0.01, 0.003, 0.002};
      segment.damping = 0.02;
    };
    add(*chain.ends[0], 0.0);
    for (const CornerPlaces& corners : chain.segments) {
      add(corners, norm(Vector3<double>(corners[1]) - Vector3<double>(corners[0])));
      vertices.push_back(
          {segments.size() - 2, 0.1 + 0.05 * static_cast<double>(vertices.size()), {1.3, 0.7}, 0.9, 0.03});
    }
    // The section is the first segment, and the last cell.
    const auto last = static_cast<std::int64_t>(chain.segments.size());
    std::vector<std::ptrdiff_t> segment_of_cell;
    for (const std::int64_t number : layout().cell_numbers)
      segment_of_cell.push_back(number == last ? 0 : static_cast<std::ptrdiff_t>(number) + 1);
    term_ = std::make_unique<Rods>(layout(), segment_of_cell, std::move(segments), std::move(vertices));
    viscosity_ = std::make_unique<RodViscosity>(*term_);
    act(acts == Acts::elasticity ? static_cast<const EnergyTerm&>(*term_) : *viscosity_, acts);
  }

  std::unique_ptr<Rods> term_;
  std::unique_ptr<RodViscosity> viscosity_;
};

class RodTerm : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Elements, RodTerm, ::testing::Values(1, 2),
                         [](const auto& order) { return "P" + std::to_string(order.param); });

TEST_P(RodTerm, DerivativesAreThoseOfDifferences) {
  BentRod rod(MPI_COMM_WORLD, GetParam());
  IncrementalPotential& potential = rod.potential();
  constexpr double h = 1e-6;
  for (const double amount : {0.0, 0.02, 0.08}) {
    const Handle<Vec> q = rod.rough(amount, 0.3), d = rod.rough(1.0, 1.1);
    const Handle<Vec> ahead = moved(q.get(), h, d.get()), behind = moved(q.get(), -h, d.get());
    const Handle<Vec> r = potential.make_vector();
    potential.gradient(q.get(), r.get());
    if (amount > 0.0) {
      ASSERT_GT(size(r.get()), 1.0);
      const double slope = (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h);
      EXPECT_NEAR(product(r.get(), d.get()), slope, 1e-7 * size(r.get()));
    } else {
      EXPECT_LT(size(r.get()), 1e-11);  // at rest in the given bent_curve
    }
    expect_hessian_of_differences(potential, q.get(), d.get(), 1.0);
  }
}

TEST_P(RodTerm, ViscosityHasTheHessianOfItsForcesAndDissipatesTheirPower) {
  BentRod rod(MPI_COMM_WORLD, GetParam(), Acts::viscosity);
  expect_dissipation(rod);
}

TEST_P(RodTerm, ProjectedHessianIsPositiveSemidefinite) {
  BentRod rod(MPI_COMM_WORLD, GetParam());
  const Handle<Vec> q = rod.rough(0.15, 0.3), y = rod.potential().make_vector();
  const Handle<Mat> K = rod.potential().make_hessian();
  double lowest = 0.0;
  for (const Projection projection : {Projection::none, Projection::positive_semidefinite}) {
    rod.potential().hessian(q.get(), K.get(), projection);
    lowest = 0.0;
    for (int phase = 0; phase < 200; ++phase) {
      const Handle<Vec> d = rod.rough(1.0, 0.7 * phase);
      check(MatMult(K.get(), d.get(), y.get()));
      lowest = std::min(lowest, product(d.get(), y.get()) / product(d.get(), d.get()));
    }
  }
  EXPECT_GE(lowest, -1e-9);
}

TEST_P(RodTerm, RigidMotionsCostNothing) {
  BentRod rod(MPI_COMM_WORLD, GetParam());
  // x = R X + c by half a turn and more, so that no frame of the start is near.
  const double angle = 2.5;
  const Vector3<double> axis = unit(Vector3<double>{1.0, -2.0, 0.5}), shift{0.3, -0.2, 4.0};
  const Handle<Vec> q = rod.vector([&](const Vector3<double>& X) {
    const Vector3<double> along = dot(axis, X) * axis, across = X - along;
    return along + std::cos(angle) * across + std::sin(angle) * cross(axis, X) + shift - X;
  });
  const Handle<Vec> r = rod.potential().make_vector();
  rod.potential().gradient(q.get(), r.get());
  EXPECT_LT(size(r.get()), 1e-10);  // rounding of 4 m over arms of 3 cm
  EXPECT_LT(rod.energy(q.get()), 1e-24);
}

TEST_P(RodTerm, SmallChangesKeepTheirDigits) {
  BentRod rod(MPI_COMM_WORLD, GetParam());
  const Handle<Vec> q = rod.rough(1e-9, 0.3);
  const double value = rod.potential().value(q.get()), tenth = [&] {
    const Handle<Vec> less = rod.rough(1e-10, 0.3);
    return rod.potential().value(less.get());
  }();
  ASSERT_GT(value, 0.0);
  EXPECT_NEAR(value / tenth, 100.0, 1e-4);
}

TEST(RodMass, IsThatOfTheRod) {
  BentRod rod(MPI_COMM_WORLD);
  const auto& [layout, pattern] = std::pair<const NodeLayout&, const BlockPattern&>(rod.layout(), rod.pattern());
  CellGroups<1> none;
  MassMatrix mass = make_mass_matrix<1>(layout, pattern, none, {}, Mass::consistent);
  rod.term().add_masses(pattern, mass);
  const double total = mass_of_segment * static_cast<double>(bent_curve.size() - 1);
  EXPECT_NEAR(sum(MPI_COMM_WORLD, mass.total()), total, 1e-12 * total);
  double weight = 0.0;
  for (const MassAtNode& at : rod.term().masses(std::vector<char>(rod.term().num_segments(), 1))) weight += at.mass;
  EXPECT_NEAR(sum(MPI_COMM_WORLD, weight), total, 1e-12 * total);
  // A turn about an axis has the kinetic energy of the second moments: those of points and of sections.
  const Vector3<double> omega{0.3, -0.2, 0.5};
  std::vector<double> v;
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
    for (const double x : cross(omega, Vector3<double>(layout.position(n)))) v.push_back(x);
  }
  double expected = 0.0;
  for (std::size_t s = 1; s < bent_curve.size(); ++s) {
    const Vector3<double> a = bent_curve[s - 1], b = bent_curve[s], t = unit(b - a);
    const Vector3<double> up = unit(Vector3<double>{0.1, 0.2, 1.0}), d = unit(up - dot(up, t) * t);
    const auto square = [&](const Vector3<double>& x) { return dot(cross(omega, x), cross(omega, x)); };
    expected += 0.5 * (mass_of_segment * square(0.5 * (a + b)) + 0.01 * square(t) + 0.003 * square(d) +
                       0.002 * square(cross(t, d)));
  }
  EXPECT_NEAR(sum(MPI_COMM_WORLD, 0.5 * mass.product(v, v)), expected, 1e-12 * expected);
}

TEST_P(RodTerm, NumbersAreThoseOfOneRank) {
  BentRod here(MPI_COMM_WORLD, GetParam()), alone(MPI_COMM_SELF, GetParam());
  const std::vector<double> numbers = numbers_of(here), expected = numbers_of(alone);
  for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_NEAR(numbers[k], expected[k], 1e-12 * std::abs(expected[k]));
}

}  // namespace
}  // namespace pliant::test_rods
