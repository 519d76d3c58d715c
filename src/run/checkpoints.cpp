#include "run/checkpoints.hpp"

#include "energy/volume/internal_keys.hpp"
#include "fem/entry_keys.hpp"
#include "input/input.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/version.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t num_kept = 2;
constexpr std::string_view prefix = "checkpoint-", suffix = ".h5";

/// The step of a checkpoint, from its name; nullopt if the name is not that of a checkpoint.
std::optional<std::int64_t> step_of(const fs::path& file) {
  const std::string name = file.filename().string();
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return std::nullopt;
  std::int64_t step = 0;
  const char* const end = name.data() + name.size() - suffix.size();
  const auto parsed = std::from_chars(name.data() + prefix.size(), end, step);
  return parsed.ec == std::errc{} && parsed.ptr == end ? std::optional(step) : std::nullopt;
}

std::string fingerprint_of(const Model& model) {
  return fmt::format("{:016x}", model.mesh_fingerprint());
}

}  // namespace

std::vector<fs::path> checkpoints_in(const fs::path& directory) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    if (step_of(entry->path())) found.push_back(entry->path());
  }
  std::ranges::sort(found, std::ranges::greater{}, [](const fs::path& file) { return *step_of(file); });
  return found;
}

Checkpoints::Checkpoints(const Config& config, Model& model)
    : config_(config), model_(model), directory_(config.output.directory) {}

const ArchiveOrders& Checkpoints::orders() {
  if (orders_) return *orders_;
  const MPI_Comm comm = model_.layout().comm;
  const MixedEquation* mixed = model_.mixed_equation();
  const auto of_pressures =
      mixed != nullptr ? pressure_keys(model_.layout(), mixed->pressure_layout()) : std::vector<EntryKey>{};
  const auto terms = model_.potential().terms();
  orders_ = std::make_unique<ArchiveOrders>(ArchiveOrders{{comm, node_keys(model_.layout())},
                                                          {comm, internal_keys(model_.layout(), terms)},
                                                          {comm, of_pressures},
                                                          internal_components(terms)});
  return *orders_;
}

bool Checkpoints::is_due(std::int64_t step) const {
  return config_.checkpoint && config_.checkpoint->every && step % *config_.checkpoint->every == 0;
}

bool Checkpoints::is_due_by_clock() const {
  if (!config_.checkpoint || !config_.checkpoint->minutes) return false;
  return std::chrono::duration<double, std::ratio<60>>(Clock::now() - last_).count() >= *config_.checkpoint->minutes;
}

void Checkpoints::write(std::int64_t step, double time, const Keep& keep) {
  if (last_step_ == step) return;
  const Stopwatch watch(seconds_);
  const MPI_Comm comm = model_.layout().comm;
  CheckpointWriter writer(comm, orders());
  keep(writer);
  writer.write(directory_ / fmt::format("{}{:06}{}", prefix, step, suffix),
               {step, time, config_.title, dump(config_), fingerprint_of(model_), version_text(), petsc_options(),
                num_ranks(comm)});
  last_step_ = step;
  last_ = Clock::now();
  on_root(comm, [&] {
    const auto files = checkpoints_in(directory_);
    std::error_code ignored;
    for (std::size_t i = num_kept; i < files.size(); ++i) fs::remove(files[i], ignored);
  });
}

void Checkpoints::restore(const fs::path& file, const CheckpointInfo& info, const Keep& keep) {
  if (fingerprint_of(model_) != info.mesh) {
    throw InputError(
        config_.mesh.file.where,
        fmt::format("the mesh '{}' differs from the one with which '{}' was written; restore that mesh, or start "
                    "again with `pliant run`",
                    config_.mesh.file.value, file.string()));
  }
  CheckpointReader reader(model_.layout().comm, file, orders());
  keep(reader);
  std::error_code ignored;
  if (fs::equivalent(file.has_parent_path() ? file.parent_path() : ".", directory_, ignored)) last_step_ = info.step;
  remove_after(info.step);
}

void Checkpoints::remove_all() {
  remove_after(-1);
}

void Checkpoints::remove_after(std::int64_t step) {
  on_root(model_.layout().comm, [&] {
    std::error_code ignored;
    for (const auto& file : checkpoints_in(directory_)) {
      if (*step_of(file) > step) fs::remove(file, ignored);
    }
  });
}

}  // namespace pliant
