#include "model/rigid_bodies.hpp"

#include "fem/cell_integration.hpp"
#include "input/elasticity.hpp"
#include "material/spectral.hpp"
#include "mesh/rod_chain.hpp"
#include "model/rods.hpp"
#include "model/shells.hpp"
#include "model/wave_speeds.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace pliant {
namespace {

/// Thinnest tetrahedron of a body that is flat or thin, relative to its length.
constexpr double flattest = 0.3;
/// Half the length of a body that has no moments of inertia, a mass point: at most [m], in units of a mesh, and
/// relative to what the input says of a model without a mesh.
constexpr double largest_point = 0.1, point_in_units_of_mesh = 5.0, point_of_extent = 0.03;
/// The relative difference in size of the tetrahedra of two bodies that follow each other.
constexpr double difference_of_sizes = 1.37e-4;

/// Shear modulus from which the stiffness of contact follows where all bodies are rigid [Pa].
constexpr double modulus_between_rigid_bodies = 1e7;

/// S = tr(J) / 2 I - J.
Tensor3<double> second_moment(const RigidBodyConfig& body) {
  const auto& [xx, yy, zz, xy, yz, zx] = body.inertia.moments;
  const Tensor3<double> J{{xx, xy, zx, xy, yy, yz, zx, yz, zz}};
  return add_to_diagonal(-1.0 * J, 0.5 * trace(J));
}

double size_of_point(const Config& config) {
  if (!config.mesh.file.value.empty()) return std::min(largest_point, point_in_units_of_mesh * config.mesh.scale);
  std::vector<std::array<double, 3>> points;
  for (const RigidBodyConfig& body : config.rigid_bodies) points.push_back(body.center);
  for (const RodConfig& rod : config.rods) points.insert(points.end(), rod.points.begin(), rod.points.end());
  double extent = 0.0;
  for (const auto& X : points) extent = std::max(extent, norm(Vector3<double>(X) - Vector3<double>(points.front())));
  return extent > 0.0 ? std::min(largest_point, point_of_extent * extent) : largest_point;
}

/// Half the edges of the cube in which the tetrahedron of the body of this number is inscribed, along the principal
/// axes; about the same second moments as the body, where that is not too thin: those of the tetrahedron are m s^2 / 5.
/// No two are equal, so that their corners do not coincide.
Vector3<double> half_edges(const RigidBodyConfig& body, const EigenDecomposition<double>& principal, std::size_t number,
                           double of_point) {
  Vector3<double> s{};
  for (std::size_t i = 0; i < 3 && body.mass > 0.0; ++i) {
    s[i] = std::sqrt(5.0 * std::max(principal.values[i], 0.0) / body.mass);
  }
  const double longest = std::ranges::max(s);
  for (double& x : s) {
    x = longest > 0.0 ? std::max(x, flattest * longest) : of_point;
    x *= 1.0 + difference_of_sizes * static_cast<double>(number + 1);
  }
  return s;
}

/// Where a place of the mesh is at the start.
Vector3<double> at_start(const Config& config, const std::array<double, 3>& X) {
  const auto& [x, y, z] = X;
  Vector3<double> place = X;
  for (std::size_t i = 0; i < 3; ++i) place[i] += config.initial.displacement[i](x, y, z, 0.0);
  return place;
}

Selection part_named(Selection::Kind kind, const std::string& name, const Location& where) {
  Selection part;
  part.kind = kind;
  part.name = name;
  part.where = where;
  return part;
}

std::vector<Selection> surfaces_named(const std::vector<Located<std::string>>& names) {
  std::vector<Selection> result;
  for (const auto& name : names) result.push_back(part_named(Selection::Kind::surface, name.value, name.where));
  return result;
}

/// The number of the first of `rigid_bodies` among the bodies: they are the last.
int first_rigid_body(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell) {
  const int last = body_of_cell.empty() ? -1 : std::ranges::max(body_of_cell);
  return static_cast<int>(maximum(layout.comm, last)) + 1 - static_cast<int>(config.rigid_bodies.size());
}

bool all_stand_for_bodies(const Config& config) {
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    if (!stands_for_body(config, static_cast<int>(b))) return false;
  }
  return true;
}

bool is_made_rigid(const Config& config, const Selection& part) {
  return std::ranges::any_of(config.constraints, [&](const ConstraintConfig& constraint) {
    return std::holds_alternative<ConstraintConfig::Rigid>(constraint.kind) && constraint.part.kind == part.kind &&
           constraint.part.name == part.name;
  });
}

}  // namespace

bool stands_for_body(const Config& config, int body) {
  if (body < 0) return false;
  const auto first = static_cast<int>(config.bodies.size() - config.rigid_bodies.size());
  if (body < first) {
    const BodyConfig& of = config.bodies[static_cast<std::size_t>(body)];
    return of.is_rod || of.is_shell;
  }
  return !config.rigid_bodies[static_cast<std::size_t>(body - first)].surface;
}

Config with_rigid_bodies(Config config) {
  add_bodies_of_rods(config);
  add_bodies_of_shells(config);
  for (const RigidBodyConfig& rigid : config.rigid_bodies) {
    BodyConfig body;
    body.part = part_named(Selection::Kind::volume, rigid.name, rigid.where);
    body.is_rigid = true;
    body.attached = rigid.attached;
    body.coupled = rigid.coupled;
    body.coupling_stiffness = rigid.coupling_stiffness;
    body.where = rigid.where;
    config.bodies.push_back(std::move(body));
  }
  for (ConstraintConfig& constraint : config.constraints) {
    auto* rigid = std::get_if<ConstraintConfig::Rigid>(&constraint.kind);
    if (rigid == nullptr || rigid->center || constraint.part.kind != Selection::Kind::volume) continue;
    const auto body = std::ranges::find(config.rigid_bodies, constraint.part.name, &RigidBodyConfig::name);
    if (body != config.rigid_bodies.end()) rigid->center = body->center;
  }
  for (const BodyConfig& body : config.bodies) {
    if (!body.is_rigid || is_made_rigid(config, body.part)) continue;
    ConstraintConfig constraint;
    ConstraintConfig::Rigid rigid;
    rigid.is_implied = true;
    constraint.kind = std::move(rigid);
    constraint.part = body.part;
    constraint.where = body.where;
    config.constraints.push_back(std::move(constraint));
  }
  for (const BodyConfig& body : config.bodies) {
    for (ConstraintConfig& constraint : config.constraints) {
      auto* rigid = std::get_if<ConstraintConfig::Rigid>(&constraint.kind);
      const bool is_of_body = constraint.part.kind == body.part.kind && constraint.part.name == body.part.name;
      if (rigid == nullptr || !is_of_body) continue;
      for (Selection& surface : surfaces_named(body.attached)) rigid->attached.push_back(std::move(surface));
      for (Selection& section : sections_held_by(config, body.part.name)) rigid->attached.push_back(std::move(section));
    }
  }
  return config;
}

std::vector<AddedTetrahedron> added_tetrahedra(const Config& config) {
  std::vector<AddedTetrahedron> result;
  const double of_point = size_of_point(config);
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    if (body.surface) continue;
    const auto principal = eigen_decomposition(second_moment(body));
    const Vector3<double> s = half_edges(body, principal, result.size(), of_point);
    constexpr std::array<std::array<double, 3>, 4> corners{
        {{1.0, 1.0, 1.0}, {1.0, -1.0, -1.0}, {-1.0, 1.0, -1.0}, {-1.0, -1.0, 1.0}}};
    AddedTetrahedron& tetrahedron = result.emplace_back();
    tetrahedron.name = body.name;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3<double> along = {corners[k][0] * s[0], corners[k][1] * s[1], corners[k][2] * s[2]};
      tetrahedron.corners[k] = body.center + matvec(principal.vectors, along);
    }
    const Vector3<double> X = tetrahedron.corners[0];
    const Vector3<double> a = tetrahedron.corners[1] - X, b = tetrahedron.corners[2] - X,
                          c = tetrahedron.corners[3] - X;
    // The axes may be left-handed.
    if (dot(a, cross(b, c)) < 0.0) std::swap(tetrahedron.corners[0], tetrahedron.corners[1]);
  }
  return result;
}

std::vector<AddedVolume> added_volumes(const Config& config) {
  std::vector<AddedVolume> result;
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    if (!body.surface) continue;
    const auto& [file, scale, size] = *body.surface;
    result.push_back({body.name, file.value, file.where, size, scale});
    if (size) *result.back().size /= scale;
  }
  return result;
}

std::vector<AffineBody> masses_of_rigid_bodies(const Config& config) {
  auto first = static_cast<int>(config.bodies.size() - config.rigid_bodies.size());
  std::vector<AffineBody> result;
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    result.push_back({first++, body.mass, body.center, second_moment(body)});
  }
  return result;
}

RigidMass mass_of_rigid_body(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                             const ModelShells& shells, int body) {
  const auto first = static_cast<int>(config.bodies.size() - config.rigid_bodies.size());
  if (body >= first) {
    const RigidBodyConfig& given = config.rigid_bodies[static_cast<std::size_t>(body - first)];
    return {given.mass, given.center};
  }
  std::vector<char> is_of_body(static_cast<std::size_t>(layout.num_local_nodes), 0);
  std::array<double, 4> of_volume{}, of_layers{};  // sums of measure times place, and of the measure
  const auto add = [](std::array<double, 4>& sums, double size, const Vector3<double>& place) {
    for (std::size_t i = 0; i < 3; ++i) sums[i] += size * place[i];
    sums[3] += size;
  };
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (body_of_cell[static_cast<std::size_t>(c)] != body) continue;
    const auto nodes = layout.nodes_of_cell(c);
    for (const PetscInt n : nodes) is_of_body[static_cast<std::size_t>(n)] = 1;
    if (c >= layout.num_owned_cells) continue;
    for_each_point_of_cell(layout, c, [&](const IntegrationPoint& point) {
      Vector3<double> place{};
      for (std::size_t a = 0; a < nodes.size(); ++a) place = place + point.shape[a] * layout.position(nodes[a]);
      add(of_volume, point.weight, place);
    });
  }
  for (const ModelShell& shell : shells.shells) {
    const std::vector<double> masses = lumped_masses_of_layer(layout, shell.facets, shell.mass_per_area);
    for (PetscInt f = 0; f < shell.facets.size(); ++f) {
      const auto nodes = shell.facets.nodes_of(f);
      const auto is_its_own = [&](PetscInt n) { return is_of_body[static_cast<std::size_t>(n)] != 0; };
      if (shell.facets.is_owned[static_cast<std::size_t>(f)] == 0 || !std::ranges::all_of(nodes, is_its_own)) continue;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        add(of_layers, masses[static_cast<std::size_t>(f) * nodes.size() + a], layout.position(nodes[a]));
      }
    }
  }
  sum_in_place(layout.comm, of_volume);
  sum_in_place(layout.comm, of_layers);
  const double density = config.bodies[static_cast<std::size_t>(body)].density.value_or(0.0);
  std::array<double, 4> moments = of_volume;
  RigidMass result{density * of_volume[3] + of_layers[3], {}};
  if (result.mass > 0.0) {
    for (std::size_t i = 0; i < 4; ++i) moments[i] = density * of_volume[i] + of_layers[i];
  }
  result.center = (1.0 / moments[3]) * Vector3<double>{moments[0], moments[1], moments[2]};
  return result;
}

std::vector<char> components_of_rigid_bodies(const Config& config, const NodeLayout& layout,
                                             const Components& components, const std::vector<int>& body_of_cell) {
  std::vector<char> result(static_cast<std::size_t>(components.count), 0);
  if (config.rigid_bodies.empty() && config.rods.empty() && !has_free_shells(config)) return result;
  std::vector<char> has_mesh(result.size(), 0);
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto component = static_cast<std::size_t>(components.of_node[layout.nodes_of_cell(c)[0]]);
    (stands_for_body(config, body_of_cell[static_cast<std::size_t>(c)]) ? result : has_mesh)[component] = 1;
  }
  for (std::size_t k = 0; k < result.size(); ++k) {
    const bool is_without = any_rank(layout.comm, result[k] != 0), has = any_rank(layout.comm, has_mesh[k] != 0);
    result[k] = is_without && !has ? 1 : 0;
  }
  return result;
}

std::vector<char> cells_without_mesh(const Config& config, const std::vector<int>& body_of_cell) {
  std::vector<char> result;
  for (const int body : body_of_cell) result.push_back(stands_for_body(config, body) ? 1 : 0);
  return result;
}

std::vector<char> cells_without_places(const Config& config, const std::vector<int>& body_of_cell) {
  if (config.rigid_bodies.empty() && config.rods.empty()) return {};
  const bool only_rigid = config.rods.empty() && all_stand_for_bodies(config);
  if (only_rigid) return {};
  std::vector<char> is_left_out;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const auto is_free_rod = [&](const RodConfig& rod) {
      return rod.curve.empty() && config.bodies[b].part.name == rod.name;
    };
    const bool is_rod = config.bodies[b].is_rod && std::ranges::any_of(config.rods, is_free_rod);
    const bool has_places = is_rod || config.bodies[b].is_shell;
    is_left_out.push_back(stands_for_body(config, static_cast<int>(b)) && !has_places ? 1 : 0);
  }
  std::vector<char> result;
  for (const int body : body_of_cell) result.push_back(body < 0 ? 0 : is_left_out[static_cast<std::size_t>(body)]);
  return result;
}

void set_velocities_of_rigid_bodies(const Config& config, const NodeLayout& layout,
                                    const std::vector<int>& body_of_cell, Vec v) {
  if (config.rigid_bodies.empty()) return;
  const int first = first_rigid_body(config, layout, body_of_cell);
  const ArrayView velocity(v);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const int body = body_of_cell[static_cast<std::size_t>(c)];
    if (body < first) continue;
    const RigidBodyConfig& rigid = config.rigid_bodies[static_cast<std::size_t>(body - first)];
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      if (n >= layout.num_owned_nodes) continue;
      const Vector3<double> arm = at_start(config, layout.position(n)) - at_start(config, rigid.center);
      const Vector3<double> omega = rigid.angular_velocity, turning = cross(omega, arm);
      // The field of all bodies turns the body, too, unless it has an angular velocity of its own.
      const auto [x, y, z] = norm(omega) > 0.0 ? Vector3<double>(rigid.center) : layout.position(n);
      for (std::size_t i = 0; i < 3; ++i) {
        const double of_field = config.initial.velocity[i](x, y, z, 0.0);
        velocity[3 * n + static_cast<PetscInt>(i)] = (rigid.velocity ? (*rigid.velocity)[i] : of_field) + turning[i];
      }
    }
  }
}

void set_moduli_of_rigid_bodies(const Config& config, std::vector<double>& shear_moduli) {
  for (const ShellConfig& shell : config.shells) {
    const auto is_its_body = [&](const BodyConfig& body) { return body.is_shell && body.part.name == shell.name; };
    const auto body = std::ranges::find_if(config.bodies, is_its_body);
    if (body == config.bodies.end()) continue;
    shear_moduli[static_cast<std::size_t>(body - config.bodies.begin())] =
        wave_moduli(ElasticityRule(shell.elasticity).law_at(0, {})).smallest;
  }
  give_rigid_bodies_the_largest_modulus(config, shear_moduli);
}

void give_rigid_bodies_the_largest_modulus(const Config& config, std::vector<double>& shear_moduli) {
  double largest = 0.0;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    if (!config.bodies[b].is_rigid) largest = std::max(largest, shear_moduli[b]);
  }
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    if (config.bodies[b].is_rigid) shear_moduli[b] = largest > 0.0 ? largest : modulus_between_rigid_bodies;
  }
}

std::vector<Selection> coupled_surfaces(const BodyConfig& body) {
  return surfaces_named(body.coupled);
}

std::vector<Selection> surfaces_held_by(const BodyConfig& body) {
  auto result = surfaces_named(body.attached);
  std::ranges::move(surfaces_named(body.coupled), std::back_inserter(result));
  return result;
}

std::vector<std::array<Selection, 2>> attached_surfaces(const Config& config) {
  std::vector<std::array<Selection, 2>> result;
  const std::size_t first = config.bodies.size() - config.rigid_bodies.size();
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    if (b >= first && !config.rigid_bodies[b - first].surface) continue;
    const BodyConfig& body = config.bodies[b];
    if (body.part.kind != Selection::Kind::volume) continue;
    for (const Selection& surface : surfaces_held_by(body)) result.push_back({surface, body.part});
  }
  return result;
}

AddedBodies names_of_added_bodies(const Config& config) {
  AddedBodies result = names_of_rigid_bodies(config);
  for (std::string& name : names_of_rods(config)) {
    result.names.push_back(name);
    result.without_surface.push_back(std::move(name));
  }
  for (const RodConfig& rod : config.rods) {
    if (!rod.curve.empty()) result.on_curves.emplace_back(rod.name, rod.curve);
  }
  for (const ShellConfig& shell : config.shells) {
    if (!shell.is_free) continue;
    result.names.push_back(shell.name);
    result.shells.push_back(shell.name);
  }
  return result;
}

std::vector<std::string> names_of_rods(const Config& config) {
  std::vector<std::string> names;
  for (const RodConfig& rod : config.rods) {
    names.push_back(rod.name);
    for (std::size_t end = 0; end < 2; ++end) {
      if (!rod.holder(end).empty()) names.push_back(name_of_end(rod.name, end));
    }
  }
  return names;
}

AddedBodies names_of_rigid_bodies(const Config& config) {
  AddedBodies result;
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    result.names.push_back(body.name);
    if (!body.surface) result.without_surface.push_back(body.name);
  }
  return result;
}

}  // namespace pliant
