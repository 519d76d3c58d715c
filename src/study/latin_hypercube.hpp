/// Samples of ranges of numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Numbers from `low` to `high`, as a user gives them: "900..1100", "1 MPa..2 MPa", "5..20 ms".
struct NumberRange {
  double low = 0.0, high = 0.0;
  std::string unit;  ///< of both; empty if none was given
  bool is_logarithmic = false;

  /// The number at a share of the range in [0, 1], with its unit: "1.37 MPa". With a logarithmic range equal shares are
  /// equal factors. It has six digits, more where the range is narrow, and never leaves the range.
  std::string at(double share) const;
};

/// The range that a text spells; nothing if it is not of the form NUMBER..NUMBER, with a unit at the end or at both.
/// Throws std::invalid_argument that says what is wrong with one: units that differ, ends that do not ascend.
std::optional<NumberRange> parse_range(const std::string& text);

/// `count` points in the unit cube of `num_ranges` dimensions: in each dimension, one in each of `count` intervals of
/// equal length, at a random place of it, in random order (McKay, Beckman & Conover, Technometrics 21, 1979). Points x
/// dimensions. The same for the same arguments, on every machine.
std::vector<std::vector<double>> latin_hypercube(std::size_t count, std::size_t num_ranges, std::uint64_t seed);

}  // namespace pliant
