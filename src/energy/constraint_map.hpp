/// The configuration as a function of the unknowns that linear constraints leave.
#pragma once

#include "energy/linear_constraint.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <array>
#include <vector>

namespace pliant {

/// q = C y + g(t), y with the layout of q: rows of slaves hold their masters' coefficients, all other rows are those of
/// the identity; entries of slaves in y have no meaning. Masters may lie on other ranks. All methods but those that say
/// otherwise are collective.
class ConstraintMap {
 public:
  /// `slaves`: those of all ranks. `given`: what their given terms refer to.
  ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves, std::vector<GivenDisplacement> given);

  /// The time that `expand` speaks of; `factor`: the part of what is given that a load step has reached.
  void set_time(double time, double factor);
  /// q = C y + g.
  void expand(Vec y, Vec q) const;
  /// C, with places for the diagonal entries of slaves, which are zero.
  Mat matrix() const { return C_.get(); }

  /// One flag per owned entry: a slave. Not collective.
  const std::vector<char>& is_slave() const { return is_slave_; }
  /// One flag per owned entry: a slave or a master, where constraints do work. Not collective.
  const std::vector<char>& is_tied() const { return is_tied_; }

  /// `before`, then the motion of the slaves: where g depends on time, its own velocity and acceleration are theirs, as
  /// for prescribed displacements (energy/prescribed.hpp). Refers to this object. Not collective.
  PrescribedMotion motion(PrescribedMotion before) const;

  /// What holds the given displacements, per source and component: the work of the constraints per given displacement
  /// [N]. `reaction`: the gradient of the potential. This rank's part. Not collective.
  std::vector<std::array<double, 3>> multipliers(Vec reaction) const;

 private:
  struct OwnedSlave {
    PetscInt local_entry;
    std::vector<GivenTerm> given;
  };
  /// g of each slave.
  std::vector<Kinematics> offsets(double time, double time_scale, double factor) const;
  /// x = C x + offset(slave) in the entries of slaves.
  template <class Offset>
  void put_slaves(Vec x, Offset offset) const;

  std::vector<GivenDisplacement> given_;
  std::vector<OwnedSlave> slaves_;
  std::vector<char> is_slave_, is_tied_;
  Handle<Mat> C_;
  Handle<Vec> offset_, work_;  // g at the time set
};

}  // namespace pliant
