#include "model/body_contact_laws.hpp"

#include "collision/candidates.hpp"
#include "model/contact_defaults.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace pliant {

namespace {

/// Along its surface, what is thin does not feel itself over this multiple of the distance that it keeps: a rod, bent
/// to a circle of 1.3 radii, still does not touch itself there.
constexpr double neighbour_part = 3.0;

/// How thick the surface of each body is [m]; 0: a solid.
std::vector<double> thicknesses(const CollisionSurface& surface, std::size_t num_bodies) {
  std::vector<double> result(num_bodies, 0.0);
  for (const auto& triangle : surface.triangles()) result[triangle.body] = triangle.thickness;
  return result;
}

}  // namespace

std::vector<double> facet_sizes(const CollisionSurface& surface, std::size_t num_bodies, double triangles_per_facet) {
  std::vector<double> area(num_bodies, 0.0), number(num_bodies, 0.0), size(num_bodies, 0.0);
  for (const auto& triangle : surface.triangles()) {
    area[triangle.body] += triangle.area;
    number[triangle.body] += triangle.is_segment() ? 1.0 : 1.0 / triangles_per_facet;
  }
  for (std::size_t b = 0; b < num_bodies; ++b) size[b] = number[b] > 0.0 ? std::sqrt(2.0 * area[b] / number[b]) : 0.0;
  return size;
}

BodyContactLaws body_contact_laws(const ContactConfig& config, const ContactPairConfig* pair,
                                  const BodyStiffnesses& bodies, const CollisionSurface& surface,
                                  std::span<const Vector3<double>> start, double triangles_per_facet) {
  const auto& [names, shear_moduli] = bodies;
  const std::size_t n = names.size();
  const std::vector<double> sizes = facet_sizes(surface, n, triangles_per_facet);
  const ContactPressureConfig& common = config.pressure;
  const auto given = [&](std::optional<double> ContactPairConfig::*of_pair, std::optional<double> of_all) {
    return pair != nullptr && pair->*of_pair ? pair->*of_pair : of_all;
  };
  const auto stiffness = given(&ContactPairConfig::stiffness, common.stiffness);
  const auto width = given(&ContactPairConfig::width, common.width);
  const std::vector<double> thick = thicknesses(surface, n);
  const auto threshold_of = [&](std::size_t a, std::size_t b) {
    if (pair != nullptr && pair->thickness) return *pair->thickness;
    return common.threshold + 0.5 * (thick[a] + thick[b]);
  };
  const NormalKind kind = config.law_of(pair);
  const double widest = width.value_or(width_per_facet * *std::ranges::max_element(sizes));
  BodyContactLaws laws{static_cast<int>(n), {}, {}};
  double thickest = 0.0;
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b < n; ++b) {
      const bool is_thin = thick[a] > 0.0 || thick[b] > 0.0;
      thickest = std::max(thickest, threshold_of(a, b));
      laws.neighbour_distances.push_back(is_thin ? neighbour_part * threshold_of(a, b) : 0.0);
    }
  }
  const SurfaceNeighbours neighbours(surface, laws.num_bodies, laws.neighbour_distances);
  const double far = 2.0 * widest + thickest;
  const auto at_rest = least_distances(surface, surface.rest_positions(), laws.num_bodies, far, neighbours),
             at_start = least_distances(surface, start, laws.num_bodies, far, neighbours);
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b < n; ++b) {
      // Parts of one body that are near each other at the start only are folded: there is no room to leave.
      const double threshold = threshold_of(a, b);
      const double apart = a == b ? at_rest[n * a + b] : std::min(at_rest[n * a + b], at_start[n * a + b]);
      const double h = std::min(sizes[a], sizes[b]), room = apart - threshold;
      if (kind == NormalKind::barrier && a == b && h > 0.0 && !(room > 0.0)) {
        throw InputError(pair != nullptr ? pair->where : config.where,
                         fmt::format("parts of '{}' that share no edge are {:.3g} m apart in the mesh, and 'thickness' "
                                     "keeps them {:.3g} m apart; a smaller thickness, or no contact with itself",
                                     names[a], apart, threshold));
      }
      NormalLaw law{kind, 1.0, width.value_or(width_per_facet * h), threshold};
      if (h > 0.0) {
        const auto stiffness_at = [&](std::size_t body) {
          return shear_moduli_per_facet * contact_modulus(shear_moduli[body], thick[body], sizes[body]) / sizes[body];
        };
        const double k_a = stiffness_at(a), k_b = stiffness_at(b);
        law.stiffness = stiffness.value_or(2.0 * k_a * k_b / (k_a + k_b));
        // Nothing pushes within a body at rest, nor between bodies at the start unless the user wants so.
        if (kind == NormalKind::barrier && room > 0.0 && (a == b || !width))
          law.width = std::min(law.width, 0.5 * room);
      }
      laws.of_bodies.push_back(law);
    }
  }
  return laws;
}

std::vector<char> bodies_that_may_meet(const CollisionSurface& surface, const ContactSets& sets,
                                       std::size_t num_bodies) {
  std::vector<std::set<std::int32_t>> groups(num_bodies);
  for (const auto& triangle : surface.triangles()) groups[triangle.body].insert(triangle.group);
  std::vector<char> may_meet;
  for (const auto& one : groups) {
    for (const auto& other : groups) {
      const bool meets = std::ranges::any_of(
          one, [&](std::int32_t s) { return std::ranges::any_of(other, [&](std::int32_t t) { return sets(s, t); }); });
      may_meet.push_back(meets ? 1 : 0);
    }
  }
  return may_meet;
}

std::pair<double, double> stiffest_and_widest(const BodyContactLaws& laws, const std::vector<char>& may_meet) {
  double stiffest = 0.0, widest = 0.0;
  for (std::size_t pair = 0; pair < laws.of_bodies.size(); ++pair) {
    if (may_meet[pair] == 0) continue;
    stiffest = std::max(stiffest, laws.of_bodies[pair].stiffness);
    widest = std::max(widest, laws.of_bodies[pair].width);
  }
  return {stiffest, widest};
}

std::string name_of(const ContactPairConfig* pair) {
  if (pair == nullptr) return "all bodies";
  return fmt::format("'{}' with {}", pair->part.value, pair->with ? "'" + pair->with->value + "'" : "itself");
}

void require_two_bodies(const ContactPairConfig* pair, const std::vector<char>& may_meet, std::size_t num_bodies) {
  if (pair == nullptr) return;
  for (std::size_t place = 0; place < may_meet.size(); ++place) {
    if (may_meet[place] != 0 && place / num_bodies != place % num_bodies) return;
  }
  throw InputError(
      pair->where,
      fmt::format("{} are parts of one body, and contact of a body with itself needs 'law: barrier'", name_of(pair)));
}

}  // namespace pliant
