#include "mesh/formats/vtk_reader.hpp"

#include "mesh/formats/line_reader.hpp"
#include "mesh/formats/vtk_grid.hpp"
#include "mesh/msh_cursor.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <bit>
#include <map>

namespace pliant {
namespace {

/// The value as an index; -1 if it cannot be one.
std::int64_t integer_of(double value) {
  constexpr double most = 9e15;
  return value >= 0.0 && value < most ? static_cast<std::int64_t>(value) : -1;
}

class VtkFile {
 public:
  explicit VtkFile(std::string_view bytes) : in_(bytes) {}
  SerialMesh read();

 private:
  using Read = double (VtkFile::*)();
  struct Format {
    Read read;
    std::size_t bytes;
    bool is_integer;
  };
  template <class T>
  double one() {
    if (in_.encoding() == Encoding::ascii && std::is_floating_point_v<T>) return in_.number<double>("a number");
    return static_cast<double>(in_.number<T>("an integer"));
  }
  template <class T>
  static constexpr Format format(bool is_integer = true) {
    return {&VtkFile::one<T>, sizeof(T), is_integer};
  }
  static const std::map<std::string, Format>& formats();

  void read_header();
  void read_points();
  void read_cells();
  void read_new_cells(std::size_t num_offsets, std::size_t size);
  void read_cell_types();
  void read_attribute(const std::string& word);
  void read_field();
  void skip_metadata();
  Format number_format();
  std::string name();
  std::size_t count(const char* what);
  std::vector<double> numbers(std::size_t count, const Format& format);
  void keep(std::string name, std::size_t components, const Format& format, std::size_t num_tuples);

  MshCursor in_;
  Encoding encoding_ = Encoding::ascii;
  VtkGrid grid_;
  enum class Of { nothing, cells, points } data_of_ = Of::nothing;
  std::size_t num_data_ = 0;
};

const std::map<std::string, VtkFile::Format>& VtkFile::formats() {
  static const std::map<std::string, Format> known{{"char", format<std::int8_t>()},
                                                   {"unsigned_char", format<std::uint8_t>()},
                                                   {"short", format<std::int16_t>()},
                                                   {"unsigned_short", format<std::uint16_t>()},
                                                   {"int", format<std::int32_t>()},
                                                   {"unsigned_int", format<std::uint32_t>()},
                                                   {"long", format<std::int64_t>()},
                                                   {"unsigned_long", format<std::uint64_t>()},
                                                   {"vtkidtype", format<std::int32_t>()},
                                                   {"vtktypeint64", format<std::int64_t>()},
                                                   {"vtktypeuint64", format<std::uint64_t>()},
                                                   {"vtktypeint32", format<std::int32_t>()},
                                                   {"float", format<float>(false)},
                                                   {"double", format<double>(false)}};
  return known;
}

void VtkFile::read_header() {
  if (MshCursor begin = in_; !begin.line().starts_with("# vtk DataFile Version")) {
    in_.fail("the file does not begin with '# vtk DataFile Version': it is not a .vtk file, or damaged");
  }
  (void)in_.line();
  (void)in_.line();  // the title
  const std::string kind = in_capitals(in_.line());
  if (kind != "ASCII" && kind != "BINARY") in_.fail("ASCII or BINARY is expected in the third line");
  constexpr bool is_big_endian = std::endian::native == std::endian::big;  // as the numbers of the format
  if (kind == "BINARY") encoding_ = is_big_endian ? Encoding::binary : Encoding::binary_swapped;
  const std::string keyword = in_capitals(in_.word()), set = in_capitals(in_.word());
  if (keyword != "DATASET" || set != "UNSTRUCTURED_GRID") {
    in_.fail("DATASET UNSTRUCTURED_GRID is expected here: grids of other kinds have no tetrahedra");
  }
}

std::string VtkFile::name() {
  const std::string_view word = in_.word();
  if (word.empty()) in_.fail_at_end("where a name is expected");
  std::string plain;  // blanks and others are written %20
  for (std::size_t i = 0; i < word.size(); ++i) {
    const auto is_hex = [&](std::size_t k) {
      return k < word.size() && std::isxdigit(static_cast<unsigned char>(word[k])) != 0;
    };
    if (word[i] == '%' && is_hex(i + 1) && is_hex(i + 2)) {
      plain += static_cast<char>(std::stoi(std::string(word.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    } else {
      plain += word[i];
    }
  }
  return plain;
}

std::size_t VtkFile::count(const char* what) {
  return in_.count<std::int64_t>(what, 1);
}

VtkFile::Format VtkFile::number_format() {
  std::string word(in_.word());
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = formats().find(word);
  if (found == formats().end())
    in_.fail("the type of the data is expected here (int, double, ...), not " + in_quotes(word));
  return found->second;
}

/// Numbers that begin in the next line.
std::vector<double> VtkFile::numbers(std::size_t count, const Format& format) {
  (void)in_.line();
  in_.use(encoding_);
  const std::size_t least = encoding_ == Encoding::ascii ? 1 : format.bytes;
  if (count > in_.remaining() / least) in_.fail_at_end("before its " + std::to_string(count) + " numbers");
  std::vector<double> values(count);
  for (double& value : values) value = (this->*format.read)();
  in_.use(Encoding::ascii);
  return values;
}

void VtkFile::read_points() {
  const std::size_t num_points = count("the number of points");
  const Format format = number_format();
  if (!grid_.points.empty()) in_.fail("there is a second POINTS section");
  if (num_points > in_.remaining() / 3) in_.fail_at_end("before its " + std::to_string(num_points) + " points");
  grid_.points = numbers(3 * num_points, format);
}

void VtkFile::read_new_cells(std::size_t num_offsets, std::size_t size) {
  const Format of_offsets = number_format();
  const auto offsets = numbers(num_offsets, of_offsets);
  if (in_capitals(in_.word()) != "CONNECTIVITY") in_.fail("CONNECTIVITY is expected here");
  const Format of_points = number_format();
  for (const double point : numbers(size, of_points)) grid_.connectivity.push_back(integer_of(point));
  for (std::size_t i = 1; i < offsets.size(); ++i) grid_.ends.push_back(integer_of(offsets[i]));
}

// Until version 5: the number of points of each cell, then the points; since then the arrays OFFSETS and CONNECTIVITY.
void VtkFile::read_cells() {
  const std::size_t num_cells = count("the number of cells"), size = count("the size of the list of cells");
  if (!grid_.ends.empty()) in_.fail("there is a second CELLS section");
  MshCursor ahead = in_;
  if (in_capitals(ahead.word()) == "OFFSETS") {
    in_ = ahead;
    return read_new_cells(num_cells, size);
  }
  const auto list = numbers(size, format<std::int32_t>());
  std::size_t at = 0;
  for (std::size_t c = 0; c < num_cells; ++c) {
    const std::int64_t num_points = at < size ? integer_of(list[at]) : -1;
    if (num_points < 0 || static_cast<std::size_t>(num_points) >= size - at) {
      in_.fail_as_damaged("the list of cells ends within cell " + std::to_string(c));
    }
    const auto first = list.begin() + static_cast<std::ptrdiff_t>(at) + 1;
    std::for_each(first, first + num_points, [&](double point) { grid_.connectivity.push_back(integer_of(point)); });
    grid_.ends.push_back(static_cast<std::int64_t>(grid_.connectivity.size()));
    at += static_cast<std::size_t>(num_points) + 1;
  }
}

void VtkFile::read_cell_types() {
  const std::size_t num_cells = count("the number of cells");
  if (!grid_.types.empty()) in_.fail("there is a second CELL_TYPES section");
  for (const double type : numbers(num_cells, format<std::int32_t>())) {
    grid_.types.push_back(integer_of(type));
  }
}

void VtkFile::keep(std::string name, std::size_t components, const Format& format, std::size_t num_tuples) {
  if (num_tuples != 0 && components > in_.remaining() / num_tuples)
    in_.fail_at_end("within the data " + in_quotes(name));
  auto values = numbers(components * num_tuples, format);
  if (data_of_ != Of::cells || components == 0 || num_tuples != num_data_) return;
  grid_.cell_arrays.push_back({std::move(name), components, format.is_integer, std::move(values)});
}

void VtkFile::read_field() {
  (void)name();
  const std::size_t num_arrays = count("the number of arrays");
  for (std::size_t i = 0; i < num_arrays; ++i) {
    std::string array = name();
    while (array == "METADATA") {
      skip_metadata();
      array = name();
    }
    const std::size_t components = count("the number of components"), num_tuples = count("the number of tuples");
    keep(std::move(array), components, number_format(), num_tuples);
  }
}

// Ends with an empty line.
void VtkFile::skip_metadata() {
  (void)in_.line();
  while (in_.remaining() > 0 && !in_.line().empty()) {
  }
}

void VtkFile::read_attribute(const std::string& word) {
  static const std::map<std::string, std::size_t> components_of{
      {"VECTORS", 3}, {"NORMALS", 3}, {"TENSORS", 9}, {"TENSORS6", 6}, {"GLOBAL_IDS", 1}, {"PEDIGREE_IDS", 1}};
  if (word == "SCALARS") {
    std::string array = name();
    const Format format = number_format();
    const auto components = integer_in(in_.line()).value_or(1);
    if (components < 1 || components > 4) in_.fail("scalars have 1 to 4 components");
    MshCursor ahead = in_;
    if (ahead.word() != "LOOKUP_TABLE") in_.fail("LOOKUP_TABLE is expected here");
    (void)ahead.word();
    in_ = ahead;
    return keep(std::move(array), static_cast<std::size_t>(components), format, num_data_);
  }
  const auto found = components_of.find(word);
  if (found == components_of.end()) {
    in_.fail("a section (POINTS, CELLS, CELL_TYPES, CELL_DATA, ...) is expected here, not " + in_quotes(word) +
             ": it is not supported, or the file is damaged; write it as .vtu");
  }
  std::string array = name();
  const Format format = number_format();
  // Numbers of cells are not regions.
  const Of data_of = data_of_;
  if (word.ends_with("_IDS")) data_of_ = Of::nothing;
  keep(std::move(array), found->second, format, num_data_);
  data_of_ = data_of;
}

SerialMesh VtkFile::read() {
  read_header();
  for (std::string word = in_capitals(in_.word()); !word.empty(); word = in_capitals(in_.word())) {
    if (word == "POINTS") {
      read_points();
    } else if (word == "CELLS") {
      read_cells();
    } else if (word == "CELL_TYPES") {
      read_cell_types();
    } else if (word == "CELL_DATA" || word == "POINT_DATA") {
      data_of_ = word == "CELL_DATA" ? Of::cells : Of::points;
      num_data_ = count("the number of points or cells of the data");
    } else if (word == "FIELD") {
      read_field();
    } else if (word == "METADATA") {
      skip_metadata();
    } else {
      read_attribute(word);
    }
  }
  if (grid_.types.empty()) in_.fail_at_end("without cells (CELL_TYPES)");
  return mesh_of_grid(std::move(grid_));
}

}  // namespace

SerialMesh read_vtk(const std::string& file) {
  const std::string bytes = file_contents(file);
  return VtkFile(bytes).read();
}

}  // namespace pliant
