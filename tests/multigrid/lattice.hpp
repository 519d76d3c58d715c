/// An elastic lattice: nodes on a grid, springs between neighbours, clamped at one end.
#pragma once

#include "petsc/handle.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace pliant {

/// The stiffness of an nx x ny x nz grid of nodes with springs of length 1, sqrt 2 and sqrt 3, nodes distributed in the
/// order of their numbers. Entries of the nodes at x = 0 are eliminated: the identity in their rows and columns.
class Lattice {
 public:
  Lattice(MPI_Comm comm, int nx, int ny, int nz, double stiffness = 1.0) : n_{nx, ny, nz} {
    const PetscInt size = 3 * nx * ny * nz;
    PetscInt local = PETSC_DECIDE, global = nx * ny * nz;
    check(PetscSplitOwnership(comm, &local, &global));
    check(MatCreateAIJ(comm, 3 * local, 3 * local, size, size, 81, nullptr, 81, nullptr, K_.out()));
    check(MatSetBlockSize(K_.get(), 3));
    PetscInt begin = 0, end = 0;
    check(MatGetOwnershipRange(K_.get(), &begin, &end));
    for (PetscInt node = begin / 3; node < end / 3; ++node) add_springs(static_cast<int>(node), stiffness);
    check(MatAssemblyBegin(K_.get(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(K_.get(), MAT_FINAL_ASSEMBLY));
    add_modes(comm, begin / 3, end / 3);
  }

  Mat K() const { return K_.get(); }

 private:
  std::array<int, 3> place(int node) const { return {node % n_[0], node / n_[0] % n_[1], node / (n_[0] * n_[1])}; }

  void add_springs(int node, double stiffness) {
    const std::array<int, 3> at = place(node);
    std::array<std::array<double, 3>, 3> diagonal{};
    for (int e = 0; e < 27; ++e) {
      const std::array<int, 3> d{e % 3 - 1, e / 3 % 3 - 1, e / 9 - 1};
      bool is_inside = e != 13;
      for (std::size_t c = 0; c < 3; ++c) is_inside = is_inside && at[c] + d[c] >= 0 && at[c] + d[c] < n_[c];
      if (!is_inside) continue;
      const int other = node + d[0] + n_[0] * (d[1] + n_[1] * d[2]);
      const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      const bool is_coupled = at[0] > 0 && at[0] + d[0] > 0;
      std::array<double, 9> block{};
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
          const double k = stiffness * d[r] * d[c] / square;
          diagonal[r][c] += k;
          block[3 * r + c] = is_coupled ? -k : 0.0;
        }
      }
      const PetscInt row = node, column = other;
      check(MatSetValuesBlocked(K_.get(), 1, &row, 1, &column, block.data(), INSERT_VALUES));
    }
    std::array<double, 9> block{};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) block[3 * r + c] = at[0] > 0 ? diagonal[r][c] : (r == c ? 1.0 : 0.0);
    }
    const PetscInt row = node;
    check(MatSetValuesBlocked(K_.get(), 1, &row, 1, &row, block.data(), INSERT_VALUES));
  }

  void add_modes(MPI_Comm comm, PetscInt begin, PetscInt end) {
    std::vector<Handle<Vec>> modes(6);
    std::vector<Vec> raw;
    for (std::size_t m = 0; m < 6; ++m) {
      check(MatCreateVecs(K_.get(), modes[m].out(), nullptr));
      for (PetscInt node = begin; node < end; ++node) {
        const std::array<int, 3> x = place(static_cast<int>(node));
        if (x[0] == 0) continue;
        std::array<double, 3> u{};
        if (m < 3) {
          u[m] = 1.0;
        } else {
          const std::size_t a = (m + 1) % 3, b = (m + 2) % 3;
          u[a] = -x[b];
          u[b] = x[a];
        }
        const std::array<PetscInt, 3> rows{3 * node, 3 * node + 1, 3 * node + 2};
        check(VecSetValues(modes[m].get(), 3, rows.data(), u.data(), INSERT_VALUES));
      }
      check(VecAssemblyBegin(modes[m].get()));
      check(VecAssemblyEnd(modes[m].get()));
      for (std::size_t k = 0; k < m; ++k) {
        PetscScalar product = 0.0;
        check(VecDot(modes[m].get(), modes[k].get(), &product));
        check(VecAXPY(modes[m].get(), -product, modes[k].get()));
      }
      check(VecNormalize(modes[m].get(), nullptr));
      raw.push_back(modes[m].get());
    }
    Handle<MatNullSpace> space;
    check(MatNullSpaceCreate(comm, PETSC_FALSE, 6, raw.data(), space.out()));
    check(MatSetNearNullSpace(K_.get(), space.get()));
  }

  std::array<int, 3> n_;
  Handle<Mat> K_;
};

}  // namespace pliant
