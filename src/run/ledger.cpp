#include "run/ledger.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace pliant {
namespace {

void sum_over_ranks(MPI_Comm comm, double* values, int count) {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, comm));
}

double sum_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

Ledger::Ledger(Model& model, Analysis analysis, const StateView& initial)
    : model_(model),
      analysis_(analysis),
      held_(model.constraints().held()),
      reactions_(model.constraints().supports().size()),
      at_([&model] { return make_vector(model.layout()); }),
      direction_([&model] { return make_vector(model.layout()); }) {
  for (const EnergyTerm* term : model.potential().terms()) {
    const auto known = std::ranges::find(mechanisms_, term->name());
    mechanism_of_term_.push_back(static_cast<std::size_t>(known - mechanisms_.begin()));
    if (term->declaration().dissipates && known == mechanisms_.end()) mechanisms_.emplace_back(term->name());
    if (term->declaration().dissipates_by_state) dissipates_by_state_ = true;
  }
  if (const Contacts* contacts = model.contacts()) contacts_.resize(contacts->groups().size());
  for (const EnergyTerm* term : model.potential().terms()) {
    auto& groups = contacts_of_term_.emplace_back();
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const auto& members = model.contacts()->groups()[c].terms;
      if (std::ranges::find(members, term) != members.end()) groups.push_back(c);
    }
  }
  works_ = last_powers_ = no_works();
  energies_.dissipated_by.resize(mechanisms_.size());
  energies_.dissipated_by_state.resize(mechanisms_.size());
  for (Handle<Vec>* x : {&q_, &reaction_}) *x = make_vector(model.layout());
  measure(initial);
  initial_ = energies_;
  time_ = initial.time;
  load_factor_ = initial.load_factor;
  check(VecCopy(initial.q, q_.get()));
  if (analysis == Analysis::dynamic) return;
  for (auto& f : forces_) f = make_vector(model.layout());
  // Static: no load acts yet. Quasistatic: the first state is at rest.
  const Handle<Vec> at_rest = make_vector(model.layout());
  StagePoint start{initial.time, 1e-12, initial.q, at_rest.get()};  // in which nothing relaxes
  start.load_factor = analysis == Analysis::static_equilibrium ? 0.0 : 1.0;
  start.z0 = start.accepted_z = initial.z;
  keep_forces(start, initial.q);
  if (MixedEquation* mixed = model.mixed_equation()) check(VecDuplicate(mixed->pressures(), pressures_.out()));
  keep_pressures();
}

void Ledger::keep_pressures() {
  if (pressures_) check(VecCopy(model_.mixed_equation()->pressures(), pressures_.get()));
}

double Ledger::supplied_at_last_state(const Instant& start, const Instant& end) {
  const auto exchange = [&] {
    if (!pressures_) return;
    Vec present = model_.mixed_equation()->pressures();
    check(VecSwap(present, pressures_.get()));
    update_ghosts(present);
  };
  exchange();
  const double supplied =
      model_.potential().accounts().supplied(start, end, q_.get(), EnergyAccounts::MovingObstacles::left_out);
  exchange();
  return supplied;
}

Ledger::Works Ledger::powers(const StagePoint& stage, Vec q, Vec v) {
  IncrementalPotential& potential_of_stage = model_.potential();
  potential_of_stage.begin_stage(stage);
  const auto of_term = potential_of_stage.accounts().powers(q, v, reaction_.get());
  Works power = no_works();
  supply_without_energy_ = 0.0;
  for (ContactForce& contact : contacts_) contact.force = {};
  for (std::size_t k = 0; k < of_term.size(); ++k) {
    const auto& [exerted, dissipated, supplied, force] = of_term[k];
    for (const std::size_t c : contacts_of_term_[k]) {
      for (std::size_t i = 0; i < 3; ++i) {
        contacts_[c].force[i] += force[i];
        power[first_impulse() + 3 * c + i] += force[i];
      }
    }
    if (potential_of_stage.terms()[k]->declaration().dissipates) power[num_works + mechanism_of_term_[k]] += dissipated;
    if (!potential_of_stage.terms()[k]->declaration().depends_on_time) supply_without_energy_ += supplied;
    switch (account_of(*potential_of_stage.terms()[k])) {
      case Account::kinetic:
        power[kinetic] -= exerted;
        break;
      case Account::stored:
        power[stored] += supplied - exerted - dissipated;
        power[loads] += supplied;
        break;
      case Account::load_potential:
        power[potential] -= exerted;
        break;
      case Account::load:
        power[loads] += exerted;
        break;
    }
  }
  set_works_of_constraints(v, power);
  return power;
}

Account Ledger::account_of(const EnergyTerm& term) const {
  const Account account = term.declaration().account;
  // Load steps change even loads that do not depend on time.
  const bool grows = analysis_ == Analysis::static_equilibrium && account == Account::load_potential;
  return grows ? Account::load : account;
}

Quadratures Ledger::quadratures() {
  return {[this](const StagePoint& stage, Vec q, Vec v, Vec /*a*/, std::span<double> rates) {
    const Works power = powers(stage, q, v);
    std::copy(power.begin(), power.end(), rates.begin());
  }};
}

void Ledger::book(const StepAttempt& attempt) {
  if (analysis_ != Analysis::dynamic) {
    add_works_along_displacement(attempt);
  } else if (attempt.w.empty()) {
    add_works_in_time(attempt);
  } else {
    std::copy(attempt.w.begin(), attempt.w.end(), works_.begin());
  }
  if (!reactions_.empty()) reactions_ = model_.constraints().reactions(reaction_.get(), attempt.last_q);
  joint_reactions_ = model_.constraints().joint_reactions(reaction_.get(), attempt.last_q);
  measure(attempt.view());
  time_ = attempt.time;
  load_factor_ = attempt.load_factor;
  check(VecCopy(attempt.q, q_.get()));
  keep_pressures();
  balance();
}

Ledger::Gain Ledger::gain(const StepAttempt& attempt) {
  if (analysis_ != Analysis::dynamic || attempt.w.empty()) return {};
  const Energies before = energies_;
  measure(attempt.view());
  const Energies after = std::exchange(energies_, before);
  const auto done = [&](Work w) { return attempt.w[w] - works_[w]; };
  const double fallen = before.load_potential - after.load_potential;
  const auto lost = [](const Energies& e) { return sum_of(e.dissipated_by_state); };
  const double change = after.kinetic - before.kinetic + after.elastic - before.elastic + lost(after) - lost(before);
  return {change - fallen - done(kinetic) - done(stored) - done(potential) + done(ideal_constraints),
          before.kinetic + before.elastic + std::max(0.0, fallen) + std::max(0.0, done(loads) + done(supports))};
}

void Ledger::book_jump(const StateView& after) {
  if (analysis_ != Analysis::dynamic) return;
  const Energies before = energies_;
  measure(after, Side::after);
  const double gained = energies_.kinetic - before.kinetic;
  works_[kinetic] += gained;
  works_[supports] += gained;
  for (const auto& [work, change] : {std::pair(stored, energies_.elastic - before.elastic),
                                     std::pair(potential, energies_.load_potential - before.load_potential)}) {
    works_[work] += change;
    works_[loads] += change;
  }
  balance();
}

std::vector<double> Ledger::book_change(const StateView& state) {
  const Energies before = energies_;
  measure(state, Side::after);
  Works change = no_works();
  change[stored] = energies_.elastic - before.elastic;
  change[potential] = energies_.load_potential - before.load_potential;
  change[loads] = change[stored] + change[potential];
  for (std::size_t w = 0; w < works_.size(); ++w) works_[w] += change[w];
  balance();
  return change;
}

void Ledger::keep(Archive& archive, const StateView& newest, Side side) {
  archive.numbers("works", works_);
  archive.numbers("last_powers", last_powers_);
  archive.number("powers_are_known", powers_are_known_);
  archive.number("initial_kinetic", initial_.kinetic);
  archive.number("initial_elastic", initial_.elastic);
  archive.number("initial_load_potential", initial_.load_potential);
  if (dissipates_by_state_) archive.numbers("initial_dissipated", initial_.dissipated_by_state);
  if (analysis_ != Analysis::dynamic) {
    archive.vector("reaction", Entries::nodes, reaction_.get());
    archive.number("released", released_);
    for (std::size_t k = 0; k < num_shares; ++k) {
      archive.vector("forces" + std::to_string(k), Entries::nodes, forces_[k].get());
    }
  }
  if (!archive.restores()) return;
  measure(newest, side);
  time_ = newest.time;
  load_factor_ = newest.load_factor;
  check(VecCopy(newest.q, q_.get()));
  keep_pressures();
  balance();
}

void Ledger::balance() {
  Energies& e = energies_;
  const auto mechanisms = std::span(works_).subspan(num_works, mechanisms_.size());
  e.dissipated_by.assign(mechanisms.begin(), mechanisms.end());
  for (std::size_t m = 0; m < mechanisms_.size(); ++m) {
    e.dissipated_by[m] += e.dissipated_by_state[m] - initial_.dissipated_by_state[m];
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    for (std::size_t i = 0; i < 3; ++i) contacts_[c].impulse[i] = works_[first_impulse() + 3 * c + i];
  }
  e.dissipated = sum_of(e.dissipated_by);
  const double dissipated_by_state = sum_of(e.dissipated_by_state) - sum_of(initial_.dissipated_by_state);
  e.support_work = works_[supports];
  e.load_work = works_[loads] + works_[supports];
  e.numerical_dissipation = (works_[kinetic] - (e.kinetic - initial_.kinetic)) +
                            (works_[stored] - dissipated_by_state - (e.elastic - initial_.elastic)) +
                            (works_[potential] - (e.load_potential - initial_.load_potential)) -
                            works_[ideal_constraints] + released_;
  e.balance_error = (e.kinetic - initial_.kinetic) + (e.elastic - initial_.elastic) +
                    (e.load_potential - initial_.load_potential) + e.dissipated + e.numerical_dissipation - e.load_work;
}

// The midpoint rule if the last equation solved lies within the step, otherwise the trapezoidal rule. The powers at the
// start of the first step are not known: they depend on the accelerations there.
void Ledger::add_works_in_time(const StepAttempt& attempt) {
  const double dt = attempt.time - time_;
  check(VecWAXPY(direction_.get(), -1.0, q_.get(), attempt.q));
  check(VecScale(direction_.get(), 1.0 / dt));
  const bool is_within = attempt.last_stage.time < attempt.time - 1e-6 * dt;
  const Works power = powers(attempt.last_stage, attempt.last_q, is_within ? direction_.get() : attempt.v);
  const bool takes_mean = !is_within && powers_are_known_;
  for (std::size_t w = 0; w < works_.size(); ++w) {
    works_[w] += dt * (takes_mean ? 0.5 * (last_powers_[w] + power[w]) : power[w]);
  }
  last_powers_ = power;
  powers_are_known_ = true;
}

// Works of the forces at both ends of the step along the displacement between them; other powers by the trapezoidal
// rule. Where points turn about one another, forces do another work along the chord than along the path. That of loads
// follows from their energies, and that of the bodies, whose error is the same, from equilibrium.
// The first state need not be in equilibrium, since loads may act at once. Without inertia, the work of the unbalanced
// forces up to the first equilibrium does not become kinetic energy; it is lost.
void Ledger::add_works_along_displacement(const StepAttempt& attempt) {
  check(VecWAXPY(direction_.get(), -1.0, q_.get(), attempt.q));
  const Works before = works_along(direction_.get());
  if (!powers_are_known_) {
    released_ =
        -0.5 * (before[stored] + before[potential] - before[loads] - before[supports] - before[ideal_constraints]);
  }
  Works power = powers(attempt.last_stage, attempt.last_q, attempt.v);
  power[loads] = supply_without_energy_;  // other supply is the change of energies, below
  keep_forces(attempt.last_stage, attempt.last_q);
  const Works after = works_along(direction_.get());
  Works done = works_of_load_energies(attempt);
  const auto along_chord = [&](Work w) { return 0.5 * (before[w] + after[w]); };
  done[stored] += done[loads] - done[potential] + along_chord(potential);
  for (const Work w : {stored, loads, supports, ideal_constraints}) done[w] += along_chord(w);
  for (std::size_t w = 0; w < num_works; ++w) works_[w] += done[w];
  const Instant start = model_.instant(time_, load_factor_), end = model_.instant(attempt.time, attempt.load_factor);
  EnergyAccounts accounts = model_.potential().accounts();
  const double supplied = 0.5 * (supplied_at_last_state(start, end) +
                                 accounts.supplied(start, end, attempt.q, EnergyAccounts::MovingObstacles::left_out)) +
                          work_of_obstacles(attempt);
  const double passed =
      analysis_ == Analysis::static_equilibrium ? attempt.load_factor - load_factor_ : attempt.time - time_;
  const auto integral = [&](std::size_t w) { return 0.5 * passed * (last_powers_[w] + power[w]); };
  works_[stored] += supplied + integral(loads);
  works_[loads] += supplied + integral(loads);
  for (std::size_t m = num_works; m < first_impulse(); ++m) {
    const double dissipated = integral(m);
    works_[stored] -= dissipated;
    works_[m] += dissipated;
  }
  // Time stands still in static analyses.
  for (std::size_t w = first_impulse(); w < works_.size() && analysis_ == Analysis::quasistatic; ++w) {
    works_[w] += integral(w);
  }
  last_powers_ = power;
  powers_are_known_ = true;
}

// Powers by one-sided differences of second order.
double Ledger::work_of_obstacles(const StepAttempt& attempt) {
  constexpr double part = 1e-4;  // of the step
  const auto instant = [&](double fraction) {
    return model_.instant(time_ + fraction * (attempt.time - time_),
                          load_factor_ + fraction * (attempt.load_factor - load_factor_));
  };
  EnergyAccounts accounts = model_.potential().accounts();
  const auto gained = [&](double from, double to, Vec q) {
    return accounts.supplied(instant(from), instant(to), q, EnergyAccounts::MovingObstacles::alone);
  };
  const double at_start = 4.0 * gained(0.0, part, q_.get()) - gained(0.0, 2.0 * part, q_.get());
  const double at_end = 4.0 * gained(1.0 - part, 1.0, attempt.q) - gained(1.0 - 2.0 * part, 1.0, attempt.q);
  return 0.5 * (at_start + at_end) / (2.0 * part);
}

Ledger::Works Ledger::works_of_load_energies(const StepAttempt& attempt) {
  const Instant start = model_.instant(time_, load_factor_), end = model_.instant(attempt.time, attempt.load_factor);
  EnergyAccounts accounts = model_.potential().accounts();
  const auto first = accounts.load_energies(start, end, q_.get()), last = accounts.load_energies(start, end, attempt.q);
  Works works = no_works();
  for (std::size_t k = 0; k < first.size(); ++k) {
    const double gained = 0.5 * (last[k] - first[k]);
    if (account_of(*model_.potential().terms()[k]) == Account::load_potential) {
      works[potential] += gained;
    } else {
      works[loads] -= gained;
    }
  }
  return works;
}

std::optional<Ledger::Share> Ledger::share_of(const TermDeclaration& is) {
  if (is.has_load_energy) return loads_with_energy;
  if (is.account == Account::stored) return body_forces;
  if (is.account == Account::load) return other_loads;
  return std::nullopt;
}

void Ledger::keep_forces(const StagePoint& stage, Vec q) {
  IncrementalPotential& potential_of_stage = model_.potential();
  potential_of_stage.begin_stage(stage);
  for (std::size_t k = 0; k < num_shares; ++k) {
    const auto is_booked_here = [&](const EnergyTerm& term) { return share_of(term.declaration()) == Share(k); };
    potential_of_stage.gradient_of(is_booked_here, q, forces_[k].get());
  }
  potential_of_stage.gradient_with_reactions(q, reaction_.get());
}

Ledger::Works Ledger::works_along(Vec displacement) const {
  const auto along = [&](Share share) {
    PetscScalar work = 0.0;
    check(VecDot(forces_[share].get(), displacement, &work));
    return work;
  };
  Works works = no_works();
  works[stored] = along(body_forces);
  works[potential] = along(loads_with_energy);
  works[loads] = -along(other_loads);
  set_works_of_constraints(displacement, works);
  return works;
}

void Ledger::set_works_of_constraints(Vec displacement, Works& works) const {
  double done[2] = {0.0, 0.0};
  {
    const ConstArrayView reaction(reaction_.get()), moved(displacement);
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (held_[i] == Constraints::Hold::none) continue;
      done[held_[i] == Constraints::Hold::ideal ? 1 : 0] += reaction.span()[i] * moved.span()[i];
    }
  }
  sum_over_ranks(model_.layout().comm, done, 2);
  works[supports] = done[0];
  works[ideal_constraints] = done[1];
}

void Ledger::measure(const StateView& state, Side side) {
  const IncrementalPotential& sum = model_.potential();
  energies_.elastic = energies_.load_potential = 0.0;
  const bool is_before = analysis_ == Analysis::dynamic && side == Side::before && state.time > 0.0;
  const double time = is_before ? std::nextafter(state.time, 0.0) : state.time;
  const auto energies =
      model_.potential().accounts().energies(model_.instant(time, state.load_factor), state.q, state.z);
  for (std::size_t k = 0; k < energies.size(); ++k) {
    const Account account = account_of(*sum.terms()[k]);
    if (account == Account::stored) energies_.elastic += energies[k];
    if (account == Account::load_potential) energies_.load_potential += energies[k];
  }
  if (dissipates_by_state_) {
    energies_.dissipated_by_state.assign(mechanisms_.size(), 0.0);
    const auto dissipated = model_.potential().accounts().dissipated(state.z);
    for (std::size_t k = 0; k < dissipated.size(); ++k) {
      if (sum.terms()[k]->declaration().dissipates) {
        energies_.dissipated_by_state[mechanism_of_term_[k]] += dissipated[k];
      }
    }
  }
  if (analysis_ != Analysis::dynamic || model_.inertia() == nullptr) return;
  check(VecCopy(state.q, at_.get()));
  check(VecCopy(state.v, direction_.get()));
  update_ghosts(at_.get());
  update_ghosts(direction_.get());
  const ConstGhostedView u(at_.get()), velocity(direction_.get());
  const Momenta m = model_.inertia()->momenta(model_.layout().coordinates, u.span(), velocity.span());
  std::array<double, 7> local{model_.inertia()->kinetic_energy(velocity.span())};
  std::copy(m.linear.begin(), m.linear.end(), local.begin() + 1);
  std::copy(m.angular.begin(), m.angular.end(), local.begin() + 4);
  sum_over_ranks(model_.layout().comm, local.data(), static_cast<int>(local.size()));
  energies_.kinetic = local[0];
  std::copy_n(local.begin() + 1, 3, energies_.momenta.linear.begin());
  std::copy_n(local.begin() + 4, 3, energies_.momenta.angular.begin());
}

}  // namespace pliant
