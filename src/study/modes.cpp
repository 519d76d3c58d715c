#include "study/modes.hpp"

#include "base/file.hpp"
#include "input/analysis.hpp"
#include "input/input.hpp"
#include "input/loads.hpp"
#include "model/unknown_counts.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/simulation.hpp"
#include "study/mode_files.hpp"

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

/// Unbalanced forces above this part of all forces are worth a warning.
constexpr double balanced = 1e-5;

/// The static problem of the same bodies and supports without loads, to be taken at the load factor 0; nothing touches
/// there.
Config at_rest(Config config) {
  config.time = {};
  config.time.method.kind = MethodConfig::Static{};
  config.contact.reset();
  std::erase_if(config.loads, [](const LoadConfig& load) { return !foundation_of(load); });
  return config;
}

/// Whether anything may deform the bodies.
bool is_loaded(const Config& config) {
  const auto deforms = [](const BodyConfig& body) { return body.active || body.expansion; };
  return !config.loads.empty() || !config.constraints.empty() || !config.joints.empty() || !config.tendons.empty() ||
         !config.springs.empty() || !config.cavities.empty() || !config.shells.empty() || config.contact ||
         std::ranges::any_of(config.bodies, deforms);
}

/// The input, whose bodies need not be held: their modes about the undeformed state are well defined.
Config read_input_of_modes(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                           ModesOptions& options) {
  Config config = read_input_file(comm, file, changes, Supports::optional);
  if (analysis_of(config) != Analysis::static_equilibrium || options.is_unloaded) return config;
  try {
    (void)read_input_file(comm, file, changes);
  } catch (const InputError& error) {
    if (is_loaded(config)) {
      std::vector<Diagnostic> refused = error.diagnostics();
      refused.front().message += "; to get the modes of the undeformed state, in which bodies may be free: --unloaded";
      throw InputError(std::move(refused));
    }
    options.is_unloaded = true;
  }
  return config;
}

class ModesStudy {
 public:
  ModesStudy(MPI_Comm comm, const Config& given, const ModesOptions& options, Console& console)
      : options_(options),
        console_(console),
        is_loaded_(analysis_of(given) == Analysis::static_equilibrium && !options.is_unloaded),
        config_(is_loaded_ ? given : at_rest(given)),
        // That nothing moves the bodies is as it should be; adding terms, though there are none, keeps it unsaid.
        model_(comm, config_, [](const Model&) { return std::vector<std::unique_ptr<EnergyTerm>>(); }) {
    introduce();
    require_mass(config_, model_);
  }

  ExitCode operator()() {
    const NodeLayout& layout = model_.layout();
    const std::filesystem::path directory = options_.output.empty()
                                                ? std::filesystem::path(config_.output.directory) / "modes"
                                                : std::filesystem::path(options_.output);
    on_root(layout.comm, [&] {
      make_directory(directory);
      if (std::filesystem::exists(directory / "history.csv")) {
        throw FileError(fmt::format("'{}' has the results of a run; give the modes another directory by --output",
                                    directory.string()));
      }
    });
    simulation_.emplace(config_, model_);
    if (is_loaded_) find_equilibrium();
    const StepRecord& record = simulation_->record();
    const Vibration vibration(config_, model_, {record.q, record.z, config_.time.end, record.load_factor});
    if (vibration.imbalance() > balanced) {
      console_.warn(
          fmt::format("{}: the state is not an equilibrium: {:.2g} of the forces are unbalanced; the modes are "
                      "those of its stiffness all the same",
                      config_.file, vibration.imbalance()));
    }
    const Eigenpairs pairs = eigenpairs(vibration.problem());
    const std::vector<Mode> modes = modes_of(vibration, layout, pairs);
    print(vibration, modes);
    write_modes_csv(layout.comm, directory, modes);
    write_mode_frames(directory, config_, model_, record.q, modes);
    console_.print(fmt::format("results: {0}/modes.csv, {0}/result.xdmf", directory.string()));
    for (const auto& option : unused_petsc_options()) {
      console_.warn(fmt::format("no solver used the PETSc option {}; is it misspelt?", option));
    }
    return ExitCode::done;
  }

 private:
  void introduce() {
    const NodeLayout& layout = model_.layout();
    console_.print(fmt::format("{}: {} tetrahedra, {} unknowns, {} rank{}",
                               config_.title.empty() ? config_.file : config_.title, layout.num_global_cells,
                               count_unknowns(config_, model_).all, num_ranks(layout.comm),
                               num_ranks(layout.comm) == 1 ? "" : "s"));
    if (!is_loaded_) return;  // what there is to say is about the static problem that stands for the input
    for (const auto& diagnostic : model_.diagnostics()) console_.report(diagnostic);
  }

  void find_equilibrium() {
    while (!simulation_->finished()) {
      const StepOutcome outcome = simulation_->complete_step();
      if (outcome.is_input_error) throw InputError({config_.file, 0, 0}, outcome.reason);
      if (outcome.kind == StepOutcome::Kind::failed) {
        throw SolveError("no equilibrium to vibrate about: " + simulation_->in_words(outcome));
      }
      console_.progress(fmt::format("load factor {:.6g}", simulation_->record().load_factor));
    }
  }

  Eigenpairs eigenpairs(const EigenProblem& problem) const {
    if (!options_.near) return smallest_eigenpairs(problem, options_.number);
    const double w = 2.0 * std::numbers::pi * *options_.near;
    return nearest_eigenpairs(problem, options_.number, w * w);
  }

  void print(const Vibration& vibration, const std::vector<Mode>& modes) {
    console_.print(fmt::format("modes about the {}; mass {:.6g} kg",
                               is_loaded_ ? "equilibrium under load" : "undeformed state without loads",
                               vibration.mass()));
    for (const std::string& line : mode_table(modes)) console_.print(line);
    const auto count = [&](Mode::Kind kind) { return std::ranges::count(modes, kind, &Mode::kind); };
    if (const auto rigid = count(Mode::Kind::rigid); rigid > 0) {
      console_.print(fmt::format("note: {} at 0 Hz: nothing holds the bodies in these motions", number_of(rigid)));
    }
    if (!vibration.relaxing().empty()) {
      console_.print(
          fmt::format("note: the modes are those of the long-term stiffness: what relaxes ({}) counts neither "
                      "as stiffness nor as damping",
                      fmt::join(vibration.relaxing(), ", ")));
    }
    if (const auto unstable = count(Mode::Kind::unstable); unstable > 0) {
      console_.warn(fmt::format(
          "the state is unstable: {} with the rate in the table; the slightest disturbance makes the body leave it",
          unstable == 1 ? "one mode grows" : fmt::format("{} modes grow", unstable)));
    }
  }

  static std::string number_of(std::ptrdiff_t modes) {
    return modes == 1 ? "one mode" : fmt::format("{} modes", modes);
  }

  ModesOptions options_;
  Console& console_;
  bool is_loaded_;
  Config config_;
  Model model_;
  std::optional<Simulation> simulation_;
};

}  // namespace

ExitCode modes_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                       const ModesOptions& options, Console& console) {
  ModesOptions chosen = options;
  const Config config = read_input_of_modes(comm, file, changes, chosen);
  return ModesStudy(comm, config, chosen, console)();
}

}  // namespace pliant
