#include "study/neighbours.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {

double size_of_number(const std::string& key, double value) {
  const double size = std::abs(value), distance = std::abs(0.5 - value);
  return key.ends_with("poissons_ratio") && distance > 0.0 ? std::min(size, distance) : size;
}

InputError without_neighbours(const std::string& file, const std::string& key) {
  return {{file, 0, 0},
          fmt::format("'{}' is 0, so that no change of it is a small one; give it a value, however small", key)};
}

}  // namespace pliant
