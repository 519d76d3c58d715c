#include "model/mesh_source.hpp"

#include "model/rigid_bodies.hpp"
#include "model/rods.hpp"
#include "model/shells.hpp"
#include "model/start_adjustment.hpp"
#include "model/tendons.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace pliant {

namespace {

// Lengths in the input are in metres, those of gmsh in the unit of the geometry.
std::vector<LocalSize> local_sizes(const MeshConfig& mesh) {
  std::vector<LocalSize> sizes;
  for (const LocalSizeConfig& local : mesh.sizes) {
    const int dimension = !local.surface.empty() ? 2 : !local.curve.empty() ? 1 : 0;
    sizes.push_back(
        {dimension, local.surface + local.curve + local.point, local.size / mesh.scale, local.distance / mesh.scale});
  }
  return sizes;
}

}  // namespace

MeshSource mesh_source(const Config& given) {
  const Config config = with_rigid_bodies(given);
  // The size in the input is in metres, that of gmsh in the unit of the geometry.
  auto size = config.mesh.size;
  if (size) *size /= config.mesh.scale;
  std::vector<std::string> curves = curves_of_tendons(config);
  std::ranges::move(curves_of_rods(config), std::back_inserter(curves));
  return {config.mesh.file.value,
          config.mesh.file.value.empty() ? Location{config.file, 0, 0} : config.mesh.file.where,
          size,
          config.mesh.scale,
          config.mesh.refine,
          config.mesh.allow_commands ? Commands::allowed : Commands::refused,
          config.mesh.time_limit,
          parts_that_meet(config),
          added_tetrahedra(config),
          added_volumes(config),
          added_rods(config),
          added_shells(config),
          std::move(curves),
          local_sizes(config.mesh)};
}

}  // namespace pliant
