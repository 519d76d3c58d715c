#include "run/path_end.hpp"

#include "base/text.hpp"
#include "run/history_row.hpp"
#include "run/simulation.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {

PathEnd::PathEnd(const Config& config, Model& model, const Ledger& ledger) : path_(*config.time.path) {
  if (path_.stop.empty()) return;
  row_ = std::make_unique<HistoryRow>(config, model, ledger);
  const auto& names = row_->columns();
  for (const PathStopConfig& stop : path_.stop) {
    const auto column = std::ranges::find(names, stop.column);
    if (column == names.end()) {
      throw InputError(stop.where, fmt::format("history.csv has no column '{}'{}; it has {}", stop.column,
                                               did_you_mean(stop.column, names), fmt::join(names, ", ")));
    }
    columns_.push_back(static_cast<std::size_t>(column - names.begin()));
  }
}

PathEnd::~PathEnd() = default;

std::string PathEnd::reason(const StepRecord& record, const Ledger& ledger, bool is_at_end) {
  if (record.step == 0) return {};
  if (is_at_end) return fmt::format("the load factor is {:.6g}", record.load_factor);
  if (row_) {
    const std::vector<double> values = row_->values(record, ledger);
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const PathStopConfig& stop = path_.stop[k];
      const double value = values[columns_[k]];
      const bool is_reached = (stop.above && value >= *stop.above) || (stop.below && value <= *stop.below);
      if (is_reached) return fmt::format("{} is {:.6g}", stop.column, value);
    }
  }
  if (record.step >= path_.max_steps) {
    return fmt::format("it has taken {} steps, as many as 'max_steps' allows", record.step);
  }
  return {};
}

}  // namespace pliant
