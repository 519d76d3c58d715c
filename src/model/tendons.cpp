#include "model/tendons.hpp"

#include "base/vector3.hpp"
#include "petsc/collective.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

/// How far outside the mesh a point may lie, in units of the distance to the next one: rounding, and curved surfaces.
constexpr double slack = 1e-3;

}  // namespace

double length_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u) {
  std::vector<double> places;
  for (const ProbeLocation& point : tendon.points) {
    const auto X = point.interpolate(layout.coordinates), d = point.interpolate(u);
    for (std::size_t i = 0; i < 3; ++i) places.push_back(X[i] + d[i]);
  }
  sum_in_place(layout.comm, places);
  double length = 0.0;
  for (std::size_t k = 3; k < places.size(); k += 3) {
    length +=
        norm(Vector3<double>{places[k] - places[k - 3], places[k + 1] - places[k - 2], places[k + 2] - places[k - 1]});
  }
  return length;
}

std::vector<ModelTendon> make_tendons(const Config& config, const NodeLayout& layout,
                                      std::span<const char> is_left_out) {
  std::vector<ModelTendon> result;
  std::vector<Diagnostic> errors;
  for (const TendonConfig& tendon : config.tendons) {
    const auto locations = locate(layout, tendon.points, is_left_out);
    for (std::size_t k = 0; k < locations.size(); ++k) {
      const Vector3<double> X = tendon.points[k], next = tendon.points[k == 0 ? 1 : k - 1];
      if (locations[k].distance == 0.0) continue;
      const double far = nearest_of_mesh(layout, tendon.points[k], is_left_out).distance;
      if (far <= slack * norm(next - X)) continue;
      errors.push_back(
          {Severity::error, tendon.where,
           fmt::format("point {} of tendon '{}' at ({:g}, {:g}, {:g}) lies {:.3g} m outside the mesh; its points "
                       "are places in the bodies",
                       k, tendon.name, X[0], X[1], X[2], far)});
    }
    result.push_back({tendon.name, locations, std::make_unique<Tendon>(layout, locations, tendon.tension)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  return result;
}

}  // namespace pliant
