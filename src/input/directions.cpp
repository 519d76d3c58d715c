#include "input/directions.hpp"

#include "base/vector3.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {

std::string at_place(const std::array<double, 3>& X) {
  return fmt::format(" at ({:g}, {:g}, {:g})", X[0], X[1], X[2]);
}

bool DirectionRule::is_uniform() const {
  const auto varies = [](const Expression& e) { return e.depends_on_space(); };
  return given_.cell_data.empty() && std::ranges::none_of(given_.value, varies);
}

void DirectionRule::bind(const CellData& data) {
  if (given_.cell_data.empty()) return;
  number_ = data.find(given_.cell_data, 3, given_.where);
  data_ = &data;
}

std::array<double, 3> DirectionRule::at(PetscInt cell, const std::array<double, 3>& X) const {
  std::array<double, 3> d{};
  if (data_ != nullptr) {
    std::ranges::copy(data_->at(number_, cell), d.begin());
  } else {
    for (int i = 0; i < 3; ++i) d[i] = given_.value[i](X[0], X[1], X[2], 0.0);
  }
  const double length = std::hypot(d[0], d[1], d[2]);
  if (!(length > 0.0) || !std::isfinite(length)) {
    const std::string place = is_uniform() ? "" : at_place(X);
    throw InputError(given_.where, std::isnan(length) && data_ != nullptr
                                       ? fmt::format("cell data '{}' has no value{}", given_.cell_data, place)
                                       : fmt::format("'{}' has no direction{}: its components are ({:g}, {:g}, {:g})",
                                                     given_.key, place, d[0], d[1], d[2]));
  }
  return (1.0 / length) * d;
}

std::optional<std::array<double, 3>> across(const std::array<double, 3>& first, const std::array<double, 3>& second) {
  const std::array<double, 3> rest = second - dot(first, second) * first;
  const double length = std::sqrt(dot(rest, rest));
  if (length < 1e-6) return std::nullopt;
  return (1.0 / length) * rest;
}

}  // namespace pliant
