#include "study/latin_hypercube.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A number and what follows it: "5 ms" as 5 and "ms".
struct NumberWithUnit {
  double number;
  std::string unit;
};

std::optional<NumberWithUnit> number_with_unit(std::string_view text) {
  text = trimmed(text);
  for (std::size_t end = text.size(); end > 0; --end) {
    const auto number = parse_number(text.substr(0, end));
    if (!number) continue;
    const std::string unit(trimmed(text.substr(end)));
    const bool is_unit = unit.empty() || std::isalpha(static_cast<unsigned char>(unit[0])) != 0 || unit[0] == '%';
    return is_unit ? std::optional(NumberWithUnit{*number, unit}) : std::nullopt;
  }
  return std::nullopt;
}

/// In [0, 1), with all bits of a double. Unlike the distributions of the standard library, the same everywhere.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace

std::string NumberRange::at(double share) const {
  const double exact = is_logarithmic ? low * std::pow(high / low, share) : low + share * (high - low);
  const double narrow = std::max(std::abs(low), std::abs(high)) / (high - low);
  const int digits = std::clamp(5 + static_cast<int>(std::ceil(std::log10(narrow))), 6, 17);
  const double rounded = std::clamp(*parse_number(fmt::format("{:.{}g}", exact, digits)), low, high);
  return unit.empty() ? format_number(rounded) : format_number(rounded) + " " + unit;
}

std::optional<NumberRange> parse_range(const std::string& text) {
  const auto dots = text.find("..");
  if (dots == std::string::npos) return std::nullopt;
  const auto low = number_with_unit(std::string_view(text).substr(0, dots));
  const auto high = number_with_unit(std::string_view(text).substr(dots + 2));
  if (!low || !high) return std::nullopt;
  if (!low->unit.empty() && low->unit != high->unit) {
    throw std::invalid_argument(
        fmt::format("the ends of the range '{}' have different units: give both the same, or "
                    "one for both, as in 1..2 MPa",
                    text));
  }
  if (!(low->number < high->number)) {
    throw std::invalid_argument(fmt::format("the range '{}' does not ascend: write LOW..HIGH", text));
  }
  return NumberRange{low->number, high->number, high->unit};
}

std::vector<std::vector<double>> latin_hypercube(std::size_t count, std::size_t num_ranges, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::vector<double>> points(count, std::vector<double>(num_ranges));
  std::vector<std::size_t> interval(count);
  for (std::size_t d = 0; d < num_ranges; ++d) {
    std::iota(interval.begin(), interval.end(), std::size_t{0});
    for (std::size_t i = count; i > 1; --i) {
      std::swap(interval[i - 1], interval[static_cast<std::size_t>(uniform(random) * static_cast<double>(i))]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      points[i][d] = (static_cast<double>(interval[i]) + uniform(random)) / static_cast<double>(count);
    }
  }
  return points;
}

}  // namespace pliant
