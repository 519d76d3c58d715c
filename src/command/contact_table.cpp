#include "command/contact_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

using Cells = std::array<std::string, 10>;

std::string gap_text(const StartGap& start) {
  return std::isfinite(start.gap) ? fmt::format("{:.3g}", start.gap) : "none near";
}

Cells cells_of(const ContactRow& row, std::string name, std::string between, std::string facets) {
  return {std::move(name),
          std::move(between),
          std::move(facets),
          row.law.kind == NormalKind::barrier ? "barrier" : "penalty",
          fmt::format("{:.3g}", row.law.stiffness),
          fmt::format("{:.3g}", row.law.width),
          fmt::format("{:.3g}", row.law.threshold),
          row.friction > 0.0 ? fmt::format("{:g}", row.friction) : "-",
          gap_text(row.start),
          std::isfinite(row.start.gap) ? place_text(row.start.place) : std::string()};
}

/// Rows under their headings, each column as wide as it needs to be.
void append_table(std::vector<Cells> rows, Cells headings, std::vector<std::string>& lines) {
  rows.insert(rows.begin(), std::move(headings));
  std::array<std::size_t, std::tuple_size_v<Cells>> widths{};
  for (const Cells& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) line += fmt::format("  {:<{}}", row[k], widths[k]);
    line.erase(line.find_last_not_of(' ') + 1);
    lines.push_back(std::move(line));
  }
}

Cells headings(std::string name, std::string between, std::string threshold) {
  return {
      std::move(name), std::move(between),     "facets", "law", "stiffness [Pa/m]", "width [m]", std::move(threshold),
      "friction",      "gap at the start [m]", "at [m]"};
}

}  // namespace

std::vector<std::string> contact_table(const ContactSummary& summary) {
  std::vector<std::string> lines;
  std::vector<Cells> rows;
  for (std::size_t k = 0; k < summary.pairs.size(); ++k) {
    const ContactRow& row = summary.pairs[k];
    const std::string facets = row.second.empty()
                                   ? fmt::format("{:.0f}", row.num_facets)
                                   : fmt::format("{:.0f} and {:.0f}", row.num_facets, row.num_other_facets);
    rows.push_back(cells_of(row, row.name.empty() ? fmt::format("{}", k) : row.name,
                            row.first + " with " + (row.second.empty() ? "itself" : row.second), facets));
  }
  if (!rows.empty() || summary.num_far_pairs > 0) lines.emplace_back("contact pairs");
  if (!rows.empty()) append_table(std::move(rows), headings("pair", "between", "thickness [m]"), lines);
  if (summary.num_far_pairs > 0) {
    lines.push_back(fmt::format("  {} {}{} of bodies farther apart than {:.3g} m", summary.num_far_pairs,
                                summary.pairs.empty() ? "" : "more ", summary.num_far_pairs == 1 ? "pair" : "pairs",
                                summary.far));
  }
  rows.clear();
  for (const ContactRow& row : summary.obstacles) {
    if (row.first.empty()) continue;
    rows.push_back(cells_of(row, row.name, row.first, fmt::format("{:.0f}", row.num_facets)));
  }
  if (rows.empty()) return lines;
  lines.emplace_back("obstacles");
  append_table(std::move(rows), headings("obstacle", "nearest body", "threshold [m]"), lines);
  return lines;
}

}  // namespace pliant
