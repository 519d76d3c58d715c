/// An iteration that does what a test says.
#pragma once

#include "solver/iteration.hpp"

#include <vector>

namespace pliant::test {

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
