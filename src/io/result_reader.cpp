#include "io/result_reader.hpp"

#include "base/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>

#include <fmt/format.h>

namespace pliant {
namespace {

Hdf5Handle open_group(hid_t parent, const std::string& name) {
  return {H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "open '" + name + "'"};
}

Hdf5Handle open_dataset(hid_t parent, const std::string& name) {
  return {H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "read '" + name + "'"};
}

/// Rows and columns.
std::array<std::int64_t, 2> shape_of(hid_t dataset, const std::string& name) {
  const auto sizes = sizes_of(dataset);
  if (sizes.empty() || sizes.size() > 2) throw FileError("cannot read '" + name + "': it is not a table");
  return {static_cast<std::int64_t>(sizes[0]), sizes.size() > 1 ? static_cast<std::int64_t>(sizes[1]) : 1};
}

/// A whole table. `columns`: as many as it must have, 0 for any.
template <class T>
std::vector<T> table(hid_t parent, const std::string& name, hid_t type, std::int64_t columns = 0) {
  const Hdf5Handle dataset = open_dataset(parent, name);
  const auto shape = shape_of(dataset.get(), name);
  if (columns != 0 && shape[1] != columns) {
    throw FileError(fmt::format("cannot read '{}': it has {} columns, not {}", name, shape[1], columns));
  }
  require_stored(dataset.get(), "read '" + name + "'");
  std::vector<T> values(static_cast<std::size_t>(shape[0] * shape[1]));
  read_rows(dataset.get(), {0, shape[0]}, type, values.data());
  return values;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A run that is adding a frame may be caught between two of its writes; retry a moment later.
Hdf5Handle open_patiently(const std::filesystem::path& file) {
  constexpr int attempts = 5;
  for (int i = 1;; ++i) {
    try {
      return open_hdf5(file, Hdf5Mode::read);
    } catch (const FileError&) {
      if (i == attempts) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
}

bool has_link(hid_t parent, const std::string& name) {
  return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0;
}

ResultFrame frame_of(hid_t frames, const std::string& name) {
  const Hdf5Handle group = open_group(frames, name);
  return {name, finite_attribute(group.get(), "time"), integer_attribute(group.get(), "step"),
          text_attribute(group.get(), "mesh"),
          H5Aexists(group.get(), "label") > 0 ? text_attribute(group.get(), "label") : ""};
}

}  // namespace

void refuse_input(const std::filesystem::path& place, std::string_view wanted) {
  std::error_code ignored;
  const bool is_input = place.extension() == ".yaml" || place.extension() == ".yml";
  if (!is_input || !std::filesystem::is_regular_file(place, ignored)) return;
  throw FileError(fmt::format("'{}' is an input, not a {}: give the directory of its results, such as out/{}",
                              place.string(), wanted, place.stem().string()));
}

std::string results_elsewhere(const std::filesystem::path& place, std::string_view name) {
  namespace fs = std::filesystem;
  constexpr int deepest = 1;
  constexpr std::size_t most_shown = 5, most_seen = 10000;
  std::error_code ignored;
  std::vector<std::string> found;
  std::size_t seen = 0;
  for (fs::recursive_directory_iterator at(place, ignored), end; at != end && ++seen < most_seen;
       at.increment(ignored)) {
    if (at.depth() >= deepest) at.disable_recursion_pending();
    if (fs::is_regular_file(at->path() / name, ignored)) found.push_back(at->path().lexically_normal().string());
  }
  std::ranges::sort(found);
  if (found.size() > most_shown) {
    found.resize(most_shown);
    found.emplace_back("...");
  }
  if (!found.empty()) return "; there are results in " + joined(found);
  const fs::path above = (place.has_filename() ? fs::absolute(place) : fs::absolute(place).parent_path()).parent_path();
  if (!fs::is_regular_file(above / name, ignored)) return "";
  return "; there is one in " + fs::proximate(above, ignored).string();
}

std::filesystem::path result_file(const std::filesystem::path& place) {
  refuse_input(place, "result");
  std::error_code ignored;
  std::filesystem::path file = place;
  if (std::filesystem::is_directory(place, ignored)) {
    const auto is_there = [&](const char* name) { return std::filesystem::is_regular_file(place / name, ignored); };
    file /= is_there("state.h5") && !is_there("result.h5") ? "state.h5" : "result.h5";
  }
  if (file.extension() == ".xdmf") file.replace_extension(".h5");
  constexpr std::array others{".csv", ".json", ".html", ".txt"};
  if (std::ranges::find(others, file.extension()) != others.end()) {
    throw FileError(fmt::format("'{}' is not a result: give the directory of the run", file.string()));
  }
  if (!std::filesystem::is_regular_file(file, ignored)) {
    throw FileError(
        fmt::format("no result: '{}' does not exist{}", file.string(), results_elsewhere(place, "result.h5")));
  }
  return file;
}

void naming(const std::filesystem::path& file, const std::function<void()>& work) {
  try {
    work();
  } catch (const FileError& error) {
    const std::string reason = error.what();
    if (reason.find(file.string()) != std::string::npos) throw;
    throw FileError("'" + file.string() + "': " + reason);
  }
}

void require_result(hid_t file, const std::filesystem::path& path, std::string_view otherwise) {
  if (H5Aexists(file, "format") <= 0 || text_attribute(file, "format") != "pliant-result") {
    throw FileError(fmt::format("'{}' is {}", path.string(), otherwise));
  }
  const std::int64_t version = integer_attribute(file, "version");
  if (version != result_version) {
    throw FileError(
        fmt::format("'{}' has version {} of the format, but this program reads version {}; read it with the "
                    "Pliant that wrote it",
                    path.string(), version, result_version));
  }
}

ResultReader::ResultReader(std::filesystem::path file) : path_(std::move(file)), file_(open_patiently(path_)) {
  require_result(file_.get(), path_, "not a result of Pliant");
  title_ = text_attribute(file_.get(), "title");
  const Hdf5Handle frames = open_group(file_.get(), "frames");
  for (const auto& name : names_in(frames.get())) frames_.push_back(frame_of(frames.get(), name));
}

OutputMesh ResultReader::mesh(const std::string& group) const {
  const Hdf5Handle mesh = open_group(file_.get(), group);
  OutputMesh result;
  result.coordinates = table<double>(mesh.get(), "coordinates", H5T_NATIVE_DOUBLE, 3);
  result.global_num_nodes = std::ssize(result.coordinates) / 3;
  result.nodes_per_cell = static_cast<int>(shape_of(open_dataset(mesh.get(), "cells").get(), "cells")[1]);
  result.cells = table<std::int64_t>(mesh.get(), "cells", H5T_NATIVE_INT64);
  result.bodies = table<int>(mesh.get(), "body", H5T_NATIVE_INT, 1);
  const Hdf5Handle body_of_cell = open_dataset(mesh.get(), "body");
  result.body_names = lines_of(text_attribute(body_of_cell.get(), "names"));
  for (const auto& [name, list] : {std::pair{"masses", &result.masses},
                                   {"rigid", &result.rigid},
                                   {"rods", &result.rods},
                                   {"rectangular_rods", &result.rectangular_rods},
                                   {"sections", &result.sections},
                                   {"shells", &result.shells}}) {
    if (H5Aexists(body_of_cell.get(), name) > 0) *list = lines_of(text_attribute(body_of_cell.get(), name));
  }
  const auto is_known = [&](std::int64_t node) { return node >= 0 && node < result.global_num_nodes; };
  const auto has_name = [&](int body) { return body >= 0 && body < std::ssize(result.body_names); };
  const bool fits = (result.nodes_per_cell == 4 || result.nodes_per_cell == 10) &&
                    result.cells.size() == result.bodies.size() * static_cast<std::size_t>(result.nodes_per_cell);
  if (!fits || !std::ranges::all_of(result.cells, is_known) || !std::ranges::all_of(result.bodies, has_name)) {
    throw FileError(fmt::format("the mesh '{}' of '{}' is damaged", group, path_.string()));
  }
  return result;
}

std::optional<OutputObstacles> ResultReader::obstacles(const std::string& group) const {
  const std::string place = group_beside(group, "obstacles");
  if (!has_link(file_.get(), place)) return std::nullopt;
  const Hdf5Handle obstacles = open_group(file_.get(), place);
  OutputObstacles result;
  result.points = table<double>(obstacles.get(), "points", H5T_NATIVE_DOUBLE, 3);
  result.triangles = table<std::int64_t>(obstacles.get(), "triangles", H5T_NATIVE_INT64, 3);
  result.obstacles = table<std::int32_t>(obstacles.get(), "obstacle", H5T_NATIVE_INT32, 1);
  result.names = lines_of(text_attribute(open_dataset(obstacles.get(), "obstacle").get(), "names"));
  const auto is_known = [&](std::int64_t p) { return p >= 0 && p < std::ssize(result.points) / 3; };
  const auto has_name = [&](std::int32_t o) { return o >= 0 && o < std::ssize(result.names); };
  if (!std::ranges::all_of(result.triangles, is_known) || !std::ranges::all_of(result.obstacles, has_name) ||
      result.triangles.size() != 3 * result.obstacles.size()) {
    throw FileError(fmt::format("the obstacles '{}' of '{}' are damaged", place, path_.string()));
  }
  return result;
}

std::vector<double> ResultReader::obstacle_points(const ResultFrame& frame) const {
  const std::string place = group_beside(frame.mesh, "obstacles"),
                    moved = fmt::format("{}/frames/{:06}", place, frame.step);
  const bool moves = has_link(file_.get(), place + "/frames") && has_link(file_.get(), moved);
  return table<double>(file_.get(), (moves ? moved : place) + "/points", H5T_NATIVE_DOUBLE, 3);
}

std::optional<OutputMechanisms> ResultReader::mechanisms(const std::string& group) const {
  const std::string place = group_beside(group, "mechanisms");
  if (!has_link(file_.get(), place)) return std::nullopt;
  const Hdf5Handle mechanisms = open_group(file_.get(), place);
  OutputMechanisms result;
  result.points = table<double>(mechanisms.get(), "points", H5T_NATIVE_DOUBLE, 3);
  result.segments = table<std::int64_t>(mechanisms.get(), "segments", H5T_NATIVE_INT64, 2);
  result.parts = table<std::int32_t>(mechanisms.get(), "part", H5T_NATIVE_INT32, 1);
  const Hdf5Handle part = open_dataset(mechanisms.get(), "part");
  result.names = lines_of(text_attribute(part.get(), "names"));
  result.kinds = lines_of(text_attribute(part.get(), "kinds"));
  if (has_link(mechanisms.get(), "joints")) {
    result.joints = table<std::int64_t>(mechanisms.get(), "joints", H5T_NATIVE_INT64, 1);
  }
  const auto is_known = [&](std::int64_t p) { return p >= 0 && p < std::ssize(result.points) / 3; };
  const auto has_name = [&](std::int32_t p) { return p >= 0 && p < std::ssize(result.names); };
  if (!std::ranges::all_of(result.segments, is_known) || !std::ranges::all_of(result.joints, is_known) ||
      !std::ranges::all_of(result.parts, has_name) || result.segments.size() != 2 * result.parts.size() ||
      result.kinds.size() != result.names.size() || result.joints.size() > result.names.size()) {
    throw FileError(fmt::format("the mechanisms '{}' of '{}' are damaged", place, path_.string()));
  }
  return result;
}

MechanismState ResultReader::mechanism_state(const ResultFrame& frame, const OutputMechanisms& mechanisms) const {
  const std::string place = fmt::format("{}/frames/{:06}", group_beside(frame.mesh, "mechanisms"), frame.step);
  MechanismState state;
  state.points = table<double>(file_.get(), place + "/points", H5T_NATIVE_DOUBLE, 3);
  state.tensions = table<double>(file_.get(), place + "/tension", H5T_NATIVE_DOUBLE, 1);
  if (!mechanisms.joints.empty()) state.axes = table<double>(file_.get(), place + "/axes", H5T_NATIVE_DOUBLE, 3);
  if (state.points.size() != mechanisms.points.size() || state.tensions.size() != mechanisms.parts.size() ||
      state.axes.size() != 3 * mechanisms.joints.size()) {
    throw FileError("the mechanisms of frame '" + frame.name + "' are damaged");
  }
  return state;
}

std::vector<ResultField> ResultReader::fields(const ResultFrame& frame) const {
  const Hdf5Handle group = open_group(file_.get(), "/frames/" + frame.name);
  std::vector<ResultField> fields;
  for (const auto& name : names_in(group.get())) {
    const Hdf5Handle dataset = open_dataset(group.get(), name);
    const bool is_of_cells = text_attribute(dataset.get(), "location") == "cell";
    fields.push_back({name, text_attribute(dataset.get(), "unit"),
                      is_of_cells ? FieldLocation::cell : FieldLocation::node,
                      static_cast<int>(shape_of(dataset.get(), name)[1])});
  }
  return fields;
}

std::vector<double> ResultReader::values(const ResultFrame& frame, const ResultField& field) const {
  const Hdf5Handle group = open_group(file_.get(), "/frames/" + frame.name);
  return table<double>(group.get(), field.name, H5T_NATIVE_DOUBLE, field.components);
}

}  // namespace pliant
