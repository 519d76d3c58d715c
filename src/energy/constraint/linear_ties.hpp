/// Linear ties (multi-point constraints, MPC) after their elimination: slaves that follow from other entries.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "fem/layout.hpp"
#include "petsc/array_view.hpp"
#include "time/stage.hpp"

#include <array>
#include <functional>
#include <vector>

namespace pliant {

/// How a vector is changed so that it fulfils the ties.
enum class Correction {
  nearest,   ///< the least change of all entries: for methods that act on configurations
  of_slaves  ///< slaves follow their masters: for methods that act on the unknowns alone
};

/// q_s = sum_m C_sm q_m + g_s(t) for the slaves s, or G q = g with G = I - C in the rows of slaves. Masters may be on
/// other ranks. Vectors have the layout of q. All methods are collective unless they say otherwise.
class LinearTies {
 public:
  /// `slaves`: those of all ranks. `given`: the displacements that their given terms refer to.
  LinearTies(const NodeLayout& layout, std::span<const Slave> slaves, std::vector<GivenDisplacement> given);

  /// Begins a stage, to which all following calls of `set_prescribed_fraction` and `put_slaves` refer; q: a guess of
  /// its end.
  void begin_stage(const StagePoint& stage, Vec q);
  /// Sets g to its value at a fraction of the way from the accepted state (0) to the end of the stage (1), which is
  /// where begin_stage leaves it.
  void set_prescribed_fraction(double fraction);
  /// The entries of slaves in q follow from the others in y.
  void put_slaves(Vec y, Vec q) const;

  /// Corrects the start of the stage, and the guess q of its end: where g depends on time, its own velocity and
  /// acceleration hold exactly, as for prescribed displacements (energy/constraint/prescribed.hpp). The remaining error
  /// of a method's formulas is corrected by the least change of all entries (Correction::nearest): the formulas then
  /// act on the coordinates along the ties, which keeps their order, and the choice of slaves makes no difference.
  void start_stage(const StagePoint& stage, Vec q, Correction correction) const;
  /// Corrects displacements and velocities at the end of a step.
  void complete_step(const Step& step, Vec q, Vec v, Correction correction) const;
  /// Corrects velocities, with those of g just after the time.
  void restart(const Step& step, Vec v) const;

  /// Rounding errors of ties: x = in the entry of each slave the sum of |C_sm q_m| over its masters, which bounds its
  /// error by cancellation, times the fraction of an error of its force that reaches them by C^T; 0 in all other
  /// entries.
  void weigh_slaves(Vec q, Vec x) const;

  /// Reactions of the given displacements, by source and component: the work of the ties per unit of given displacement
  /// [N]. `reaction`: the gradient of the potential. This rank's part. Not collective.
  std::vector<std::array<double, 3>> multipliers(Vec reaction) const;
  /// visit(term, f): f, a force [N] in the direction of a given displacement at its place, for each owned slave that
  /// refers to one. Not collective.
  template <class Visit>
  void for_each_given(Vec reaction, const Visit& visit) const {
    const ConstArrayView r(reaction);
    for (const auto& slave : slaves_) {
      for (const GivenTerm& term : slave.given) visit(term, term.weight * r[slave.local_entry]);
    }
  }

 private:
  using Offsets = std::function<double(std::size_t slave)>;
  /// g and its rates per owned slave.
  std::vector<Kinematics> offsets(double time, double time_scale, double factor, Side side = Side::before) const;
  /// Those of a stage.
  std::vector<Kinematics> offsets(const StagePoint& stage) const;
  void correct(Vec x, const Offsets& offset, Correction correction) const;
  /// x = C x + offset in the entries of slaves, by the least change of all entries.
  void put_nearest(Vec x, const Offsets& offset) const;
  /// x = C x + offset in the entries of slaves, by these alone.
  void follow(Vec x, const Offsets& offset) const;
  /// y = G x in the entries of slaves, zero elsewhere.
  void constrain(Vec x, Vec y) const;
  /// x += G^T m, m in the entries of slaves, and zero elsewhere.
  void add_constraint_forces(Vec m, Vec x) const;

  struct OwnedSlave {
    PetscInt local_entry;
    std::vector<GivenTerm> given;
  };
  bool is_empty_;  // on every rank
  std::vector<GivenDisplacement> given_;
  std::vector<OwnedSlave> slaves_;
  Handle<Mat> C_, sizes_;                           // the rows of slaves; their absolute values
  Handle<Vec> offset_, start_offset_, end_offset_;  // g: prescribed values; at the accepted state; at the stage's time
  Handle<Vec> work_;
  // put_nearest: the violation, the forces that correct it, the search direction and its image.
  Handle<Vec> missing_, forces_, direction_, image_;
  Handle<Vec> inverse_diagonal_;  // of G G^T; 0 except for slaves
};

}  // namespace pliant
