#include "petsc/global_order.hpp"
#include "petsc/session.hpp"

#include <gtest/gtest.h>

namespace pliant::test_global_order {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

/// What is sorted is known: key k of 0 .. num_keys-1 is the k-th. Rank r has those with k % (r + 2) == 0, backwards,
/// and rank 0 has them all besides.
constexpr std::int64_t num_keys = 97;

EntryKey key(std::int64_t k) {
  return {3 * (k / 2), k % 2 == 0 ? -5 : 7};
}

std::vector<std::int64_t> keys_here() {
  std::vector<std::int64_t> result;
  const int r = rank(comm);
  for (std::int64_t k = num_keys; k-- > 0;) {
    if (r == 0 || k % (r + 2) == 0) result.push_back(k);
  }
  return result;
}

GlobalOrder order_of(const std::vector<std::int64_t>& numbers) {
  std::vector<EntryKey> keys;
  for (const auto k : numbers) keys.push_back(key(k));
  return {comm, keys};
}

TEST(GlobalOrder, RowsAreInTheOrderOfTheKeys) {
  const auto numbers = keys_here();
  const GlobalOrder order = order_of(numbers);
  EXPECT_EQ(order.num_global(), num_keys);
  EXPECT_EQ(order.row_of_entry(), numbers);
}

TEST(GlobalOrder, ValuesGoToTheirRowsAndBack) {
  const auto numbers = keys_here();
  const GlobalOrder order = order_of(numbers);
  std::vector<double> values;
  for (const auto k : numbers) values.insert(values.end(), {0.5 * static_cast<double>(k), -static_cast<double>(k)});
  const auto rows = order.rows(values, 2);
  ASSERT_EQ(std::ssize(rows), 2 * order.num_rows());
  for (std::int64_t i = 0; i < order.num_rows(); ++i) {
    const auto k = static_cast<double>(order.first_row() + i);
    EXPECT_EQ(rows[2 * static_cast<std::size_t>(i)], 0.5 * k);
    EXPECT_EQ(rows[2 * static_cast<std::size_t>(i) + 1], -k);
  }
  EXPECT_EQ(order.entries(rows, 2), values);
}

TEST(GlobalOrder, RanksMayHaveNothing) {
  const std::vector<EntryKey> keys(rank(comm) == 0 ? 0 : 1, EntryKey{4, 4});
  const GlobalOrder order(comm, keys);
  EXPECT_EQ(order.num_global(), num_ranks(comm) > 1 ? 1 : 0);
  EXPECT_EQ(order.entries(order.rows(std::vector<double>(keys.size(), 2.5), 1), 1),
            std::vector<double>(keys.size(), 2.5));
}

}  // namespace
}  // namespace pliant::test_global_order
