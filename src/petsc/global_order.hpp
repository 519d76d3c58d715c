/// A global order of distributed entries that does not depend on how they are distributed.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// The identity of an entry, the same on whichever rank holds it.
struct EntryKey {
  std::int64_t first = 0;  ///< >= 0
  std::int64_t second = 0;
  auto operator<=>(const EntryKey&) const = default;
};

/// The distinct keys in ascending order, in rows 0, 1, ...; each rank holds a contiguous block of rows. Moves values
/// from the ranks that have the entries to the rows, and back.
class GlobalOrder {
 public:
  /// `keys`: the keys of this rank's entries; copies of one entry on several ranks have the same key. Collective.
  GlobalOrder(MPI_Comm comm, std::span<const EntryKey> keys);

  std::int64_t num_global() const { return num_global_; }
  std::int64_t first_row() const { return first_row_; }  ///< of this rank's block
  std::int64_t num_rows() const { return num_rows_; }    ///< in this rank's block
  /// The row of each entry.
  const std::vector<std::int64_t>& row_of_entry() const { return row_of_entry_; }

  /// `values`: `components` per entry. Returns the values of this rank's rows; if several entries have the same key,
  /// one of them counts. Collective.
  std::vector<double> rows(std::span<const double> values, int components) const;
  /// The inverse: the values of this rank's entries from those of the rows. Collective.
  std::vector<double> entries(std::span<const double> rows, int components) const;

 private:
  MPI_Comm comm_;
  std::int64_t num_global_ = 0, first_row_ = 0, num_rows_ = 0;
  std::vector<std::int64_t> row_of_entry_;
  std::vector<std::size_t> sent_;             // entries in the order in which they are sent
  std::vector<std::int64_t> received_;        // row within the block of each entry received
  std::vector<int> num_sent_, num_received_;  // entries to and from each rank
};

}  // namespace pliant
