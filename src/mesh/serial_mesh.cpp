#include "mesh/serial_mesh.hpp"

namespace pliant {
namespace {

std::string joined(const std::vector<std::string>& reasons) {
  std::string text;
  for (const auto& reason : reasons) text += (text.empty() ? "" : "\n") + reason;
  return text;
}

}  // namespace

std::size_t num_local_parts(int dimension) {
  constexpr std::array<std::size_t, 4> numbers{4, 6, 4, 1};
  return numbers.at(static_cast<std::size_t>(dimension));
}

std::span<const int> local_part(int dimension, std::size_t number) {
  static constexpr std::array<int, 4> corners{0, 1, 2, 3};
  if (dimension == 3) return corners;
  if (dimension == 2) return local_facets[number];
  if (dimension == 1) return local_edges[number];
  return {&corners[number], 1};
}

MeshDefect::MeshDefect(std::vector<std::string> reasons)
    : std::runtime_error(joined(reasons)), reasons_(std::move(reasons)) {}

MeshDefect no_tetrahedra(const std::string& what) {
  return MeshDefect("it contains no tetrahedra, only " + what +
                    ": the geometry needs a Volume, meshed in three dimensions (gmsh -3)");
}

std::string describe(const PhysicalGroup& group) {
  constexpr std::array<const char*, 4> kinds{"point", "curve", "surface", "volume"};
  const std::string name = group.name.empty() ? std::to_string(group.tag) : "'" + group.name + "'";
  return std::string("physical ") + kinds.at(static_cast<std::size_t>(group.dimension)) + " " + name;
}

void notice_left_out(const SerialGroup& group, std::size_t num_found, std::vector<std::string>& notices) {
  const std::size_t num_members = group.members.size() / (static_cast<std::size_t>(group.group.dimension) + 1);
  if (num_found == num_members) return;
  notices.push_back(describe(group.group) + ": " + std::to_string(num_members - num_found) + " of its " +
                    std::to_string(num_members) + " elements are not part of a tetrahedron and were left out");
}

std::string first_few(const std::vector<std::size_t>& numbers) {
  constexpr std::size_t shown = 5;
  std::string text;
  for (std::size_t i = 0; i < numbers.size() && i < shown; ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
  }
  if (numbers.size() > shown) text += ", ... (" + std::to_string(numbers.size()) + " in all)";
  return text;
}

}  // namespace pliant
