#include "mesh/kept_mesh.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "mesh/mesh_bytes.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>
#include <gmsh.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "pliant kept mesh 4\n";
/// All kept meshes together [bytes].
constexpr std::uintmax_t most_bytes = 1'000'000'000;

/// FNV-1a (Fowler, Noll & Vo).
std::uint64_t hash_of(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

std::optional<std::string> contents_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) return std::nullopt;
  return bytes;
}

std::optional<fs::path> directory() {
  const auto absolute = [](const char* variable) -> std::optional<fs::path> {
    const char* value = std::getenv(variable);
    if (value == nullptr || !fs::path(value).is_absolute()) return std::nullopt;
    return value;
  };
  if (const auto cache = absolute("XDG_CACHE_HOME")) return *cache / "pliant" / "meshes";
  if (const auto home = absolute("HOME")) return *home / ".cache" / "pliant" / "meshes";
  return std::nullopt;
}

std::optional<SerialMesh> find(const fs::path& file, const std::string& recipe) {
  const auto bytes = contents_of(file);
  if (!bytes || !bytes->starts_with(magic)) return std::nullopt;
  try {
    Unpacker in(std::string_view(*bytes).substr(magic.size()));
    if (in.get_range<std::string>() != recipe) return std::nullopt;
    if (in.get<std::uint64_t>() != hash_of(in.rest())) return std::nullopt;
    SerialMesh mesh = unpack_mesh(in);
    std::error_code ignored;
    fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);  // of its last use
    return mesh;
  } catch (const std::exception&) {
    return std::nullopt;  // damaged
  }
}

/// Removes the least recently used meshes.
void make_room(const fs::path& place) {
  struct Kept {
    fs::file_time_type used;
    std::uintmax_t size;
    fs::path file;
  };
  std::vector<Kept> all;
  std::uintmax_t total = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(place, ignored)) {
    all.push_back({entry.last_write_time(ignored), entry.file_size(ignored), entry.path()});
    total += all.back().size;
  }
  std::ranges::sort(all, {}, &Kept::used);
  for (const Kept& kept : all) {
    if (total <= most_bytes) return;
    if (fs::remove(kept.file, ignored)) total -= kept.size;
  }
}

void keep(const fs::path& file, const std::string& recipe, const SerialMesh& mesh) {
  Packer packed;
  pack(packed, mesh);
  Packer head;
  head.put_range(recipe);
  head.put(hash_of(packed.bytes()));
  try {
    make_directory(file.parent_path());
    const fs::path part = fmt::format("{}.{}", file.string(), getpid());
    {
      File out(part, FileMode::anew);
      for (const std::string_view bytes : {magic, std::string_view(head.bytes()), std::string_view(packed.bytes())}) {
        out.write(bytes);
      }
      out.close();
    }
    replace_file(part, file, Durability::process);
    make_room(file.parent_path());
  } catch (const FileError&) {  // a full disk, a directory without rights
    std::error_code ignored;
    fs::remove(fmt::format("{}.{}", file.string(), getpid()), ignored);
  }
}

}  // namespace

std::string recipe_of(const MeshSource& source, const std::vector<fs::path>& files) {
  std::string recipe = fmt::format("pliant {} gmsh {} index {} size {} scale {}\n", PLIANT_VERSION, GMSH_API_VERSION,
                                   sizeof(PetscInt), source.size.value_or(0.0), source.scale);
  for (const LocalSize& local : source.sizes) {
    recipe += fmt::format("{} {} {} {}\n", local.dimension, local.name, local.size, local.distance);
  }
  for (const fs::path& file : files) {
    const auto bytes = contents_of(file);
    if (!bytes) throw FileError(file.string() + ": cannot be read");
    recipe += fmt::format("{} {} {:016x} {:016x}\n", file.extension().string(), bytes->size(), hash_of(*bytes),
                          hash_of(*bytes, 0x9e3779b97f4a7c15));
  }
  return recipe;
}

SerialMesh kept_or_made(const std::string& recipe, const std::function<SerialMesh()>& make) {
  const auto place = directory();
  if (!place) return make();
  const fs::path file = *place / fmt::format("{:016x}", hash_of(recipe));
  if (auto mesh = find(file, recipe)) {
    mesh->notices.push_back("its mesh is that of an earlier run, kept as " + file.string());
    return std::move(*mesh);
  }
  SerialMesh mesh = make();
  keep(file, recipe, mesh);
  return mesh;
}

}  // namespace pliant
