#include "io/xdmf.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

namespace pliant {
namespace {

std::string_view number_type(XdmfArray::Number number) {
  return number == XdmfArray::Number::float64 ? "Float" : "Int";
}

int precision(XdmfArray::Number number) {
  return number == XdmfArray::Number::int32 ? 4 : 8;
}

// Symmetric tensors have six columns xx, yy, zz, xy, yz, xz. XDMF's own "Tensor6" means another order (xx, xy, xz, yy,
// yz, zz), which its readers do not honour alike; as a "Matrix" the columns arrive as written, and VTK and ParaView
// label six columns in our order.
std::string_view attribute_type(int columns) {
  switch (columns) {
    case 1:
      return "Scalar";
    case 3:
      return "Vector";
    case 9:
      return "Tensor";
    default:
      return "Matrix";
  }
}

std::string_view topology_type(int nodes_per_cell) {
  switch (nodes_per_cell) {
    case 2:
      return "Polyline";
    case 3:
      return "Triangle";
    case 4:
      return "Tetrahedron";
    default:
      return "Tetrahedron_10";
  }
}

std::string to_xml(const XdmfArray& array) {
  const std::string dimensions =
      array.columns == 1 ? fmt::format("{}", array.rows) : fmt::format("{} {}", array.rows, array.columns);
  return fmt::format(R"(<DataItem Format="HDF" NumberType="{}" Precision="{}" Dimensions="{}">{}</DataItem>)",
                     number_type(array.number), precision(array.number), dimensions, xml_escaped(array.place));
}

std::string to_xml(const XdmfField& field) {
  std::string text =
      fmt::format("        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">\n", xml_escaped(field.name),
                  attribute_type(field.values.columns), field.center == XdmfField::Center::node ? "Node" : "Cell");
  if (!field.unit.empty()) {
    text += fmt::format("          <Information Name=\"unit\" Value=\"{}\"/>\n", xml_escaped(field.unit));
  }
  return text + fmt::format("          {}\n        </Attribute>\n", to_xml(field.values));
}

}  // namespace

std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&apos;";
        break;
      default:
        // XML 1.0 does not allow other control characters, not even escaped.
        escaped += static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' ? ' ' : c;
    }
  }
  return escaped;
}

std::string to_xml(const XdmfGrid& grid) {
  const std::string nodes_per_line = grid.cells.columns == 2 ? R"( NodesPerElement="2")" : "";
  std::string text = fmt::format(
      R"(      <Grid Name="{}" GridType="Uniform">
        <Time Value="{}"/>
        <Information Name="step" Value="{}"/>
        <Topology TopologyType="{}"{} NumberOfElements="{}">
          {}
        </Topology>
        <Geometry GeometryType="XYZ">
          {}
        </Geometry>
)",
      xml_escaped(grid.name), grid.time, grid.step, topology_type(grid.cells.columns), nodes_per_line, grid.cells.rows,
      to_xml(grid.cells), to_xml(grid.coordinates));
  for (const auto& field : grid.fields) text += to_xml(field);
  return text + "      </Grid>\n";
}

std::string xdmf_document(const std::string& title, const std::string& grids) {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<Xdmf Version="3.0">
  <Domain>
    <Information Name="title" Value="{}"/>
    <Grid Name="{}" GridType="Collection" CollectionType="Temporal">
{}    </Grid>
  </Domain>
</Xdmf>
)",
      xml_escaped(title), xml_escaped(title), grids);
}

std::string grids_up_to_step(const std::string& document, std::int64_t last_step) {
  const std::string begin = "      <Grid ", end = "      </Grid>\n", step = "<Information Name=\"step\" Value=\"";
  std::string kept;
  std::size_t at = document.find(begin);
  while (at != std::string::npos) {
    const std::size_t past = document.find(end, at), value = document.find(step, at);
    if (past == std::string::npos || value > past) break;
    if (std::strtoll(document.c_str() + value + step.size(), nullptr, 10) > last_step) break;
    kept += document.substr(at, past + end.size() - at);
    at = document.find(begin, past);
  }
  return kept;
}

std::string listed_frames(const std::filesystem::path& file, std::int64_t last_step) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return grids_up_to_step(text.str(), last_step);
}

}  // namespace pliant
