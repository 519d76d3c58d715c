#include "io/facet_file.hpp"

#include "base/file.hpp"

#include <cstdint>
#include <iterator>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

template <class Values>
std::string data_array(const std::string& attributes, const Values& values) {
  std::string text = fmt::format("        <DataArray {} format=\"ascii\">\n", attributes);
  for (const auto& value : values) fmt::format_to(std::back_inserter(text), "{}\n", value);
  return text + "        </DataArray>\n";
}

}  // namespace

void write_facets(const std::filesystem::path& file, std::span<const std::array<Vector3<double>, 3>> corners,
                  std::span<const FacetField> fields) {
  std::map<Vector3<double>, std::int64_t> numbers;
  std::vector<double> points;
  std::vector<std::int64_t> connectivity, offsets;
  for (const auto& triangle : corners) {
    for (const Vector3<double>& corner : triangle) {
      const auto [place, is_new] = numbers.try_emplace(corner, static_cast<std::int64_t>(numbers.size()));
      if (is_new) points.insert(points.end(), corner.begin(), corner.end());
      connectivity.push_back(place->second);
    }
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  constexpr int vtk_triangle = 5;
  const std::vector<int> types(corners.size(), vtk_triangle);
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      numbers.size(), corners.size());
  text += "      <Points>\n" + data_array("type=\"Float64\" NumberOfComponents=\"3\"", points) + "      </Points>\n";
  text += "      <Cells>\n" + data_array("type=\"Int64\" Name=\"connectivity\"", connectivity) +
          data_array("type=\"Int64\" Name=\"offsets\"", offsets) + data_array("type=\"UInt8\" Name=\"types\"", types) +
          "      </Cells>\n      <CellData>\n";
  for (const FacetField& field : fields) {
    if (field.is_whole) {
      const std::vector<std::int64_t> whole(field.values.begin(), field.values.end());
      text += data_array(fmt::format("type=\"Int32\" Name=\"{}\"", field.name), whole);
    } else {
      text += data_array(fmt::format("type=\"Float64\" Name=\"{}\"", field.name), field.values);
    }
  }
  text += "      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
  write_text_atomically(file, text);
}

}  // namespace pliant
