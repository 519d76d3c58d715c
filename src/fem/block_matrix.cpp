#include "fem/block_matrix.hpp"

#include "base/error.hpp"
#include "petsc/array_view.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

namespace pliant {

BlockPattern::BlockPattern(const NodeLayout& layout) : BlockPattern(layout, FarCouplings{}) {}

BlockPattern::BlockPattern(const NodeLayout& layout, const FarCouplings& far)
    : num_owned_nodes_(layout.num_owned_nodes),
      first_global_node_(layout.first_global_node),
      other_globals_(layout.ghost_global_nodes) {
  other_globals_.insert(other_globals_.end(), far.globals.begin(), far.globals.end());
  const NodeGraph graph =
      node_graph(layout.cell_nodes, layout.nodes_per_cell, layout.num_local_nodes, layout.num_owned_nodes);
  std::vector<std::pair<PetscInt, PetscInt>> more = far.pairs;
  std::ranges::sort(more);
  auto next = more.begin();
  diagonal_.offsets.assign(1, 0);
  off_diagonal_.offsets.assign(1, 0);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const auto add = [&](PetscInt m) { (m < num_owned_nodes_ ? diagonal_ : off_diagonal_).nodes.push_back(m); };
    for (PetscInt k = graph.offsets[n]; k < graph.offsets[n + 1]; ++k) add(graph.neighbours[k]);
    for (; next != more.end() && next->first == n; ++next) add(next->second);
    for (Rows* part : {&diagonal_, &off_diagonal_}) {
      const auto first = part->nodes.begin() + part->offsets.back();
      std::sort(first, part->nodes.end(), [&](PetscInt a, PetscInt b) { return global_node(a) < global_node(b); });
      part->nodes.erase(std::unique(first, part->nodes.end()), part->nodes.end());
      part->offsets.push_back(static_cast<PetscInt>(part->nodes.size()));
    }
    own_blocks_.push_back(block(n, n));
  }
  const std::size_t num_blocks = diagonal_.nodes.size() + off_diagonal_.nodes.size();
  const auto most = std::min<PetscInt>(PETSC_MAX_INT / 9, std::numeric_limits<std::int32_t>::max());
  if (num_blocks > static_cast<std::size_t>(most)) {
    throw InputError({}, "the matrix has " + std::to_string(9 * num_blocks) +
                             " entries on one rank, more than its integers count: run on more ranks");
  }
}

std::vector<PetscInt>::const_iterator BlockPattern::find(const Rows& part, PetscInt row_node,
                                                         PetscInt column_node) const {
  const auto begin = part.nodes.begin() + part.offsets[row_node], end = part.nodes.begin() + part.offsets[row_node + 1];
  return std::lower_bound(begin, end, global_node(column_node),
                          [&](PetscInt node, PetscInt global) { return global_node(node) < global; });
}

std::int32_t BlockPattern::block(PetscInt row_node, PetscInt column_node) const {
  const bool owned_column = column_node < num_owned_nodes_;
  const Rows& part = owned_column ? diagonal_ : off_diagonal_;
  const auto number = static_cast<std::int32_t>(find(part, row_node, column_node) - part.nodes.begin());
  return owned_column ? number : -1 - number;
}

bool BlockPattern::contains(PetscInt row_node, PetscInt column_node) const {
  const Rows& part = column_node < num_owned_nodes_ ? diagonal_ : off_diagonal_;
  const auto place = find(part, row_node, column_node);
  return place != part.nodes.begin() + part.offsets[row_node + 1] && *place == column_node;
}

Handle<Mat> make_matrix(const NodeLayout& layout, const BlockPattern& pattern) {
  // Rows in CSR form over global columns; PETSc splits them into the same two parts in the same order.
  const auto& diagonal = pattern.diagonal();
  const auto& off_diagonal = pattern.off_diagonal();
  const PetscInt num_rows = 3 * layout.num_owned_nodes;
  std::vector<PetscInt> offsets(num_rows + 1, 0), columns;
  columns.reserve(9 * (diagonal.nodes.size() + off_diagonal.nodes.size()));
  std::vector<PetscInt> nodes;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    nodes.clear();
    for (const auto* part : {&diagonal, &off_diagonal}) {
      for (PetscInt k = part->offsets[n]; k < part->offsets[n + 1]; ++k) {
        nodes.push_back(pattern.global_node(part->nodes[k]));
      }
    }
    std::sort(nodes.begin(), nodes.end());
    for (int i = 0; i < 3; ++i) {
      for (const PetscInt m : nodes) {
        for (int j = 0; j < 3; ++j) columns.push_back(3 * m + j);
      }
      offsets[3 * n + i + 1] = static_cast<PetscInt>(columns.size());
    }
  }
  Handle<Mat> matrix;
  check(MatCreate(layout.comm, matrix.out()));
  check(MatSetSizes(matrix.get(), num_rows, num_rows, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix.get(), MATMPIAIJ));
  check(MatSetBlockSize(matrix.get(), 3));
  check(MatMPIAIJSetPreallocationCSR(matrix.get(), offsets.data(), columns.data(), nullptr));
  check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
  check(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  check(MatSetOption(matrix.get(), MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  return matrix;
}

std::vector<Handle<Vec>> rigid_body_modes(const NodeLayout& layout, std::span<const char> prescribed,
                                          std::span<const double> displacements) {
  std::vector<Handle<Vec>> modes(6);
  for (int m = 0; m < 6; ++m) {
    check(VecCreateMPI(layout.comm, 3 * layout.num_owned_nodes, PETSC_DETERMINE, modes[m].out()));
    const ArrayView mode(modes[m].get());
    for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
      auto x = layout.position(a);
      for (std::size_t i = 0; i < 3 && !displacements.empty(); ++i)
        x[i] += displacements[3 * static_cast<std::size_t>(a) + i];
      std::array<double, 3> u{};
      if (m < 3) {
        u[m] = 1.0;
      } else {
        const int i = m - 3, j = (i + 1) % 3, k = (i + 2) % 3;
        u[j] = -x[k];
        u[k] = x[j];
      }
      for (int i = 0; i < 3; ++i) mode[3 * a + i] = prescribed[3 * a + i] ? 0.0 : u[i];
    }
  }
  return modes;
}

BlockWriter::BlockWriter(const BlockPattern& pattern, Mat matrix)
    : pattern_(pattern),
      matrix_(matrix),
      diagonal_offsets_(pattern.diagonal().offsets.data()),
      off_diagonal_offsets_(pattern.off_diagonal().offsets.data()),
      diagonal_size_(9 * pattern.diagonal().nodes.size()),
      off_diagonal_size_(9 * pattern.off_diagonal().nodes.size()) {
  check(MatMPIAIJGetSeqAIJ(matrix_, &diagonal_matrix_, &off_diagonal_matrix_, nullptr));
  check(MatSeqAIJGetArray(diagonal_matrix_, &diagonal_));
  check(MatSeqAIJGetArray(off_diagonal_matrix_, &off_diagonal_));
}

BlockWriter::~BlockWriter() {
  if (diagonal_ == nullptr) return;
  (void)MatSeqAIJRestoreArray(diagonal_matrix_, &diagonal_);
  (void)MatSeqAIJRestoreArray(off_diagonal_matrix_, &off_diagonal_);
}

void BlockWriter::finish() {
  check(MatSeqAIJRestoreArray(diagonal_matrix_, &diagonal_));
  check(MatSeqAIJRestoreArray(off_diagonal_matrix_, &off_diagonal_));
  diagonal_ = off_diagonal_ = nullptr;
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
}

void BlockWriter::zero() {
  std::fill_n(diagonal_, diagonal_size_, 0.0);
  std::fill_n(off_diagonal_, off_diagonal_size_, 0.0);
}

void BlockWriter::add(PetscInt row_node, PetscInt column_node, std::span<const double, 9> block) const {
  if (row_node >= pattern_.num_owned_nodes()) return;
  const auto [values, stride] = this->block(row_node, pattern_.block(row_node, column_node));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) values[i * stride + j] += block[3 * i + j];
  }
}

void BlockWriter::add(const BlockPattern& pattern, Mat matrix) const {
  const BlockWriter from(pattern, matrix);
  const auto add_part = [&](const BlockPattern::Rows& blocks, const BlockPattern::Rows& among, bool is_diagonal) {
    const auto numbered = [is_diagonal](PetscInt k) { return static_cast<std::int32_t>(is_diagonal ? k : -1 - k); };
    for (PetscInt n = 0; n < pattern.num_owned_nodes(); ++n) {
      PetscInt place = among.offsets[n];
      for (PetscInt k = blocks.offsets[n]; k < blocks.offsets[n + 1]; ++k) {
        while (among.nodes[place] != blocks.nodes[k]) ++place;  // both ascend
        const Block source = from.block(n, numbered(k)), target = block(n, numbered(place));
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) target.values[i * target.stride + j] += source.values[i * source.stride + j];
        }
      }
    }
  };
  add_part(pattern.diagonal(), pattern_.diagonal(), true);
  add_part(pattern.off_diagonal(), pattern_.off_diagonal(), false);
}

void BlockWriter::copy_diagonal(std::span<double> diagonal) const {
  const auto own = pattern_.own_blocks();
  for (std::size_t n = 0; n < own.size(); ++n) {
    const auto [values, stride] = block(static_cast<PetscInt>(n), own[n]);
    for (int i = 0; i < 3; ++i) diagonal[3 * n + i] = values[i * stride + i];
  }
}

RowElimination::RowElimination(const NodeLayout& layout, const BlockPattern& pattern,
                               std::span<const char> is_prescribed) {
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    for (const auto* part : {&pattern.diagonal(), &pattern.off_diagonal()}) {
      const bool owned_columns = part == &pattern.diagonal();
      for (PetscInt k = part->offsets[n]; k < part->offsets[n + 1]; ++k) {
        const PetscInt m = part->nodes[k];
        std::uint16_t mask = 0;
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            if (is_prescribed[3 * n + i] || is_prescribed[3 * m + j]) mask |= 1u << (3 * i + j);
          }
        }
        if (mask != 0) entries_.push_back({n, static_cast<std::int32_t>(owned_columns ? k : -1 - k), mask, m == n});
      }
    }
  }
}

void RowElimination::apply(const BlockWriter& writer, double diagonal) const {
  for (const Entry& e : entries_) {
    const auto [values, stride] = writer.block(e.node, e.block);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if ((e.mask >> (3 * i + j) & 1u) == 0) continue;
        // On a diagonal block, entry (i, i) is masked only when i itself is prescribed.
        values[i * stride + j] = e.on_diagonal && i == j ? diagonal : 0.0;
      }
    }
  }
}

}  // namespace pliant
