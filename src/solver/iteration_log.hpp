/// A log of the Newton iterations of a stage, for progress reports and for the post-mortem.
#pragma once

#include "solver/failed_stage.hpp"
#include "solver/statistics.hpp"

#include <chrono>
#include <functional>
#include <utility>
#include <vector>

namespace pliant {

/// The iterations of the stage's last run; the first entry is its start.
class IterationLog {
 public:
  void begin_stage() {
    iterations_.clear();
    start_ = std::chrono::steady_clock::now();
  }
  /// Adds an iteration; a start (`is_start`) begins a new run. Calls the watcher. Collective if the watcher is.
  void note(const NewtonIteration& iteration, double target, bool is_start) {
    if (is_start) iterations_.clear();
    iterations_.push_back(iteration);
    if (!watcher_) return;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_;
    watcher_({seconds.count(), static_cast<int>(iterations_.size()) - 1, iteration.residual, target,
              iteration.linear_iterations});
  }
  void watch(std::function<void(const StageProgress&)> watcher) { watcher_ = std::move(watcher); }

  const std::vector<NewtonIteration>& iterations() const { return iterations_; }

 private:
  std::vector<NewtonIteration> iterations_;
  std::function<void(const StageProgress&)> watcher_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace pliant
