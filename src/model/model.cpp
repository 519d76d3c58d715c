#include "model/model.hpp"

#include "base/stopwatch.hpp"
#include "energy/constraint/velocity_projection.hpp"
#include "fem/entry_keys.hpp"
#include "input/checks/volumetric.hpp"
#include "input/elasticity.hpp"
#include "model/active.hpp"
#include "model/checks.hpp"
#include "model/elastic_parts.hpp"
#include "model/events.hpp"
#include "model/free_rotation.hpp"
#include "model/initial_displacement.hpp"
#include "model/joint_efforts.hpp"
#include "model/joints_at_start.hpp"
#include "model/may_touch.hpp"
#include "model/mesh_cell_data.hpp"
#include "model/mesh_source.hpp"
#include "model/method_warnings.hpp"
#include "model/places.hpp"
#include "model/rigid_bodies.hpp"
#include "model/rod_bond.hpp"
#include "model/selections.hpp"
#include "model/start_adjustment.hpp"
#include "model/start_overlap.hpp"
#include "model/tied_surfaces.hpp"
#include "model/viscosity.hpp"
#include "model/warnings.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace pliant {

Model::Model(MPI_Comm comm, const Config& given, const TermFactory& additional) : config_(with_rigid_bodies(given)) {
  const Mesh mesh = [&] {
    const Stopwatch watch(mesh_seconds_);
    return read_mesh(comm, mesh_source(given));
  }();
  build(mesh, additional);
  layout_.node_of_point = std::vector<PetscInt>();  // of the mesh, which goes
}

Model::Model(const Mesh& mesh, const Config& given, const TermFactory& additional) : config_(with_rigid_bodies(given)) {
  build(mesh, additional);
}

Model::Model(const Mesh& mesh, const Config& given, const NodeLayout& numbered)
    : config_(with_rigid_bodies(given)), layout_(numbered) {
  build(mesh, {});
}

void Model::build(const Mesh& mesh, const TermFactory& additional) {
  const Config& config = config_;
  mesh_report_ = mesh.report;
  const int order = static_cast<int>(config.element);
  if (layout_.comm == MPI_COMM_NULL) layout_ = make_layout(mesh, order);
  fingerprint_ = fingerprint(layout_);
  mesh_groups_ = find_mesh_groups(mesh, layout_);
  on_every_rank(layout_.comm, [&] { pattern_ = std::make_unique<BlockPattern>(layout_); });
  include(notes_of_curved_sides(config, mesh));
  build_terms(config, mesh);
  if (additional) {
    additional_ = additional(*this);
  } else if (nothing_moves(config)) {
    warn({config.file, 0, 0},
         "nothing moves the bodies: no load, no prescribed motion, no initial velocity; the result is 0");
  }
  make_equation(config);
  include(warnings_about_joints_at_start(config, layout_, body_of_cell_, constraints_->joints()));
  if (contacts_) include(contacts_->warnings_about_start(instant_of_start(), config.initial.displacement));
  check_overlap(config);
  include(notes_of_idle_keys(config));
  include(events_of(config).diagnostics);
  include(warnings_about_moving_kinks(config, mesh_report_.bounds));
  check_method(config);
  // Warnings last, where the user sees them.
  std::ranges::stable_sort(diagnostics_, std::ranges::greater{}, &Diagnostic::severity);
}

void Model::check_method(const Config& config) {
  std::vector<double> shear_waves;
  for (std::size_t b = 0; b < densities_.size(); ++b) {
    shear_waves.push_back(densities_[b] > 0.0 ? std::sqrt(shear_moduli_[b] / densities_[b]) : 0.0);
  }
  auto warnings =
      warnings_about_method(config, {layout_, body_of_cell_, shear_waves, wave_speeds_.slowest, mesh_report_});
  if (is_incompressible_) {
    if (auto warning = warning_about_pressures(config)) warnings.push_back(std::move(*warning));
  }
  if (auto of_growth = note_about_growth(config); of_growth && warnings.empty()) {
    diagnostics_.push_back(std::move(*of_growth));
  }
  include(std::move(warnings));
}

void Model::include(std::vector<Diagnostic> found) {
  std::ranges::move(found, std::back_inserter(diagnostics_));
}

template <int Order>
void Model::build_cells(const Config& config, const Mesh& mesh) {
  std::vector<std::optional<ElasticityRule>> rules;  // of bodies that are not rigid
  std::vector<int> degrees;
  for (const auto& body : config.bodies) {
    auto& rule = rules.emplace_back();
    if (body.elasticity) rule.emplace(*body.elasticity);
    degrees.push_back(rule ? elastic_quadrature_degree(rule->kind().traits(), Order) : 1);
  }
  auto& groups = cells_.emplace<CellGroups<Order>>();
  const bool is_mixed = config.volumetric == VolumetricTreatment::mixed;
  if (is_mixed) {
    std::vector<int> with_pressure = body_of_cell_;
    for (int& body : with_pressure) {
      if (body >= 0 && !rules[static_cast<std::size_t>(body)]) body = -1;
    }
    pressures_ = std::make_unique<PressureField>(
        make_pressure_layout(layout_, with_pressure, static_cast<int>(rules.size())), layout_.comm);
  }
  on_every_rank(layout_.comm, [&] {
    try {
      groups = make_cell_groups<Order>(layout_, *pattern_, body_of_cell_, degrees);
    } catch (const InputError& e) {
      throw InputError(config.mesh.file.where, e.diagnostics().front().message);
    }
  });
  wave_speeds_ = {0.0, HUGE_VAL};
  shear_moduli_.assign(rules.size(), 0.0);
  const MeshCellData cell_data(mesh, layout_);
  std::vector<VolumeOfPoints> found(rules.size());
  laws_.resize(rules.size());
  expansions_.resize(rules.size());
  activations_.resize(rules.size());
  on_every_rank(layout_.comm, [&] {
    for (std::size_t b = 0; b < rules.size(); ++b) {
      const int body = static_cast<int>(b);
      if (!rules[b]) continue;
      ElasticityRule& rule = *rules[b];
      rule.bind(cell_data);
      const auto law_at = [&](PetscInt cell, const std::array<double, 3>& X) {
        ElasticLawSpec law = rule.law_at(cell, X);
        if (!is_mixed) require_compressible(law, config.bodies[b].elasticity->where);
        const WaveModuli moduli = wave_moduli(law);
        wave_speeds_.include(moduli, densities_[b]);
        shear_moduli_[b] = std::max(shear_moduli_[b], moduli.smallest);
        return law;
      };
      const ActiveParts active = make_active_parts<Order>(config.bodies[b], {cell_data, layout_, groups, body});
      if (active.tension) {
        active_.push_back(make_active_stress_term<Order>(active.tension, groups, body, layout_.num_owned_nodes));
      }
      expansions_[b] = active.shape.expansion;
      activations_[b] = active.tension ? active.tension : active.shape.shortening;
      auto parts =
          make_elastic_parts<Order>({config, rule, layout_, groups, body, pressures_.get()}, law_at, active.shape);
      found[b] = parts.volume;
      laws_[b] = std::move(parts.shape);
      if (parts.mixed != nullptr) mixed_.push_back(parts.mixed);
      if (parts.softening) softening_.push_back(std::move(parts.softening));
      elastic_.push_back(std::move(parts.term));
      bodies_of_elastic_.push_back(body);
    }
  });
  for (std::size_t b = 0; b < rules.size() && is_mixed; ++b) {
    if (rules[b] && is_incompressible(layout_.comm, found[b], config, b)) is_incompressible_ = true;
  }
  wave_speeds_ = {maximum(layout_.comm, wave_speeds_.fastest), minimum(layout_.comm, wave_speeds_.slowest)};
  for (double& modulus : shear_moduli_) modulus = maximum(layout_.comm, modulus);
  set_moduli_of_rigid_bodies(config, shear_moduli_);
}

template <int Order>
void Model::build_inertia(const Config& config) {
  const auto& groups = std::get<CellGroups<Order>>(cells_);
  const bool has_mass = std::any_of(densities_.begin(), densities_.end(), [](double d) { return d > 0.0; });
  if (!has_mass && config.rigid_bodies.empty() && config.rods.empty() && config.shells.empty()) return;
  const Mass kind = config.mass == MassKind::consistent ? Mass::consistent : Mass::lumped;
  MassMatrix mass = make_mass_matrix<Order>(layout_, *pattern_, groups, densities_, kind);
  add_affine_bodies(layout_, *pattern_, body_of_cell_, masses_of_rigid_bodies(config), mass);
  rods_.add_masses(*pattern_, config.mass, mass);
  add_masses_of_shells(layout_, *pattern_, config.mass, shells_, mass);
  inertia_ = std::make_unique<Inertia>(layout_, std::move(mass),
                                       make_cell_mass_products<Order>(layout_, groups, densities_, kind));
}

void Model::build_terms(const Config& config, const Mesh& mesh) {
  // Selections are by places in the mesh as it is given, whatever is moved before the start.
  const std::optional<NodeLayout> as_meshed = resolves_start(config) ? std::optional(layout_) : std::nullopt;
  Selections selections(mesh, as_meshed ? *as_meshed : layout_, names_of_added_bodies(config));

  std::vector<Selection> parts;
  for (const auto& body : config.bodies) {
    parts.push_back(body.part);
    body_names_.push_back(body.part.name.empty() ? "body" : body.part.name);
    densities_.push_back(body.density.value_or(0.0));
  }
  body_of_cell_ = selections.cells(parts);
  if (any_rank(layout_.comm, std::ranges::count(body_of_cell_, -1) > 0)) selections.throw_if_errors();
  rods_ = make_rods(config, mesh, layout_, body_of_cell_, selections);
  include(notes_about_fibres(config, rods_));
  shells_ = find_shells(config, layout_, selections);
  LoadParts load_parts =
      find_loads(config, {layout_, *pattern_, body_of_cell_, densities_, rods_, shells_}, selections);
  MayTouch may_touch;
  if (config.contact) {
    may_touch = find_what_may_touch(config, layout_, body_of_cell_, rods_, selections);
    if (as_meshed) {
      include(adjust_start(*config.contact, may_touch.each_other, body_names_, config.initial.displacement,
                           selections.facets(Selection{}), *as_meshed, layout_));
    }
  }
  field_regions_ = find_field_regions(config, layout_, body_of_cell_, selections);
  constraints_ = std::make_unique<Constraints>(config, layout_, selections);
  require_factorization(config, constraints_->map() == nullptr && may_touch.each_other.empty());
  include(constraints_->description());
  const std::vector<char> left_out = cells_without_places(config, body_of_cell_);
  const BodiesOnMesh bodies{config, layout_, body_of_cell_, left_out};
  tendons_ = make_tendons(bodies, mesh, selections);
  build_shells(config, layout_, *pattern_, shells_);
  if (layout_.order == 1) {
    build_cells<1>(config, mesh);
    build_inertia<1>(config);
  } else {
    build_cells<2>(config, mesh);
    build_inertia<2>(config);
  }
  add_bond(bodies, shear_moduli_, rods_);
  couplings_ = make_couplings(bodies, shear_moduli_, constraints_->rigid_parts(), selections);
  for (const ModelCoupling& coupling : couplings_) diagnostics_.push_back(coupling.note);
  include(selections.unused_groups());
  include(warnings_about(config));
  include(warnings_about_places(config, layout_, body_of_cell_, shear_moduli_));
  include(warnings_about_what_is_held(config, layout_, selections, constraints_->prescribed()));
  if (!has_incompressible_body(config) && analysis_of(config) == Analysis::dynamic) {  // or a strain is refused later
    include(warnings_about_start(config, layout_, selections));
  }
  include(warnings_about_shared_walls(config, layout_, load_parts.wetted));
  loads_ = std::make_unique<Loads>(config, layout_, *pattern_, std::move(load_parts), constraints_->prescribed());
  include(warnings_about_given_volumes(config, loads_->cavities()));
  require_finite(analysis_of(config) == Analysis::static_equilibrium ? config.time.end : 0.0);
  if (config.contact) {
    const std::vector<char> not_of_mesh = cells_without_mesh(config, body_of_cell_);
    contacts_ = std::make_unique<Contacts>(
        *config.contact, analysis_of(config),
        ContactBodies{may_touch.obstacles, layout_, *pattern_, body_of_cell_, body_names_,
                      may_touch.moduli(config, shear_moduli_), constraints_->prescribed().flags(),
                      constraints_->rigid_parts(), may_touch.thin,
                      initial_displacement(config.initial.displacement, layout_), not_of_mesh},
        may_touch.each_other);
    include(contacts_->description());
  }

  find_components(config, selections);
  are_kept_apart_ = components_kept_apart(layout_.comm, components_, may_touch.each_other);
  are_without_surface_ = components_of_rigid_bodies(config, layout_, components_, body_of_cell_);
  for (std::size_t k = 0; k < are_kept_apart_.size(); ++k) {
    if (is_without_surface(k)) are_kept_apart_[k] = 1;
  }

  springs_ = make_springs(bodies);
  find_probes(config, left_out);
}

void Model::find_probes(const Config& config, const std::vector<char>& left_out) {
  std::vector<std::array<double, 3>> points;
  for (const auto& probe : config.probes) points.push_back(probe.point);
  probes_ = locate(layout_, points, left_out);
  move_to_triangles(config, layout_, body_of_cell_, probes_);
  require_near(layout_, mesh_report_.bounds, probes_, config.probes, left_out);
  include(notes_of_distant_probes(probes_, config.probes));
  require_bodies_at_probes(config, layout_.comm, probes_, cells_without_mesh(config, body_of_cell_));
}

void Model::find_components(const Config& config, Selections& selections) {
  components_ = connected_components(layout_);
  std::vector<std::vector<PetscInt>> links;
  std::vector<PetscInt> held;  // nodes
  for (const ConstraintConfig& c : config.constraints) {
    std::vector<PetscInt> nodes;
    const auto add = [&](const Selection& part) {
      for (const PetscInt n : selections.nodes(part)) nodes.push_back(n);
    };
    const auto* periodic = std::get_if<ConstraintConfig::Periodic>(&c.kind);
    const auto* equation = std::get_if<ConstraintConfig::Equation>(&c.kind);
    if (equation == nullptr) add(c.part);
    if (equation != nullptr) std::ranges::for_each(equation->terms, add, &EquationTermConfig::part);
    if (periodic != nullptr) add(periodic->partner);
    const auto* tied = std::get_if<ConstraintConfig::Tied>(&c.kind);
    if (tied != nullptr) add(tied->partner);
    // Ties relate parts to one another alone, and a rigid part without a given translation is free.
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&c.kind);
    const auto is_given = [](const std::optional<Expression>& component) { return component.has_value(); };
    const bool is_free = rigid != nullptr && std::ranges::none_of(rigid->translation, is_given);
    if (periodic == nullptr && tied == nullptr && !is_free) held.insert(held.end(), nodes.begin(), nodes.end());
    if (equation != nullptr || periodic != nullptr || tied != nullptr || rigid != nullptr) {
      links.push_back(std::move(nodes));
    }
  }
  for (const BodyConfig& body : config.bodies) {
    auto surfaces = surfaces_held_by(body);
    if (body.is_rigid) std::ranges::move(sections_held_by(config, body.part.name), std::back_inserter(surfaces));
    if (surfaces.empty()) continue;
    std::vector<PetscInt> nodes = selections.nodes(body.part);
    for (const Selection& surface : surfaces) std::ranges::copy(selections.nodes(surface), std::back_inserter(nodes));
    links.push_back(std::move(nodes));
  }
  for (const auto& nodes : links) join(components_, layout_, nodes);
  components_.is_left_out = cells_without_mesh(config, body_of_cell_);
  if (const auto found = check_support(config, layout_, components_, held, selections)) include({*found});
  if (constraints_->map() != nullptr) return;  // which may hold a body, too
  const auto& prescribed = constraints_->prescribed();
  if (const auto found = note_about_free_rotation(config, layout_, components_, prescribed.flags())) include({*found});
}

void Model::check_overlap(const Config& config) {
  const std::vector<double> u = initial_displacement(config.initial.displacement, layout_);
  constexpr std::size_t most_nodes = 20000;
  std::vector<char> are_skipped;
  for (std::size_t k = 0; k < are_kept_apart_.size(); ++k) are_skipped.push_back(is_without_surface(k) ? 1 : 0);
  auto overlap = deepest_overlap(layout_, components_, u, most_nodes, are_skipped);
  if (overlap && contacts_ && contacts_->between_bodies() != nullptr) {
    contacts_->between_bodies()->check_overlaps(u);
    // The surfaces of what is kept apart do not meet: only their edges do, taken as straight.
    overlap = deepest_overlap(layout_, components_, u, most_nodes, are_kept_apart_);
  }
  overlaps_at_start_ = overlap.has_value();
  if (!overlap) return;
  warn(config.mesh.file.where, describe(*overlap, contacts_ ? contacts_->between_bodies() : nullptr));
}

std::vector<const EnergyTerm*> Model::active_terms(const Config& config) const {
  const bool has_velocity = analysis_of(config) != Analysis::static_equilibrium;
  std::vector<const EnergyTerm*> terms;
  // Results take volume ratios from the last stress that counts as elastic, which must be that of the law.
  for (const auto& term : softening_) terms.push_back(term.get());
  for (const auto& term : elastic_) terms.push_back(term.get());
  for (const auto& term : active_) terms.push_back(term.get());
  for (const auto& term : viscous_) terms.push_back(term.get());
  for (const auto& term : joint_efforts_.terms) terms.push_back(term.get());
  for (const ModelTendon& tendon : tendons_) {
    terms.push_back(tendon.term.get());
    if (tendon.friction && has_velocity) terms.push_back(tendon.friction.get());
  }
  for (const auto& term : springs_.terms) terms.push_back(term.get());
  for (const EnergyTerm* term : rods_.terms(has_velocity)) terms.push_back(term);
  for (const EnergyTerm* term : shells_.terms(has_velocity)) terms.push_back(term);
  for (const ModelCoupling& coupling : couplings_) terms.push_back(coupling.term.get());
  for (const LocatedTerm& load : loads_->terms()) terms.push_back(load.term.get());
  if (contacts_) {
    for (const auto& term : contacts_->terms()) terms.push_back(term.get());
  }
  for (const auto& term : additional_) terms.push_back(term.get());
  if (analysis_of(config) == Analysis::dynamic && inertia_) terms.push_back(inertia_.get());
  return terms;
}

void Model::make_equation(const Config& config) {
  viscous_ = viscous_terms(config);
  joint_efforts_ = make_joint_efforts(config, layout_, body_of_cell_, constraints_->joints());
  potential_ = std::make_unique<IncrementalPotential>(layout_, *pattern_, active_terms(config),
                                                      constraints_->prescribed().flags());
  if (!pressures_) return;
  check(VecSet(pressures_->values(), 0.0));
  update_ghosts(pressures_->values());
  mixed_equation_ =
      std::make_unique<MixedEquation>(*potential_, layout_, mixed_, *pressures_, constraints_->rigid_parts());
  if (constraints_->map() == nullptr && !mixed_equation_->determines_pressures()) reject_undetermined_pressures(config);
}

std::vector<std::unique_ptr<EnergyTerm>> Model::viscous_terms(const Config& config) const {
  return make_viscous_terms(config, {layout_, *pattern_, cells_, laws_, expansions_});
}

StageEquation& Model::equation() {
  StageEquation& of_nodes = mixed_equation_ ? static_cast<StageEquation&>(*mixed_equation_) : *potential_;
  ConstraintMap* const map = constraints_->map();
  if (map == nullptr) return of_nodes;
  if (!constrained_equation_) constrained_equation_ = std::make_unique<ConstrainedEquation>(of_nodes, *map);
  return *constrained_equation_;
}

PrescribedMotion Model::motion(Correction correction) const {
  PrescribedMotion motion = constraints_->motion(correction);
  if (!inertia_ || analysis_of(config_) != Analysis::dynamic) return motion;
  const Method* const method = integrator_of(config_);
  // What velocities miss of the joints changes its sign from one midpoint rule to the next, if these are equally long.
  const bool keeps_energy = method != nullptr && method->symplectic &&
                            std::ranges::all_of(method->b, [&](double weight) { return weight == method->b.front(); });
  return with_projected_velocities(std::move(motion),
                                   {layout_, *inertia_, constraints_->prescribed().flags(), constraints_->map()},
                                   keeps_energy ? EndVelocities::of_method : EndVelocities::projected);
}

void Model::require_finite(double time) const {
  loads_->require_finite(time);
  constraints_->require_finite(time);
  require_positive_stretches(config_, layout_.comm, expansions_, time);
  require_possible_contractions(config_, layout_.comm, activations_, time);
  require_finite_formulas(config_, time);
}

void Model::set_initial_state(const Config& config, Vec q, Vec v) const {
  put_initial_state(config, layout_, body_of_cell_, q, v);
  if (rods_.term) rods_.term->turn_frames(q);
  for (const auto& [what, vec] : {std::pair{"displacement", q}, {"velocity", v}})
    require_finite_initial(config, layout_, what, vec);
  const Step before_start{0.0, config.time.step};
  Handle<Vec> wanted;
  check(VecDuplicate(v, wanted.out()));
  check(VecCopy(v, wanted.get()));
  constraints_->motion().complete_step(before_start, q, v);
  check(VecCopy(wanted.get(), v));
  motion().restart(before_start, q, v);
  if (is_incompressible_) {
    require_undeformed(config, q, mesh_report_.bounds);
  } else if (mixed_equation_) {
    mixed_equation_->settle(q, instant_of_start());
  }
  update_ghosts(q);
  const ConstGhostedView at(q);
  double energy = 0.0;
  for (const auto& term : elastic_) energy += term->energy_at(instant_of_start(), at.span(), {});
  if (!std::isfinite(sum(layout_.comm, energy))) {
    throw InputError({config.file, 0, 0},
                     "the initial displacement, or a prescribed one at t = 0, inverts tetrahedra; start from "
                     "a smaller one");
  }
  if (contacts_) contacts_->check_start(instant_of_start(), at.span());
}

void Model::check_contact_at_start(Vec q) const {
  if (!contacts_) return;
  update_ghosts(q);
  const ConstGhostedView at(q);
  contacts_->check_start(instant_of_start(), at.span());
}

}  // namespace pliant
