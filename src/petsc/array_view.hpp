/// Scoped access to the owned entries of a vector.
#pragma once

#include "petsc/handle.hpp"

#include <span>

namespace pliant {

/// Read access to the owned entries; restored at the end of the scope. Not collective.
class ConstArrayView {
 public:
  explicit ConstArrayView(Vec v) : v_(v) {
    check(VecGetLocalSize(v_, &size_));
    check(VecGetArrayRead(v_, &data_));
  }
  ~ConstArrayView() { (void)VecRestoreArrayRead(v_, &data_); }
  ConstArrayView(const ConstArrayView&) = delete;
  ConstArrayView& operator=(const ConstArrayView&) = delete;
  double operator[](PetscInt i) const { return data_[i]; }
  operator std::span<const double>() const { return span(); }
  std::span<const double> span() const { return {data_, static_cast<std::size_t>(size_)}; }

 private:
  Vec v_;
  PetscInt size_ = 0;
  const double* data_ = nullptr;
};

/// Write access to the owned entries; restored at the end of the scope. Not collective.
class ArrayView {
 public:
  explicit ArrayView(Vec v) : v_(v) {
    check(VecGetLocalSize(v_, &size_));
    check(VecGetArray(v_, &data_));
  }
  ~ArrayView() { (void)VecRestoreArray(v_, &data_); }
  ArrayView(const ArrayView&) = delete;
  ArrayView& operator=(const ArrayView&) = delete;
  double& operator[](PetscInt i) const { return data_[i]; }
  operator std::span<double>() const { return span(); }
  std::span<double> span() const { return {data_, static_cast<std::size_t>(size_)}; }

 private:
  Vec v_;
  PetscInt size_ = 0;
  double* data_ = nullptr;
};

}  // namespace pliant
