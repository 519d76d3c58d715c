#include "multigrid/prolongation.hpp"

#include "petsc/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {
namespace {

/// A mode of an aggregate of which the earlier ones leave less than this part is a combination of them.
constexpr double dependent = 1e-8;

/// The nodes of each aggregate.
std::vector<std::vector<int>> members(const Aggregates& aggregates) {
  std::vector<std::vector<int>> nodes(static_cast<std::size_t>(aggregates.number));
  for (std::size_t i = 0; i < aggregates.of_node.size(); ++i) {
    if (aggregates.of_node[i] >= 0)
      nodes[static_cast<std::size_t>(aggregates.of_node[i])].push_back(static_cast<int>(i));
  }
  return nodes;
}

/// The scalar product of two columns of the modes over some nodes.
double product(const Modes& modes, std::span<const int> nodes, int a, int b) {
  double sum = 0.0;
  for (const int node : nodes) {
    const double* const block = modes.block(node);
    for (int r = 0; r < modes.height; ++r) sum += block[a * modes.height + r] * block[b * modes.height + r];
  }
  return sum;
}

void subtract(Modes& modes, std::span<const int> nodes, int from, int column, double times) {
  for (const int node : nodes) {
    double* const block = modes.block(node);
    for (int r = 0; r < modes.height; ++r) block[from * modes.height + r] -= times * block[column * modes.height + r];
  }
}

void scale(Modes& modes, std::span<const int> nodes, int column, double by) {
  for (const int node : nodes) {
    double* const block = modes.block(node);
    for (int r = 0; r < modes.height; ++r) block[column * modes.height + r] *= by;
  }
}

/// The rows of a prolongation as they are computed.
class RowBuilder {
 public:
  RowBuilder(int height, int width) { rows_.blocks.height = height, rows_.blocks.width = width; }

  /// The block of the current row in a column, zero at first.
  double* block(PetscInt column) {
    const auto k = static_cast<std::size_t>(std::ranges::find(columns_, column) - columns_.begin());
    const std::size_t size = rows_.blocks.block_size();
    if (k == columns_.size()) {
      columns_.push_back(column);
      sums_.resize(columns_.size() * size);
    }
    return sums_.data() + k * size;
  }
  void finish_row() {
    rows_.columns.insert(rows_.columns.end(), columns_.begin(), columns_.end());
    rows_.blocks.values.insert(rows_.blocks.values.end(), sums_.begin(), sums_.end());
    rows_.blocks.offsets.push_back(static_cast<int>(rows_.columns.size()));
    columns_.clear();
    sums_.clear();
  }
  ProlongationRows take() { return std::move(rows_); }

 private:
  ProlongationRows rows_;
  std::vector<PetscInt> columns_;
  std::vector<double> sums_;
};

/// Adds the rows of the ghosts, which their owners send.
void fetch_rows(ProlongationRows& rows, const Halo& halo) {
  std::vector<int> lengths(static_cast<std::size_t>(halo.num_local()));
  for (int i = 0; i < halo.num_owned(); ++i) {
    lengths[static_cast<std::size_t>(i)] = static_cast<int>(rows.blocks.end(i) - rows.blocks.begin(i));
  }
  halo.fetch(std::span(lengths), 1);
  const std::size_t size = rows.blocks.block_size();
  std::vector<PetscInt> columns;
  std::vector<float> values;
  std::vector<int> counts;
  for (const std::vector<int>& nodes : halo.wanted()) {
    const std::size_t before = columns.size();
    for (const int node : nodes) {
      const std::size_t begin = rows.blocks.begin(node), end = rows.blocks.end(node);
      columns.insert(columns.end(), &rows.columns[begin], &rows.columns[begin] + (end - begin));
      values.insert(values.end(), rows.blocks.block(begin), rows.blocks.block(end));
    }
    counts.push_back(static_cast<int>(columns.size() - before));
  }
  const std::vector<int> num_in = exchanged_counts(halo.comm(), counts);
  const std::vector<PetscInt> received = exchanged(halo.comm(), columns, counts, num_in);
  const std::vector<float> blocks = exchanged(halo.comm(), values, counts, num_in, size);
  rows.columns.insert(rows.columns.end(), received.begin(), received.end());
  rows.blocks.values.insert(rows.blocks.values.end(), blocks.begin(), blocks.end());
  for (int i = halo.num_owned(); i < halo.num_local(); ++i) {
    rows.blocks.offsets.push_back(rows.blocks.offsets.back() + lengths[static_cast<std::size_t>(i)]);
  }
}

}  // namespace

Modes orthonormalise(const Aggregates& aggregates, Modes& modes) {
  constexpr int n = Modes::number;
  Modes coarse{.height = n, .values = std::vector<double>(static_cast<std::size_t>(aggregates.number) * n * n)};
  const std::vector<std::vector<int>> nodes_of = members(aggregates);
  for (int a = 0; a < aggregates.number; ++a) {
    const std::vector<int>& nodes = nodes_of[static_cast<std::size_t>(a)];
    double* const R = coarse.block(a);
    for (int m = 0; m < n; ++m) {
      const double before = std::sqrt(product(modes, nodes, m, m));
      for (int k = 0; k < m; ++k) {
        R[m * n + k] = product(modes, nodes, k, m);
        subtract(modes, nodes, m, k, R[m * n + k]);
      }
      const double left = std::sqrt(product(modes, nodes, m, m));
      const bool is_independent = left > dependent * before;
      R[m * n + m] = is_independent ? left : 0.0;
      scale(modes, nodes, m, is_independent ? 1.0 / left : 0.0);
    }
  }
  return coarse;
}

ProlongationRows given_prolongation(Mat P, const Halo& fine) {
  RowBuilder rows(3, 3);
  PetscInt begin = 0, num_columns = 0;
  check(MatGetOwnershipRange(P, &begin, nullptr));
  check(MatGetLocalSize(P, nullptr, &num_columns));
  for (int i = 0; i < fine.num_owned(); ++i) {
    for (int r = 0; r < 3; ++r) {
      PetscInt count = 0;
      const PetscInt* columns = nullptr;
      const PetscScalar* values = nullptr;
      check(MatGetRow(P, begin + 3 * i + r, &count, &columns, &values));
      for (PetscInt k = 0; k < count; ++k) rows.block(columns[k] / 3)[3 * (columns[k] % 3) + r] = values[k];
      check(MatRestoreRow(P, begin + 3 * i + r, &count, &columns, &values));
    }
    rows.finish_row();
  }
  ProlongationRows all = rows.take();
  all.num_own_columns = static_cast<int>(num_columns / 3);
  fetch_rows(all, fine);
  return all;
}

Modes injected(const Modes& fine, const ProlongationRows& rows, PetscInt first_coarse) {
  Modes coarse;
  coarse.values.resize(static_cast<std::size_t>(rows.num_own_columns) * coarse.block_size());
  const auto num_own = static_cast<int>(fine.values.size() / fine.block_size());
  for (int i = 0; i < num_own; ++i) {
    const std::size_t k = rows.blocks.begin(i);
    const bool is_coarse_too = rows.blocks.end(i) == k + 1 && rows.blocks.block(k)[0] == 1.0F;
    if (is_coarse_too) {
      std::copy_n(fine.block(i), fine.block_size(), coarse.block(static_cast<int>(rows.columns[k] - first_coarse)));
    }
  }
  return coarse;
}

ProlongationRows smoothed_prolongation(const BlockCsr& A, const Halo& halo, std::span<const float> D, double largest,
                                       const Aggregates& aggregates, const Modes& orthonormal) {
  const int h = A.height;
  std::vector<PetscInt> coarse(static_cast<std::size_t>(halo.num_local()), -1);
  PetscInt first = 0;
  const PetscInt number = aggregates.number;
  check_mpi(MPI_Exscan(&number, &first, 1, MPIU_INT, MPI_SUM, halo.comm()));
  for (std::size_t i = 0; i < aggregates.of_node.size(); ++i) {
    if (aggregates.of_node[i] >= 0) coarse[i] = first + aggregates.of_node[i];
  }
  halo.fetch(std::span(coarse), 1);
  Modes T = orthonormal;
  T.values.resize(static_cast<std::size_t>(halo.num_local()) * T.block_size());
  halo.fetch(std::span(T.values), static_cast<int>(T.block_size()));

  const double omega = 4.0 / (3.0 * largest);
  RowBuilder rows(h, Modes::number);
  std::vector<double> AT(T.block_size());
  for (int i = 0; i < halo.num_owned(); ++i) {
    const PetscInt own = coarse[static_cast<std::size_t>(i)];
    if (own < 0) {
      rows.finish_row();
      continue;
    }
    double* const start = rows.block(own);
    std::copy_n(T.block(i), T.block_size(), start);
    for (std::size_t k = A.begin(i); k < A.end(i); ++k) {
      const int j = A.columns[k];
      if (coarse[static_cast<std::size_t>(j)] < 0) continue;
      const float* const block = A.block(k);
      const double* const modes = T.block(j);
      std::ranges::fill(AT, 0.0);
      for (int m = 0; m < Modes::number; ++m) {
        for (int c = 0; c < h; ++c) {
          for (int r = 0; r < h; ++r) AT[static_cast<std::size_t>(m * h + r)] += block[c * h + r] * modes[m * h + c];
        }
      }
      double* const sum = rows.block(coarse[static_cast<std::size_t>(j)]);
      const float* const inverse = &D[static_cast<std::size_t>(i) * A.block_size()];
      for (int m = 0; m < Modes::number; ++m) {
        for (int c = 0; c < h; ++c) {
          for (int r = 0; r < h; ++r)
            sum[m * h + r] -= omega * inverse[c * h + r] * AT[static_cast<std::size_t>(m * h + c)];
        }
      }
    }
    rows.finish_row();
  }
  ProlongationRows all = rows.take();
  all.num_own_columns = aggregates.number;
  fetch_rows(all, halo);
  return all;
}

}  // namespace pliant
