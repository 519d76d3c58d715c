#include "model/constraints.hpp"

#include "energy/rigid/rigid_fit.hpp"
#include "energy/rigid/surface_mean.hpp"
#include "fem/cell_integration.hpp"
#include "fem/plane.hpp"
#include "model/rigid_bodies.hpp"
#include "model/tied_surfaces.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

using Normal = ConstraintConfig::Normal;
using Periodic = ConstraintConfig::Periodic;
using Equation = ConstraintConfig::Equation;

/// Whether a joint has columns of forces by this name.
bool is_joint(const Config& config, const std::string& name) {
  return std::ranges::find(config.joints, name, &JointConfig::name) != config.joints.end();
}

/// The support's name in the history: its own, else its group's, else by its place in the list of constraints.
std::string support_name(const Config& config, std::size_t index) {
  const ConstraintConfig& constraint = config.constraints[index];
  if (!constraint.name.empty()) return constraint.name;
  const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&constraint.kind);
  if (rigid != nullptr && !rigid->support.empty()) return rigid->support;
  const std::string& group = constraint.part.name;
  return group.empty() || is_joint(config, group) ? fmt::format("constraint{}", index + 1) : group;
}

/// The axis that the direction lies along; nothing if it lies along none.
std::optional<int> axis_of(const Vector3<double>& direction) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(direction[static_cast<std::size_t>(i)]) == norm(direction)) return i;
  }
  return std::nullopt;
}

/// The centroid of the cells; nothing if there are none. Collective.
std::optional<Vector3<double>> centroid(const NodeLayout& layout, const std::vector<char>& is_counted) {
  std::array<double, 4> sums{};
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (is_counted[static_cast<std::size_t>(c)] == 0) continue;
    const auto nodes = layout.nodes_of_cell(c);
    for_each_point_of_cell(layout, c, [&](const IntegrationPoint& point) {
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const auto X = layout.position(nodes[a]);
        for (std::size_t i = 0; i < 3; ++i) sums[i] += point.weight * point.shape[a] * X[i];
      }
      sums[3] += point.weight;
    });
  }
  sum_in_place(layout.comm, sums);
  if (!(sums[3] > 0.0)) return std::nullopt;
  return (1.0 / sums[3]) * Vector3<double>{sums[0], sums[1], sums[2]};
}

/// The mean of owned nodes. Collective.
Vector3<double> mean_place(const NodeLayout& layout, const std::vector<PetscInt>& nodes) {
  std::array<double, 4> sums{0.0, 0.0, 0.0, static_cast<double>(nodes.size())};
  for (const PetscInt n : nodes) {
    for (std::size_t i = 0; i < 3; ++i) sums[i] += layout.position(n)[i];
  }
  sum_in_place(layout.comm, sums);
  return (1.0 / std::max(sums[3], 1.0)) * Vector3<double>{sums[0], sums[1], sums[2]};
}

/// The center of a rigid part that the input does not give. Cells that stand for rods and shells have no volume of
/// their own. Collective.
Vector3<double> default_centre(const Config& config, const NodeLayout& layout, const Selection& part,
                               const std::vector<PetscInt>& nodes, Selections& selections) {
  if (sum(layout.comm, static_cast<PetscInt64>(nodes.size())) == 0) return {};  // already an error
  if (part.kind == Selection::Kind::surface) {
    const SurfaceMean mean = mean_of_surface(layout, selections.facets(part));
    if (mean.area > 0.0) return mean.middle;
  }
  const AddedBodies added = names_of_added_bodies(config);
  if (part.kind == Selection::Kind::volume && std::ranges::find(added.names, part.name) == added.names.end()) {
    if (const auto of_cells = centroid(layout, selections.cells(part))) return *of_cells;
  }
  return mean_place(layout, nodes);
}

}  // namespace

Constraints::Constraints(const Config& config, const NodeLayout& layout, Selections& selections) : layout_(layout) {
  for (const auto& constraint : config.constraints) {
    parts_.push_back(make_part(config, constraint, selections));
    parts_.back().where = constraint.where;
  }
  std::vector<PrescribedPart> prescriptions;
  for (const Part& part : parts_) {
    prescriptions.push_back({part.is_prescribed ? part.nodes : std::vector<PetscInt>(), part.displacement});
  }
  // Nodes that no unknown belongs to.
  GivenDisplacement rest;
  for (auto& component : rest.components) component = Expression(0.0);
  prescriptions.push_back({selections.inert_nodes(), rest});
  prescribed_ = std::make_unique<PrescribedDisplacement>(layout, std::move(prescriptions), HUGE_VAL);
  on_every_rank(layout.comm, [&] {
    for (const auto& [i, j] : prescribed_->conflicts(layout, times_to_compare(config))) {
      selections.report(
          config.constraints[j].where,
          fmt::format("{} and {} share nodes but prescribe different displacements there; make one of them `free` or "
                      "let them agree",
                      title_of_constraint(config, i), title_of_constraint(config, j)));
    }
    selections.throw_if_errors();
  });
  const ConstraintsOnMesh constraints{config, layout, parts_};
  ConstraintTies all_ties = find_ties(constraints, selections);
  for (const SurfaceTie& tie : all_ties.of_surfaces) {
    parts_[tie.source].nodes = owned_nodes(layout, tie);
    description_.push_back(note_of(config, tie));
  }
  check_rotating_parts(constraints, all_ties, selections);
  const bool any_rotates = std::ranges::any_of(parts_, [](const Part& part) { return part.rotation.has_value(); });
  if (any_rotates || !all_ties.empty() || !config.joints.empty()) {
    const auto slaves = eliminate_ties(constraints, *prescribed_, std::move(all_ties), selections);
    std::vector<GivenDisplacement> given;
    for (const Part& part : parts_) given.push_back(part.displacement);
    RigidSystem system = make_rigid_system(constraints, selections);
    joints_ = std::move(system.joints);
    map_ = std::make_unique<ConstraintMap>(layout_, slaves, std::move(given), std::move(system.dependents));
    const bool has_inertia = analysis_of(config) == Analysis::dynamic;
    map_->set_rigidity(has_inertia ? Rigidity::of_accelerations : Rigidity::of_configurations);
  }
  add_supports(config);
}

void Constraints::require_finite(double time) const {
  on_every_rank(layout_.comm, [&] {
    for (const Part& part : parts_) {
      for (const PetscInt node : part.nodes) {
        for (int i = 0; i < 3; ++i) {
          if (!part.displacement.gives(i)) continue;
          if (std::isfinite(part.displacement(i, layout_.position(node), time))) continue;
          throw InputError(part.where, fmt::format("the displacement is not finite at t = {:g}", time));
        }
      }
    }
  });
}

Constraints::Part Constraints::make_part(const Config& input, const ConstraintConfig& constraint,
                                         Selections& selections) {
  const auto& kind = constraint.kind;
  if (const auto* prescribed = std::get_if<ConstraintConfig::Displacement>(&kind)) {
    return {selections.nodes(constraint.part), {prescribed->value}, true};
  }
  if (const auto* along = std::get_if<ConstraintConfig::Along>(&kind)) {
    const Vector3<double> direction = unit(along->direction);
    Part part{selections.nodes(constraint.part), {}, false, direction};
    part.displacement.components[0] = along->displacement;
    return part;
  }
  if (const auto* tied = std::get_if<Periodic>(&kind)) return {selections.nodes(constraint.part), {tied->difference}};
  if (std::holds_alternative<ConstraintConfig::Tied>(kind)) return {};  // its nodes are known later
  if (std::holds_alternative<ConstraintConfig::Rigid>(kind)) return rigid(input, constraint, selections);
  if (const auto* equation = std::get_if<Equation>(&kind)) {
    Part part;
    part.displacement.components[0] = equation->value;
    const EquationTermConfig& first = equation->terms.front();
    part.direction[static_cast<std::size_t>(first.component)] = first.coefficient;
    return part;
  }
  return plane(constraint, selections);
}

// A normal along an axis makes it a prescribed component, at no cost.
Constraints::Part Constraints::plane(const ConstraintConfig& constraint, Selections& selections) {
  Part part;
  part.nodes = selections.nodes(constraint.part);
  if (sum(layout_.comm, static_cast<PetscInt64>(part.nodes.size())) == 0) return part;  // already an error
  const bool is_of_surface = constraint.part.kind == Selection::Kind::surface ||
                             constraint.part.kind == Selection::Kind::box ||
                             constraint.part.kind == Selection::Kind::where;
  if (!is_of_surface) {
    selections.report(constraint.part.where, fmt::format("{} has no normal; choose a plane surface by `surface`, "
                                                         "`box` or `where`",
                                                         describe(constraint.part)));
    return part;
  }
  const FacetList facets = selections.facets(constraint.part);
  if (sum(layout_.comm, static_cast<PetscInt64>(facets.size())) == 0) return part;  // already an error
  if (any_rank(layout_.comm, std::ranges::find(facets.is_outer, 0) != facets.is_outer.end())) {
    selections.report(constraint.part.where, fmt::format("{} lies inside the mesh, where a normal has no outside; name "
                                                         "a part of the outer surface",
                                                         describe(constraint.part)));
    return part;
  }
  const auto normal = common_normal(layout_, facets);
  if (!normal) {
    selections.report(constraint.part.where, fmt::format("{} is not plane, so its nodes have no normal in common; give "
                                                         "each plane part a constraint of its own",
                                                         describe(constraint.part)));
    return part;
  }
  const auto* given = std::get_if<Normal>(&constraint.kind);
  const Expression value = given != nullptr ? given->displacement : Expression();  // symmetry: none
  if (const auto axis = axis_of(*normal)) {
    const auto i = static_cast<std::size_t>(*axis);
    part.displacement.components[i] = value.scaled((*normal)[i] < 0.0 ? -1.0 : 1.0);
    part.is_prescribed = true;
  } else {
    part.displacement.components[0] = value;
    part.direction = *normal;
  }
  return part;
}

Constraints::Part Constraints::rigid(const Config& input, const ConstraintConfig& constraint, Selections& selections) {
  const auto& config = std::get<ConstraintConfig::Rigid>(constraint.kind);
  Part part{selections.nodes(constraint.part), {}, true};
  for (const Selection& attached : config.attached) {
    const auto more = selections.nodes(attached);
    part.nodes.insert(part.nodes.end(), more.begin(), more.end());
  }
  std::ranges::sort(part.nodes);
  part.nodes.erase(std::ranges::unique(part.nodes).begin(), part.nodes.end());
  RigidMotion motion;
  motion.translation = config.translation;
  if (const auto* about = std::get_if<RotationConfig::AboutAxis>(&config.rotation.kind)) {
    motion.axis = unit(about->axis);
    if (about->angle) {
      motion.angle = *about->angle;
    } else {
      part.rotation = FreeRotation::about_axis;
    }
  } else if (std::holds_alternative<RotationConfig::Free>(config.rotation.kind)) {
    part.rotation = FreeRotation::about_all_axes;
  }
  part.is_prescribed = !part.rotation;
  motion.centre = config.center ? Vector3<double>(*config.center)
                                : default_centre(input, layout_, constraint.part, part.nodes, selections);
  part.displacement.rigid = motion;
  if (part.rotation && sum(layout_.comm, static_cast<PetscInt64>(part.nodes.size())) > 0) {
    if (const auto reason = why_not_rigid(layout_, part.nodes, motion, *part.rotation)) {
      selections.report(constraint.where,
                        fmt::format("{} {}; give the rotation, or say `fixed`", describe(constraint.part), *reason));
    }
  }
  return part;
}

// An entry counts for the first constraint that claims it. A rigid part claims all entries of its nodes; tied surfaces
// claim what no other constraint does.
void Constraints::add_supports(const Config& config) {
  std::vector<char> claimed(prescribed_->flags().size(), 0);
  for (std::size_t c = 0; c < parts_.size(); ++c) {
    const Part& part = parts_[c];
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&config.constraints[c].kind);
    if (rigid != nullptr && rigid->is_implied) {
      support_of_part_.push_back(no_support);
      continue;
    }
    const bool is_rigid = part.displacement.rigid.has_value();
    const std::string name = support_name(config, c);
    auto support = std::ranges::find(supports_, name, &Support::name);
    if (support == supports_.end()) support = supports_.insert(supports_.end(), {name, {}, {}});
    support_of_part_.push_back(static_cast<std::size_t>(support - supports_.begin()));
    if (is_rigid && !support->rigid_part) support->rigid_part = c;
    support->has_ties |= !is_rigid && !part.is_prescribed;
    for (int i = 0; i < 3; ++i) {
      if (!is_rigid && !(part.is_prescribed && part.displacement.gives(i))) continue;
      for (const PetscInt node : part.nodes) {
        if (std::exchange(claimed[3 * node + i], 1)) continue;
        support->dofs.push_back(3 * node + i);
      }
    }
  }
  for (std::size_t c = 0; c < parts_.size(); ++c) {
    if (!std::holds_alternative<ConstraintConfig::Tied>(config.constraints[c].kind)) continue;
    for (const PetscInt node : parts_[c].nodes) {
      for (PetscInt dof = 3 * node; dof < 3 * node + 3; ++dof) {
        if (!std::exchange(claimed[dof], 1)) supports_[support_of_part_[c]].dofs.push_back(dof);
      }
    }
  }
}

std::vector<int> Constraints::rigid_parts() const {
  const Handle<Vec> numbers = make_vector(layout_);
  {
    const ArrayView of_entries(numbers.get());
    for (std::size_t c = 0; c < parts_.size(); ++c) {
      if (!parts_[c].displacement.rigid) continue;
      for (const PetscInt node : parts_[c].nodes) of_entries[3 * node] = static_cast<double>(c + 1);
    }
  }
  update_ghosts(numbers.get());
  const ConstGhostedView view(numbers.get());
  std::vector<int> result;
  for (PetscInt n = 0; n < layout_.num_local_nodes; ++n) result.push_back(static_cast<int>(view.span()[3 * n]));
  return result;
}

PrescribedMotion Constraints::motion(Correction correction) const {
  return map_ ? map_->motion(prescribed_->motion(), correction) : prescribed_->motion();
}

std::vector<Constraints::Hold> Constraints::held() const {
  std::vector<Hold> result(3 * static_cast<std::size_t>(layout_.num_owned_nodes), Hold::none);
  const std::vector<char> is_ideal = map_ ? map_->is_ideal() : std::vector<char>(result.size(), 0);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const bool is_held = prescribed_->flags()[i] != 0 || (map_ && map_->is_tied()[i] != 0);
    if (is_held) result[i] = is_ideal[i] != 0 ? Hold::ideal : Hold::prescribed;
  }
  return result;
}

}  // namespace pliant
