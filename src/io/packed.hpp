/// Compression of numbers for pages that carry their data: quantised, predicted in time and from their neighbours,
/// deflated, encoded as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The bytes as a zlib stream (RFC 1950) in base64 (RFC 4648).
std::string packed_text(std::span<const std::byte> bytes);

/// Integers 0 .. `levels` represent values from low to high, evenly spaced.
struct Quantisation {
  double low = 0.0;
  double high = 0.0;
  int levels = 65535;

  /// Rounds to nearest; NaN becomes the lowest value.
  std::uint16_t operator()(double value) const;
};

/// For each vertex of the triangles: the preceding vertices from which a side leads up in number to it; if there is
/// none, the vertex before it (vertex 0 has none).
struct EarlierNeighbours {
  explicit EarlierNeighbours(std::size_t num_vertices = 0, std::span<const std::int32_t> triangles = {});

  std::vector<std::size_t> first;  ///< those of vertex v: `vertices` from first[v] to first[v + 1]
  std::vector<std::int32_t> vertices;
};

/// Rows of a whole number q at each vertex, a row per frame. In time q(f, v) is predicted by p = q(f-1, v), or, from
/// the third row on, by p = 2 q(f-1, v) - q(f-2, v): the order of prediction is 1 or 2, whichever leaves less; rows
/// before the first are 0. In space q - p is predicted by its mean m over the earlier neighbours, rounded to the
/// nearest (up where two are). What is kept is r = q - p - m modulo 2^16, as 2 r or -2 r - 1, whichever is not
/// negative: a byte for the order, then all lower bytes, then all upper ones.
class PackedRows {
 public:
  /// The neighbours must outlive this object.
  explicit PackedRows(const EarlierNeighbours& neighbours) : neighbours_(neighbours) {}
  /// Appends a row with one number per vertex.
  void append(std::vector<std::uint16_t> row);
  std::string text() const;

 private:
  std::vector<std::uint16_t> coded(int order) const;

  const EarlierNeighbours& neighbours_;
  std::vector<std::vector<std::uint16_t>> rows_;
};

}  // namespace pliant
