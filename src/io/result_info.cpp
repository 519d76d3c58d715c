#include "io/result_info.hpp"

#include "base/error.hpp"
#include "io/result_reader.hpp"

#include <array>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Rows and columns.
std::array<hsize_t, 2> size_of_dataset(hid_t group, const std::string& name) {
  const Hdf5Handle dataset(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose, "read '" + name + "'");
  const auto sizes = sizes_of(dataset.get());
  if (sizes.empty()) throw FileError("cannot read '" + name + "': it is one number, not a table");
  return {sizes[0], sizes.size() > 1 ? sizes[1] : 1};
}

/// A line with the names that a dataset of a group has, or nothing.
std::string names_of(hid_t file, const std::string& group, const std::string& table) {
  if (H5Lexists(file, group.c_str(), H5P_DEFAULT) <= 0) return {};
  const std::string place = group + "/" + table, doing = "read '" + place + "'";
  const Hdf5Handle dataset(H5Dopen2(file, place.c_str(), H5P_DEFAULT), H5Dclose, doing);
  std::string names = text_attribute(dataset.get(), "names");
  for (std::size_t at; (at = names.find('\n')) != std::string::npos;) names.replace(at, 1, ", ");
  return fmt::format("{}: {}\n", group, names);
}

/// The time of a frame, or what is shown in place of it.
std::string instant_of(hid_t frames, const std::string& name) {
  const Hdf5Handle frame(H5Gopen2(frames, name.c_str(), H5P_DEFAULT), H5Gclose, "open the frame '" + name + "'");
  if (H5Aexists(frame.get(), "label") > 0) return text_attribute(frame.get(), "label");
  return fmt::format("{:.6g}", finite_attribute(frame.get(), "time"));
}

std::string fields_of(hid_t frames, const std::string& name) {
  const Hdf5Handle frame(H5Gopen2(frames, name.c_str(), H5P_DEFAULT), H5Gclose, "open the frame '" + name + "'");
  std::string text;
  for (const auto& field : names_in(frame.get())) {
    const std::string doing = "read '" + field + "'";
    const Hdf5Handle dataset(H5Dopen2(frame.get(), field.c_str(), H5P_DEFAULT), H5Dclose, doing);
    const std::string unit = text_attribute(dataset.get(), "unit");
    text += fmt::format("  {}{}, {} per {}\n", field, unit.empty() ? "" : fmt::format(" [{}]", unit),
                        size_of_dataset(frame.get(), field)[1], text_attribute(dataset.get(), "location"));
  }
  return text;
}

std::string description_of(const std::filesystem::path& path) {
  const QuietHdf5 quiet;
  const Hdf5Handle file = open_hdf5(path, Hdf5Mode::read);
  require_result(file.get(), path, "neither a checkpoint nor a result of Pliant");
  const std::string title = text_attribute(file.get(), "title");
  const Hdf5Handle frames(H5Gopen2(file.get(), "frames", H5P_DEFAULT), H5Gclose, "read '" + path.string() + "'");
  const auto names = names_in(frames.get());
  std::string text =
      fmt::format("result{}: {} nodes, {} tetrahedra\n", title.empty() ? "" : fmt::format(" of '{}'", title),
                  size_of_dataset(file.get(), "mesh/coordinates")[0], size_of_dataset(file.get(), "mesh/cells")[0]);
  text += names_of(file.get(), "obstacles", "obstacle") + names_of(file.get(), "mechanisms", "part");
  if (names.empty()) return text + "no frames\n";
  const std::string first = instant_of(frames.get(), names.front()), last = instant_of(frames.get(), names.back());
  text += fmt::format("{} frame{} from {}{} to {}\n", names.size(), names.size() == 1 ? "" : "s",
                      first.starts_with("mode") ? "" : "t = ", first, last);
  return text + fields_of(frames.get(), names.back());
}

}  // namespace

std::string describe_result(const std::filesystem::path& path) {
  return hdf5_in_child(path, [&] { return description_of(path); });
}

}  // namespace pliant
