// The predicted acceleration decides the work, not the result; how close it comes is checked here.
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_stage_predictor {
namespace {

using test::Ode;

constexpr double dt = 0.1;

class StagePrediction : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, StagePrediction, test::every_method(), test::method_name);

/// Entries that vibrate, each at one of two frequencies [1/s].
Ode two_modes(double omega_a, double omega_b) {
  return {[=](double, std::span<const double> q, std::span<const double>, std::size_t k) {
            const double omega = k % 2 == 0 ? omega_a : omega_b;
            return -omega * omega * q[k];
          },
          {{1.0, 0.5, -0.3, 0.8}, {0.0, 1.0, 0.7, -0.2}},
          {}};
}

/// Largest distance of the guesses from the solutions over dt_i^2, for each stage of each step.
struct Guesses {
  std::map<int, double> errors;  // by the number of the stage, counted through
  StageSolve watch(const Ode& ode) {
    return [this, inner = test::newton(ode), number = 0](const StagePoint& stage, Vec q) mutable {
      const auto guess = test::values_of(q);
      const StageReport report = inner(stage, q);
      const auto solution = test::values_of(q);
      double error = 0.0;
      for (std::size_t k = 0; k < guess.size(); ++k) error = std::max(error, std::abs(guess[k] - solution[k]));
      errors[number++] = error / (stage.dt * stage.dt);
      return report;
    };
  }
  /// Largest error of the last step.
  double last(int num_stages) const {
    double largest = 0.0;
    int n = 0;
    for (auto it = errors.rbegin(); n < num_stages; ++it, ++n) largest = std::max(largest, it->second);
    return largest;
  }
};

Guesses guesses_of(const Method& method, const Ode& ode, const std::vector<double>& times, Guess guess) {
  Guesses guesses;
  System system = test::system_of(ode, guess);
  system.solve = guesses.watch(ode);
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  Integrator integrator({method, Startup::dirk33}, system, {0.0, q.get(), v.get()});
  for (const double time : times) integrator.accept(integrator.attempt({time, time - integrator.state().time}));
  return guesses;
}

// The polynomial through four accelerations is of third degree, and that through three velocities of second.
TEST_P(StagePrediction, FollowsSmoothMotionWithHighOrder) {
  const Ode ode = two_modes(0.5, 1.0);
  const auto error = [&](double step) {
    std::vector<double> times;
    for (int i = 1; i <= 12; ++i) times.push_back(i * step);
    return guesses_of(GetParam(), ode, times, Guess::predicted).last(GetParam().num_stages);
  };
  EXPECT_GT(std::log2(error(0.05) / error(0.025)), 3.5);
}

// A short history, changing steps and a start anew all lead to a guess that is no worse than that of inertia alone.
TEST_P(StagePrediction, IsBetterThanInertiaFromTheThirdStepOn) {
  if (GetParam().needs_equal_steps || GetParam().symplectic) GTEST_SKIP() << "its steps do not change";
  std::vector<double> times;
  for (int i = 0; i < 25; ++i) times.push_back((times.empty() ? 0.0 : times.back()) + (i % 4 == 3 ? 0.04 : 0.05));
  const Ode ode = two_modes(1.0, 2.0);
  const auto predicted = guesses_of(GetParam(), ode, times, Guess::predicted);
  const auto inertial = guesses_of(GetParam(), ode, times, Guess::extrapolated);
  ASSERT_EQ(predicted.errors.size(), inertial.errors.size());
  for (const auto& [number, error] : predicted.errors) {
    if (number >= 3 * 3) {
      EXPECT_LT(error, 0.5 * inertial.errors.at(number)) << "stage " << number;
    }
  }
}

// What a failed attempt saw is forgotten.
TEST_P(StagePrediction, LearnsOnlyFromAcceptedSteps) {
  const Ode ode = two_modes(1.0, 2.0);
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  std::array<Guesses, 2> guesses;
  for (const bool tries : {false, true}) {
    System system = test::system_of(ode, Guess::predicted);
    system.solve = guesses[tries].watch(ode);
    Integrator integrator({GetParam(), Startup::dirk33}, system, {0.0, q.get(), v.get()});
    std::map<int, double> accepted;
    for (int i = 1; i <= 8; ++i) {
      if (tries) integrator.attempt({(i + 1) * dt, 2.0 * dt});
      const auto before = guesses[tries].errors.size();
      integrator.accept(integrator.attempt({i * dt, dt}));
      for (auto k = before; k < guesses[tries].errors.size(); ++k) {
        accepted.emplace(static_cast<int>(accepted.size()), guesses[tries].errors.at(static_cast<int>(k)));
      }
    }
    guesses[tries].errors = accepted;
  }
  EXPECT_EQ(guesses[0].errors, guesses[1].errors);
}

}  // namespace
}  // namespace pliant::test_stage_predictor
