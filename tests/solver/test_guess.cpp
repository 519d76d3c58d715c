// Which guess a stage starts from, on two unknowns of which one is prescribed.
#include "solver/guess.hpp"
#include "solver/newton_loop.hpp"
#include "solver/small_equation.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_guess {
namespace {

const double infinity = std::numeric_limits<double>::infinity();

/// 1/2 (x - minimum)^2 of the free unknown x, infinite from a barrier on. The prescribed unknown comes second.
class Valley final : public test::SmallEquation {
 public:
  Valley()
      : SmallEquation(MPI_COMM_WORLD, {2,
                                       [this](std::span<const double> x) {
                                         return std::vector{x[0] - minimum, 0.0};
                                       },
                                       [](auto) {
                                         return std::vector{1.0, 0.0, 0.0, 1.0};
                                       }}) {
    if (pliant::rank(MPI_COMM_WORLD) == 0) prescribed_ = {0, 1};
  }
  double value(Vec q) override {
    const double x = free_entry(q);
    return x < barrier ? 0.5 * (x - minimum) * (x - minimum) : infinity;
  }
  bool has_walls() const override { return std::isfinite(wall); }
  double max_step_to_wall(Vec q, Vec d, Walls which) override {
    if (which == Walls::all && obstacle_has_moved_here) return 0.0;
    const double room = wall - free_entry(q), step = free_entry(d);
    return step > room ? room / step : infinity;
  }
  std::vector<std::string> non_potentials() const override { return {}; }
  Symmetry symmetry() const override { return Symmetry::symmetric; }
  const std::vector<char>& prescribed() const override { return prescribed_; }

  static double free_entry(Vec q) { return entry(q, 0); }
  static double entry(Vec q, PetscInt i) {
    const ConstArrayView x(q);
    return pliant::sum(MPI_COMM_WORLD, x.span().empty() ? 0.0 : x.span()[static_cast<std::size_t>(i)]);
  }
  /// (x, y).
  Handle<Vec> at(double x, double y) const {
    Handle<Vec> q = make_vector();
    const ArrayView entries(q.get());  // on ranks without entries too: PETSc keeps norms until it hears of a change
    if (entries.span().empty()) return q;
    entries[0] = x;
    entries[1] = y;
    return q;
  }

  double minimum = 0.0, barrier = infinity;
  double wall = infinity;
  bool obstacle_has_moved_here = false;

 private:
  std::vector<char> prescribed_;
};

class Guesses : public ::testing::Test {
 protected:
  /// From q0 at the velocity v0 of the free unknown, over a second, with a given guess.
  StartingGuess choose(double q0, double v0, double given) {
    const Handle<Vec> start = equation_.at(q0, 0.0), velocity = equation_.at(v0, 5.0);
    StagePoint stage{.dt = 1.0, .q0 = start.get(), .v0 = velocity.get()};
    accepted_ = equation_.at(q0, 0.0);
    if (has_accepted_) stage.accepted = accepted_.get();
    q_ = equation_.at(given, 7.0);
    objective_.begin_stage(stage);
    const StartingGuess guess = guesses_.choose(stage, q_.get());
    EXPECT_EQ(Valley::entry(q_.get(), 1), 7.0);  // as prescribed
    return guess;
  }
  double chosen() const { return Valley::free_entry(q_.get()); }

  Valley equation_;
  SolverStatistics statistics_;
  Objective objective_{equation_, statistics_};
  NewtonLoop loop_{objective_, {}, LinearKind::cholesky, statistics_};
  GuessSearch guesses_{objective_, loop_.system(), statistics_};
  Handle<Vec> q_, accepted_;
  bool has_accepted_ = false;
};

TEST_F(Guesses, AreTheGivenOneOrWhereInertiaLeads) {
  StartingGuess guess = choose(0.0, 3.0, 1.0);
  EXPECT_EQ(chosen(), 1.0);
  EXPECT_EQ(guess.measure, 0.5);
  equation_.minimum = 3.5;
  guess = choose(0.0, 3.0, 1.0);
  EXPECT_EQ(chosen(), 3.0);
  EXPECT_EQ(guess.measure, 0.125);
  EXPECT_FALSE(guess.failure);
  EXPECT_EQ(guesses_.second(), nullptr);
}

TEST_F(Guesses, FallBackOnTheLastSolutionBeyondABarrier) {
  equation_.barrier = 0.5;
  EXPECT_TRUE(choose(1.0, 3.0, 2.0).failure);
  const Handle<Vec> last = equation_.at(0.25, 0.0);
  guesses_.remember(last.get());
  const StartingGuess guess = choose(1.0, 3.0, 2.0);
  EXPECT_FALSE(guess.failure);
  EXPECT_EQ(chosen(), 0.25);
  guesses_.forget();
  EXPECT_TRUE(choose(1.0, 3.0, 2.0).failure);
}

// A wall stands half-way between the accepted state and the given guess.
TEST_F(Guesses, StopShortOfWalls) {
  has_accepted_ = true;
  equation_.wall = 1.0;
  equation_.minimum = 10.0;
  choose(0.0, 0.0, 2.0);
  EXPECT_DOUBLE_EQ(chosen(), 0.9 * 0.5 * 2.0);
  EXPECT_EQ(statistics_.capped_steps, 1);
}

// Bodies do not pass each other where an obstacle leaves no way from the accepted state.
TEST_F(Guesses, StopShortOfWallsThatOnlyAPathShows) {
  has_accepted_ = equation_.obstacle_has_moved_here = true;
  equation_.minimum = 10.0;
  choose(0.0, 0.0, 2.0);
  EXPECT_EQ(chosen(), 2.0);
  equation_.wall = 1.0;
  choose(0.0, 0.0, 2.0);
  EXPECT_LT(chosen(), 1.0);
}

}  // namespace
}  // namespace pliant::test_guess
