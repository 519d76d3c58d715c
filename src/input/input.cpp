#include "input/input.hpp"

#include "base/file.hpp"
#include "input/checks.hpp"
#include "input/defaults.hpp"
#include "input/keys.hpp"
#include "input/parse.hpp"
#include "input/unknown_key.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// The whole file, but never much more than an input can be (parse_yaml rejects the rest).
std::string file_text(const std::string& file) {
  constexpr std::streamsize most = 8 << 20;
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    throw InputError({file, 0, 0}, "this is a directory; name the input file in it");
  }
  constexpr std::array meshes{".msh", ".geo", ".step", ".stp", ".brep", ".stl", ".inp",
                              ".vtk", ".vtu", ".med",  ".bdf", ".nas",  ".unv", ".mesh"};
  const std::string extension = fs::path(file).extension().string();
  if (std::ranges::find(meshes, extension) != meshes.end()) {
    throw InputError({file, 0, 0},
                     "this is a mesh or a geometry, not an input file; name it in one (YAML): 'mesh: {file: " +
                         fs::path(file).filename().string() + "}'");
  }
  if (extension == ".h5") {
    throw InputError({file, 0, 0},
                     "not an input file (YAML expected); to continue from a checkpoint: pliant resume FILE");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    const bool exists = fs::exists(file, ignored);
    throw InputError({file, 0, 0}, exists ? std::string("the input file cannot be read; check its permissions")
                                          : "there is no such input file" + similar_file(file) +
                                                "; check its name and the working directory");
  }
  std::string text(static_cast<std::size_t>(most), '\0');
  stream.read(text.data(), most);
  if (stream.bad()) throw InputError({file, 0, 0}, "reading the input file failed");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace

Config read_input(const std::string& text, const std::string& file, const std::vector<Override>& overrides,
                  Supports supports) {
  Diagnostics diagnostics;
  InputNode root = parse_yaml(text, file, diagnostics);
  if (root.kind == InputNode::Kind::null) {
    if (overrides.empty()) throw InputError({file, 0, 0}, "the input is empty");
    root.where = {file, 1, 1};
  }
  const auto has_keys = [&](const char* a, const char* b) { return is_given(root, a) && is_given(root, b); };
  if (has_keys("material", "tests") || has_keys("input", "targets")) {
    throw InputError({file, 1, 1}, "this is a fit file, not the input of a run: pliant fit " + file);
  }
  for (const Override& change : overrides) apply_override(change, root, diagnostics);
  Config config = read_config(root, diagnostics);
  config.file = file;
  warn_of_decimal_commas(root, diagnostics);
  complete_defaults(config, root);
  check_combinations(config, root, diagnostics);
  if (supports == Supports::required) check_held(config, root, diagnostics);
  diagnostics.throw_if_errors();
  config.warnings = diagnostics.warnings();
  return config;
}

std::string input_text(MPI_Comm comm, const std::string& file) {
  std::string text;
  on_root(comm, [&] { text = file_text(file); });
  return broadcast(comm, std::move(text));
}

Config read_input_file(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       Supports supports) {
  return read_input(input_text(comm, file), file, overrides, supports);
}

std::string dump(const Config& config) {
  Config portable = config;
  const auto make_absolute = [](std::string& file) {
    std::error_code failure;
    const fs::path path = fs::weakly_canonical(file, failure);
    if (!failure && !file.empty()) file = fs::absolute(path).string();
  };
  make_absolute(portable.mesh.file.value);
  for (RigidBodyConfig& body : portable.rigid_bodies) {
    if (body.surface) make_absolute(body.surface->file.value);
  }
  if (portable.contact) {
    for (ObstacleConfig& obstacle : portable.contact->obstacles) {
      if (auto* surface = std::get_if<ObstacleConfig::Surface>(&obstacle.shape)) make_absolute(surface->file.value);
    }
  }
  InputNode tree = write_config(portable);
  if (portable.mesh.file.value.empty()) {
    std::erase_if(tree.children, [](const InputNode& node) { return node.key == "mesh"; });
  }
  return to_yaml(tree);
}

std::string json_schema() {
  return input_schema()->dump(2) + '\n';
}

}  // namespace pliant
