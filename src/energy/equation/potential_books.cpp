// The energies, works and stresses of IncrementalPotential, for ledgers and results; solvers do not need them.
#include "base/compensated_sum.hpp"
#include "energy/equation/incremental_potential.hpp"
#include "energy/function_of_sum.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

namespace pliant {

std::vector<TermPower> IncrementalPotential::powers(Vec q, Vec v, Vec r) {
  const auto at = evaluated_at(q);
  std::vector<TermPower> result(terms_.size());
  check(VecZeroEntries(r));
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const auto rows = empty_rows();
    terms_[k]->add_gradient(stage_of(k), at, rows);
    const ConstArrayView velocity(v);
    const ArrayView total(r);
    CompensatedSum<double> power;
    std::array<CompensatedSum<double>, 3> force;
    for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
      power.add(-rows[i] * velocity[i]);
      force[static_cast<std::size_t>(i % 3)].add(-rows[i]);
      total[i] += rows[i];
    }
    result[k] = {power.total(),
                 terms_[k]->dissipation(stage_of(k), at),
                 terms_[k]->supply(stage_of(k), at),
                 {force[0].total(), force[1].total(), force[2].total()}};
  }
  static_assert(sizeof(TermPower) == TermPower::num_numbers * sizeof(double));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, result.data(), static_cast<int>(TermPower::num_numbers * result.size()),
                          MPI_DOUBLE, MPI_SUM, layout_.comm));
  return result;
}

std::vector<double> IncrementalPotential::energies(const Instant& when, Vec q, Vec z) {
  const auto at = arrays_.at(q);
  Instant instant = when;
  std::vector<double> result;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    std::span<const double> own;
    if (z != nullptr) {
      const ConstArrayView values(z);
      own = values.span().subspan(first_internal_[k], first_internal_[k + 1] - first_internal_[k]);
    }
    instant.near = near(k);
    result.push_back(terms_[k]->energy_at(instant, at, own));
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, result.data(), static_cast<int>(result.size()), MPI_DOUBLE, MPI_SUM, layout_.comm));
  LocalStage here;  // a stage that starts at q
  here.q0 = at;
  add_up(here, at);
  for (const std::size_t k : functions_of_sum_) {
    result[k] += sum_function(k).energy_of_sum(sums_[k].total());
  }
  return result;
}

void IncrementalPotential::visit_stresses(const Instant& at, Vec q, Vec v, Vec z,
                                          const std::function<void(StressPart, PetscInt, const CellStress&)>& visit) {
  BodyState state{.at = at, .q = arrays_.at(q)};
  if (v != nullptr) state.v = arrays_.beside(v);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const auto* term = dynamic_cast<const StressTerm*>(terms_[k]);
    if (term == nullptr) continue;
    state.z = {};
    if (z != nullptr) {
      const ConstArrayView values(z);
      state.z = values.span().subspan(first_internal_[k], first_internal_[k + 1] - first_internal_[k]);
    }
    term->stresses(state, [&](PetscInt cell, const CellStress& stress) { visit(term->part(), cell, stress); });
  }
}

double IncrementalPotential::supplied(const Instant& from, const Instant& to, Vec q) {
  const auto is_concerned = [](const EnergyTerm* term) { return term->declaration().depends_on_time; };
  if (std::ranges::none_of(terms_, is_concerned)) return 0.0;
  const auto at = arrays_.at(q);
  double mine = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (!is_concerned(terms_[k])) continue;
    Instant before = from, after = to;
    before.near = after.near = near(k);
    mine += terms_[k]->energy_at(after, at, {}) - terms_[k]->energy_at(before, at, {});
  }
  return sum(layout_.comm, mine);
}

}  // namespace pliant
