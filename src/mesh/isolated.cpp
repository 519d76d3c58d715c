#include "mesh/isolated.hpp"

#include "mesh/mesh_bytes.hpp"

#include <chrono>
#include <stdexcept>

#include <fmt/format.h>

namespace pliant {
namespace {

enum class Outcome : char { mesh = 'M', defect = 'D', failure = 'F' };

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
  if (isolation.suspect == Suspect::med) {
    throw MeshDefect("the HDF5 library crashed while reading it (" + end.how +
                     "): the file is damaged; write or copy it again");
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
