#include "petsc/global_order.hpp"

#include "petsc/check.hpp"
#include "petsc/exchange.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace pliant {
GlobalOrder::GlobalOrder(MPI_Comm comm, std::span<const EntryKey> keys) : comm_(comm), sent_(keys.size()) {
  const auto num_ranks_here = static_cast<std::size_t>(num_ranks(comm));
  std::int64_t largest = -1;
  for (const auto& key : keys) {
    assert(key.first >= 0);
    largest = std::max(largest, key.first);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_INT64_T, MPI_MAX, comm));
  // Keys with the same first part meet on one rank; the first parts are spread evenly.
  const std::int64_t width = std::max<std::int64_t>(largest, 0) / static_cast<std::int64_t>(num_ranks_here) + 1;
  std::iota(sent_.begin(), sent_.end(), std::size_t{0});
  std::ranges::stable_sort(sent_, {}, [&](std::size_t entry) { return keys[entry].first / width; });
  num_sent_.assign(num_ranks_here, 0);
  std::vector<EntryKey> out;
  out.reserve(keys.size());
  for (const std::size_t entry : sent_) {
    ++num_sent_[static_cast<std::size_t>(keys[entry].first / width)];
    out.push_back(keys[entry]);
  }
  num_received_ = exchanged_counts(comm, num_sent_);
  const std::vector<EntryKey> mine = exchanged(comm, out, num_sent_, num_received_);
  std::vector<EntryKey> distinct = mine;
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  num_rows_ = std::ssize(distinct);
  check_mpi(MPI_Allreduce(&num_rows_, &num_global_, 1, MPI_INT64_T, MPI_SUM, comm));
  check_mpi(MPI_Exscan(&num_rows_, &first_row_, 1, MPI_INT64_T, MPI_SUM, comm));
  if (rank(comm) == 0) first_row_ = 0;  // MPI_Exscan leaves it undefined there
  received_.reserve(mine.size());
  std::vector<std::int64_t> answers;
  answers.reserve(mine.size());
  for (const auto& key : mine) {
    received_.push_back(std::ranges::lower_bound(distinct, key) - distinct.begin());
    answers.push_back(first_row_ + received_.back());
  }
  const auto rows = exchanged(comm, answers, num_received_, num_sent_);
  row_of_entry_.resize(keys.size());
  for (std::size_t i = 0; i < sent_.size(); ++i) row_of_entry_[sent_[i]] = rows[i];
}

std::vector<double> GlobalOrder::rows(std::span<const double> values, int components) const {
  const auto size = static_cast<std::size_t>(components);
  assert(values.size() == size * sent_.size());
  std::vector<double> out;
  out.reserve(values.size());
  for (const std::size_t entry : sent_) {
    const auto part = values.subspan(size * entry, size);
    out.insert(out.end(), part.begin(), part.end());
  }
  const auto in = exchanged(comm_, out, num_sent_, num_received_, size);
  std::vector<double> result(size * static_cast<std::size_t>(num_rows_));
  for (std::size_t i = 0; i < received_.size(); ++i) {
    std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(size * i), size,
                result.begin() + static_cast<std::ptrdiff_t>(size) * received_[i]);
  }
  return result;
}

std::vector<double> GlobalOrder::entries(std::span<const double> rows, int components) const {
  const auto size = static_cast<std::size_t>(components);
  assert(rows.size() == size * static_cast<std::size_t>(num_rows_));
  std::vector<double> out;
  out.reserve(size * received_.size());
  for (const std::int64_t row : received_) {
    const auto part = rows.subspan(size * static_cast<std::size_t>(row), size);
    out.insert(out.end(), part.begin(), part.end());
  }
  const auto in = exchanged(comm_, out, num_received_, num_sent_, size);
  std::vector<double> result(size * sent_.size());
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(size * i), size,
                result.begin() + static_cast<std::ptrdiff_t>(size * sent_[i]));
  }
  return result;
}

}  // namespace pliant
