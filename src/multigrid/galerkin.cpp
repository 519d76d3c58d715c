#include "multigrid/galerkin.hpp"

#include "petsc/exchange.hpp"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

/// A place in a matrix, by the numbers of its nodes through the ranks.
struct Place {
  PetscInt row = 0, column = 0;
};

void sort_unique(std::vector<PetscInt>& list) {
  std::ranges::sort(list);
  list.erase(std::ranges::unique(list).begin(), list.end());
}

/// Columns that a row of A P has, each once.
class ColumnSet {
 public:
  void clear() { list_.clear(); }
  void add(PetscInt column) {
    if (std::ranges::find(list_, column) == list_.end()) list_.push_back(column);
  }
  const std::vector<PetscInt>& list() const { return list_; }

 private:
  std::vector<PetscInt> list_;  // short
};

}  // namespace

GalerkinProduct::GalerkinProduct(const BlockCsr& A, const Halo& fine, ProlongationRows rows)
    : P_(std::move(rows.blocks)) {
  make_pattern(A, fine, rows.columns, rows.num_own_columns);
  P_.columns.reserve(rows.columns.size());
  for (const PetscInt column : rows.columns) P_.columns.push_back(coarse_.local(column));
  P_.values.resize(P_.values.size() + BlockCsr::padding);
  plan_exchange();
}

void GalerkinProduct::take(const ProlongationRows& rows) {
  std::ranges::copy(rows.blocks.values, P_.values.begin());
}

void GalerkinProduct::make_pattern(const BlockCsr& A, const Halo& fine, const std::vector<PetscInt>& columns,
                                   int num_own) {
  const auto of_row = [&](int row) { return std::span(columns).subspan(P_.begin(row), P_.end(row) - P_.begin(row)); };
  const Halo owners(fine.comm(), num_own, {});
  const auto is_own = [&](PetscInt node) { return owners.owns(node); };
  std::vector<std::vector<PetscInt>> lists(static_cast<std::size_t>(num_own));
  std::vector<std::vector<Place>> of_others(fine.wanted().size());
  ColumnSet of_product;
  for (int i = 0; i < fine.num_owned(); ++i) {
    of_product.clear();
    for (const int j : A.columns_of(i)) {
      for (const PetscInt column : of_row(j)) of_product.add(column);
    }
    for (const PetscInt row : of_row(i)) {
      if (is_own(row)) {
        std::vector<PetscInt>& list = lists[static_cast<std::size_t>(row - owners.first())];
        list.insert(list.end(), of_product.list().begin(), of_product.list().end());
        if (list.size() > 512) sort_unique(list);
      } else {
        std::vector<Place>& list = of_others[static_cast<std::size_t>(owners.owner(row))];
        for (const PetscInt column : of_product.list()) list.push_back({row, column});
      }
    }
  }
  const auto order = [](const Place& p) { return std::pair(p.row, p.column); };
  for (std::vector<Place>& list : of_others) {
    std::ranges::sort(list, {}, order);
    list.erase(std::ranges::unique(list, {}, order).begin(), list.end());
  }
  for (const Place& place : exchanged(fine.comm(), of_others)) {
    lists[static_cast<std::size_t>(place.row - owners.first())].push_back(place.column);
  }
  std::vector<PetscInt> ghosts;
  for (std::vector<PetscInt>& list : lists) {
    sort_unique(list);
    std::ranges::remove_copy_if(list, std::back_inserter(ghosts), is_own);
  }
  for (const std::vector<Place>& list : of_others) {
    for (const Place& place : list) {
      ghosts.push_back(place.row);
      if (!is_own(place.column)) ghosts.push_back(place.column);
    }
  }
  sort_unique(ghosts);
  coarse_ = Halo(fine.comm(), num_own, std::move(ghosts));

  std::vector<std::vector<int>> rows(static_cast<std::size_t>(coarse_.num_local()));
  for (std::size_t row = 0; row < lists.size(); ++row) {
    for (const PetscInt column : lists[row]) rows[row].push_back(coarse_.local(column));
  }
  for (const std::vector<Place>& list : of_others) {
    for (const Place& place : list) {
      rows[static_cast<std::size_t>(coarse_.local(place.row))].push_back(coarse_.local(place.column));
    }
  }
  offsets_ = {0};
  for (std::vector<int>& row : rows) {
    std::ranges::sort(row);
    columns_.insert(columns_.end(), row.begin(), row.end());
    offsets_.push_back(static_cast<int>(columns_.size()));
  }
}

void GalerkinProduct::plan_exchange() {
  std::vector<Place> sent;
  num_sent_.assign(coarse_.wanted().size(), 0);
  for (int row = coarse_.num_owned(); row < coarse_.num_local(); ++row) {
    const PetscInt global = coarse_.global(row);
    for (int k = offsets_[static_cast<std::size_t>(row)]; k < offsets_[static_cast<std::size_t>(row) + 1]; ++k) {
      sent.push_back({global, coarse_.global(columns_[static_cast<std::size_t>(k)])});
      ++num_sent_[static_cast<std::size_t>(coarse_.owner(global))];
    }
  }
  num_received_ = exchanged_counts(coarse_.comm(), num_sent_);
  for (const Place& place : exchanged(coarse_.comm(), sent, num_sent_, num_received_)) {
    received_.push_back(find(coarse_.local(place.row), coarse_.local(place.column)));
  }
}

std::size_t GalerkinProduct::find(int row, int column) const {
  const auto begin = columns_.begin() + offsets_[static_cast<std::size_t>(row)];
  const auto end = columns_.begin() + offsets_[static_cast<std::size_t>(row) + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, column) - columns_.begin());
}

BlockCsr GalerkinProduct::pattern() const {
  BlockCsr A(P_.width, P_.width);
  A.offsets.assign(offsets_.begin(), offsets_.begin() + coarse_.num_owned() + 1);
  A.columns.assign(columns_.begin(), columns_.begin() + A.offsets.back());
  return A;
}

void GalerkinProduct::read(int row, std::size_t k, double* block) const {
  const std::size_t at = static_cast<std::size_t>(offsets_[static_cast<std::size_t>(row)]) + k;
  std::copy_n(sums_.data() + at * block_size(), block_size(), block);
}

template <int height, int width>
void GalerkinProduct::add_products(const BlockCsr& A, const BlockSource& values) {
  constexpr std::size_t size = std::size_t{height} * width;
  std::vector<int> slot_of(static_cast<std::size_t>(coarse_.num_local()), -1);
  std::vector<int> columns;
  std::vector<double> AP;
  double a[height * height];
  for (int i = 0; i < A.num_rows(); ++i) {
    if (P_.begin(i) == P_.end(i)) continue;
    columns.clear();
    AP.clear();
    for (std::size_t k = A.begin(i); k < A.end(i); ++k) {
      const int j = A.columns[k];
      if (P_.begin(j) == P_.end(j)) continue;
      values.read(i, k - A.begin(i), a);
      for (std::size_t l = P_.begin(j); l < P_.end(j); ++l) {
        int& slot = slot_of[static_cast<std::size_t>(P_.columns[l])];
        if (slot < 0) {
          slot = static_cast<int>(columns.size());
          columns.push_back(P_.columns[l]);
          AP.resize(AP.size() + size);
        }
        double* const sum = AP.data() + static_cast<std::size_t>(slot) * size;
        const float* const p = P_.block(l);
        for (int m = 0; m < width; ++m) {
          for (int c = 0; c < height; ++c) {
            for (int r = 0; r < height; ++r) sum[m * height + r] += a[c * height + r] * p[m * height + c];
          }
        }
      }
    }
    for (std::size_t l = P_.begin(i); l < P_.end(i); ++l) {
      const float* const p = P_.block(l);
      for (std::size_t slot = 0; slot < columns.size(); ++slot) {
        double* const sum = sums_.data() + find(P_.columns[l], columns[slot]) * std::size_t{width} * width;
        const double* const right = AP.data() + slot * size;
        for (int m = 0; m < width; ++m) {
          for (int n = 0; n < width; ++n) {
            double dot = 0.0;
            for (int r = 0; r < height; ++r) dot += p[n * height + r] * right[m * height + r];
            sum[m * width + n] += dot;
          }
        }
      }
    }
    for (const int column : columns) slot_of[static_cast<std::size_t>(column)] = -1;
  }
}

void GalerkinProduct::compute(const BlockCsr& A, const BlockSource& values) {
  const std::size_t size = block_size();
  sums_.assign(columns_.size() * size, 0.0);
  if (A.height == 6) {
    add_products<6, 6>(A, values);
  } else {
    P_.width == 6 ? add_products<3, 6>(A, values) : add_products<3, 3>(A, values);
  }
  const std::size_t own = static_cast<std::size_t>(offsets_[static_cast<std::size_t>(coarse_.num_owned())]) * size;
  const std::vector<double> sent(sums_.begin() + static_cast<std::ptrdiff_t>(own), sums_.end());
  sums_.resize(own);
  const std::vector<double> parts = exchanged(coarse_.comm(), sent, num_sent_, num_received_, size);
  for (std::size_t k = 0; k < received_.size(); ++k) {
    for (std::size_t e = 0; e < size; ++e) sums_[received_[k] * size + e] += parts[k * size + e];
  }
  complete_diagonal();
}

// A mode that an aggregate lacks has no energy; a one keeps the matrix regular.
void GalerkinProduct::complete_diagonal() {
  for (int row = 0; row < coarse_.num_owned(); ++row) {
    double* const block = sums_.data() + find(row, row) * block_size();
    for (int m = 0; m < P_.width; ++m) {
      if (block[m * P_.width + m] == 0.0) block[m * P_.width + m] = 1.0;
    }
  }
}

}  // namespace pliant
