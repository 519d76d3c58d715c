#include "base/error.hpp"
#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "io/result_info.hpp"
#include "io/result_writer.hpp"

#include <fmt/format.h>

namespace pliant::fuzz {
namespace {

constexpr int num_frames = 2;  // of the result in the corpus

/// The list of frames beside the file, which a run that goes on reads first.
std::string list_of_frames(const std::string& file) {
  std::string grids;
  for (int frame = 0; frame < num_frames; ++frame) {
    XdmfGrid grid;
    grid.name = fmt::format("{}", frame);
    grid.step = frame;
    grid.cells = {file + ":/mesh/cells", XdmfArray::Number::int64, 1, 4};
    grid.coordinates = {file + ":/mesh/coordinates", XdmfArray::Number::float64, 4, 3};
    const XdmfArray values{fmt::format("{}:/frames/{:06}/u", file, frame), XdmfArray::Number::float64, 4, 3};
    grid.fields = {{"u", "m", XdmfField::Center::node, values}};
    grids += to_xml(grid);
  }
  return xdmf_document("", grids);
}

OutputMesh tetrahedron() {
  OutputMesh mesh;
  mesh.global_num_nodes = 4;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  mesh.cells = {0, 1, 2, 3};
  mesh.bodies = {0};
  mesh.body_names = {"body"};
  return mesh;
}

/// Whether a superblock of version 0, such as HDF5 gives our files, has the address of information of a driver: HDF5
/// may take gigabytes for that, which makes a search slow. tests/program/test_restart.py has such a file.
bool has_driver_information(std::string_view bytes) {
  constexpr std::size_t place = 48, size = 8;
  return bytes.size() >= place + size && bytes.substr(place, size) != std::string(size, '\xFF');
}

}  // namespace

void read_as_result(std::string_view bytes) {
  if (has_driver_information(bytes)) return;
  const BytesInFile file(bytes, ".h5");
  try {
    (void)describe_result(file.path());
  } catch (const FileError&) {
  }
  const BytesInFile list(list_of_frames(file.path().filename().string()), ".xdmf");
  try {
    ResultWriter writer(MPI_COMM_SELF, {file.path().parent_path(), file.path().stem().string()}, "", tetrahedron(),
                        /*last_step=*/0);
    const std::vector<double> values(12, 0.5);
    const OutputField field{"u", "m", FieldLocation::node, 3, values};
    writer.write_frame(1.0, 1, {&field, 1});
  } catch (const FileError&) {
  }
}

}  // namespace pliant::fuzz
