#include "mesh/mesh_bytes.hpp"

namespace pliant {

void pack(Packer& out, const std::vector<std::string>& texts) {
  out.put(texts.size());
  for (const auto& text : texts) out.put_range(text);
}

std::vector<std::string> unpack_texts(Unpacker& in) {
  std::vector<std::string> texts(in.get<std::size_t>());
  for (auto& text : texts) text = in.get_range<std::string>();
  return texts;
}

void pack(Packer& out, const SerialMesh& mesh) {
  out.put_range(mesh.coordinates);
  out.put_range(mesh.node_tags);
  out.put_range(mesh.cells);
  out.put_range(mesh.mid_nodes);
  out.put_range(mesh.cell_tags);
  out.put(mesh.groups.size());
  for (const auto& [group, members] : mesh.groups) {
    out.put(group.dimension);
    out.put(group.tag);
    out.put_range(group.name);
    out.put_range(members);
  }
  pack(out, mesh.notices);
  out.put(mesh.is_straightened);
  out.put_range(mesh.only);
}

SerialMesh unpack_mesh(Unpacker& in) {
  SerialMesh mesh;
  mesh.coordinates = in.get_range<std::vector<double>>();
  mesh.node_tags = in.get_range<std::vector<std::size_t>>();
  mesh.cells = in.get_range<std::vector<PetscInt>>();
  mesh.mid_nodes = in.get_range<std::vector<PetscInt>>();
  mesh.cell_tags = in.get_range<std::vector<std::size_t>>();
  mesh.groups.resize(in.get<std::size_t>());
  for (auto& [group, members] : mesh.groups) {
    group.dimension = in.get<int>();
    group.tag = in.get<int>();
    group.name = in.get_range<std::string>();
    members = in.get_range<std::vector<PetscInt>>();
  }
  mesh.notices = unpack_texts(in);
  mesh.is_straightened = in.get<bool>();
  mesh.only = in.get_range<std::string>();
  return mesh;
}

}  // namespace pliant
