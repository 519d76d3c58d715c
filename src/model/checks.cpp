#include "model/checks.hpp"

#include "input/analysis.hpp"
#include "input/checks/volumetric.hpp"
#include "input/loads.hpp"
#include "input/output_fields.hpp"
#include "model/shells.hpp"
#include "model/warnings.hpp"
#include "petsc/array_view.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace pliant {

void require_compressible(const ElasticLawSpec& law, const Location& where) {
  if (is_incompressible(law)) throw InputError(where, std::string(incompressible_without_pressures));
}

void require_volumetric_stiffness(const VolumeSplit& law, const ElasticityConfig& elasticity) {
  if (!(law.kappa > 0.0)) throw InputError(elasticity.where, lacks_volumetric_stiffness(elasticity.model, law.kappa));
}

bool is_incompressible(MPI_Comm comm, VolumeOfPoints found, const Config& config, std::size_t body) {
  const bool some_compressible = maximum(comm, found.some_compressible ? 1.0 : 0.0) > 0.0;
  if (!(maximum(comm, found.some_incompressible ? 1.0 : 0.0) > 0.0)) return false;
  if (some_compressible) {
    throw InputError(
        config.bodies[body].elasticity->where,
        "the body is incompressible at some places only; give the incompressible region a body of its own");
  }
  if (const auto error = method_error_of_incompressible_bodies(config))
    throw InputError(config.time.method.where, *error);
  return true;
}

void reject_undetermined_pressures(const Config& config) {
  throw InputError(
      {config.file, 0, 0},
      "the pressure of an incompressible body is not determined, because its whole surface is held; free a "
      "part of it, or use a poissons_ratio below 1/2");
}

void require_factorization(const Config& config, bool is_plain) {
  if (config.volumetric != VolumetricTreatment::mixed || config.solver.linear != LinearSolver::amg || is_plain) return;
  throw InputError(
      {config.file, 0, 0},
      "'volumetric: mixed' with ties, rigid parts, joints or contact between bodies needs a factorization; "
      "use 'solver: {linear: cholesky}'");
}

namespace {

/// A note about an axis along which constraints hold nothing, and contact has to.
std::optional<Diagnostic> free_direction(const Config& config) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_free = [&](const ConstraintConfig& constraint) {
      const auto* displacement = std::get_if<ConstraintConfig::Displacement>(&constraint.kind);
      return displacement != nullptr && !displacement->value[axis];
    };
    if (!std::ranges::all_of(config.constraints, is_free)) continue;
    return Diagnostic{Severity::note, config.time.method.where,
                      fmt::format("no constraint holds {}, where only contact and springs can: without inertia bodies "
                                  "move at once to where obstacles stop them, and a load that none of these bears has "
                                  "no equilibrium",
                                  "xyz"[axis])};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Diagnostic> check_support(const Config& config, const NodeLayout& layout, const Components& components,
                                        std::span<const PetscInt> held, Selections& selections) {
  // Joints, tendons and rigid bodies may hold a part, too.
  const bool is_plain = config.joints.empty() && config.tendons.empty() && config.rigid_bodies.empty();
  if (!is_plain) return std::nullopt;
  std::vector<double> is_held(static_cast<std::size_t>(components.count), 0.0);
  const auto component = [&](PetscInt n) { return static_cast<std::size_t>(components.of_node[n]); };
  for (const PetscInt n : held) is_held[component(n)] = 1.0;
  sum_in_place(layout.comm, is_held);
  const auto num_free = std::ranges::count(is_held, 0.0);
  const bool may_lie = config.contact && !config.contact->obstacles.empty();
  if (num_free == 0) return may_lie && analysis_of(config) != Analysis::dynamic ? free_direction(config) : std::nullopt;
  if (analysis_of(config) == Analysis::dynamic) {
    if (!may_fall(config)) return std::nullopt;
    return note(fmt::format(
        "nothing holds {}: the loads move {} away; add constraints, springs or contact to hold a body",
        components.count == 1 ? "the body" : fmt::format("{} of the mesh's {} parts", num_free, components.count),
        num_free == 1 ? "it" : "them"));
  }
  const std::span<const LoadConfig> loads = may_fall(config) ? std::span(config.loads) : std::span<const LoadConfig>();
  for (const LoadConfig& load : loads) {
    const VectorExpression* vector = vector_of(load);
    const auto is_nothing = [](const Expression& part) { return part.is_zero(); };
    if (vector == nullptr || std::ranges::all_of(*vector, is_nothing)) continue;
    std::vector<PetscInt> nodes(static_cast<std::size_t>(layout.num_owned_nodes));
    std::iota(nodes.begin(), nodes.end(), 0);
    if (load.part.kind != Selection::Kind::everything) nodes = selections.nodes(load.part);
    const auto pushed = std::ranges::find_if(nodes, [&](PetscInt n) { return is_held[component(n)] == 0.0; });
    std::vector<Vector3<double>> place;
    if (pushed != nodes.end()) place.push_back(layout.position(*pushed));
    const auto places = gathered(layout.comm, place);
    if (places.empty()) continue;
    const auto& [x, y, z] = places.front();
    selections.report(load.where,
                      fmt::format("nothing holds the part of the mesh near ({:.4g}, {:.4g}, {:.4g}) m, which shares no "
                                  "node with what is held: the loads move it, and without inertia it has no "
                                  "equilibrium; add constraints, springs or contact, or use a method with inertia",
                                  x, y, z));
    selections.throw_if_errors();
  }
  const auto is_foundation = [](const LoadConfig& load) { return foundation_of(load).has_value(); };
  if (num_free == components.count && may_lie && config.springs.empty() && config.rods.empty() &&
      std::ranges::none_of(config.loads, is_foundation)) {
    return Diagnostic{
        Severity::note, config.time.method.where,
        "nothing but contact holds the bodies: without inertia they move at once to where obstacles stop "
        "them, and along these their place is arbitrary unless friction holds them; if that fails, a weak "
        "`spring` on a surface holds bodies until they touch"};
  }
  if (num_free == components.count || !config.springs.empty() || !config.rods.empty() ||
      std::ranges::any_of(config.loads, is_foundation)) {
    return std::nullopt;  // or something else may hold it
  }
  const bool is_one = num_free == 1;
  return Diagnostic{
      config.contact ? Severity::note : Severity::warning, config.time.method.where,
      fmt::format("nothing{} holds {} of the mesh's {} parts: without inertia {} can move as a rigid body{}, where the "
                  "stiffness is singular; a constraint, or a weak `spring` on a surface, holds a part",
                  config.contact ? " but contact" : "", num_free, components.count, is_one ? "it" : "they",
                  config.contact ? (is_one ? " until it touches" : " until they touch") : "")};
}

void require_undeformed(const Config& config, Vec q, const std::array<double, 6>& bounds) {
  constexpr double rounding = 1e-12;  // of places: rods that turn with their start move by it
  PetscReal largest = 0.0;
  check(VecNorm(q, NORM_INFINITY, &largest));
  if (largest <= rounding * std::hypot(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2])) return;
  const auto moves = [](const ConstraintConfig& constraint) {
    const auto* prescribed = std::get_if<ConstraintConfig::Displacement>(&constraint.kind);
    return prescribed != nullptr &&
           std::ranges::any_of(prescribed->value, [](const auto& u) { return u && !u->is_zero(); });
  };
  const auto constraint = std::ranges::find_if(config.constraints, moves);
  throw InputError(
      constraint != config.constraints.end() ? constraint->where : Location{config.file, 0, 0},
      "an incompressible body must start undeformed, because its deformation does not determine its pressure, "
      "but a displacement is prescribed at t = 0; let it grow from 0, or use a poissons_ratio below 1/2");
}

void require_near(const NodeLayout& layout, const std::array<double, 6>& bounds,
                  const std::vector<ProbeLocation>& locations, const std::vector<ProbeConfig>& probes,
                  const std::vector<char>& is_left_out) {
  constexpr double near = 0.05;  // of the mesh's diagonal
  const double diagonal = std::hypot(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2]);
  std::vector<Diagnostic> errors;
  for (std::size_t p = 0; p < locations.size(); ++p) {
    if (!(locations[p].distance > near * diagonal)) continue;  // to a node
    const NearestOfMesh nearest = nearest_of_mesh(layout, probes[p].point, is_left_out);
    if (!(nearest.distance > near * diagonal)) continue;
    const auto& [x, y, z] = nearest.point;
    errors.push_back({Severity::error, probes[p].where,
                      fmt::format("probe '{}' lies outside the mesh, {:.3g} m from its nearest point ({:.4g}, {:.4g}, "
                                  "{:.4g}); positions are in metres, after 'mesh.scale', of the undeformed body",
                                  probes[p].name, nearest.distance, x, y, z)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
}

void require_bodies_at_probes(const Config& config, MPI_Comm comm, const std::vector<ProbeLocation>& locations,
                              const std::vector<char>& stands_in) {
  std::vector<Diagnostic> errors;
  for (const FieldColumnConfig& column : config.output.history) {
    const auto of = field_component(column.of.value);
    if (!column.at || of->field.owner != FieldOwner::bodies) continue;
    const auto probe = std::ranges::find(config.probes, column.at->value, &ProbeConfig::name);
    const PetscInt cell = locations[static_cast<std::size_t>(probe - config.probes.begin())].cell;
    if (!any_rank(comm, cell >= 0 && stands_in[static_cast<std::size_t>(cell)] != 0)) continue;
    errors.push_back({Severity::error, column.at->where,
                      fmt::format("probe '{}' lies on a body without tetrahedra, where the field '{}' is not",
                                  probe->name, of->field.name)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
}

std::vector<Diagnostic> notes_of_curved_sides(const Config& config, const Mesh& mesh) {
  const bool is_quadratic = config.element == ElementOrder::p2;
  if (!is_quadratic && mesh.geometry_order == 2) {
    return {note("the mesh has curved edges, which P1 elements straighten; `element: P2` keeps them")};
  }
  const bool takes_curves = config.mesh.refine == 0 && config.rods.empty() && !has_free_shells(config);
  if (!is_quadratic || !mesh.report.is_straightened || !takes_curves) return {};
  const std::string& file = config.mesh.file.value;
  const std::string order = "'Mesh.ElementOrder = 2;'";
  return {note("the geometry has curved faces, and the sides of its P2 elements are straight: for curved ones, " +
               (file.ends_with(".geo")
                    ? "write " + order + " in " + file
                    : "mesh it by a .geo file with " + order + " that loads it ('Merge \"" + file + "\";')"))};
}

std::vector<Diagnostic> notes_of_distant_probes(const std::vector<ProbeLocation>& locations,
                                                const std::vector<ProbeConfig>& probes) {
  std::vector<Diagnostic> notes;
  for (std::size_t p = 0; p < locations.size(); ++p) {
    const double far = locations[p].distance;
    if (!(far > 0.0)) continue;
    notes.push_back(
        note(fmt::format("probe '{}' lies outside the mesh; the nearest node, {:.3g} m away, is recorded instead",
                         probes[p].name, far)));
  }
  return notes;
}

void require_finite_initial(const Config& config, const NodeLayout& layout, const char* what, Vec values) {
  on_every_rank(layout.comm, [&] {
    const ConstArrayView view(values);
    const std::span<const double> numbers = view.span();
    const auto found = std::ranges::find_if_not(numbers, [](double number) { return std::isfinite(number); });
    if (found == numbers.end()) return;
    const auto [x, y, z] = layout.position(static_cast<PetscInt>((found - numbers.begin()) / 3));
    throw InputError({config.file, 0, 0},
                     fmt::format("the initial {} is not finite at ({:g}, {:g}, {:g})", what, x, y, z));
  });
}

}  // namespace pliant
