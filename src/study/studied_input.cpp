#include "study/studied_input.hpp"

#include "input/analysis.hpp"

#include <algorithm>

namespace pliant {
namespace {

constexpr double newton_tolerance = 1e-11;  // so that the error of Newton's method is far below that in time

/// Throws InputError where nothing converges, or nothing can be compared.
void require_convergence(const Config& config, Refine refine) {
  const Analysis analysis = analysis_of(config);
  if (refine != Refine::space && analysis == Analysis::static_equilibrium) {
    throw InputError(config.time.method.where, "a static problem has no convergence in time; use --in space");
  }
  if (config.time.path) {
    throw InputError(config.time.path->where,
                     "steps along a path end elsewhere on each mesh, so that there is nothing to compare; remove "
                     "'path', or run the input on several meshes and compare limit points");
  }
  if (refine == Refine::space && !config.rods.empty()) {
    throw InputError(
        config.rods.front().where,
        "rods cannot be refined with the mesh: run the input with other `segments` or `size`, or with another "
        "`mesh.size` where they follow curves, and compare what the histories end with");
  }
  const bool has_mesh = !config.mesh.file.value.empty() || !config.shells.empty();
  if (refine == Refine::space && !has_mesh) {
    throw InputError({config.file, 0, 0},
                     "the input has only rigid bodies, so refining a mesh changes nothing; use `--in time`");
  }
  if (refine == Refine::tolerance && !config.time.adaptive) {
    throw InputError(config.time.method.where, "a study by tolerance needs `adaptive` in time");
  }
}

}  // namespace

std::vector<Config> read_studied_inputs(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                                        const StudyOptions& options) {
  std::vector<std::string> names;
  for (const auto& name : options.methods) {
    if (name != "all") names.push_back(name);
    for (const auto& m : methods()) {
      if (name == "all") names.push_back(m.name);
    }
  }
  std::vector<Config> configs;
  if (names.empty()) configs.push_back(read_input_file(comm, file, overrides));
  for (const auto& name : names) {
    auto with_method = overrides;
    with_method.push_back({"time.method", name});
    configs.push_back(read_input_file(comm, file, with_method));
  }
  for (Config& config : configs) {
    require_convergence(config, options.refine);
    if (options.refine == Refine::time) config.time.adaptive.reset();
    config.time.startup = Startup::dirk33;
    config.solver.newton.relative = std::min(config.solver.newton.relative, newton_tolerance);
  }
  return configs;
}

}  // namespace pliant
