#include "energy/equation/stage_arrays.hpp"

#include "petsc/ghosted.hpp"

namespace pliant {

StageArrays::StageArrays(const NodeLayout& layout, std::vector<const PairCoupling*> couplings,
                         const std::vector<char>& prescribed)
    : layout_(layout), couplings_(std::move(couplings)) {
  if (!couplings_.empty()) pairs_ = std::make_unique<PairAssembly>(layout, couplings_, prescribed);
}

std::size_t StageArrays::num_nodes() const {
  return static_cast<std::size_t>(layout_.num_local_nodes) + (pairs_ ? pairs_->num_far_nodes() : 0);
}

std::span<const double> StageArrays::copied(Vec v, Copy& copy) {
  check(VecCopy(v, copy.ghosted.get()));
  update_ghosts(copy.ghosted.get());
  const std::span<const double> entries = ConstGhostedView(copy.ghosted.get()).span();  // stays where it is
  if (!pairs_) return entries;
  pairs_->extend(entries, copy.extended);
  return copy.extended;
}

void StageArrays::follow_pairs(Path& path, Copy& of_q) {
  if (!pairs_) return;
  std::vector<std::span<const double>> frozen;
  for (const PairCoupling* coupling : couplings_) frozen.push_back(coupling->frozen_place(stage_, path.q));
  if (!pairs_->follow(path, frozen)) return;
  const auto extend = [&](std::span<const double>& entries, Copy& copy) {
    if (entries.empty()) return;
    pairs_->extend(ConstGhostedView(copy.ghosted.get()).span(), copy.extended);
    entries = copy.extended;
  };
  extend(path.q, of_q);
  extend(path.d, d_);
  extend(stage_.q0, q0_);
  extend(stage_.v0, v0_);
  extend(stage_.accepted, accepted_);
  extend(stage_.previous, previous_);
  extend(stage_.frozen, frozen_);
}

void StageArrays::begin(const StagePoint& stage) {
  stage_ = {.time = stage.time,
            .dt = stage.dt,
            .load_factor = stage.load_factor,
            .q0 = copied(stage.q0, q0_),
            .v0 = copied(stage.v0, v0_),
            .step_start = stage.step_start};
  if (stage.accepted != nullptr) stage_.accepted = copied(stage.accepted, accepted_);
}

std::span<const double> StageArrays::at(Vec q) {
  Path point{copied(q, q_)};
  follow_pairs(point, q_);
  return point.q;
}

Path StageArrays::along(Vec q, Vec d) {
  Path path{copied(q, q_), copied(d, d_)};
  if (pairs_) path.end = pairs_->searchable_part(path.d);
  follow_pairs(path, q_);
  return path;
}

void StageArrays::return_to_accepted() {
  Path point{stage_.accepted};
  follow_pairs(point, accepted_);
}

}  // namespace pliant
