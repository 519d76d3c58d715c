/// What objects with state keep, in memory: to return to an earlier state of the same objects.
#pragma once

#include "petsc/archive.hpp"

#include <functional>
#include <vector>

namespace pliant {

class KeptInMemory {
 public:
  using Keep = std::function<void(Archive&)>;

  /// Nothing.
  KeptInMemory() = default;
  /// Stores what `keep` names. Collective.
  explicit KeptInMemory(const Keep& keep);
  /// Restores it: `keep` names the same items in the same order. Collective.
  void restore(const Keep& keep) const;

 private:
  std::vector<std::vector<double>> items_;  // in the order in which they were kept
};

}  // namespace pliant
