/// The tags of patches as small numbers, and which of them may couple (energy/coupling.hpp).
#pragma once

#include "energy/coupling.hpp"

#include <cstdint>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// The tags of all ranks, numbered in ascending order: the same kinds on every rank. PairCoupling::may_couple is called
/// once for each two of them.
class PatchKinds {
 public:
  /// Collective.
  PatchKinds(MPI_Comm comm, const PairCoupling& coupling);

  std::size_t size() const { return tags_.size(); }
  int tag_of(std::int32_t kind) const { return tags_[static_cast<std::size_t>(kind)]; }
  std::int32_t kind_of(int tag) const;
  bool may_couple(std::int32_t kind, std::int32_t other) const {
    return may_couple_[static_cast<std::size_t>(kind) * size() + static_cast<std::size_t>(other)] != 0;
  }

 private:
  std::vector<int> tags_;
  std::vector<char> may_couple_;  // of any two, row by row
};

}  // namespace pliant
