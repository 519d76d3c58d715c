/// The error of the mesh: what a smoother displacement gradient, recovered around each vertex, says about that of the
/// elements (fem/patch_recovery.hpp, energy/volume/recovery_error.hpp).
#pragma once

#include "fem/patch_recovery.hpp"
#include "model/model.hpp"
#include "run/ledger.hpp"
#include "run/simulation.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The error of a state, over all ranks.
struct MeshError {
  double energy = 0.0;            ///< of the error [J]
  double share = 0.0;             ///< of the elastic energy and that of the error together [1]
  double elastic = 0.0;           ///< [J]
  std::array<double, 3> place{};  ///< centroid of the cell with the largest density of it [m]
};

class DiscretizationError {
 public:
  /// `model` outlives the object. Collective.
  explicit DiscretizationError(Model& model);

  /// The error at the end of a step, kept until `forget`. Collective.
  const MeshError& at(const StepRecord& record);
  void forget() { step_.reset(); }
  /// The energy of the error per reference volume, of each local cell [J/m^3]; after `at`.
  const std::vector<double>& densities() const { return densities_; }

 private:
  void find_groups();
  /// Sets the densities, and the rank's energy of the error.
  void recover(const Instant& at, std::span<const double> u);

  Model& model_;
  PatchRecovery recovery_;
  std::vector<std::vector<char>> groups_;  // flags of bodies: those of a group share no node
  double negligible_ = 0.0;                // energy below which strains are rounding errors [J]
  std::optional<std::int64_t> step_;
  MeshError error_;
  std::vector<double> densities_;
};

/// Keeps the error of the step at which the elastic energy was largest.
class MeshErrorWatch {
 public:
  /// A larger share of the energy than this is worth a warning [1].
  static constexpr double tolerance = 0.1;

  void look(const MeshError& error, double time);
  const MeshError& worst() const { return worst_; }
  double time() const { return time_; }  ///< of `worst` [s]
  void keep(Archive& archive);

 private:
  MeshError worst_;
  double time_ = 0.0;
};

/// Does the input ask for the error, as a field of the result or in the history?
bool asks_for_mesh_error(const Config& config);

/// A line of the log; `when`: "t = 1 s".
std::string in_words(const MeshErrorWatch& watch, std::string_view when);
/// A note about linear elements that are far too coarse at the end of a run that does not ask for the error: one
/// estimate, which costs about as much as a few evaluations of the forces. Nothing for quadratic elements, or where
/// little of the energy is elastic then: what is left of larger deformations says nothing of these. Collective.
std::optional<Diagnostic> note_about_linear_elements(Model& model, const Config& config, const StepRecord& record,
                                                     const Energies& energies);

/// A warning of a mesh that is too coarse.
std::optional<Diagnostic> warning_about(const MeshErrorWatch& watch, const Config& config);

}  // namespace pliant
