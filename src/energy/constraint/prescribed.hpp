/// Prescribed displacements (Dirichlet boundary conditions): which entries of the configuration they fix, and their
/// motion in time.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "energy/given_motion.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <map>
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

  /// The path of a prescribed entry from one displacement to another, and its rest there. It is given at steps only, by
  /// another solver for instance, so that its rates are those that the method's formula finds, as for free entries: two
  /// bodies that share nodes then have the same motion, and together the equations of one body.
  struct Path {
    double from = 0.0, to = 0.0;    ///< [m]
    double start = 0.0, end = 0.0;  ///< linear in between [s]; without a duration, `to` is reached at once
    double at(double time) const;
  };
  /// From now on an owned entry follows the path instead of its formula; one that is not prescribed stays free.
  void follow(PetscInt dof, const Path& path);
  /// All paths by owned entry, to be kept and restored.
  const std::map<PetscInt, Path>& paths() const { return paths_; }
  void set_paths(std::map<PetscInt, Path> paths) { paths_ = std::move(paths); }

  /// Hooks for the time layer; they refer to this object. Rates are one-sided, from the side of t on which the stage or
  /// the step lies, so that a kink at the step's start has no effect.
  PrescribedMotion motion() const;

 private:
  struct Entry {
    PetscInt dof;
    std::size_t part;
    std::array<double, 3> X;
  };
  /// Calls `set(dof, kinematics)` for each prescribed entry without a path, with one-sided rates from differences over
  /// `time_scale`; `factor`: the fraction of the motion that a load step has reached.
  template <class Set>
  void for_each(double time, double time_scale, double factor, Side side, Set set) const;

  std::vector<PrescribedPart> parts_;
  std::vector<Entry> entries_;
  std::map<PetscInt, Path> paths_;  // of entries that a program moves
  std::vector<char> flags_;
  double time_scale_;
};

}  // namespace pliant
