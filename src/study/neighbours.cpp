#include "study/neighbours.hpp"

#include <fmt/format.h>

namespace pliant {

InputError without_neighbours(const std::string& file, const std::string& key) {
  return {{file, 0, 0},
          fmt::format("'{}' is 0, so that no change of it is a small one; give it a value, however small", key)};
}

}  // namespace pliant
