#include "mesh/refinement.hpp"

#include "petsc/global_order.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// A vertex of a child: the middle of two corners of the cell, or a corner twice.
using Middle = std::array<std::size_t, 2>;

/// Positively oriented if the cell is.
constexpr std::array<std::array<Middle, 4>, 8> children{{{{{0, 0}, {0, 1}, {0, 2}, {0, 3}}},
                                                         {{{0, 1}, {1, 1}, {1, 2}, {1, 3}}},
                                                         {{{0, 2}, {1, 2}, {2, 2}, {2, 3}}},
                                                         {{{0, 3}, {1, 3}, {2, 3}, {3, 3}}},
                                                         {{{0, 2}, {0, 3}, {0, 1}, {2, 3}}},
                                                         {{{1, 3}, {1, 2}, {0, 1}, {2, 3}}},
                                                         {{{2, 3}, {0, 1}, {0, 2}, {1, 2}}},
                                                         {{{2, 3}, {0, 1}, {1, 3}, {0, 3}}}}};

EntryKey key_of(const CellBlock& block, std::size_t cell, const Middle& middle) {
  const auto [a, b] = std::minmax(block.corners[4 * cell + middle[0]], block.corners[4 * cell + middle[1]]);
  return {a, b};
}

/// The vertices and edges of the block's cells, ascending.
std::vector<EntryKey> keys_of(const CellBlock& block) {
  std::vector<EntryKey> keys;
  keys.reserve(6 * block.num_cells() + block.vertices.size());
  for (const std::int64_t v : block.vertices) keys.push_back({v, v});
  for (std::size_t c = 0; c < block.num_cells(); ++c) {
    for (const auto& [a, b] : local_edges) {
      keys.push_back(key_of(block, c, {static_cast<std::size_t>(a), static_cast<std::size_t>(b)}));
    }
  }
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

/// The parts of a cell's children that lie in the marked part of the cell.
void add_marks_of_children(const CellMark& mark, std::vector<CellMark>& marks) {
  const auto inside = local_part(mark.dimension, static_cast<std::size_t>(mark.part));
  const auto is_inside = [&](std::size_t corner) {
    return std::ranges::find(inside, static_cast<int>(corner)) != inside.end();
  };
  for (std::size_t k = 0; k < children.size(); ++k) {
    for (std::size_t part = 0; part < num_local_parts(mark.dimension); ++part) {
      const bool lies_inside = std::ranges::all_of(local_part(mark.dimension, part), [&](int corner) {
        return std::ranges::all_of(children[k][static_cast<std::size_t>(corner)], is_inside);
      });
      if (!lies_inside) continue;
      marks.push_back(
          {8 * mark.cell + static_cast<PetscInt>(k), mark.group, mark.dimension, static_cast<std::int8_t>(part)});
    }
  }
}

}  // namespace

CellBlock refined(MPI_Comm comm, const CellBlock& block) {
  const std::vector<EntryKey> keys = keys_of(block);
  const GlobalOrder order(comm, keys);
  CellBlock fine;
  fine.width = block.width;
  fine.vertices = order.row_of_entry();  // ascending as the keys are
  fine.coordinates.reserve(3 * keys.size());
  for (const auto& [a, b] : keys) {
    const double* from = &block.coordinates[3 * index_of(block.vertices, a)];
    const double* to = &block.coordinates[3 * index_of(block.vertices, b)];
    for (std::size_t k = 0; k < 3; ++k) fine.coordinates.push_back(0.5 * (from[k] + to[k]));
  }
  fine.corners.reserve(32 * block.num_cells());
  fine.numbers.reserve(8 * block.num_cells());
  fine.values.reserve(8 * block.values.size());
  for (std::size_t c = 0; c < block.num_cells(); ++c) {
    const auto values = std::span(block.values).subspan(block.width * c, block.width);
    for (std::size_t k = 0; k < children.size(); ++k) {
      for (const Middle& middle : children[k]) {
        const auto at = std::ranges::lower_bound(keys, key_of(block, c, middle)) - keys.begin();
        fine.corners.push_back(fine.vertices[static_cast<std::size_t>(at)]);
      }
      fine.numbers.push_back(8 * block.numbers[c] + static_cast<std::int64_t>(k));
      fine.values.insert(fine.values.end(), values.begin(), values.end());
    }
  }
  for (const CellMark& mark : block.marks) add_marks_of_children(mark, fine.marks);
  std::ranges::stable_sort(fine.marks, {}, &CellMark::cell);
  return fine;
}

}  // namespace pliant
