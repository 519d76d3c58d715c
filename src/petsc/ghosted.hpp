/// Access to the local form (owned entries, then ghosts) of a ghosted vector.
#pragma once

#include "petsc/handle.hpp"

#include <span>

namespace pliant {

/// Updates the ghosts of `v` from their owners. Collective.
inline void update_ghosts(Vec v) {
  check(VecGhostUpdateBegin(v, INSERT_VALUES, SCATTER_FORWARD));
  check(VecGhostUpdateEnd(v, INSERT_VALUES, SCATTER_FORWARD));
}

/// Read access to owned and ghost entries; restored at the end of the scope. Not collective.
class ConstGhostedView {
 public:
  explicit ConstGhostedView(Vec v) : v_(v) {
    check(VecGhostGetLocalForm(v_, &local_));
    PetscInt size = 0;
    check(VecGetLocalSize(local_, &size));
    check(VecGetArrayRead(local_, &data_));
    span_ = {data_, static_cast<std::size_t>(size)};
  }
  ~ConstGhostedView() {
    (void)VecRestoreArrayRead(local_, &data_);
    (void)VecGhostRestoreLocalForm(v_, &local_);
  }
  ConstGhostedView(const ConstGhostedView&) = delete;
  ConstGhostedView& operator=(const ConstGhostedView&) = delete;
  std::span<const double> span() const { return span_; }

 private:
  Vec v_;
  Vec local_ = nullptr;
  const double* data_ = nullptr;
  std::span<const double> span_;
};

/// Write access to owned and ghost entries; restored at the end of the scope. Not collective.
class GhostedView {
 public:
  explicit GhostedView(Vec v) : v_(v) {
    check(VecGhostGetLocalForm(v_, &local_));
    PetscInt size = 0;
    check(VecGetLocalSize(local_, &size));
    check(VecGetArray(local_, &data_));
    span_ = {data_, static_cast<std::size_t>(size)};
  }
  ~GhostedView() {
    (void)VecRestoreArray(local_, &data_);
    (void)VecGhostRestoreLocalForm(v_, &local_);
  }
  GhostedView(const GhostedView&) = delete;
  GhostedView& operator=(const GhostedView&) = delete;
  std::span<double> span() const { return span_; }

 private:
  Vec v_;
  Vec local_ = nullptr;
  double* data_ = nullptr;
  std::span<double> span_;
};

}  // namespace pliant
