/// Where a path of equilibria ends (`time.path`).
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "run/ledger.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace pliant {

struct StepRecord;
class HistoryRow;

/// Compares the numbers of a state with the conditions of the input under which a path ends.
class PathEnd {
 public:
  /// Throws InputError if the history has no column of the name that a condition gives. `model` outlives the object.
  /// Collective.
  PathEnd(const Config& config, Model& model, const Ledger& ledger);
  ~PathEnd();

  /// Why the path ends at this state, in plain words; empty if it continues. `is_at_end`: by its load factor.
  /// Collective.
  std::string reason(const StepRecord& record, const Ledger& ledger, bool is_at_end);

 private:
  PathConfig path_;
  std::unique_ptr<HistoryRow> row_;   // nullptr without conditions on columns
  std::vector<std::size_t> columns_;  // of the conditions
};

}  // namespace pliant
