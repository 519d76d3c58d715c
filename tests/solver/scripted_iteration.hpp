/// An iteration that does what a test says.
#pragma once

#include "solver/iteration.hpp"
#include "solver/small_equation.hpp"

#include <string>
#include <utility>
#include <vector>

namespace pliant::test {

/// An equation that is asked for nothing but its kind: with a potential, or with the names of what has none.
class AnyEquation final : public SmallEquation {
 public:
  AnyEquation(std::vector<std::string> non_potentials, bool is_static)
      : SmallEquation(MPI_COMM_WORLD,
                      {1, [](auto) { return std::vector{1.0}; }, [](auto) { return std::vector{1.0}; }}),
        non_potentials_(std::move(non_potentials)),
        is_static_(is_static) {}
  std::vector<std::string> non_potentials() const override { return non_potentials_; }
  Symmetry symmetry() const override {
    return non_potentials_.empty() ? Symmetry::symmetric : SmallEquation::symmetry();
  }
  bool is_static() const override { return is_static_; }

 private:
  std::vector<std::string> non_potentials_;
  bool is_static_;
};

/// Runs that do what the test says, and what was asked of them.
class Script final : public Iteration {
 public:
  struct Run {
    Aim aim;
    int limit;
  };
  explicit Script(Objective& objective) : objective_(objective) {}

  void begin(Vec, Aim aim) override { objective_.set_aim(aim); }
  void begin_again(Vec) override {}
  StageReport run(Vec) override { return {}; }
  StageReport run(Vec, int limit) override {
    runs.push_back({objective_.aim(), limit});
    const bool fails = runs.size() <= failures;
    return {fails ? StageOutcome::retry : StageOutcome::converged, "", fails ? limit : 3, 2};
  }
  bool is_converging() const override { return converges; }
  bool is_stable(Vec /*q*/) override { return finds_minimum; }
  void renew_factor() override { ++renewed; }
  double stiffness(Vec) override { return 1.0; }
  void accept(double residual) override { accepted = residual; }

  std::vector<Aim> aims() const {
    std::vector<Aim> result;
    for (const Run& run : runs) result.push_back(run.aim);
    return result;
  }

  std::size_t failures = 0;  // of the first runs
  bool finds_minimum = true, converges = false;
  std::vector<Run> runs;
  int renewed = 0;
  double accepted = 0.0;

 private:
  Objective& objective_;
};

}  // namespace pliant::test
