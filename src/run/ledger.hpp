/// The energy ledger (energy balance): the energies of the bodies, the energy supplied, and the energy lost, by cause.
///
/// Every term's forces do work along the motion, and so do the supports. The works are quadratures of the time
/// integration method itself: dw/dt = f . v, integrated with the weights that integrate q and v. Then, to the accuracy
/// of Newton's method,
///
///     w_kinetic + w_stored + w_potential + dissipated - load_work = 0
///
/// for every method and step, because the forces balance in every stage. The change of the state's energies differs
/// from the works that should have caused it; the difference is the energy that the method dissipated (or created).
///
/// Without inertia the works are integrated by the trapezoidal rule between equilibria. The first state need not be an
/// equilibrium: the work of its unbalanced forces up to the first equilibrium, which would become kinetic energy,
/// counts as dissipated by the method.
#pragma once

#include "model/model.hpp"
#include "petsc/work_vector.hpp"
#include "time/stepper.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Totals over all ranks. Loads that do not depend on time count with their potential. Other loads count with their
/// work, as do all loads of a static analysis, which grow from step to step, and the shortening of active fibres.
/// Kinetic energy and momenta belong to inertia and are zero without it (static, quasistatic).
struct Energies {
  double kinetic = 0.0;                     ///< [J]
  double elastic = 0.0;                     ///< stored in the material, including springs of viscous branches [J]
  double load_potential = 0.0;              ///< -int f . u of the constant dead loads [J]
  double dissipated = 0.0;                  ///< by physical mechanisms, since the start [J]
  std::vector<double> dissipated_by;        ///< by each of Ledger::mechanisms() [J]
  std::vector<double> dissipated_by_state;  ///< EnergyTerm::dissipated of the state, likewise [J]
  double load_work = 0.0;                   ///< of other loads and of prescribed motion, since the start [J]
  double support_work = 0.0;                ///< the part of it due to prescribed motion [J]
  double numerical_dissipation = 0.0;       ///< by the method, since the start; negative if it created energy [J]
  /// kinetic + elastic + load_potential + dissipated + numerical_dissipation - load_work - initial [J]: as small as
  /// Newton's tolerance allows.
  double balance_error = 0.0;
  Momenta momenta;
};

/// Force and impulse of one of the model's ContactGroups on the bodies.
struct ContactForce {
  std::array<double, 3> force{};    ///< at the end of the last stage [N]; zero before the first step
  std::array<double, 3> impulse{};  ///< since the start, integrated like momentum [N s]; zero without inertia
};

/// Keeps the books from step to step. All methods are collective.
class Ledger {
 public:
  /// Starts with the initial state. `model` outlives the ledger.
  Ledger(Model& model, Analysis analysis, const StateView& initial);

  /// Names of the terms that dissipate, each once.
  const std::vector<std::string>& mechanisms() const { return mechanisms_; }

  /// The works, for the integrator; they refer to this object.
  Quadratures quadratures();
  /// The works so far.
  std::span<const double> works() const { return works_; }

  /// Books a completed step; to be called before it is accepted into the history, while `attempt` is valid. If the
  /// integrator has not integrated the works, they are integrated by the trapezoidal or the midpoint rule.
  void book(const StepAttempt& attempt);
  /// Energy that a method has created in a step, and the energy available.
  struct Gain {
    double created = 0.0;    ///< minus the numerical dissipation [J]
    double available = 0.0;  ///< kinetic and elastic energy at the step's start, and the energy supplied since [J]
  };
  /// The gain of a completed step that is not booked yet; zero if the integrator has not integrated the works.
  Gain gain(const StepAttempt& attempt);
  /// Books a jump of the velocity from that of the last booked state to that of `after`, where impulses of the
  /// constraints have done work, and of energies that depend on time, to which loads have.
  void book_jump(const StateView& after);

  /// Books a change of the loads at the last booked state, to be called after it: what the energies gain by it is
  /// supplied from outside. Returns by how much the works change.
  std::vector<double> book_change(const StateView& state);

  /// `newest`: the last completed step, at its end or after what jumps there.
  void keep(Archive& archive, const StateView& newest, Side side);

  const Energies& energies() const { return energies_; }
  /// The part of the numerical dissipation that is the work of unbalanced forces up to the first equilibrium [J].
  double lost_at_start() const { return released_; }
  /// Reactions of the model's supports at the end of the last stage; zero before the first step.
  const std::vector<Reaction>& reactions() const { return reactions_; }
  const std::vector<JointReaction>& joint_reactions() const { return joint_reactions_; }
  /// The gradient of the potential with the reactions on prescribed entries, at the end of the last stage [N].
  Vec reaction() const { return reaction_.get(); }
  /// In the order of Contacts::groups.
  const std::vector<ContactForce>& contacts() const { return contacts_; }

 private:
  /// The works; the dissipation of each mechanism follows them, then the impulse of each contact.
  enum Work : std::size_t { kinetic, stored, potential, loads, supports, ideal_constraints, num_works };
  using Works = std::vector<double>;

  /// The powers at the end of a stage; leaves its reactions in `reaction_`.
  Works powers(const StagePoint& stage, Vec q, Vec v);
  Works no_works() const { return Works(first_impulse() + 3 * contacts_.size(), 0.0); }
  std::size_t first_impulse() const { return num_works + mechanisms_.size(); }
  Account account_of(const EnergyTerm& term) const;
  /// The terms by what is known of their works without inertia.
  enum Share : std::size_t { body_forces, loads_with_energy, other_loads, num_shares };
  static std::optional<Share> share_of(const TermDeclaration& is);
  void add_works_in_time(const StepAttempt& attempt);
  void add_works_along_displacement(const StepAttempt& attempt);
  void keep_forces(const StagePoint& stage, Vec q);
  /// What the energies of terms that depend on time gain at the last state, with its pressures [J].
  double supplied_at_last_state(const Instant& start, const Instant& end);
  /// The work of obstacles that move in a step to `attempt`, by the trapezoidal rule of their powers: a state of one of
  /// its ends may lie beyond an obstacle at its other end [J].
  double work_of_obstacles(const StepAttempt& attempt);
  /// The works of loads in a step to `attempt` that follow from their energies, however far the bodies move: of each
  /// load the mean of what it does at either end of the step [J].
  Works works_of_load_energies(const StepAttempt& attempt);
  void keep_pressures();
  /// By the forces kept; those of all loads with an energy count as work of `potential`.
  Works works_along(Vec displacement) const;
  /// Sets the works of `supports` and `ideal_constraints`.
  void set_works_of_constraints(Vec displacement, Works& works) const;
  /// The energies of a state: at the end of a step, or at the start of what follows, where formulas of time jump.
  void measure(const StateView& state, Side side = Side::before);
  /// Computes the quantities that follow from the works and the energies of the state.
  void balance();

  Model& model_;
  Analysis analysis_;
  std::vector<std::string> mechanisms_;
  std::vector<std::size_t> mechanism_of_term_;  // of terms that dissipate
  bool dissipates_by_state_ = false;            // TermDeclaration::dissipates_by_state of any term
  Energies energies_;
  Energies initial_;
  Works works_;        // since the start
  Works last_powers_;  // at the last step, for trapezoids
  bool powers_are_known_ = false;
  double released_ = 0.0;                // without inertia: by forces unbalanced at the start [J]
  double time_ = 0.0;                    // of the last step
  double load_factor_ = 1.0;             // likewise
  std::vector<Constraints::Hold> held_;  // of owned entries
  std::vector<Reaction> reactions_;
  std::vector<JointReaction> joint_reactions_;
  std::vector<ContactForce> contacts_;
  std::vector<std::vector<std::size_t>> contacts_of_term_;
  Handle<Vec> q_;          // of the last step
  Handle<Vec> pressures_;  // likewise; without inertia, if there are any
  double supply_without_energy_ =
      0.0;  // by terms without an energy, at the last `powers` [W]: friction at moving obstacles
  WorkVector at_, direction_;
  Handle<Vec> reaction_;
  std::array<Handle<Vec>, num_shares> forces_;  // without inertia: of each share at the last step
};

}  // namespace pliant
