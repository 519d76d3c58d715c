#include "app/advice.hpp"

#include "app/input_schema.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Acts at places of the body's surface, not in its volume.
bool is_local(const LoadConfig& load) {
  using Kind = LoadConfig::Kind;
  return load.kind != Kind::gravity && load.kind != Kind::force_density;
}

}  // namespace

std::vector<std::string> doubts_about(const Config& config) {
  std::vector<std::string> doubts;
  const TimeConfig& time = config.time;
  const OutputConfig& output = config.output;
  constexpr double rounding = 1e-9;
  if (time.method.value != static_method && !time.adaptive && output.every &&
      time.step > *output.every * (1.0 + rounding)) {
    doubts.push_back(
        fmt::format("{}: frames are asked for every {} s, but a step takes {} s, and there is one frame per step; "
                    "choose a shorter 'time.step', or leave 'every' out",
                    to_string(output.every_where), format_number(*output.every), format_number(time.step)));
  }
  const std::string extension = std::filesystem::path(config.mesh.file.value).extension().string();
  if (config.mesh.scale == 0.001 && (extension == ".step" || extension == ".stp")) {
    doubts.push_back(
        to_string(config.mesh.file.where) +
        ": a STEP file says its unit and is read in metres; with 'scale: 0.001' the part is a thousandth of what it "
        "was drawn: leave 'scale' out");
  }
  return doubts;
}

std::vector<std::string> doubts_about_loads(const Config& config, const NodeLayout& layout, Selections& selections,
                                            const PrescribedDisplacement& prescribed) {
  const std::vector<char>& is_given = prescribed.flags();
  std::vector<std::string> doubts;
  for (const LoadConfig& load : config.loads) {
    if (!is_local(load)) continue;
    const auto nodes = selections.nodes(load.part);
    const bool moves_here = std::ranges::any_of(nodes, [&](PetscInt n) {
      const auto* node = is_given.data() + 3 * n;
      return std::any_of(node, node + 3, [](char given) { return given == 0; });
    });
    if (any(layout.comm, moves_here)) continue;
    doubts.push_back(
        fmt::format("{}: the load moves nothing, for constraints give the displacement of all that it acts "
                    "on; it changes reactions alone",
                    to_string(load.where)));
  }
  return doubts;
}

}  // namespace pliant
