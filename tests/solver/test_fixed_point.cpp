// Anderson's mixing: fast where a map is nearly linear, and no worse than plain iteration where it is not.
#include "petsc/array_view.hpp"
#include "solver/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace pliant::test_fixed_point {
namespace {

constexpr PetscInt num_entries = 40;  // of each rank

Handle<Vec> zero() {
  Handle<Vec> x;
  check(VecCreateMPI(MPI_COMM_WORLD, num_entries, PETSC_DECIDE, x.out()));
  return x;
}

/// Rounds until |g(x) - x| is a 1e-10 of its first size.
int rounds_of(const std::function<double(PetscInt, double)>& g) {
  const Handle<Vec> x = zero(), image = zero(), f = zero();
  FixedPoint rounds(x.get());
  double first = 0.0;
  for (int round = 0; round < 1000; ++round) {
    {
      const ArrayView to(image.get());
      const ConstArrayView from(x.get());
      for (PetscInt i = 0; i < num_entries; ++i) to[i] = g(i, from[i]);
    }
    PetscReal size = 0.0;
    check(VecWAXPY(f.get(), -1.0, x.get(), image.get()));
    check(VecNorm(f.get(), NORM_2, &size));
    if (round == 0) first = size;
    if (size <= 1e-10 * first) return round;
    check(VecWAXPY(x.get(), 1.0, rounds.step(image.get()), image.get()));
    rounds.take(x.get());
  }
  return 1000;
}

TEST(FixedPoint, OfALinearMapOfFewRatesTakesAsManyRounds) {
  // Plain iteration: log 1e-10 / log 0.9 = 219.
  EXPECT_LE(rounds_of([](PetscInt i, double x) { return 1.0 + (i % 3 == 0 ? 0.9 : i % 3 == 1 ? -0.5 : 0.2) * x; }), 5);
}

TEST(FixedPoint, OfACurvedMapIsFoundFast) {
  EXPECT_LE(rounds_of([](PetscInt i, double x) { return std::cos(x + 0.02 * static_cast<double>(i)); }), 15);
}

TEST(FixedPoint, OfAMapThatGoesAwayIsFoundAllTheSame) {
  EXPECT_LE(rounds_of([](PetscInt i, double x) { return 1.0 - (i % 2 == 0 ? 1.5 : 0.3) * x; }), 8);
}

/// Plain iteration goes to and fro for ever.
TEST(FixedPoint, OfAMapWithKinksIsFoundAllTheSame) {
  const auto kink = [](PetscInt i, double x) {
    return std::cos(1.7 * static_cast<double>(i)) - 3.0 * std::max(x, 0.0);
  };
  EXPECT_LE(rounds_of(kink), 15);
  const auto bend = [](PetscInt i, double x) { return std::cos(static_cast<double>(i)) - 1.5 * std::tanh(4.0 * x); };
  EXPECT_LE(rounds_of(bend), 45);
}

}  // namespace
}  // namespace pliant::test_fixed_point
