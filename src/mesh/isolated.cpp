#include "mesh/isolated.hpp"

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

namespace pliant {
namespace {

enum class Outcome : char { mesh = 'M', defect = 'D', failure = 'F' };

/// Serializes values of plain types and vectors of them, one after another.
class Packer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <class Range>
  void put_range(const Range& range) {
    put(range.size());
    bytes_.append(reinterpret_cast<const char*>(range.data()), range.size() * sizeof(typename Range::value_type));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T get() {
    T value;
    take(&value, sizeof(T));
    return value;
  }
  template <class Range>
  Range get_range() {
    Range range;
    range.resize(get<std::size_t>());
    take(range.data(), range.size() * sizeof(typename Range::value_type));
    return range;
  }

 private:
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) throw std::runtime_error("the answer of the other process is incomplete");
    if (size == 0) return;  // memcpy takes no null pointers
    std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  std::string_view bytes_;
};

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
  return mesh;
}

Packer outcome_of(const std::function<SerialMesh()>& work) {
  Packer out;
  try {
    const SerialMesh mesh = work();
    out.put(Outcome::mesh);
    pack(out, mesh);
  } catch (const MeshDefect& defect) {
    out = {};
    out.put(Outcome::defect);
    pack(out, defect.reasons());
  } catch (const std::exception& e) {
    out = {};
    out.put(Outcome::failure);
    pack(out, {e.what()});
  }
  return out;
}

[[noreturn]] void reject_dead_child(const Isolation& isolation, const ChildEnd& end) {
  if (end.is_too_late) {
    throw MeshDefect(
        fmt::format("gmsh has not finished after {:g} s: a script may have an endless loop; if it needs "
                    "longer, set 'mesh.time_limit', or mesh it with gmsh and take its .msh file",
                    std::chrono::duration<double>(*isolation.limits.time).count()));
  }
  if (isolation.suspect == Suspect::hdf5) {
    throw MeshDefect("the HDF5 library crashed while reading it (" + end.how +
                     "): the file is damaged; write it again with `pliant mesh convert`");
  }
  if (end.exited) throw MeshDefect("the file made gmsh exit before it had a mesh: remove its Exit or Abort command");
  throw MeshDefect(
      "gmsh crashed while working on it (" + end.how +
      "): the file is damaged, or the mesh does not fit into memory; open it in the gmsh program to see why");
}

}  // namespace

Isolation gmsh_isolation(const MeshSource& source) {
  const auto rights = source.commands == Commands::refused ? ChildRights::reading : ChildRights::all;
  const std::chrono::duration<double> time(source.time_limit);
  return {Suspect::gmsh, {rights, std::chrono::ceil<std::chrono::milliseconds>(time)}};
}

SerialMesh isolated(const Isolation& isolation, const std::function<SerialMesh()>& work) {
  const ChildEnd end = in_child([&] { return outcome_of(work).bytes(); }, isolation.limits);
  if (!end.answer || end.answer->empty()) reject_dead_child(isolation, end);
  Unpacker in(*end.answer);
  switch (in.get<Outcome>()) {
    case Outcome::mesh:
      return unpack_mesh(in);
    case Outcome::defect:
      throw MeshDefect(unpack_texts(in));
    default:
      throw std::runtime_error(unpack_texts(in).at(0));
  }
}

}  // namespace pliant
