/// Prescribed displacements: which entries of the configuration are given, and their motion in time.
#pragma once

#include "base/expression.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace pliant {

/// Owned nodes that share a prescription; a component without a formula is free.
struct PrescribedPart {
  std::vector<PetscInt> nodes;
  std::array<std::optional<Expression>, 3> displacement;  ///< [m]
};

class PrescribedDisplacement {
 public:
  /// Where parts overlap, the first one counts. `time_scale`: over which the formulas are smooth, e.g. the step [s].
  /// Collective.
  PrescribedDisplacement(const NodeLayout& layout, std::vector<PrescribedPart> parts, double time_scale);

  /// One flag per local entry, ghosts included.
  const std::vector<char>& flags() const { return flags_; }

  /// Pairs of parts (i < j) that prescribe different displacements to a node of this rank at one of the times.
  std::vector<std::pair<std::size_t, std::size_t>> conflicts(const NodeLayout& layout,
                                                             const std::vector<double>& times) const;

  /// The hooks of the time layer; they refer to this object. The velocity and acceleration of a formula are one-sided
  /// differences of sixth and fifth order over at most `time_scale`, in a stage at most the stage's length, before t
  /// (at t = 0: after it), so that a formula with kinks at step boundaries is not differentiated across one. (Only a
  /// stage longer than the part of the step that has passed, the second of dirk23, still sees the step before.)
  PrescribedMotion motion() const;

  /// Displacement, velocity and acceleration of a formula at a place and time.
  struct Kinematics {
    double u = 0.0, v = 0.0, a = 0.0;
  };
  static Kinematics kinematics(const Expression& formula, const std::array<double, 3>& X, double time,
                               double time_scale);

 private:
  struct Entry {
    PetscInt dof;
    std::size_t part;
    std::array<double, 3> X;
  };
  /// Calls `set(dof, kinematics)` for each prescribed entry, with rates from differences over `time_scale`.
  template <class Set>
  void for_each(double time, double time_scale, Set set) const;

  std::vector<PrescribedPart> parts_;
  std::vector<Entry> entries_;
  std::vector<char> flags_;
  double time_scale_;
};

}  // namespace pliant
