#include "model/rods.hpp"

#include "energy/load/spring.hpp"
#include "energy/rod/rod_viscosity.hpp"
#include "fem/probe.hpp"
#include "mesh/rod_chain.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {
namespace {

/// Stiffness of a frame against its distortions, in E (I_1 + I_2) / l^2: the frames then vibrate about as fast as
/// segments do along the rod.
constexpr double distortion_by_bending = 1.0;
/// The part of a segment's rotary inertia that belongs to the section at an end that is held.
constexpr double part_of_section = 0.25;

/// J of a rectangle with sides a >= b: a b^3/3 (1 - 192/pi^5 b/a sum_n tanh(n pi a / (2 b)) / n^5), n odd.
/// Source: Timoshenko & Goodier, Theory of Elasticity, section 109.
double torsion_of_rectangle(double one, double other) {
  const double a = std::max(one, other), b = std::min(one, other), pi = std::numbers::pi;
  double sum = 0.0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(n * pi * a / (2.0 * b)) / std::pow(n, 5);
  return a * b * b * b / 3.0 * (1.0 - 192.0 / std::pow(pi, 5) * b / a * sum);
}

Selection volume_named(const std::string& name, const Location& where) {
  Selection part;
  part.kind = Selection::Kind::volume;
  part.name = name;
  part.where = where;
  return part;
}

/// The points between which segments are straight.
std::vector<std::array<double, 3>> divided(const RodConfig& rod) {
  if (rod.points.empty()) return {};
  std::vector<std::array<double, 3>> points{rod.points.front()};
  for (std::size_t k = 1; k < rod.points.size(); ++k) {
    const Vector3<double> from = rod.points[k - 1], to = rod.points[k];
    int parts = rod.segments.value_or(1);
    if (rod.size) parts = std::max(1, static_cast<int>(std::ceil(norm(to - from) / *rod.size - 1e-9)));
    for (int i = 1; i < parts; ++i) {
      const double share = static_cast<double>(i) / parts;
      points.push_back(from + share * (to - from));
    }
    points.push_back(rod.points[k]);
  }
  return points;
}

/// Segments and vertices of all rods, one after another.
struct Parts {
  std::vector<RodSegment> segments;
  std::vector<RodVertex> vertices;
};

std::array<Vector3<double>, 4> places(const CornerPlaces& corners) {
  std::array<Vector3<double>, 4> result;
  std::ranges::copy(corners, result.begin());
  return result;
}

/// Appends a rod; returns the number of its first segment.
std::size_t append(const RodConfig& rod, const RodChain& chain, MassKind kind, Parts& parts) {
  const RodSection section = section_of(rod);
  const double E = rod.youngs_modulus, G = E / (2.0 * (1.0 + rod.poissons_ratio));
  const auto [I_1, I_2] = section.second_moments;
  const auto rotary = [&](double length) {
    return std::array{0.0, rod.density * I_1 * length, rod.density * I_2 * length};
  };
  const auto add_vertex = [&](double length) {
    parts.vertices.push_back({parts.segments.size() - 1, length, {E * I_1, E * I_2}, G * section.torsion, rod.damping});
  };
  std::vector<double> lengths;
  for (const CornerPlaces& corners : chain.segments) {
    const auto X = places(corners);
    lengths.push_back(norm(X[1] - X[0]));
  }
  if (chain.ends[0]) {
    parts.segments.push_back({places(*chain.ends[0]), 0.0, 0.0, 0.0, 0.0, rotary(part_of_section * lengths.front())});
    add_vertex(0.5 * lengths.front());
  }
  const std::size_t first = parts.segments.size();
  for (std::size_t s = 0; s < lengths.size(); ++s) {
    const double l = lengths[s], mass = rod.density * section.area * l;
    double turning = l;  // whose rotary inertia is its own
    if (s == 0 && chain.ends[0]) turning -= part_of_section * l;
    if (s + 1 == lengths.size() && chain.ends[1]) turning -= part_of_section * l;
    RodSegment segment{places(chain.segments[s]), l, E * section.area, 0.0, mass, rotary(turning), rod.damping};
    segment.distortion = std::min(segment.axial, distortion_by_bending * E * (I_1 + I_2) / (l * l));
    segment.second_moments[0] = mass * l * l / (kind == MassKind::lumped ? 4.0 : 12.0);
    if (s > 0) add_vertex(0.5 * (lengths[s - 1] + l));
    parts.segments.push_back(segment);
  }
  if (chain.ends[1]) {
    add_vertex(0.5 * lengths.back());
    parts.segments.push_back({places(*chain.ends[1]), 0.0, 0.0, 0.0, 0.0, rotary(part_of_section * lengths.back())});
  }
  return first;
}

/// The nodes of a rod's axis, each on the rank that owns it.
std::vector<AttachedPoint> axis_of(const Rods& term, const NodeLayout& layout, std::size_t first, std::size_t count) {
  std::vector<AttachedPoint> points(count + 1);
  const auto put = [&](std::size_t point, PetscInt node) {
    if (node >= layout.num_owned_nodes) return;
    points[point].location.nodes = {node};
    points[point].location.weights = {1.0};
  };
  for (const Rods::SegmentNodes& segment : term.segments_here()) {
    if (segment.number < first || segment.number >= first + count) continue;
    put(segment.number - first, segment.nodes[0]);
    put(segment.number - first + 1, segment.nodes[1]);
  }
  return points;
}

/// A point on a director's line that a body may hold: the director's own, or that on the other side of the segment.
struct Director {
  std::size_t segment = 0, number = 0;
  double side = 1.0;       // 1 or -1
  double stiffness = 0.0;  // of both sides [N/m]
  std::array<double, 3> place{};
};

/// Those of this rank's segments along curves in bodies; the two sides of a director follow each other.
std::vector<Director> bonded_directors(const BodiesOnMesh& bodies, std::span<const double> shear_moduli,
                                       const ModelRods& rods) {
  const NodeLayout& layout = bodies.layout;
  std::vector<double> modulus_at(static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const int body = bodies.body_of_cell[static_cast<std::size_t>(c)];
    if (body < 0) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      double& modulus = modulus_at[static_cast<std::size_t>(n)];
      modulus = std::max(modulus, shear_moduli[static_cast<std::size_t>(body)]);
    }
  }
  std::vector<Director> result;
  for (const Rods::SegmentNodes& segment : rods.term->segments_here()) {
    const auto is_in = [&](const ModelRod& rod) {
      return segment.number >= rod.first_segment && segment.number < rod.first_segment + rod.num_segments();
    };
    const auto rod = std::ranges::find_if(rods.rods, is_in);
    if (!segment.is_counted || rod == rods.rods.end()) continue;
    if (bodies.config.rods[static_cast<std::size_t>(rod - rods.rods.begin())].curve.empty()) continue;
    const double length =
        norm(Vector3<double>(layout.position(segment.nodes[1])) - Vector3<double>(layout.position(segment.nodes[0])));
    const double modulus = modulus_at[static_cast<std::size_t>(segment.nodes[0])];
    if (!(modulus > 0.0)) continue;
    const Vector3<double> middle =
        0.5 * (Vector3<double>(layout.position(segment.nodes[0])) + Vector3<double>(layout.position(segment.nodes[1])));
    for (std::size_t k = 0; k < 2; ++k) {
      const Vector3<double> arm = Vector3<double>(layout.position(segment.nodes[2 + k])) - middle;
      for (const double side : {1.0, -1.0}) {
        result.push_back({segment.number, k, side, modulus * length, middle + side * arm});
      }
    }
  }
  return result;
}

}  // namespace

RodSection section_of(const RodConfig& rod) {
  if (!rod.section) {
    const double r = rod.radius.value_or(0.0), I = 0.25 * std::numbers::pi * r * r * r * r;
    return {std::numbers::pi * r * r, {I, I}, 2.0 * I, {r, r}};
  }
  const double w = rod.section->width, h = rod.section->height;
  return {w * h,
          {w * h * h * h / 12.0, h * w * w * w / 12.0},
          rod.section->torsion.value_or(torsion_of_rectangle(w, h)),
          {0.5 * h, 0.5 * w}};
}

void add_bodies_of_rods(Config& config) {
  for (const RodConfig& rod : config.rods) {
    const auto add = [&](const std::string& name) {
      BodyConfig& body = config.bodies.emplace_back();
      body.part = volume_named(name, rod.where);
      body.is_rod = true;
      body.where = rod.where;
    };
    add(rod.name);
    for (std::size_t end = 0; end < 2; ++end) {
      if (rod.holder(end).empty()) continue;
      const std::string name = name_of_end(rod.name, end);
      add(name);
      if (rod.holder(end) != "ground") continue;
      ConstraintConfig::Rigid rigid;
      rigid.translation = {Expression(0.0), Expression(0.0), Expression(0.0)};
      rigid.rotation.kind = RotationConfig::Fixed{};
      if (!rod.points.empty()) rigid.center = end == 0 ? rod.points.front() : rod.points.back();
      rigid.support = name;
      ConstraintConfig& constraint = config.constraints.emplace_back();
      constraint.kind = std::move(rigid);
      constraint.part = volume_named(name, rod.where);
      constraint.where = rod.where;
    }
  }
}

std::vector<Selection> sections_held_by(const Config& config, const std::string& body) {
  std::vector<Selection> result;
  for (const RodConfig& rod : config.rods) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (rod.holder(end) == body) result.push_back(volume_named(name_of_end(rod.name, end), rod.where));
    }
  }
  return result;
}

std::vector<AddedRod> added_rods(const Config& config) {
  std::vector<AddedRod> result;
  for (const RodConfig& rod : config.rods) {
    AddedRod& added = result.emplace_back();
    added.name = rod.name;
    added.where = rod.where;
    added.points = divided(rod);
    added.curve = rod.curve;
    if (rod.section) added.up = rod.section->up;
    added.arms = section_of(rod).arms;
    added.has_end = {!rod.holder(0).empty(), !rod.holder(1).empty()};
  }
  return result;
}

std::vector<std::string> curves_of_rods(const Config& config) {
  std::vector<std::string> names;
  for (const RodConfig& rod : config.rods) {
    if (!rod.curve.empty()) names.push_back(rod.curve);
  }
  return names;
}

ModelRods make_rods(const Config& config, const Mesh& mesh, const NodeLayout& layout,
                    const std::vector<int>& body_of_cell, Selections& selections) {
  ModelRods result;
  if (config.rods.empty()) return result;
  for (const RodConfig& rod : config.rods) {
    Selection part;
    part.kind = Selection::Kind::curve;
    part.name = rod.curve;
    if (!rod.curve.empty() && selections.has_group(part.kind, part.name)) selections.use(part);
  }
  Parts parts;
  const std::vector<AddedRod> added = added_rods(config);
  for (std::size_t r = 0; r < added.size(); ++r) {
    const RodChain chain = rod_chain(added[r], points_of(added[r], mesh.curves));
    ModelRod& rod = result.rods.emplace_back();
    rod.name = added[r].name;
    rod.first_segment = append(config.rods[r], chain, config.mass, parts);
    rod.points.resize(chain.segments.size() + 1);
    for (const CornerPlaces& corners : chain.segments) {
      const auto X = places(corners);
      rod.length += norm(X[1] - X[0]);
    }
    const auto is_its_body = [&](const BodyConfig& body) { return body.is_rod && body.part.name == rod.name; };
    rod.body = static_cast<int>(std::ranges::find_if(config.bodies, is_its_body) - config.bodies.begin());
  }
  std::vector<char> is_segment;
  for (const int body : body_of_cell) {
    is_segment.push_back(body >= 0 && config.bodies[static_cast<std::size_t>(body)].is_rod ? 1 : 0);
  }
  result.term = std::make_unique<Rods>(layout, is_segment, std::move(parts.segments), std::move(parts.vertices));
  if (std::ranges::any_of(config.rods, [](const RodConfig& rod) { return rod.damping > 0.0; })) {
    result.viscosity = std::make_unique<RodViscosity>(*result.term);
  }
  for (ModelRod& rod : result.rods) {
    rod.points = axis_of(*result.term, layout, rod.first_segment, rod.num_segments());
  }
  return result;
}

void add_bond(const BodiesOnMesh& bodies, std::span<const double> shear_moduli, ModelRods& rods) {
  if (curves_of_rods(bodies.config).empty()) return;
  const NodeLayout& layout = bodies.layout;
  const auto directors = gathered(layout.comm, bonded_directors(bodies, shear_moduli, rods));
  std::vector<std::array<double, 3>> places;
  for (const Director& director : directors) places.push_back(director.place);
  if (places.empty()) return;
  const auto held = locate(layout, places, bodies.is_left_out);
  const auto here = rods.term->segments_here();
  std::vector<AttachedPoint> points;
  std::vector<LineSpring> springs;
  for (std::size_t k = 0; k < directors.size(); ++k) {
    if (held[k].distance > 0.0) continue;
    const auto& [number, director, side, stiffness, place] = directors[k];
    AttachedPoint of_rod;
    const auto segment = std::ranges::find(here, number, &Rods::SegmentNodes::number);
    if (segment != here.end() && segment->nodes[2 + director] < layout.num_owned_nodes) {
      const auto& [first, last, d_1, d_2] = segment->nodes;
      const PetscInt node = director == 0 ? d_1 : d_2;
      // The place on the other side is as far behind the middle as the director's point is before it.
      of_rod.location.nodes = side > 0.0 ? std::vector<PetscInt>{node} : std::vector<PetscInt>{node, first, last};
      of_rod.location.weights = side > 0.0 ? std::vector<double>{1.0} : std::vector<double>{-1.0, 1.0, 1.0};
    }
    points.push_back(std::move(of_rod));
    points.push_back({held[k], {}});
    // One side alone does the work of both: at a face of the body the rest of the section is outside.
    const bool is_alone = held[k % 2 == 0 ? k + 1 : k - 1].distance > 0.0;
    springs.push_back({is_alone ? stiffness : 0.5 * stiffness, 0.0, 0.0, false});
  }
  if (!springs.empty()) rods.bond = std::make_unique<Springs>(layout, points, std::move(springs));
}

std::vector<double> tensions_of(const ModelRods& rods, const ModelRod& rod, MPI_Comm comm, std::span<const double> u) {
  std::vector<double> tensions(rod.num_segments(), 0.0);
  for (const Rods::SegmentNodes& segment : rods.term->segments_here()) {
    const bool is_of_rod =
        segment.number >= rod.first_segment && segment.number < rod.first_segment + rod.num_segments();
    if (is_of_rod && segment.is_counted) tensions[segment.number - rod.first_segment] = rods.term->tension(segment, u);
  }
  sum_in_place(comm, tensions);
  return tensions;
}

}  // namespace pliant
