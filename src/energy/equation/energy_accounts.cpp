#include "energy/equation/energy_accounts.hpp"

#include "base/compensated_sum.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <numeric>

namespace pliant {

std::vector<TermPower> EnergyAccounts::powers(Vec q, Vec v, Vec r) {
  const auto at = terms_.at(q);
  std::vector<TermPower> result(terms_.size());
  check(VecZeroEntries(r));
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const auto rows = terms_.empty_rows();
    terms_[k].add_gradient(terms_.stage_of(k), at, rows);
    const ConstArrayView velocity(v);
    const ArrayView total(r);
    CompensatedSum<double> power;
    std::array<CompensatedSum<double>, 3> force;
    for (PetscInt i = 0; i < 3 * terms_.layout().num_owned_nodes; ++i) {
      power.add(-rows[i] * velocity[i]);
      if (terms_[k].is_measured_at(i / 3)) force[static_cast<std::size_t>(i % 3)].add(-rows[i]);
      total[i] += rows[i];
    }
    result[k] = {power.total(),
                 terms_[k].dissipation(terms_.stage_of(k), at),
                 terms_[k].supply(terms_.stage_of(k), at),
                 {force[0].total(), force[1].total(), force[2].total()}};
  }
  static_assert(sizeof(TermPower) == TermPower::num_numbers * sizeof(double));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, result.data(), static_cast<int>(TermPower::num_numbers * result.size()),
                          MPI_DOUBLE, MPI_SUM, terms_.layout().comm));
  return result;
}

std::vector<double> EnergyAccounts::sums_of_energies(const Wanted& wanted, std::initializer_list<Weighted> instants,
                                                     Vec q, Vec z) {
  std::vector<double> result(terms_.size(), 0.0);
  const auto is_wanted = [&](std::size_t k) { return wanted(terms_[k].declaration()); };
  if (std::ranges::none_of(terms_.all(), [&](const EnergyTerm* term) { return wanted(term->declaration()); })) {
    return result;
  }
  const auto at = terms_.at_without_stage(q);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (!is_wanted(k)) continue;
    for (auto [when, weight] : instants) {
      when.near = terms_.near(k);
      result[k] += weight * terms_[k].energy_at(when, at, terms_.internal_of(k, z));
    }
  }
  sum_in_place(terms_.layout().comm, result);
  for (const std::size_t k : terms_.functions_of_sum()) {
    if (!is_wanted(k)) continue;
    const FunctionOfSum& function = terms_.function_of_sum(k);
    for (const auto& [when, weight] : instants) result[k] += weight * function.energy_of_sum(when, terms_.sum_of(k));
  }
  return result;
}

std::vector<double> EnergyAccounts::energies(const Instant& when, Vec q, Vec z) {
  const auto has_account = [](const TermDeclaration& is) {
    return is.account == Account::stored || is.account == Account::load_potential;
  };
  return sums_of_energies(has_account, {{when}}, q, z);
}

std::vector<double> EnergyAccounts::dissipated(Vec z) const {
  std::vector<double> result(terms_.size(), 0.0);
  if (z == nullptr) return result;
  for (std::size_t k = 0; k < terms_.size(); ++k) result[k] = terms_[k].dissipated(terms_.internal_of(k, z));
  sum_in_place(terms_.layout().comm, result);
  return result;
}

double EnergyAccounts::supplied(const Instant& from, const Instant& to, Vec q, MovingObstacles which) {
  const auto is_concerned = [which](const TermDeclaration& is) {
    return is.depends_on_time && is.has_moving_obstacle == (which == MovingObstacles::alone);
  };
  const auto gained = sums_of_energies(is_concerned, {{to}, {from, -1.0}}, q);
  return std::accumulate(gained.begin(), gained.end(), 0.0);
}

std::vector<double> EnergyAccounts::load_energies(const Instant& one, const Instant& other, Vec q) {
  return sums_of_energies([](const TermDeclaration& is) { return is.has_load_energy; }, {{one}, {other}}, q);
}

BodyState EnergyAccounts::state_of(const EnergyTerm& term, const Instant& at, Vec q, Vec v, Vec z) {
  BodyState state{.at = at, .q = terms_.at_without_stage(q), .visited = VisitedCells::local};
  if (v != nullptr) state.v = terms_.arrays().beside(v);
  const auto terms = terms_.all();
  const auto k = static_cast<std::size_t>(std::ranges::find(terms, &term) - terms.begin());
  state.at.near = terms_.near(k);
  state.z = terms_.internal_of(k, z);
  return state;
}

void EnergyAccounts::visit_stresses(const Instant& at, Vec q, Vec v, Vec z,
                                    const std::function<void(StressPart, PetscInt, const CellStress&)>& visit) {
  BodyState state{.at = at, .q = terms_.arrays().at(q), .visited = VisitedCells::local};
  if (v != nullptr) state.v = terms_.arrays().beside(v);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const auto* term = dynamic_cast<const StressTerm*>(&terms_[k]);
    if (term == nullptr) continue;
    state.z = terms_.internal_of(k, z);
    term->stresses(state, [&](PetscInt cell, const CellStress& stress) { visit(term->part(), cell, stress); });
  }
}

}  // namespace pliant
