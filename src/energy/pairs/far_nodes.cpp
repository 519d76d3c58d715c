#include "energy/pairs/far_nodes.hpp"

#include <algorithm>

namespace pliant {

FarNodes::FarNodes(const NodeLayout& layout, std::vector<PetscInt> globals)
    : layout_(layout), globals_(std::move(globals)) {
  Handle<PetscLayout> owners;
  check(PetscLayoutCreateFromSizes(layout.comm, 3 * layout.num_owned_nodes, PETSC_DETERMINE, 1, owners.out()));
  std::vector<PetscInt> entries;
  for (const PetscInt global : globals_) entries.insert(entries.end(), {3 * global, 3 * global + 1, 3 * global + 2});
  check(PetscSFCreate(layout.comm, from_owners_.out()));
  check(PetscSFSetGraphLayout(from_owners_.get(), owners.get(), static_cast<PetscInt>(entries.size()), nullptr,
                              PETSC_COPY_VALUES, entries.data()));
  check(PetscSFSetUp(from_owners_.get()));
}

PetscInt FarNodes::local_node(PetscInt global_node) const {
  const PetscInt owned = global_node - layout_.first_global_node;
  if (owned >= 0 && owned < layout_.num_owned_nodes) return owned;
  const auto& ghosts = layout_.ghost_global_nodes;
  const auto ghost = std::ranges::lower_bound(ghosts, global_node);
  if (ghost != ghosts.end() && *ghost == global_node) {
    return layout_.num_owned_nodes + static_cast<PetscInt>(ghost - ghosts.begin());
  }
  const auto far = std::ranges::lower_bound(globals_, global_node);
  return layout_.num_local_nodes + static_cast<PetscInt>(far - globals_.begin());
}

void FarNodes::extend(std::span<const double> local, std::vector<double>& all) const {
  const std::size_t num_local = 3 * static_cast<std::size_t>(layout_.num_local_nodes);
  if (local.data() != all.data()) all.assign(local.begin(), local.begin() + static_cast<std::ptrdiff_t>(num_local));
  all.resize(num_local + 3 * globals_.size());
  double* far = all.data() + num_local;
  check(PetscSFBcastBegin(from_owners_.get(), MPIU_SCALAR, all.data(), far, MPI_REPLACE));
  check(PetscSFBcastEnd(from_owners_.get(), MPIU_SCALAR, all.data(), far, MPI_REPLACE));
}

}  // namespace pliant
