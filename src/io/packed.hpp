/// Numbers made small, for pages that carry their data: quantised, predicted from their neighbours, deflated, as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The bytes as a zlib stream (RFC 1950) in base64 (RFC 4648).
std::string packed_text(std::span<const std::byte> bytes);

/// Whole numbers 0 .. `levels` stand for low .. high; evenly spaced.
struct Quantisation {
  double low = 0.0;
  double high = 0.0;
  int levels = 65535;

  /// The nearest; what is no number counts as low.
  std::uint16_t operator()(double value) const;
};

/// Rows of equally many whole numbers, e.g. a value at all vertices, a row per frame. What is kept of number v of row f
/// is its difference r from q(f-1, v) + q(f, v-1) - q(f-1, v-1) (Lorenzo's predictor; numbers outside are 0; modulo
/// 2^16), as 2 r or -2 r - 1, whichever is not negative: all lower bytes, then all upper ones.
class PackedRows {
 public:
  explicit PackedRows(std::size_t row_size) : before_(row_size, 0) {}
  /// Appends a row; it has the size of all rows.
  void append(std::span<const std::uint16_t> row);
  std::string text() const;

 private:
  std::vector<std::uint16_t> before_;
  std::vector<std::byte> low_, high_;
};

}  // namespace pliant
