#include "energy/shell/hinge.hpp"

namespace pliant {

HingeMap hinge_map(const Vector3<double>* mirror) {
  HingeMap map{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t v = 0; v < 3; ++v) {
      if (v == 2 && mirror != nullptr) continue;
      const std::size_t row = 3 * v + i;
      map[12 * row + i] = -1.0;
      map[12 * row + 3 * (v + 1) + i] = 1.0;
    }
    for (std::size_t j = 0; mirror != nullptr && j < 3; ++j) {
      const double entry = (i == j ? 1.0 : 0.0) - 2.0 * (*mirror)[i] * (*mirror)[j];
      map[12 * (6 + i) + j] = -entry;
      map[12 * (6 + i) + 6 + j] = entry;
    }
  }
  return map;
}

}  // namespace pliant
