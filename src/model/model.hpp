/// Everything that the input describes, ready to be solved: unknowns, terms and their sum.
#pragma once

#include "energy/equation/constrained_equation.hpp"
#include "energy/equation/incremental_potential.hpp"
#include "energy/equation/mixed_equation.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/inertia.hpp"
#include "fem/components.hpp"
#include "fem/probe.hpp"
#include "input/analysis.hpp"
#include "mesh/mesh.hpp"
#include "model/constraints.hpp"
#include "model/contacts.hpp"
#include "model/couplings.hpp"
#include "model/field_regions.hpp"
#include "model/joint_efforts.hpp"
#include "model/loads.hpp"
#include "model/mesh_groups.hpp"
#include "model/rods.hpp"
#include "model/shells.hpp"
#include "model/springs.hpp"
#include "model/tendons.hpp"
#include "model/wave_speeds.hpp"

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

class Model;

/// Terms that a program adds to those of an input (docs/developer/extending.md). Called once, when the model is
/// complete except for the sum of the terms; the model outlives the terms. Collective.
using TermFactory = std::function<std::vector<std::unique_ptr<EnergyTerm>>(const Model&)>;

/// Built in one go from the input, for its method: the form of strain rates depends on that. The members refer to one
/// another, so it cannot be moved. The mesh itself is released once everything is found on it: it takes as much memory
/// as all terms. A static problem has no inertia.
class Model {
 public:
  /// Throws InputError with all errors that only the mesh reveals. Collective.
  Model(MPI_Comm comm, const Config& config, const TermFactory& additional = {});
  /// On a mesh that is there already, that of mesh_source (model/mesh_source.hpp).
  Model(const Mesh& mesh, const Config& config, const TermFactory& additional = {});
  /// Likewise, with the nodes that another model has numbered for the same mesh and elements.
  Model(const Mesh& mesh, const Config& config, const NodeLayout& numbered);
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const MeshReport& mesh_report() const { return mesh_report_; }
  const NodeLayout& layout() const { return layout_; }
  const BlockPattern& pattern() const { return *pattern_; }
  /// The packed cells of P1 or P2 elements, by body.
  const std::variant<CellGroups<1>, CellGroups<2>>& cells() const { return cells_; }
  const std::vector<int>& body_of_cell() const { return body_of_cell_; }
  const std::vector<std::string>& body_names() const { return body_names_; }
  const std::vector<std::unique_ptr<ElasticTerm>>& elastic() const { return elastic_; }
  const std::vector<int>& bodies_of_elastic() const { return bodies_of_elastic_; }  ///< the body of each
  const Inertia* inertia() const { return inertia_.get(); }  ///< nullptr if no body has a density
  const Constraints& constraints() const { return *constraints_; }
  Constraints& constraints() { return *constraints_; }
  /// The input's joints; those of constraints() have the same order.
  const std::vector<JointConfig>& given_joints() const { return config_.joints; }
  /// The laws of a joint, in the order of its columns.
  const std::vector<JointLaw>& laws_of_joint(std::size_t joint) const { return joint_efforts_.laws[joint]; }
  const std::vector<ModelTendon>& tendons() const { return tendons_; }
  const ModelSprings& springs() const { return springs_; }
  const ModelRods& rods() const { return rods_; }
  const Loads& loads() const { return *loads_; }
  const ModelShells& shells() const { return shells_; }
  const std::vector<ModelCavity>& cavities() const { return loads_->cavities(); }
  const Contacts* contacts() const { return contacts_.get(); }  ///< nullptr if the input has none
  IncrementalPotential& potential() { return *potential_; }
  /// The equation that a solver sees: that of the potential, in the unknowns that constraints leave free and, if there
  /// are any, pressures.
  StageEquation& equation();
  /// The equation with pressures as unknowns; nullptr if there are none.
  MixedEquation* mixed_equation() { return mixed_equation_.get(); }
  const std::vector<ProbeLocation>& probes() const { return probes_; }
  const std::vector<MeshGroup>& mesh_groups() const { return mesh_groups_; }
  /// The region of each entry of `output.history`.
  const std::vector<FieldRegion>& field_regions() const { return field_regions_; }
  /// The stiffest shear modulus of each body at rest [Pa].
  const std::vector<double>& shear_moduli() const { return shear_moduli_; }
  const WaveSpeeds& wave_speeds() const { return wave_speeds_; }
  /// Wall-clock time that the mesh took: reading or meshing, checks, partition, distribution [s].
  double mesh_seconds() const { return mesh_seconds_; }
  /// The fingerprint of the mesh as it is given (fem/entry_keys).
  std::uint64_t mesh_fingerprint() const { return fingerprint_; }
  /// Parts of the mesh that neither nodes nor constraints join.
  const Components& components() const { return components_; }
  /// Whether contact keeps two of them apart, for each two, by rows.
  const std::vector<char>& are_kept_apart() const { return are_kept_apart_; }
  bool overlaps_at_start() const { return overlaps_at_start_; }
  /// Notes, then warnings.
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

  /// Throws InputError at a load, a prescribed displacement, an expansion or a contraction that is not finite at the
  /// time [s]. Collective.
  void require_finite(double time) const;

  /// The terms of viscosity for the method of `config`, which has the bodies of the model. Not collective.
  std::vector<std::unique_ptr<EnergyTerm>> viscous_terms(const Config& config) const;

  /// What terms know about a time of the run; the load factor is that of a static problem, which has one time only.
  Instant instant(double time, double load_factor) const {
    return analysis_of(config_) == Analysis::static_equilibrium ? Instant{config_.time.end, load_factor}
                                                                : Instant{time, 1.0};
  }
  /// The same at the start.
  Instant instant_of_start() const { return instant(0.0, 0.0); }

  /// The hooks of the time layer; they refer to this object. Collective.
  PrescribedMotion motion(Correction correction = Correction::nearest) const;

  /// Initial displacement and velocity: those that constraints allow at t = 0 and that are nearest to the ones of the
  /// input, displacements by their squares, velocities in dynamics by kinetic energy. Collective.
  void set_initial_state(const Config& config, Vec q, Vec v) const;
  /// Throws InputError if bodies overlap one another, or obstacles with barriers, at the configuration q of the start:
  /// an OverlapError for bodies. Part of set_initial_state; for analyses that have no initial state. Collective.
  void check_contact_at_start(Vec q) const;

 private:
  void build(const Mesh& mesh, const TermFactory& additional);
  void build_terms(const Config& config, const Mesh& mesh);
  /// All terms that act under the method of the input.
  std::vector<const EnergyTerm*> active_terms(const Config& config) const;
  void make_equation(const Config& config);
  /// Parts of the mesh that neither nodes nor constraints join.
  void find_components(const Config& config, Selections& selections);
  /// `left_out`: per local cell, whether no probe is in it.
  void find_probes(const Config& config, const std::vector<char>& left_out);
  void check_overlap(const Config& config);
  /// Whether one of two components has no surface; `k`: as in are_kept_apart.
  bool is_without_surface(std::size_t k) const {
    const std::size_t count = are_without_surface_.size();
    return are_without_surface_[k / count] != 0 || are_without_surface_[k % count] != 0;
  }
  void check_method(const Config& config);
  void warn(const Location& where, std::string message) {
    diagnostics_.push_back({Severity::warning, where, std::move(message)});
  }
  void include(std::vector<Diagnostic> found);
  template <int Order>
  void build_cells(const Config& config, const Mesh& mesh);
  template <int Order>
  void build_inertia(const Config& config);

  Config config_;  // with all rigid bodies; others refer to it
  double mesh_seconds_ = 0.0;
  MeshReport mesh_report_;
  NodeLayout layout_;
  std::unique_ptr<BlockPattern> pattern_;
  std::vector<int> body_of_cell_;
  std::vector<std::string> body_names_;
  std::vector<double> densities_;
  std::vector<double> shear_moduli_;  // of each body's stiffest part at rest [Pa]
  std::variant<CellGroups<1>, CellGroups<2>> cells_;
  std::vector<std::shared_ptr<const LawField>> laws_;             // of each body: elastic, or its part without volume
  std::vector<std::shared_ptr<const FreeExpansion>> expansions_;  // of each body; nullptr: none
  std::vector<std::shared_ptr<const Activation>> activations_;    // of each body; nullptr: none
  std::vector<std::unique_ptr<ElasticTerm>> elastic_;
  std::vector<int> bodies_of_elastic_;
  std::vector<std::unique_ptr<EnergyTerm>> softening_;
  std::vector<std::unique_ptr<EnergyTerm>> active_;
  std::vector<std::unique_ptr<EnergyTerm>> viscous_;
  JointEfforts joint_efforts_;
  std::vector<ModelTendon> tendons_;
  ModelSprings springs_;
  ModelRods rods_;
  ModelShells shells_;
  std::vector<ModelCoupling> couplings_;
  std::unique_ptr<Loads> loads_;
  std::unique_ptr<Contacts> contacts_;
  std::vector<std::unique_ptr<EnergyTerm>> additional_;
  std::unique_ptr<Inertia> inertia_;
  std::unique_ptr<Constraints> constraints_;
  std::unique_ptr<IncrementalPotential> potential_;
  std::unique_ptr<PressureField> pressures_;
  std::vector<const MixedTerm*> mixed_;
  std::unique_ptr<MixedEquation> mixed_equation_;
  bool is_incompressible_ = false;  // any body
  std::unique_ptr<ConstrainedEquation> constrained_equation_;
  std::vector<ProbeLocation> probes_;
  std::vector<MeshGroup> mesh_groups_;
  std::vector<FieldRegion> field_regions_;
  Components components_;
  std::uint64_t fingerprint_ = 0;
  std::vector<char> are_kept_apart_;       // of each two
  std::vector<char> are_without_surface_;  // components that stand for bodies without a mesh
  bool overlaps_at_start_ = false;
  WaveSpeeds wave_speeds_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace pliant
