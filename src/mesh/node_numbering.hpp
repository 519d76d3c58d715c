/// Maps node tags, which may have gaps, to 0, 1, 2, ...
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <petscsystypes.h>

namespace pliant {

/// A dense table, or a sorted one where the tags are sparse. Throws MeshDefect for a tag that is given twice or looked
/// up but missing.
class NodeNumbering {
 public:
  explicit NodeNumbering(const std::vector<std::size_t>& tags);
  PetscInt operator()(std::size_t tag) const;

 private:
  std::vector<PetscInt> dense_;
  std::vector<std::pair<std::size_t, PetscInt>> sparse_;
};

}  // namespace pliant
