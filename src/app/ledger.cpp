#include "app/ledger.hpp"

#include "base/compensated_sum.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>

namespace pliant {
namespace {

void sum_over_ranks(MPI_Comm comm, double* values, int count) {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, comm));
}

}  // namespace

Ledger::Ledger(Model& model, Analysis analysis, Vec q, Vec v)
    : model_(model), analysis_(analysis), reactions_(model.supports().size(), std::array<double, 3>{}) {
  for (Handle<Vec>* x : {&q_, &v_, &reaction_, &next_reaction_}) *x = make_vector(model.layout());
  measure(q, v);
  initial_ = energies_.kinetic + energies_.elastic + energies_.load_potential;
  const auto size = static_cast<std::size_t>(3 * model.layout().num_local_nodes);
  for (const auto& load : model.loads()) {
    if (analysis == Analysis::static_equilibrium) {
      forces_.emplace_back(size, 0.0);  // load steps start from nothing
    } else {
      forces_.push_back(load->depends_on_time() ? load->forces(0.0) : std::vector<double>());
    }
  }
  reaction_is_known_ = analysis == Analysis::static_equilibrium;  // load steps start from nothing
}

void Ledger::measure(Vec q, Vec v) {
  check(VecCopy(q, q_.get()));
  check(VecCopy(v, v_.get()));
  update_ghosts(q_.get());
  update_ghosts(v_.get());
  const ConstGhostedView u(q_.get()), velocity(v_.get());
  const PetscInt num_owned = 3 * model_.layout().num_owned_nodes;

  std::array<double, 9> local{};
  for (const auto& term : model_.elastic()) local[0] += term->energy(u.span(), {});
  for (const auto& load : model_.loads()) {
    if (counts_by_work(*load)) continue;
    const auto f = load->forces(0.0);
    CompensatedSum<double> potential;
    for (PetscInt i = 0; i < num_owned; ++i) potential.add(-f[i] * u.span()[i]);
    local[1] += potential.total();
  }
  if (analysis_ == Analysis::dynamic && model_.inertia() != nullptr) {
    local[2] = model_.inertia()->kinetic_energy(velocity.span());
    const Momenta m = model_.inertia()->momenta(model_.layout().coordinates, u.span(), velocity.span());
    std::copy(m.linear.begin(), m.linear.end(), local.begin() + 3);
    std::copy(m.angular.begin(), m.angular.end(), local.begin() + 6);
  }
  sum_over_ranks(model_.layout().comm, local.data(), static_cast<int>(local.size()));
  energies_.elastic = local[0];
  energies_.load_potential = local[1];
  energies_.kinetic = local[2];
  std::copy_n(local.begin() + 3, 3, energies_.momenta.linear.begin());
  std::copy_n(local.begin() + 6, 3, energies_.momenta.angular.begin());
}

void Ledger::book(const StepAttempt& attempt) {
  const PetscInt num_owned = 3 * model_.layout().num_owned_nodes;
  const double time_of_loads = analysis_ == Analysis::static_equilibrium ? attempt.last_stage.time : attempt.time;
  model_.potential().begin_stage(attempt.last_stage);
  model_.potential().gradient_with_reactions(attempt.last_q, next_reaction_.get());
  std::vector<double> local(3 * reactions_.size() + 1, 0.0);
  {
    const ConstArrayView before(reaction_.get()), after(next_reaction_.get());
    for (std::size_t s = 0; s < reactions_.size(); ++s) {
      for (const PetscInt dof : model_.supports()[s].dofs) local[3 * s + dof % 3] += after[dof];
    }
    CompensatedSum<double> work;
    const ConstArrayView u0(q_.get()), u1(attempt.q);
    const auto& prescribed = model_.prescribed().flags();
    for (PetscInt i = 0; i < num_owned; ++i) {
      // In time the reaction at the start is not known: it depends on the accelerations there.
      if (prescribed[i]) work.add((reaction_is_known_ ? 0.5 * (before[i] + after[i]) : after[i]) * (u1[i] - u0[i]));
    }
    for (std::size_t k = 0; k < forces_.size(); ++k) {
      if (forces_[k].empty()) continue;
      auto f = model_.loads()[k]->forces(time_of_loads);
      for (double& x : f) x *= attempt.last_stage.load_factor;
      for (PetscInt i = 0; i < num_owned; ++i) work.add(0.5 * (forces_[k][i] + f[i]) * (u1[i] - u0[i]));
      forces_[k] = f;
    }
    local.back() = work.total();
  }
  sum_over_ranks(model_.layout().comm, local.data(), static_cast<int>(local.size()));
  for (std::size_t s = 0; s < reactions_.size(); ++s) std::copy_n(local.begin() + 3 * s, 3, reactions_[s].begin());
  energies_.load_work += local.back();
  std::swap(reaction_, next_reaction_);
  reaction_is_known_ = true;
  measure(attempt.q, attempt.v);
  energies_.balance_error = energies_.kinetic + energies_.elastic + energies_.load_potential + energies_.dissipated -
                            energies_.load_work - initial_;
}

}  // namespace pliant
