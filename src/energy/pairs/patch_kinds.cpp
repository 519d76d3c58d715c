#include "energy/pairs/patch_kinds.hpp"

#include "petsc/collective.hpp"

#include <algorithm>

namespace pliant {
namespace {

void keep_one_of_each(std::vector<int>& tags) {
  std::ranges::sort(tags);
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
}

}  // namespace

PatchKinds::PatchKinds(MPI_Comm comm, const PairCoupling& coupling) : tags_(coupling.patches().tags) {
  keep_one_of_each(tags_);
  tags_ = gathered(comm, tags_);
  keep_one_of_each(tags_);
  may_couple_.reserve(size() * size());
  for (const int tag : tags_) {
    for (const int other : tags_) may_couple_.push_back(coupling.may_couple(tag, other) ? 1 : 0);
  }
}

std::int32_t PatchKinds::kind_of(int tag) const {
  return static_cast<std::int32_t>(std::ranges::lower_bound(tags_, tag) - tags_.begin());
}

}  // namespace pliant
