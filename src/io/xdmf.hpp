/// The text of an XDMF 3 file: which arrays of result.h5 make up the grid of each frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// A rows x columns array in an HDF5 file, as XDMF refers to it.
struct XdmfArray {
  std::string place;  ///< "result.h5:/frames/000000/displacement"
  enum class Number { float64, int64, int32 } number = Number::float64;
  std::int64_t rows = 0;
  int columns = 1;
};

/// A field on the nodes or cells of a grid.
struct XdmfField {
  std::string name;
  std::string unit;  ///< empty if there is none
  enum class Center { node, cell } center = Center::node;
  XdmfArray values;
};

/// One frame of the time series.
struct XdmfGrid {
  std::string name;
  double time = 0;  ///< [s]
  std::int64_t step = 0;
  XdmfArray cells;        ///< 2 columns: lines; 3: triangles; 4: linear tetrahedra; 10: quadratic ones
  XdmfArray coordinates;  ///< 3 columns
  std::vector<XdmfField> fields;
};

/// `text` with XML's special characters escaped, for an attribute value or an element's content.
std::string xml_escaped(const std::string& text);

/// The <Grid> element of one frame.
std::string to_xml(const XdmfGrid& grid);

/// The whole file; `grids`: the <Grid> elements of the frames in order of time.
std::string xdmf_document(const std::string& title, const std::string& grids);

/// The <Grid> elements in a text made by xdmf_document, up to the frame of step `last_step`.
std::string grids_up_to_step(const std::string& document, std::int64_t last_step);
/// The elements of a file; none if it cannot be read.
std::string listed_frames(const std::filesystem::path& file, std::int64_t last_step);

}  // namespace pliant
