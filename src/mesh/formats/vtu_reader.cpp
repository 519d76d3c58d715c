#include "mesh/formats/vtu_reader.hpp"

#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/vtk_grid.hpp"
#include "mesh/formats/vtu_xml.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <functional>
#include <limits>
#include <zlib.h>

namespace pliant {
namespace {

/// The value of a digit of base64; 64 for '=', 65 for other characters.
int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return c == '=' ? 64 : 65;
}

/// Bytes of base64 (RFC 4648). Several texts may follow one another, each padded with '='; the text ends at the first
/// character of another kind.
std::string from_base64(std::string_view text) {
  std::string bytes;
  std::array<int, 4> group{};
  std::size_t filled = 0;
  for (const char c : text) {
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    const int digit = base64_digit(c);
    if (digit == 65) break;
    group[filled++] = digit;
    if (filled < 4) continue;
    filled = 0;
    const int d2 = group[2] & 63, d3 = group[3] & 63;
    bytes += static_cast<char>((group[0] << 2) | ((group[1] & 63) >> 4));
    if (group[2] < 64) bytes += static_cast<char>((group[1] << 4) | (d2 >> 2));
    if (group[3] < 64 && group[2] < 64) bytes += static_cast<char>((d2 << 6) | d3);
  }
  return bytes;
}

/// The type of the numbers of an array.
struct VtuType {
  const char* name;
  std::size_t bytes;
  bool is_integer;
  std::function<double(const char*)> read;
};

template <class T>
VtuType vtu_type(const char* name) {
  return {name, sizeof(T), std::is_integral_v<T>, [](const char* bytes) {
            T value{};
            std::memcpy(&value, bytes, sizeof(T));
            return static_cast<double>(value);
          }};
}

const VtuType* type_named(const std::string& name) {
  static const std::array<VtuType, 10> types{vtu_type<std::int8_t>("Int8"),   vtu_type<std::uint8_t>("UInt8"),
                                             vtu_type<std::int16_t>("Int16"), vtu_type<std::uint16_t>("UInt16"),
                                             vtu_type<std::int32_t>("Int32"), vtu_type<std::uint32_t>("UInt32"),
                                             vtu_type<std::int64_t>("Int64"), vtu_type<std::uint64_t>("UInt64"),
                                             vtu_type<float>("Float32"),      vtu_type<double>("Float64")};
  const auto found = std::ranges::find_if(types, [&](const VtuType& type) { return name == type.name; });
  return found == types.end() ? nullptr : &*found;
}

class VtuFile {
 public:
  explicit VtuFile(std::string_view bytes) : document_(parse_xml(bytes)) {}
  SerialMesh read();

 private:
  [[noreturn]] static void fail(const XmlElement& element, const std::string& message);
  void read_settings();
  const XmlElement& only(const XmlElement& parent, const char* name) const;
  const XmlElement& array_named(const XmlElement& parent, const char* name) const;
  std::vector<double> values(const XmlElement& array) const;
  std::vector<double> values_of_text(const XmlElement& array) const;
  std::vector<std::int64_t> integers(const XmlElement& array) const;
  std::string bytes(const XmlElement& array) const;
  std::string_view appended_part(const XmlElement& array) const;
  std::string unpacked(const XmlElement& array, std::string_view raw) const;
  std::string inflated(const XmlElement& array, std::string_view raw) const;
  std::uint64_t header(const XmlElement& array, std::string_view raw, std::size_t number) const;
  VtkArray cell_array(const XmlElement& array) const;

  XmlDocument document_;
  bool is_swapped_ = false, is_compressed_ = false, is_appended_base64_ = false;
  std::size_t header_bytes_ = 4;
};

void VtuFile::fail(const XmlElement& element, const std::string& message) {
  const std::string name = element.attribute("Name");
  throw MeshDefect("line " + std::to_string(element.line) + ": " +
                   (name.empty() ? "<" + element.name + ">" : "the array " + in_quotes(name)) + " " + message);
}

const XmlElement& VtuFile::only(const XmlElement& parent, const char* name) const {
  const auto found = document_.children(parent, name);
  if (found.empty()) fail(parent, std::string("has no <") + name + ">: the file is damaged, or of another kind");
  if (found.size() > 1) {
    fail(*found[1],
         "is there " + std::to_string(found.size()) +
             " times, but the mesh must be one piece: in ParaView, Merge Blocks or Append Datasets, and save it again");
  }
  return *found.front();
}

void VtuFile::read_settings() {
  const XmlElement& root = document_.elements.front();
  if (root.name != "VTKFile" || root.attribute("type") != "UnstructuredGrid") {
    fail(root, "is expected to be VTKFile of type UnstructuredGrid: files of other kinds have no tetrahedra");
  }
  is_swapped_ = (root.attribute("byte_order") == "BigEndian") == (std::endian::native == std::endian::little);
  header_bytes_ = root.attribute("header_type") == "UInt64" ? 8 : 4;
  const std::string compressor = root.attribute("compressor");
  is_compressed_ = !compressor.empty();
  if (is_compressed_ && compressor != "vtkZLibDataCompressor") {
    fail(root, "is compressed by " + in_quotes(compressor) +
                   ", which is not supported: save it with ZLib or without compression");
  }
  for (const XmlElement* appended : document_.children(root, "AppendedData")) {
    is_appended_base64_ = appended->attribute("encoding") == "base64";
  }
}

std::uint64_t VtuFile::header(const XmlElement& array, std::string_view raw, std::size_t number) const {
  if (number >= raw.size() / header_bytes_) fail(array, "is incomplete: the file is truncated; write or copy it again");
  std::array<char, 8> bytes{};
  std::memcpy(bytes.data(), raw.data() + number * header_bytes_, header_bytes_);
  if (is_swapped_) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header_bytes_));
  constexpr bool is_little = std::endian::native == std::endian::little;
  if (!is_little && header_bytes_ == 4) std::rotate(bytes.begin(), bytes.begin() + 4, bytes.end());
  return std::bit_cast<std::uint64_t>(bytes);
}

// Number of blocks, their size, that of a last partial block (or 0), the compressed size of each; then the blocks.
std::string VtuFile::inflated(const XmlElement& array, std::string_view raw) const {
  constexpr std::uint64_t best_packing = 1100;
  const std::uint64_t num_blocks = header(array, raw, 0);
  if (num_blocks == 0) return "";
  const std::uint64_t size = header(array, raw, 1), last = header(array, raw, 2);
  const char* const damaged = "is damaged: its compressed blocks do not fit; write or copy the file again";
  if (num_blocks > raw.size() / header_bytes_ || size > best_packing * raw.size() || last > size) fail(array, damaged);
  std::size_t at = (3 + num_blocks) * header_bytes_;
  std::string result;
  for (std::uint64_t b = 0; b < num_blocks; ++b) {
    const std::uint64_t packed = header(array, raw, 3 + b);
    if (at > raw.size() || packed > raw.size() - at) {
      fail(array, "is incomplete: the file is truncated; write or copy it again");
    }
    const std::uint64_t expected = b + 1 == num_blocks && last != 0 ? last : size;
    if (expected > best_packing * (packed + 1)) fail(array, damaged);
    std::string block(expected, '\0');
    uLongf length = expected;
    const int code = uncompress(reinterpret_cast<Bytef*>(block.data()), &length,
                                reinterpret_cast<const Bytef*>(raw.data() + at), packed);
    if (code != Z_OK || length != expected) fail(array, damaged);
    result += block;
    at += packed;
  }
  return result;
}

std::string VtuFile::unpacked(const XmlElement& array, std::string_view raw) const {
  if (is_compressed_) return inflated(array, raw);
  const std::uint64_t size = header(array, raw, 0);
  if (size > raw.size() - header_bytes_) fail(array, "is incomplete: the file is truncated; write or copy it again");
  return std::string(raw.substr(header_bytes_, size));
}

std::string_view VtuFile::appended_part(const XmlElement& array) const {
  const auto offset = integer_in(array.attribute("offset"));
  if (!offset || *offset < 0 || static_cast<std::size_t>(*offset) >= document_.appended.size()) {
    fail(array, "is not where its offset says: the file is truncated or damaged; write or copy it again");
  }
  std::int64_t end = static_cast<std::int64_t>(document_.appended.size());  // where the next one begins
  for (const XmlElement& other : document_.elements) {
    if (const auto begin = integer_in(other.attribute("offset")); begin && *begin > *offset)
      end = std::min(end, *begin);
  }
  return document_.appended.substr(static_cast<std::size_t>(*offset), static_cast<std::size_t>(end - *offset));
}

std::string VtuFile::bytes(const XmlElement& array) const {
  const std::string format = array.attribute("format");
  if (format == "binary") return unpacked(array, from_base64(array.text));
  if (format != "appended") fail(array, "has the unknown format " + in_quotes(format));
  const std::string_view part = appended_part(array);
  return is_appended_base64_ ? unpacked(array, from_base64(part)) : unpacked(array, part);
}

std::vector<double> VtuFile::values_of_text(const XmlElement& array) const {
  std::vector<double> result;
  const std::string_view text = array.text;
  const auto is_blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  for (auto at = std::find_if_not(text.begin(), text.end(), is_blank); at != text.end();) {
    const auto end = std::find_if(at, text.end(), is_blank);
    const std::string_view word(&*at, static_cast<std::size_t>(end - at));
    const auto value = real_in(word);
    if (!value) fail(array, "has " + in_quotes(word) + " where a number is expected");
    result.push_back(*value);
    at = std::find_if_not(end, text.end(), is_blank);
  }
  return result;
}

std::vector<double> VtuFile::values(const XmlElement& array) const {
  if (array.attribute("format").empty() || array.attribute("format") == "ascii") return values_of_text(array);
  const VtuType* const type = type_named(array.attribute("type"));
  if (type == nullptr) fail(array, "has the unknown type " + in_quotes(array.attribute("type")));
  std::string raw = bytes(array);
  if (raw.size() % type->bytes != 0) fail(array, "is damaged: it ends within a number");
  std::vector<double> result;
  result.reserve(raw.size() / type->bytes);
  for (std::size_t at = 0; at < raw.size(); at += type->bytes) {
    const auto number = raw.begin() + static_cast<std::ptrdiff_t>(at);
    if (is_swapped_) std::reverse(number, number + static_cast<std::ptrdiff_t>(type->bytes));
    result.push_back(type->read(&raw[at]));
  }
  return result;
}

std::vector<std::int64_t> VtuFile::integers(const XmlElement& array) const {
  constexpr double most = 9e15;
  std::vector<std::int64_t> result;
  for (const double value : values(array)) {
    if (!(value >= 0.0 && value < most)) fail(array, "has a number that is negative or too large");
    result.push_back(static_cast<std::int64_t>(value));
  }
  return result;
}

const XmlElement& VtuFile::array_named(const XmlElement& parent, const char* name) const {
  for (const XmlElement* array : document_.children(parent, "DataArray")) {
    if (array->attribute("Name") == name) return *array;
  }
  fail(parent, std::string("has no array '") + name + "': the file is damaged");
}

VtkArray VtuFile::cell_array(const XmlElement& array) const {
  const VtuType* const type = type_named(array.attribute("type"));
  if (type == nullptr) fail(array, "has the unknown type " + in_quotes(array.attribute("type")));
  const std::int64_t components = integer_in(array.attribute("NumberOfComponents")).value_or(1);
  if (components < 1 || components > 1000) fail(array, "has an impossible number of components");
  return {array.attribute("Name"), static_cast<std::size_t>(components), type->is_integer, values(array)};
}

SerialMesh VtuFile::read() {
  read_settings();
  const XmlElement& piece = only(only(document_.elements.front(), "UnstructuredGrid"), "Piece");
  VtkGrid grid;
  const XmlElement& points = only(only(piece, "Points"), "DataArray");
  grid.points = values(points);
  const auto num_points = integer_in(piece.attribute("NumberOfPoints"));
  const auto num_cells = integer_in(piece.attribute("NumberOfCells"));
  if (!num_points || *num_points < 0 || grid.points.size() / 3 != static_cast<std::size_t>(*num_points) ||
      grid.points.size() % 3 != 0) {
    fail(points, "has " + std::to_string(grid.points.size()) +
                     " numbers, not three for each of the NumberOfPoints: the file is truncated or damaged");
  }
  const XmlElement& cells = only(piece, "Cells");
  grid.connectivity = integers(array_named(cells, "connectivity"));
  grid.ends = integers(array_named(cells, "offsets"));
  grid.types = integers(array_named(cells, "types"));
  if (!num_cells || *num_cells < 0 || grid.types.size() != static_cast<std::size_t>(*num_cells)) {
    fail(cells, "has " + std::to_string(grid.types.size()) +
                    " types, not one for each of the NumberOfCells: the file is truncated or damaged");
  }
  for (const XmlElement* data : document_.children(piece, "CellData")) {
    for (const XmlElement* array : document_.children(*data, "DataArray")) {
      grid.cell_arrays.push_back(cell_array(*array));
    }
  }
  return mesh_of_grid(std::move(grid));
}

}  // namespace

SerialMesh read_vtu(const std::string& file) {
  const std::string bytes = file_contents(file);
  return VtuFile(bytes).read();
}

}  // namespace pliant
