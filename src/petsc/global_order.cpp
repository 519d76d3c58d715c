#include "petsc/global_order.hpp"

#include "petsc/check.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace pliant {
namespace {

std::vector<int> offsets_of(const std::vector<int>& counts) {
  std::vector<int> offsets(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, offsets.begin() + 1);
  return offsets;
}

/// Exchanges blocks of `width` numbers; the counts give the number of blocks to and from each rank.
template <class T>
std::vector<T> exchanged(MPI_Comm comm, const std::vector<T>& out, std::vector<int> num_out, std::vector<int> num_in,
                         int width) {
  static_assert(sizeof(T) == sizeof(double));
  for (auto* counts : {&num_out, &num_in}) {
    for (int& count : *counts) count *= width;
  }
  const std::vector<int> from = offsets_of(num_out), to = offsets_of(num_in);
  std::vector<T> in(static_cast<std::size_t>(to.back() + num_in.back()));
  check_mpi(MPI_Alltoallv(out.data(), num_out.data(), from.data(), MPI_INT64_T, in.data(), num_in.data(), to.data(),
                          MPI_INT64_T, comm));
  return in;
}

}  // namespace

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
  num_received_.assign(num_ranks_here, 0);
  std::vector<std::int64_t> out;
  out.reserve(2 * keys.size());
  for (const std::size_t entry : sent_) {
    ++num_sent_[static_cast<std::size_t>(keys[entry].first / width)];
    out.insert(out.end(), {keys[entry].first, keys[entry].second});
  }
  check_mpi(MPI_Alltoall(num_sent_.data(), 1, MPI_INT, num_received_.data(), 1, MPI_INT, comm));
  const auto in = exchanged(comm, out, num_sent_, num_received_, 2);

  std::vector<EntryKey> mine(in.size() / 2);
  for (std::size_t i = 0; i < mine.size(); ++i) mine[i] = {in[2 * i], in[2 * i + 1]};
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
  const auto rows = exchanged(comm, answers, num_received_, num_sent_, 1);
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
  const auto in = exchanged(comm_, out, num_sent_, num_received_, components);
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
  const auto in = exchanged(comm_, out, num_received_, num_sent_, components);
  std::vector<double> result(size * sent_.size());
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(size * i), size,
                result.begin() + static_cast<std::ptrdiff_t>(size * sent_[i]));
  }
  return result;
}

}  // namespace pliant
