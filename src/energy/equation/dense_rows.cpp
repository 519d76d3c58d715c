#include "energy/equation/dense_rows.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace pliant {

DenseRows::DenseRows(RowsOfColumns of, Mat W, Mat B, Mat K) : of_(std::move(of)) {
  {
    PetscInt first = 0, last = 0;
    check(MatGetOwnershipRangeColumn(W, &first, &last));
    const MatrixRows own(W, 0), others(W, 1);
    for (const PetscInt row : of_.rows) {
      for (const PetscInt column : of_.columns) {
        const bool is_own = column >= first && column < last;
        of_W_.push_back({is_own ? std::size_t{0} : std::size_t{1}, (is_own ? own : others).entry(row, column)});
      }
    }
  }
  find_columns(B);
  find_targets(K);
  const auto num_rows = static_cast<Eigen::Index>(of_.rows.size());
  W_.setZero(static_cast<Eigen::Index>(of_.columns.size()), num_rows);
  B_.setZero(num_rows, num_dense_);
}

// Columns are dense if at least every second row has them.
void DenseRows::find_columns(Mat B) {
  const MatrixRows own(B, 0), others(B, 1);
  const std::array parts{&own, &others};
  const auto for_each_entry = [&](const auto& visit) {
    for (std::size_t r = 0; r < of_.rows.size(); ++r) {
      for (std::size_t part = 0; part < 2; ++part) {
        for (PetscInt k = parts[part]->begin(of_.rows[r]); k < parts[part]->end(of_.rows[r]); ++k) {
          visit(r, Place{part, k}, parts[part]->column(k));
        }
      }
    }
  };
  std::map<PetscInt, std::size_t> number_of_rows;  // of each column
  for_each_entry([&](std::size_t, const Place&, PetscInt column) { ++number_of_rows[column]; });
  for (const bool is_dense : {true, false}) {
    for (const auto& [column, number] : number_of_rows) {
      if ((2 * number >= of_.rows.size()) == is_dense) columns_.push_back(column);
    }
    if (is_dense) num_dense_ = static_cast<Eigen::Index>(columns_.size());
  }
  std::map<PetscInt, Eigen::Index> place_of;
  for (std::size_t c = 0; c < columns_.size(); ++c) place_of[columns_[c]] = static_cast<Eigen::Index>(c);
  of_B_.resize(of_.rows.size() * static_cast<std::size_t>(num_dense_));
  for_each_entry([&](std::size_t r, const Place& from, PetscInt column) {
    const Eigen::Index c = place_of[column];
    if (c < num_dense_) {
      of_B_[r * static_cast<std::size_t>(num_dense_) + static_cast<std::size_t>(c)] = from;
    } else {
      sparse_.push_back({from, static_cast<Eigen::Index>(r), c});
    }
  });
}

void DenseRows::find_targets(Mat K) {
  if (columns_.empty()) return;
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(K, &first, &last));
  const MatrixRows own(K, 0), others(K, 1);
  for (std::size_t h = 0; h < of_.columns.size(); ++h) {
    const PetscInt row = of_.columns[h] - first;
    if (row < 0 || of_.columns[h] >= last) {
      far_.push_back(static_cast<Eigen::Index>(h));
      continue;
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const bool is_own = columns_[c] >= first && columns_[c] < last;
      const std::size_t part = is_own ? 0 : 1;
      const PetscInt to = (is_own ? own : others).entry(row, columns_[c]), from = static_cast<PetscInt>(c);
      const auto continues = [&](const Run& run) {
        return run.part == part && run.row == static_cast<Eigen::Index>(h) &&
               run.entries.from + run.entries.count == from && run.entries.to + run.entries.count == to;
      };
      if (runs_.empty() || !continues(runs_.back()))
        runs_.push_back({part, static_cast<Eigen::Index>(h), {from, to, 0}});
      ++runs_.back().entries.count;
    }
  }
}

void DenseRows::add(const MatrixValues& W, const MatrixValues& B, const MatrixValues& K) {
  for (std::size_t k = 0; k < of_W_.size(); ++k) W_.data()[k] = W[of_W_[k].part][of_W_[k].entry];
  auto place = of_B_.begin();
  for (Eigen::Index r = 0; r < B_.rows(); ++r) {
    for (Eigen::Index c = 0; c < num_dense_; ++c, ++place) {
      if (place->entry >= 0) B_(r, c) = B[place->part][place->entry];
    }
  }
  product_.setZero(W_.rows(), static_cast<Eigen::Index>(columns_.size()));
  product_.leftCols(num_dense_).noalias() = W_ * B_;
  for (const auto& [from, row, column] : sparse_) product_.col(column) += B[from.part][from.entry] * W_.col(row);
  for (const auto& [part, row, entries] : runs_) {
    for (PetscInt k = 0; k < entries.count; ++k) K[part][entries.to + k] += product_(row, entries.from + k);
  }
}

void DenseRows::add_far(Mat K) const {
  const auto num_columns = static_cast<PetscInt>(columns_.size());
  for (const Eigen::Index h : far_) {
    const Eigen::VectorXd values = product_.row(h);
    const PetscInt row = of_.columns[static_cast<std::size_t>(h)];
    check(MatSetValues(K, 1, &row, num_columns, columns_.data(), values.data(), ADD_VALUES));
  }
}

}  // namespace pliant
