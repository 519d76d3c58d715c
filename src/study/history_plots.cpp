#include "study/history_plots.hpp"

#include "base/file.hpp"
#include "io/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace pliant {
namespace {

constexpr std::array<std::string_view, 5> bookkeeping{"step", "time", "dt", "newton_iterations", "linear_iterations"};

}  // namespace

std::vector<std::string> columns_of(std::span<const LabelledHistory> histories) {
  std::vector<std::string> names;
  for (const LabelledHistory& history : histories) {
    for (const std::string& name : history.table.names) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

bool is_bookkeeping(const std::string& column) {
  return std::ranges::find(bookkeeping, column) != bookkeeping.end();
}

std::string file_name_of(std::string text) {
  constexpr std::size_t longest = 100;
  for (char& c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && std::string_view("._=+-,").find(c) == std::string::npos) {
      c = '_';
    }
  }
  return text.substr(0, longest);
}

bool draw_column(std::span<const LabelledHistory> histories, const std::string& column,
                 const std::filesystem::path& directory) {
  Plot plot;
  plot.title = column;
  plot.x_label = axis_label(histories);
  plot.y_label = with_unit(histories, column);
  plot.scale = Scale::linear;
  bool varies = false;
  for (const LabelledHistory& history : histories) {
    const HistoryTable& table = history.table;
    const auto *time = table.find("time"), *values = table.find(column);
    if (time == nullptr || values == nullptr || values->empty()) continue;
    const auto [low, high] = std::ranges::minmax(*values);
    varies = varies || high > low;
    plot.series.push_back({history.label, *time, *values});
  }
  if (varies) write_text_atomically(directory / (file_name_of(column) + ".svg"), svg(plot));
  return varies;
}

}  // namespace pliant
