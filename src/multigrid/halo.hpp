/// Nodes of other ranks that a rank needs, and the messages that bring their values.
#pragma once

#include "petsc/check.hpp"

#include <cstring>
#include <span>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Nodes are numbered through the ranks. A rank counts its own first, then the ghosts: nodes of others, in the order of
/// their numbers. Arrays that are exchanged have `width` values for each node, own and ghost.
///
/// Invariant: the ghosts of one owner follow each other.
class Halo {
 public:
  Halo() = default;
  /// `comm`: that of a PETSc object. `ghosts`: numbers of nodes of other ranks, ascending. Collective.
  Halo(MPI_Comm comm, int num_owned, std::vector<PetscInt> ghosts);

  MPI_Comm comm() const { return comm_; }
  int num_owned() const { return num_owned_; }
  int num_ghosts() const { return static_cast<int>(ghosts_.size()); }
  int num_local() const { return num_owned_ + num_ghosts(); }
  /// The number of nodes of all ranks.
  PetscInt num_global() const { return begins_.back(); }
  PetscInt first() const { return first_; }
  bool owns(PetscInt node) const { return node >= first_ && node < first_ + num_owned_; }
  /// The number through the ranks of a local node, and the reverse for own nodes and ghosts.
  PetscInt global(int node) const { return node < num_owned_ ? first_ + node : ghosts_[at(node - num_owned_)]; }
  int local(PetscInt node) const;
  /// The rank that owns a node.
  int owner(PetscInt node) const;
  /// Own nodes that are ghosts of each rank.
  std::span<const std::vector<int>> wanted() const { return wanted_; }

  /// Gives the ghosts the values of their owners. Collective.
  template <class T>
  void fetch(std::span<T> x, int width) const;
  /// Adds the values of ghosts to those of their owners, in the order of the ranks. Collective.
  template <class T>
  void add_to_owners(std::span<T> x, int width) const;

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  /// Exchanges blocks of bytes with the neighbours: blocks for `wanted_` one way, for the ghosts the other.
  void send_wanted(const std::byte* packed, std::byte* ghosts, std::size_t bytes) const;
  void send_ghosts(const std::byte* ghosts, std::byte* packed, std::size_t bytes) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  PetscMPIInt tag_ = 0;
  int num_owned_ = 0;
  PetscInt first_ = 0;
  std::vector<PetscInt> begins_{0};  // first node of each rank, and the number of all
  std::vector<PetscInt> ghosts_;
  std::vector<int> num_of_owner_;         // ghosts of each rank
  std::vector<std::vector<int>> wanted_;  // own nodes that are ghosts of each rank
  std::size_t num_wanted_ = 0;
};

template <class T>
void Halo::fetch(std::span<T> x, int width) const {
  const std::size_t w = at(width);
  std::vector<T> packed;
  packed.reserve(num_wanted_ * w);
  for (const std::vector<int>& nodes : wanted_) {
    for (const int node : nodes) packed.insert(packed.end(), &x[at(node) * w], &x[at(node) * w] + w);
  }
  T* const ghosts = x.data() + at(num_owned_) * w;
  send_wanted(reinterpret_cast<const std::byte*>(packed.data()), reinterpret_cast<std::byte*>(ghosts), w * sizeof(T));
}

template <class T>
void Halo::add_to_owners(std::span<T> x, int width) const {
  const std::size_t w = at(width);
  std::vector<T> packed(num_wanted_ * w);
  const T* const ghosts = x.data() + at(num_owned_) * w;
  send_ghosts(reinterpret_cast<const std::byte*>(ghosts), reinterpret_cast<std::byte*>(packed.data()), w * sizeof(T));
  const T* from = packed.data();
  for (const std::vector<int>& nodes : wanted_) {
    for (const int node : nodes) {
      for (std::size_t k = 0; k < w; ++k) x[at(node) * w + k] += *from++;
    }
  }
}

}  // namespace pliant
