/// The energy ledger: where the energy of the bodies is, what came in, and what the method lost.
#pragma once

#include "app/model.hpp"
#include "time/stepper.hpp"

namespace pliant {

/// Totals over all ranks. Loads that do not depend on time count with their potential, the others with the work they
/// did; so do all loads of a static analysis, which grow from step to step. Kinetic energy and momenta are those of
/// inertia: without it (static, quasistatic) they are zero.
struct Energies {
  double kinetic = 0.0;         ///< [J]
  double elastic = 0.0;         ///< [J]
  double load_potential = 0.0;  ///< -int f . u of the constant dead loads [J]
  double dissipated = 0.0;      ///< by physical mechanisms, since the start [J]
  double load_work = 0.0;       ///< of time-dependent loads and of prescribed motion, since the start [J]
  double balance_error = 0.0;   ///< kinetic + elastic + load_potential + dissipated - load_work - initial [J]: minus
                                ///< what the method dissipated numerically
  Momenta momenta;
};

/// Keeps the books from step to step. All methods are collective.
class Ledger {
 public:
  /// Opens with the initial state.
  Ledger(Model& model, Analysis analysis, Vec q, Vec v);

  /// Books a completed step; call before it is accepted into the history, while `attempt` is valid. The works are
  /// trapezoidal.
  void book(const StepAttempt& attempt);

  const Energies& energies() const { return energies_; }
  /// Force that holds each support of the model, on the bodies, at the end of the last stage [N]; zero before the first
  /// step.
  const std::vector<std::array<double, 3>>& reactions() const { return reactions_; }

 private:
  void measure(Vec q, Vec v);
  bool counts_by_work(const DeadLoad& load) const {
    return analysis_ == Analysis::static_equilibrium || load.depends_on_time();
  }

  Model& model_;
  Analysis analysis_;
  Energies energies_;
  double initial_ = 0.0;
  bool reaction_is_known_ = false;  // that at the last step
  std::vector<std::array<double, 3>> reactions_;
  Handle<Vec> q_, v_, reaction_, next_reaction_;
  std::vector<std::vector<double>> forces_;  // of the loads that count by their work, at the last step
};

}  // namespace pliant
