#include "mesh/node_numbering.hpp"

#include "mesh/serial_mesh.hpp"

#include <algorithm>

namespace pliant {
namespace {

[[noreturn]] void reject_twice(std::size_t tag) {
  throw MeshDefect("node " + std::to_string(tag) + " is defined twice: give every node its own number");
}

}  // namespace

NodeNumbering::NodeNumbering(const std::vector<std::size_t>& tags) {
  const std::size_t largest = tags.empty() ? 0 : *std::max_element(tags.begin(), tags.end());
  if (largest < 8 * tags.size() + 1024) {
    dense_.assign(largest + 1, -1);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      if (dense_[tags[i]] >= 0) reject_twice(tags[i]);
      dense_[tags[i]] = static_cast<PetscInt>(i);
    }
  } else {
    sparse_.resize(tags.size());
    for (std::size_t i = 0; i < tags.size(); ++i) sparse_[i] = {tags[i], static_cast<PetscInt>(i)};
    std::sort(sparse_.begin(), sparse_.end());
    for (std::size_t i = 1; i < sparse_.size(); ++i) {
      if (sparse_[i].first == sparse_[i - 1].first) reject_twice(sparse_[i].first);
    }
  }
}

PetscInt NodeNumbering::operator()(std::size_t tag) const {
  if (tag < dense_.size() && dense_[tag] >= 0) return dense_[tag];
  const auto found = std::lower_bound(sparse_.begin(), sparse_.end(), std::pair<std::size_t, PetscInt>(tag, 0));
  if (found != sparse_.end() && found->first == tag) return found->second;
  throw MeshDefect("an element refers to node " + std::to_string(tag) +
                   ", which the file does not define: write the mesh again with all its nodes");
}

}  // namespace pliant
