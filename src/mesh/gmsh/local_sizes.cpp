#include "mesh/gmsh/local_sizes.hpp"

#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gmsh.h>

namespace pliant {
namespace {

struct KindOfGroup {
  const char* noun;
  const char* list;  // option of the field Distance
};
constexpr std::array<KindOfGroup, 3> kinds_of_groups{
    {{"point", "PointsList"}, {"curve", "CurvesList"}, {"surface", "SurfacesList"}}};

/// Groups that hold nothing have a name, and are not among gmsh's groups.
bool is_empty_group(int dimension, const std::string& wanted) {
  constexpr int most_tags = 10000;
  for (int tag = 1; tag <= most_tags; ++tag) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    if (name == wanted) return true;
  }
  return false;
}

/// The entities of the group. Throws MeshDefect with the names that there are.
std::vector<int> entities_of(const LocalSize& local) {
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups, local.dimension);
  std::string names;
  for (const auto& [dimension, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    if (local.name == name || local.name == std::to_string(tag)) {
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
      for (int& entity : entities) entity = std::abs(entity);
      return entities;
    }
    names += (names.empty() ? "" : ", ") + (name.empty() ? std::to_string(tag) : name);
  }
  const std::string noun = kinds_of_groups[static_cast<std::size_t>(local.dimension)].noun;
  if (is_empty_group(local.dimension, local.name)) {
    throw MeshDefect("'mesh.sizes' names the physical " + noun + " '" + local.name +
                     "', which is empty: its statement in the geometry selects nothing ('In BoundingBox' needs a box a "
                     "little larger than what it is to find)");
  }
  throw MeshDefect("'mesh.sizes' names the physical " + noun + " '" + local.name + "', but the geometry has " +
                   (names.empty() ? "none: name it in a .geo file that loads the geometry" : "only: " + names));
}

double extent_of_model() {
  std::array<double, 6> b{};
  gmsh::model::getBoundingBox(-1, -1, b[0], b[1], b[2], b[3], b[4], b[5]);
  return std::hypot(b[3] - b[0], b[4] - b[1], b[5] - b[2]);
}

/// Rejects a size in the wrong unit, with which gmsh would fill the memory before it gives up.
void require_feasible_at(const LocalSize& local, double extent) {
  constexpr double most_along_extent = 30000;
  if (!(extent / local.size > most_along_extent)) return;
  throw MeshDefect(
      fmt::format("with elements of size {:g} at '{}' there would be {:.1g} of them along its extent of {:g} (before "
                  "`scale`): check "
                  "the unit of this size in 'mesh.sizes', and `scale`",
                  local.size, local.name, extent / local.size, extent));
}

/// gmsh measures distances to points that it lays on curves and surfaces: as many along each as the size needs, so that
/// the error of a distance stays below the size.
double num_samples(const LocalSize& local, double extent) {
  constexpr double fewest = 20, most = 400;
  return std::clamp(std::ceil(extent / local.size), fewest, most);
}

int add_field(const char* kind) {
  return gmsh::model::mesh::field::add(kind);
}

}  // namespace

void impose_local_sizes(std::span<const LocalSize> sizes, const std::optional<double>& size) {
  namespace field = gmsh::model::mesh::field;
  if (sizes.empty()) return;
  const double extent = extent_of_model();
  std::vector<double> all;
  double smallest = size.value_or(extent);
  for (const LocalSize& local : sizes) {
    require_feasible_at(local, extent);
    const std::vector<int> entities = entities_of(local);
    const int distance = add_field("Distance"), threshold = add_field("Threshold");
    field::setNumbers(distance, kinds_of_groups[static_cast<std::size_t>(local.dimension)].list,
                      {entities.begin(), entities.end()});
    if (local.dimension > 0) field::setNumber(distance, "NumPointsPerCurve", num_samples(local, extent));
    const std::array<std::pair<const char*, double>, 5> options{
        {{"InField", distance},
         {"SizeMin", local.size},
         {"SizeMax", std::max(local.size, size.value_or(extent / 10))},
         {"DistMin", 0.0},
         {"DistMax", local.distance}}};
    for (const auto& [name, value] : options) field::setNumber(threshold, name, value);
    if (!size) field::setNumber(threshold, "StopAtDistMax", 1);
    all.push_back(threshold);
    smallest = std::min(smallest, local.size);
  }
  const int least = add_field("Min");
  field::setNumbers(least, "FieldsList", all);
  field::setAsBackgroundMesh(least);
  double least_size = 0.0;
  gmsh::option::getNumber("Mesh.MeshSizeMin", least_size);
  gmsh::option::setNumber("Mesh.MeshSizeMin", std::min(least_size, smallest));
}

}  // namespace pliant
