#include "mesh/source_checks.hpp"

#include "base/file.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace pliant {

void telling_the_user(const MeshSource& source, const std::function<void()>& work) {
  try {
    work();
  } catch (const MeshDefect& defect) {
    std::vector<Diagnostic> diagnostics;
    for (const auto& reason : defect.reasons()) {
      diagnostics.push_back(
          {Severity::error, source.where, (source.file.empty() ? "" : "mesh file '" + source.file + "': ") + reason});
    }
    throw InputError(std::move(diagnostics));
  }
}

void require_readable(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw MeshDefect("the file does not exist" + similar_file(file));
  if (std::filesystem::is_directory(file, error)) throw MeshDefect("it is a directory, not a file");
  if (!std::filesystem::is_regular_file(file, error)) throw MeshDefect("it is a pipe or a device, not a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw FileError("mesh file '" + file + "' cannot be opened: no permission to read it");
  if (stream.peek() == std::ifstream::traits_type::eof()) throw MeshDefect("it is empty");
}

std::string file_contents(const std::string& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const auto size = stream.tellg();
  if (!stream || size < 0) throw FileError("mesh file '" + file + "' cannot be opened");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.seekg(0);
  if (!stream.read(bytes.data(), size)) throw FileError("mesh file '" + file + "' cannot be read to its end");
  return bytes;
}

void require_plain_name(const std::string& name) {
  if (std::ranges::none_of(name, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; })) return;
  throw MeshDefect("the name '" + excerpt(name) + "' contains a line feed or another control character: rename it");
}

void require_sane(const MeshSource& source) {
  std::vector<std::string> reasons;
  if (source.size && !(*source.size > 0.0 && std::isfinite(*source.size)))
    reasons.push_back("its size must be a positive length");
  if (!(source.scale > 0.0 && std::isfinite(source.scale))) reasons.push_back("its scale must be a positive number");
  if (source.refine < 0) reasons.push_back("refine must be 0 or a positive number of refinements");
  if (!reasons.empty()) throw MeshDefect(reasons);
}

void require_no_sizes(const MeshSource& source) {
  std::vector<std::string> reasons;
  if (source.size)
    reasons.push_back("it is a mesh already, to which 'size' does not apply: remove it, or name the geometry");
  if (!source.sizes.empty())
    reasons.push_back("it is a mesh already, to which 'mesh.sizes' does not apply: remove it, or name the geometry");
  if (!reasons.empty()) throw MeshDefect(reasons);
}

void require_enough_cells(std::int64_t num_cells, int num_ranks) {
  if (num_cells >= num_ranks) return;
  throw MeshDefect("it has " + std::to_string(num_cells) + (num_cells == 1 ? " tetrahedron" : " tetrahedra") + " for " +
                   std::to_string(num_ranks) +
                   " ranks, but every rank needs at least one: use fewer ranks or a finer mesh");
}

void require_enough_added_cells(std::int64_t num_cells, int num_ranks) {
  if (num_cells >= num_ranks) return;
  throw MeshDefect("rods and rigid bodies make " + std::to_string(num_cells) + " cells for " +
                   std::to_string(num_ranks) + " ranks, but every rank needs at least one: use fewer ranks");
}

}  // namespace pliant
