#include "model/springs.hpp"

#include "input/analysis.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

/// A term of those springs whose coefficient is not zero; none if there are none. Collective.
template <class Term>
void add_term(const NodeLayout& layout, double LineSpring::*coefficient, ModelSprings& model) {
  std::vector<AttachedPoint> points;
  std::vector<LineSpring> springs;
  for (std::size_t k = 0; k < model.springs.size(); ++k) {
    if (model.springs[k].*coefficient == 0.0) continue;
    springs.push_back(model.springs[k]);
    for (std::size_t end = 0; end < 2; ++end) points.push_back(model.points[2 * k + end]);
  }
  if (!springs.empty()) model.terms.push_back(std::make_unique<Term>(layout, points, std::move(springs)));
}

}  // namespace

ModelSprings make_springs(const BodiesOnMesh& bodies) {
  ModelSprings model;
  std::vector<Diagnostic> errors;
  const bool is_static = analysis_of(bodies.config) == Analysis::static_equilibrium;
  for (const SpringConfig& spring : bodies.config.springs) {
    const Vector3<double> a = spring.points[0].point, b = spring.points[1].point;
    for (AttachedPoint& point : attach(bodies, spring.points, {"spring '" + spring.name + "'", norm(b - a)}, errors)) {
      model.points.push_back(std::move(point));
    }
    model.names.push_back(spring.name);
    model.springs.push_back({spring.stiffness, 0.0, is_static ? 0.0 : spring.damping, spring.is_tension_only});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  const std::vector<double> at_rest(3 * static_cast<std::size_t>(bodies.layout.num_local_nodes), 0.0);
  const auto places = places_of(model.points, bodies.layout, at_rest);
  for (std::size_t k = 0; k < model.springs.size(); ++k) {
    model.springs[k].rest = bodies.config.springs[k].rest.value_or(norm(places[2 * k + 1] - places[2 * k]));
  }
  add_term<Springs>(bodies.layout, &LineSpring::stiffness, model);
  add_term<Dampers>(bodies.layout, &LineSpring::damping, model);
  return model;
}

std::vector<double> states_of(const ModelSprings& springs, const NodeLayout& layout, std::span<const double> u,
                              std::span<const double> v) {
  const auto places = places_of(springs.points, layout, u), velocities = field_at(springs.points, layout, v);
  std::vector<double> states;
  for (std::size_t k = 0; k < springs.springs.size(); ++k) {
    const Vector3<double> d = places[2 * k + 1] - places[2 * k];
    const double length = norm(d);
    states.insert(states.end(), {length, springs.springs[k].force(d, velocities[2 * k + 1] - velocities[2 * k])});
  }
  return states;
}

}  // namespace pliant
