#include "model/rod_bond.hpp"

#include "base/vector3.hpp"
#include "energy/load/spring.hpp"
#include "fem/apexes.hpp"
#include "fem/probe.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace pliant {
namespace {

/// A place of a section that a body may hold, m + along[0] (p_1 - m) + along[1] (p_2 - m).
struct SectionPoint {
  std::size_t segment = 0;
  std::array<double, 2> along{};
  double weight = 0.0;     // among those of the segment
  double stiffness = 0.0;  // of all points of the segment [N/m]
  std::array<double, 3> place{};
  PetscInt third =
      -1;  // of a free shell's triangle, with the segment's two, that holds it: local to the segment's rank
  std::array<double, 3> weights{};  // of the triangle's corners, the third first
};

/// What lies around a segment: two nodes of each cell of a body across it, one of each triangle of a free shell.
struct Surroundings {
  std::vector<std::array<PetscInt, 2>> cells;
  std::vector<PetscInt> triangles;
};
/// By the ends of segments.
using NodesAround = std::map<std::pair<PetscInt, PetscInt>, Surroundings>;

bool is_of_free_shell(const Config& config, int body) {
  return body >= 0 && static_cast<std::size_t>(body) < config.bodies.size() &&
         config.bodies[static_cast<std::size_t>(body)].is_shell;
}

/// What has a shear modulus around the segments on this rank.
NodesAround nodes_around(const BodiesOnMesh& bodies, std::span<const double> shear_moduli,
                         std::span<const Rods::SegmentNodes> segments) {
  NodesAround result;
  for (const Rods::SegmentNodes& segment : segments) result[std::minmax(segment.nodes[0], segment.nodes[1])];
  for (PetscInt c = 0; c < bodies.layout.num_local_cells; ++c) {
    const int body = bodies.body_of_cell[static_cast<std::size_t>(c)];
    if (body < 0 || !(shear_moduli[static_cast<std::size_t>(body)] > 0.0)) continue;
    const auto corners = bodies.layout.nodes_of_cell(c).first(4);
    if (is_of_free_shell(bodies.config, body)) {
      const std::size_t apex = apex_of_cell(bodies.layout, c);
      for (std::size_t k = 0; k < 4; ++k) {
        if (k == apex) continue;
        const std::size_t i = (k + 1) % 4 == apex ? (k + 2) % 4 : (k + 1) % 4, j = 6 - apex - k - i;
        const auto found = result.find(std::minmax(corners[i], corners[j]));
        if (found != result.end()) found->second.triangles.push_back(corners[k]);
      }
      continue;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const auto found = result.find(std::minmax(corners[i], corners[j]));
        if (found == result.end()) continue;
        std::array<PetscInt, 2> others{};
        for (std::size_t k = 0, at = 0; k < 4; ++k) {
          if (k != i && k != j) others[at++] = corners[k];
        }
        found->second.cells.push_back(others);
      }
    }
  }
  return result;
}

/// The stiffest shear modulus at each local node [Pa].
std::vector<double> moduli_at_nodes(const BodiesOnMesh& bodies, std::span<const double> shear_moduli) {
  std::vector<double> result(static_cast<std::size_t>(bodies.layout.num_local_nodes), 0.0);
  for (PetscInt c = 0; c < bodies.layout.num_local_cells; ++c) {
    const int body = bodies.body_of_cell[static_cast<std::size_t>(c)];
    if (body < 0) continue;
    for (const PetscInt n : bodies.layout.nodes_of_cell(c)) {
      double& modulus = result[static_cast<std::size_t>(n)];
      modulus = std::max(modulus, shear_moduli[static_cast<std::size_t>(body)]);
    }
  }
  return result;
}

/// Places in a segment's section.
class SectionPoints {
 public:
  SectionPoints(const NodeLayout& layout, const Rods::SegmentNodes& segment, double modulus)
      : layout_(layout), segment_(segment.number) {
    ends_ = {segment.nodes[0], segment.nodes[1]};
    const Vector3<double> x0 = layout.position(segment.nodes[0]), x1 = layout.position(segment.nodes[1]);
    middle_ = 0.5 * (x0 + x1);
    for (std::size_t k = 0; k < 2; ++k) arms_[k] = Vector3<double>(layout.position(segment.nodes[2 + k])) - middle_;
    stiffness_ = 2.0 * modulus * norm(x1 - x0);
  }
  /// On each arc of the circle that lies in one of the cells around it, the middle, or Gauss's two points if it is more
  /// than a quarter: the choice of the directors makes no difference.
  void add_arcs(std::span<const std::array<PetscInt, 2>> around, std::vector<SectionPoint>& points) const {
    // A quarter is common, in meshes of boxes, and one point of it or two are not the same.
    const double quarter = (1.0 + 1e-6) * 0.5 * std::numbers::pi, gauss = 0.5 / std::numbers::sqrt3;
    for (const auto& [a, b] : around) {
      const double from = angle_of(a), arc = std::remainder(angle_of(b) - from, 2.0 * std::numbers::pi);
      const auto add = [&](double part, double weight) {
        const double angle = from + part * arc;
        points.push_back(point({std::cos(angle), std::sin(angle)}, weight * std::abs(arc)));
      };
      if (std::abs(arc) <= quarter) {
        add(0.5, 1.0);
        continue;
      }
      add(0.5 - gauss, 0.5);
      add(0.5 + gauss, 0.5);
    }
  }
  /// In the plane of each triangle around, as far from the axis as the longer director.
  void add_in_triangles(std::span<const PetscInt> thirds, std::vector<SectionPoint>& points) const {
    const Vector3<double> along = layout_.position(ends_[1]) - layout_.position(ends_[0]);
    const double length = norm(along), distance = std::max(norm(arms_[0]), norm(arms_[1]));
    const Vector3<double> t = (1.0 / length) * along;
    for (const PetscInt third : thirds) {
      const Vector3<double> way = Vector3<double>(layout_.position(third)) - middle_;
      const Vector3<double> across = way - dot(way, t) * t;
      const double height = norm(across), weight = distance / height;
      const auto part = [&](const Vector3<double>& arm) { return weight * dot(across, arm) / dot(arm, arm); };
      SectionPoint& added = points.emplace_back(point({part(arms_[0]), part(arms_[1])}, 1.0));
      const double difference = -2.0 * weight * dot(way, t) / length;  // of the weights of the segment's ends
      added.third = third;
      added.weights = {weight, 0.5 * (1.0 - weight - difference), 0.5 * (1.0 - weight + difference)};
    }
  }
  /// The ends of both directors, on both sides.
  void add_ends(std::vector<SectionPoint>& points) const {
    for (const double side : {1.0, -1.0}) {
      points.push_back(point({side, 0.0}, 1.0));
      points.push_back(point({0.0, side}, 1.0));
    }
  }

 private:
  double angle_of(PetscInt node) const {
    const Vector3<double> way = Vector3<double>(layout_.position(node)) - middle_;
    return std::atan2(dot(way, unit(arms_[1])), dot(way, unit(arms_[0])));
  }
  SectionPoint point(const std::array<double, 2>& along, double weight) const {
    return {segment_, along, weight, stiffness_, middle_ + along[0] * arms_[0] + along[1] * arms_[1]};
  }

  const NodeLayout& layout_;
  std::size_t segment_;
  std::array<PetscInt, 2> ends_{};
  Vector3<double> middle_{};
  std::array<Vector3<double>, 2> arms_{};
  double stiffness_ = 0.0;
};

/// Those of this rank's segments along curves in bodies.
std::vector<SectionPoint> points_of_sections(const BodiesOnMesh& bodies, std::span<const double> shear_moduli,
                                             const ModelRods& rods) {
  const auto segments = rods.term->segments_here();
  const std::vector<double> modulus_at = moduli_at_nodes(bodies, shear_moduli);
  const NodesAround around = nodes_around(bodies, shear_moduli, segments);
  std::vector<SectionPoint> result;
  for (const Rods::SegmentNodes& segment : segments) {
    const auto is_in = [&](const ModelRod& rod) {
      return segment.number >= rod.first_segment && segment.number < rod.first_segment + rod.num_segments();
    };
    const auto rod = std::ranges::find_if(rods.rods, is_in);
    if (!segment.is_counted || rod == rods.rods.end()) continue;
    const RodConfig& config = bodies.config.rods[static_cast<std::size_t>(rod - rods.rods.begin())];
    const double modulus = modulus_at[static_cast<std::size_t>(segment.nodes[0])];
    if (config.curve.empty() || !(modulus > 0.0)) continue;
    const SectionPoints section(bodies.layout, segment, modulus);
    const auto& [cells, triangles] = around.at(std::minmax(segment.nodes[0], segment.nodes[1]));
    if (cells.empty() && !triangles.empty()) {
      section.add_in_triangles(triangles, result);
    } else if (config.section || cells.empty()) {
      section.add_ends(result);
    } else {
      section.add_arcs(cells, result);
    }
  }
  return result;
}

}  // namespace

void add_bond(const BodiesOnMesh& bodies, std::span<const double> shear_moduli, ModelRods& rods) {
  if (!rods.term || curves_of_rods(bodies.config).empty()) return;
  const NodeLayout& layout = bodies.layout;
  const auto sections = gathered(layout.comm, points_of_sections(bodies, shear_moduli, rods));
  std::vector<std::array<double, 3>> places;
  for (const SectionPoint& point : sections) places.push_back(point.place);
  if (places.empty()) return;
  auto held = locate(layout, places, cells_without_mesh(bodies.config, bodies.body_of_cell));
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (sections[k].third >= 0) held[k] = {};
  }
  // At a face of the body the part of the section that is inside does the work of the whole.
  std::map<std::size_t, double> weight_of;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (held[k].distance == 0.0) weight_of[sections[k].segment] += sections[k].weight;
  }
  const auto here = rods.term->segments_here();
  std::vector<AttachedPoint> points;
  std::vector<LineSpring> springs;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    const auto& [number, along, weight, stiffness, place, third, weights] = sections[k];
    if (held[k].distance > 0.0) continue;
    AttachedPoint of_rod;
    const auto segment = std::ranges::lower_bound(here, number, {}, &Rods::SegmentNodes::number);
    // One rank has all its nodes, and says what they are.
    if (segment != here.end() && segment->number == number && segment->is_counted) {
      const double of_ends = 0.5 * (1.0 - along[0] - along[1]);
      of_rod.location.nodes.assign(segment->nodes.begin(), segment->nodes.end());
      of_rod.location.weights = {of_ends, of_ends, along[0], along[1]};
      if (third >= 0) {
        held[k].nodes = {third, segment->nodes[0], segment->nodes[1]};
        held[k].weights.assign(weights.begin(), weights.end());
      }
    }
    points.push_back(std::move(of_rod));
    points.push_back({held[k], {}});
    springs.push_back({stiffness * weight / weight_of.at(number), 0.0, 0.0, false});
  }
  if (!springs.empty()) rods.bond = std::make_unique<Springs>(layout, points, std::move(springs));
}

}  // namespace pliant
