/// Prescribed displacements (Dirichlet boundary conditions): which entries of the configuration they fix, and their
/// motion in time.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "energy/given_motion.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <set>
#include <utility>
#include <vector>

namespace pliant {

/// Owned nodes that share a prescription.
struct PrescribedPart {
  std::vector<PetscInt> nodes;
  GivenDisplacement displacement;
};

class PrescribedDisplacement {
 public:
  /// Where parts overlap, the first one counts. `time_scale`: a time over which the formulas are smooth, e.g. the step
  /// [s]. Collective.
  PrescribedDisplacement(const NodeLayout& layout, std::vector<PrescribedPart> parts, double time_scale);

  /// One flag per local entry, ghosts included: whether it is prescribed.
  const std::vector<char>& flags() const { return flags_; }

  /// Pairs of parts (i < j) that prescribe different displacements to a node of this rank at one of the times.
  std::vector<std::pair<std::size_t, std::size_t>> conflicts(const NodeLayout& layout,
                                                             const std::vector<double>& times) const;

  /// The prescribed values of owned entries among the `wanted` (numbered over all ranks), as constraints whose source
  /// is the index of the part. Not collective.
  std::vector<LinearConstraint> constraints(const NodeLayout& layout, const std::set<PetscInt>& wanted) const;

  /// Hooks for the time layer; they refer to this object. Rates are one-sided, from the side of t on which the stage or
  /// the step lies, so that a kink at the step's start has no effect.
  PrescribedMotion motion() const;

 private:
  struct Entry {
    PetscInt dof;
    std::size_t part;
    std::array<double, 3> X;
  };
  /// Calls `set(dof, kinematics)` for each prescribed entry, with one-sided rates from differences over `time_scale`;
  /// `factor`: the fraction of the motion that a load step has reached.
  template <class Set>
  void for_each(double time, double time_scale, double factor, Side side, Set set) const;

  std::vector<PrescribedPart> parts_;
  std::vector<Entry> entries_;
  std::vector<char> flags_;
  double time_scale_;
};

}  // namespace pliant
