#include "mesh/report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr long long bar_length = 40;

void describe_groups(std::string& text, const std::vector<GroupReport>& groups) {
  constexpr std::array<const char*, 4> kinds{"point", "curve", "surface", "volume"};
  constexpr std::array<const char*, 4> members{"points", "edges", "facets", "cells"};
  constexpr std::array<const char*, 4> units{"", "m", "m^2", "m^3"};
  std::size_t width = 0;
  for (const auto& g : groups) width = std::max(width, g.name.size());
  for (int dimension = 3; dimension >= 0; --dimension) {
    const auto d = static_cast<std::size_t>(dimension);
    for (const auto& g : groups) {
      if (g.dimension != dimension || g.is_added) continue;
      text += fmt::format("  physical {:<8} {:<{}} (tag {}): {:>9} {:<6}", kinds[d], g.name, width, g.tag, g.count,
                          members[d]);
      if (dimension > 0) text += fmt::format("  {:.6g} {}", g.measure, units[d]);
      text += '\n';
    }
  }
}

void describe_quality(std::string& text, const MeshReport& report) {
  const auto& counts = report.quality_histogram;
  const long long most = std::max(1LL, *std::max_element(counts.begin(), counts.end()));
  text += fmt::format("  quality    worst {:.3g} (mean ratio: 1 regular, 0 flat)\n", report.min_quality);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    // Even a single tetrahedron shows as one mark.
    const long long length = (bar_length * counts[i] + most - 1) / most;
    text += fmt::format("    {:.1f}-{:.1f} {:>9}  {}\n", 0.1 * static_cast<double>(i), 0.1 * static_cast<double>(i + 1),
                        counts[i], std::string(static_cast<std::size_t>(length), '#'));
  }
}

void describe_ranks(std::string& text, const MeshReport& report) {
  const auto& cells = report.cells_per_rank;
  if (cells.size() < 2) return;
  const auto [fewest, most] = std::minmax_element(cells.begin(), cells.end());
  text += fmt::format("  ranks      {}, with {} to {} cells; {} facets between them before refinement\n", cells.size(),
                      *fewest, *most, report.edge_cut);
}

}  // namespace

std::string extent_text(const std::array<double, 6>& bounds) {
  std::array<double, 6> b = bounds;
  constexpr double rounding = 1e-12;
  const double size = std::hypot(b[3] - b[0], b[4] - b[1], b[5] - b[2]);
  for (double& x : b) x = std::abs(x) > rounding * size ? x : 0.0;
  return fmt::format("[{:.6g}, {:.6g}] x [{:.6g}, {:.6g}] x [{:.6g}, {:.6g}] m", b[0], b[3], b[1], b[4], b[2], b[5]);
}

std::string in_words(const ElementCounts& counts) {
  std::string text;
  const auto add = [&](long long count, const char* what) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(counts.tetrahedra, "tetrahedra");
  add(counts.triangles, "triangles of shells");
  add(counts.segments, "segments of rods");
  return text.empty() ? "rigid bodies alone" : text;
}

std::string describe(const MeshReport& report) {
  std::string text = fmt::format("  size       {}{}", in_words(report.elements),
                                 report.geometry_order == 2 ? " with curved edges" : "");
  const bool is_all_there_is = report.elements.tetrahedra == report.num_cells;
  if (is_all_there_is) text += fmt::format(", {} vertices, {} edges", report.num_vertices, report.num_edges);
  text += '\n';
  if (is_all_there_is) text += fmt::format("  extent     {}\n", extent_text(report.bounds));
  if (report.elements.tetrahedra > 0) {
    text += fmt::format("  volume     {:.6g} m^3{}\n", report.volume,
                        report.geometry_order == 2 ? " of the straight tetrahedra" : "");
    text += fmt::format("  edges      {:.3g} to {:.3g} m\n", report.min_edge, report.max_edge);
  }
  describe_groups(text, report.groups);
  if (report.elements.tetrahedra > 0) describe_quality(text, report);
  describe_ranks(text, report);
  for (const auto& notice : report.notices) text += "  note: " + notice + '\n';
  return text;
}

}  // namespace pliant
