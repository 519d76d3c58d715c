#include "model/rods.hpp"

#include "base/text.hpp"
#include "energy/rod/rod_viscosity.hpp"
#include "input/elasticity.hpp"
#include "input/output_fields.hpp"
#include "mesh/rod_chain.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Stiffness of a frame against its distortions, in E (I_1 + I_2) / l^2: the frames then vibrate about as fast as
/// segments do along the rod.
constexpr double distortion_by_bending = 1.0;
/// A rod is a fibre if it resists bending and twist by less than this part of what the cells around it do.
constexpr double negligible = 0.01;
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

/// Appends a fibre; returns the number of its first segment among those of fibres.
std::size_t append(const RodConfig& rod, std::span<const std::array<double, 3>> points,
                   std::vector<FibreSegment>& fibres) {
  const double area = section_of(rod).area;
  const std::size_t first = fibres.size();
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Vector3<double> from = points[k - 1], to = points[k];
    const double length = norm(to - from);
    fibres.push_back({{from, to}, length, rod.youngs_modulus * area, rod.density * area * length, rod.damping});
  }
  return first;
}

/// Puts the nodes of the axes of rods, each on the rank that owns it.
void put_axes(const NodeLayout& layout, ModelRods& rods) {
  const auto put = [&](std::size_t segment, PetscInt first, PetscInt second) {
    for (ModelRod& rod : rods.rods) {
      if (segment < rod.first_segment || segment >= rod.first_segment + rod.num_segments()) continue;
      for (const auto& [point, node] :
           {std::pair{segment - rod.first_segment, first}, {segment - rod.first_segment + 1, second}}) {
        if (node >= layout.num_owned_nodes) continue;
        rod.points[point].location.nodes = {node};
        rod.points[point].location.weights = {1.0};
      }
    }
  };
  if (rods.term) {
    for (const auto& segment : rods.term->segments_here()) put(segment.number, segment.nodes[0], segment.nodes[1]);
  }
  if (!rods.fibres) return;
  for (const LocalFibre& fibre : rods.fibres->segments_here()) {
    put(rods.num_bent() + fibre.number, fibre.nodes[0], fibre.nodes[1]);
  }
}

/// For each body, whether it has no cell: of rods, those that are fibres. Collective.
std::vector<char> have_no_cells(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell) {
  std::vector<double> numbers(config.bodies.size(), 0.0);
  for (const int body : body_of_cell) {
    if (body >= 0) numbers[static_cast<std::size_t>(body)] += 1.0;
  }
  sum_in_place(layout.comm, numbers);
  std::vector<char> result;
  for (const double number : numbers) result.push_back(number == 0.0 ? 1 : 0);
  return result;
}

/// The number of the segment that each local cell is; -1: it is none. The cells of a rod have successive numbers in the
/// whole mesh, whatever else lies at their places. Collective.
std::vector<std::ptrdiff_t> segments_of_cells(const Config& config, const NodeLayout& layout,
                                              const std::vector<int>& body_of_cell, std::span<const ModelRod> rods) {
  struct FirstCell {
    int body = -1;
    std::int64_t number = 0;
  };
  std::map<int, std::int64_t> lowest;
  for (std::size_t c = 0; c < body_of_cell.size(); ++c) {
    const int body = body_of_cell[c];
    if (body < 0 || !config.bodies[static_cast<std::size_t>(body)].is_rod) continue;
    const auto [found, is_new] = lowest.try_emplace(body, layout.cell_numbers[c]);
    if (!is_new) found->second = std::min(found->second, layout.cell_numbers[c]);
  }
  std::vector<FirstCell> mine;
  for (const auto& [body, number] : lowest) mine.push_back({body, number});
  for (const auto& [body, number] : gathered(layout.comm, mine)) {
    const auto [found, is_new] = lowest.try_emplace(body, number);
    if (!is_new) found->second = std::min(found->second, number);
  }
  std::map<std::string, std::size_t> first_segment;  // of bodies
  for (const ModelRod& rod : rods) {
    if (rod.is_fibre) continue;
    first_segment[rod.name] = rod.first_segment;
    first_segment[name_of_end(rod.name, 0)] = rod.first_segment - 1;
    first_segment[name_of_end(rod.name, 1)] = rod.first_segment + rod.num_segments();
  }
  std::vector<std::ptrdiff_t> result(body_of_cell.size(), -1);
  for (std::size_t c = 0; c < body_of_cell.size(); ++c) {
    const auto first = lowest.find(body_of_cell[c]);
    if (first == lowest.end()) continue;
    const std::string& name = config.bodies[static_cast<std::size_t>(body_of_cell[c])].part.name;
    result[c] = static_cast<std::ptrdiff_t>(first_segment.at(name)) + (layout.cell_numbers[c] - first->second);
  }
  return result;
}

/// The least shear modulus at rest of bodies whose laws are the same everywhere [Pa]; nothing: it is not known.
std::optional<double> least_shear_modulus(const Config& config) {
  std::optional<double> least;
  for (const BodyConfig& body : config.bodies) {
    if (!body.elasticity) continue;
    try {
      const auto law = ElasticityRule(*body.elasticity).up_to_rotation();
      if (!law) return std::nullopt;
      const double modulus = wave_moduli(*law).smallest;
      least = std::min(least.value_or(modulus), modulus);
    } catch (const InputError&) {
      return std::nullopt;  // it is reported where the law is made
    }
  }
  return least;
}

/// AddedRod::fibre_beside: a bar of the material with the section A resists bending by 2 G A^2/12 at least, and twist
/// by about G A^2/7.
double fibre_beside(const RodConfig& rod, const std::optional<double>& shear_modulus) {
  constexpr double never = std::numeric_limits<double>::infinity();
  if (rod.bends) return *rod.bends ? never : 0.0;
  if (rod.curve.empty() || !rod.holder(0).empty() || !rod.holder(1).empty() || !shear_modulus) return never;
  const RodSection section = section_of(rod);
  const double E = rod.youngs_modulus, G = E / (2.0 * (1.0 + rod.poissons_ratio));
  const double EI = E * std::max(section.second_moments[0], section.second_moments[1]), GJ = G * section.torsion;
  return std::sqrt(std::max(6.0 * EI, 7.0 * GJ) / (negligible * *shear_modulus));
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
  const std::optional<double> shear_modulus = least_shear_modulus(config);
  for (const RodConfig& rod : config.rods) {
    AddedRod& added = result.emplace_back();
    added.name = rod.name;
    added.where = rod.where;
    added.points = divided(rod);
    added.curve = rod.curve;
    if (rod.section) added.up = rod.section->up;
    added.arms = section_of(rod).arms;
    added.has_end = {!rod.holder(0).empty(), !rod.holder(1).empty()};
    added.fibre_beside = fibre_beside(rod, shear_modulus);
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
  std::vector<FibreSegment> fibres;
  const std::vector<AddedRod> added = added_rods(config);
  const std::vector<std::vector<std::array<double, 3>>> all_points = joined_points_of(added, mesh.curves);
  const std::vector<char> has_no_cells = have_no_cells(config, layout, body_of_cell);
  for (std::size_t r = 0; r < added.size(); ++r) {
    const std::vector<std::array<double, 3>>& points = all_points[r];
    ModelRod& rod = result.rods.emplace_back();
    rod.name = added[r].name;
    const auto is_its_body = [&](const BodyConfig& body) { return body.is_rod && body.part.name == rod.name; };
    rod.body = static_cast<int>(std::ranges::find_if(config.bodies, is_its_body) - config.bodies.begin());
    rod.is_fibre = has_no_cells[static_cast<std::size_t>(rod.body)] != 0;
    rod.first_segment = rod.is_fibre ? append(config.rods[r], points, fibres)
                                     : append(config.rods[r], rod_chain(added[r], points), config.mass, parts);
    rod.points.resize(points.size());
    for (std::size_t k = 1; k < points.size(); ++k) {
      rod.length += norm(Vector3<double>(points[k]) - Vector3<double>(points[k - 1]));
    }
  }
  const auto is_damped = [&](bool is_fibre) {
    bool any = false;
    for (std::size_t r = 0; r < added.size(); ++r) {
      any = any || (result.rods[r].is_fibre == is_fibre && config.rods[r].damping > 0.0);
    }
    return any;
  };
  for (const RodSegment& segment : parts.segments) result.lengths.push_back(segment.length);
  for (const FibreSegment& fibre : fibres) result.lengths.push_back(fibre.length);
  if (!fibres.empty()) {
    for (ModelRod& rod : result.rods) rod.first_segment += rod.is_fibre ? parts.segments.size() : 0;
    result.fibres = std::make_unique<Fibres>(layout, fibres);
    if (is_damped(true)) result.viscosity.push_back(std::make_unique<FibreViscosity>(layout, *result.fibres));
  }
  if (!parts.segments.empty()) {
    result.term = std::make_unique<Rods>(layout, segments_of_cells(config, layout, body_of_cell, result.rods),
                                         std::move(parts.segments), std::move(parts.vertices));
    if (is_damped(false)) result.viscosity.push_back(std::make_unique<RodViscosity>(*result.term));
  }
  put_axes(layout, result);
  return result;
}

std::vector<Diagnostic> notes_about_fibres(const Config& config, const ModelRods& rods) {
  std::vector<Diagnostic> notes;
  std::vector<std::string> fibres;
  for (const ModelRod& rod : rods.rods) {
    if (rod.is_fibre) fibres.push_back(rod.name);
  }
  if (fibres.empty()) return notes;
  const auto is_of_rods = [](const std::string& name) {
    const auto of = field_component(name);
    return of && of->field.owner == FieldOwner::rods;
  };
  if (std::ranges::any_of(config.output.fields, is_of_rods)) {
    notes.push_back(
        note(fmt::format("fields of rods do not show fibres ({}), which have no cells: `tension` shows their forces in "
                         "pictures, and 'output.history' in columns",
                         joined(fibres))));
  }
  for (const FieldColumnConfig& column : config.output.history) {
    if (!is_of_rods(column.of.value) || column.of.value.starts_with("rod_force")) continue;
    const auto is_meant = [&](const std::string& name) { return !column.in || column.in->value == name; };
    if (!std::ranges::any_of(fibres, is_meant)) continue;
    notes.push_back({Severity::warning, column.of.where,
                     fmt::format("'{}' is 0 in fibres ({}), which do not resist bending and twist", column.of.value,
                                 joined(fibres))});
  }
  return notes;
}

std::vector<const EnergyTerm*> ModelRods::terms(bool has_velocity) const {
  std::vector<const EnergyTerm*> result;
  for (std::size_t k = 0; k < viscosity.size() && has_velocity; ++k) result.push_back(viscosity[k].get());
  if (term) result.push_back(term.get());
  if (fibres) result.push_back(fibres.get());
  if (bond) result.push_back(bond.get());
  return result;
}

void ModelRods::add_masses(const BlockPattern& pattern, MassKind kind, MassMatrix& mass) const {
  if (term) term->add_masses(pattern, mass);
  if (fibres) fibres->add_masses(pattern, kind == MassKind::lumped ? Mass::lumped : Mass::consistent, mass);
}

std::vector<MassAtNode> ModelRods::masses(std::span<const char> of_segments) const {
  std::vector<MassAtNode> result;
  if (term) result = term->masses(of_segments.first(num_bent()));
  if (fibres) std::ranges::move(fibres->masses(of_segments.subspan(num_bent())), std::back_inserter(result));
  return result;
}

std::vector<double> tensions_of(const ModelRods& rods, MPI_Comm comm, std::span<const double> u) {
  std::vector<double> tensions(rods.lengths.size(), 0.0);
  if (rods.term) {
    for (const Rods::SegmentNodes& segment : rods.term->segments_here()) {
      if (segment.is_counted) tensions[segment.number] = rods.term->tension(segment, u);
    }
  }
  if (rods.fibres) {
    for (const LocalFibre& fibre : rods.fibres->segments_here()) {
      if (fibre.is_counted) tensions[rods.num_bent() + fibre.number] = Fibres::tension(fibre, u);
    }
  }
  sum_in_place(comm, tensions);
  return tensions;
}

}  // namespace pliant
