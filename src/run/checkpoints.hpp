/// The checkpoints of a run: when they are due, where they are written, which are kept.
#pragma once

#include "base/stopwatch.hpp"
#include "input/config.hpp"
#include "io/checkpoint_file.hpp"
#include "model/model.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace pliant {

/// The checkpoints in a directory, newest first. Not collective.
std::vector<std::filesystem::path> checkpoints_in(const std::filesystem::path& directory);

class Checkpoints {
 public:
  using Keep = std::function<void(Archive&)>;

  /// `config` and `model`, whose terms are set up, outlive the object.
  Checkpoints(const Config& config, Model& model);

  /// Whether a checkpoint is due after this step. The same on every rank.
  bool is_due(std::int64_t step) const;
  /// Whether a checkpoint is due by the clock. Ranks may differ.
  bool is_due_by_clock() const;

  /// Writes the data of `keep` to the output directory, unless the step already has a checkpoint, and keeps the two
  /// newest checkpoints. Throws FileError on every rank. Collective.
  void write(std::int64_t step, double time, const Keep& keep);

  /// Restores the data from an intact file, and removes later checkpoints from its directory. Throws InputError if the
  /// mesh differs. Collective.
  void restore(const std::filesystem::path& file, const CheckpointInfo& info, const Keep& keep);
  /// Removes the checkpoints of an earlier run from the output directory. Collective.
  void remove_all();

  double seconds() const { return seconds_; }

 private:
  using Clock = std::chrono::steady_clock;

  /// Made on first use.
  const ArchiveOrders& orders();
  void remove_after(std::int64_t step);

  const Config& config_;
  Model& model_;
  std::filesystem::path directory_;
  std::unique_ptr<ArchiveOrders> orders_;
  std::optional<std::int64_t> last_step_;
  Clock::time_point last_ = Clock::now();
  double seconds_ = 0.0;
};

}  // namespace pliant
