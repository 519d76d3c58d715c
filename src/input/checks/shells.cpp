#include "input/checks/shells.hpp"

#include "input/analysis.hpp"
#include "input/checks/output.hpp"
#include "input/elasticity.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

void check_elasticity(const ShellConfig& shell, Diagnostics& diagnostics) {
  const ElasticityConfig& elasticity = shell.elasticity;
  const auto refuse_data = [&](const auto& given) {
    if (given.cell_data.empty()) return;
    diagnostics.add(given.where, fmt::format("'{}' of shell '{}' is data of cells, and facets have none: give a number "
                                             "or a formula of x, y, z",
                                             given.key, shell.name));
  };
  std::ranges::for_each(elasticity.constants, refuse_data);
  std::ranges::for_each(elasticity.directions, refuse_data);
  if (shell.bends && has_fibres(elasticity)) {
    diagnostics.add(elasticity.where,
                    fmt::format("shell '{}' bends, which needs the two moduli of an isotropic law, and a law with "
                                "fibres has more: choose another law, or 'bending: false'",
                                shell.name));
  }
  if (elasticity.incompressible) {
    diagnostics.add(elasticity.where,
                    fmt::format("the thickness of shell '{}' follows from its law, which therefore must be "
                                "compressible: instead of 'incompressible' give a Poisson's ratio such as 0.4999; "
                                "plane stress does not lock",
                                shell.name));
  }
}

void check_prestretch(const ShellConfig& shell, Diagnostics& diagnostics) {
  const std::size_t count = shell.prestretch.size();
  if (count > 2) {
    diagnostics.add(shell.where, fmt::format("the prestretch of shell '{}' is one number, or two along and across "
                                             "'direction', not {}",
                                             shell.name, count));
  }
  if (count == 2 && !shell.direction) {
    diagnostics.add(
        {shell.where, {"direction"}}, shell.where,
        fmt::format("missing key 'direction' of shell '{}': its two prestretches are along and across it", shell.name));
  }
}

void check_viscosity(const ShellConfig& shell, Diagnostics& diagnostics) {
  for (const ViscosityConfig& mechanism : shell.viscosity) {
    const auto* newtonian = std::get_if<KelvinVoigt>(&mechanism.law);
    if (newtonian == nullptr || newtonian->shear > 0.0) continue;
    diagnostics.add(mechanism.where,
                    fmt::format("the viscosity of shell '{}' has no effect without 'shear': no stress acts across the "
                                "layer, which changes its thickness instead of its volume",
                                shell.name));
  }
}

void check_clamped(const ShellConfig& shell, Diagnostics& diagnostics) {
  if (shell.clamped.empty() || shell.bends) return;
  diagnostics.add(shell.clamped.front().where,
                  fmt::format("shell '{}' does not bend, and has no direction that 'clamped' could hold: add 'bending: "
                              "true'",
                              shell.name));
}

void check_free(const Config& config, const ShellConfig& shell, Diagnostics& diagnostics) {
  if (shell.part.kind != Selection::Kind::surface) {
    diagnostics.add(shell.part.where,
                    fmt::format("free shell '{}' needs 'surface', a physical surface of the mesh", shell.name));
  }
  const auto pulls = [&](const LoadConfig& load) {
    const bool is_meant = load.part.kind == Selection::Kind::everything ||
                          (load.part.kind == Selection::Kind::volume && load.part.name == shell.name);
    return is_meant && std::holds_alternative<LoadConfig::Gravity>(load.kind);
  };
  const bool is_dynamic = analysis_of(config) == Analysis::dynamic;
  if (!shell.density && (is_dynamic || std::ranges::any_of(config.loads, pulls))) {
    diagnostics.add({shell.where, {"density"}}, shell.where,
                    fmt::format("missing key 'density' of free shell '{}', which {} needs", shell.name,
                                is_dynamic ? "dynamics" : "gravity"));
  }
  if (config.mesh.refine > 0) {
    diagnostics.add(shell.where, fmt::format("free shell '{}' cannot be refined with the mesh: remove 'refine', and "
                                             "mesh it finer in gmsh",
                                             shell.name));
  }
  const bool is_taken =
      std::ranges::any_of(config.bodies, [&](const BodyConfig& body) { return body.part.name == shell.name; }) ||
      std::ranges::any_of(config.rigid_bodies, [&](const auto& body) { return body.name == shell.name; }) ||
      std::ranges::any_of(config.rods, [&](const auto& rod) { return rod.name == shell.name; });
  if (is_taken) {
    diagnostics.add(shell.where,
                    fmt::format("free shell '{}' has the name of a body or a rod: choose another name", shell.name));
  }
}

}  // namespace

void check_shells(const Config& config, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  std::vector<Location> places;
  for (const ShellConfig& shell : config.shells) {
    names.push_back(shell.name);
    places.push_back(shell.where);
    check_elasticity(shell, diagnostics);
    check_prestretch(shell, diagnostics);
    check_viscosity(shell, diagnostics);
    check_clamped(shell, diagnostics);
    if (shell.is_free) check_free(config, shell, diagnostics);
    if (config.mesh.file.value.empty() && !shell.is_free) {
      diagnostics.add(shell.where, fmt::format("shell '{}' lies on a surface of the mesh, which this input lacks: add "
                                               "'mesh' and 'bodies'",
                                               shell.name));
    }
  }
  check_unique(names, places, "shell name", diagnostics);
}

}  // namespace pliant
