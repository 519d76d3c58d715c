#include "io/svg_map.hpp"

#include "io/xdmf.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

struct Colour {
  double r, g, b;

  std::string text() const {
    return fmt::format("#{:02x}{:02x}{:02x}", std::lround(r), std::lround(g), std::lround(b));
  }
  bool is_dark() const { return 0.299 * r + 0.587 * g + 0.114 * b < 140.0; }
};

/// Viridis (van der Walt & Smith 2015), perceptually uniform, at 0, 1/8, ..., 1.
constexpr std::array<Colour, 9> viridis{{{68, 1, 84},
                                         {71, 45, 123},
                                         {59, 82, 139},
                                         {44, 114, 142},
                                         {33, 145, 140},
                                         {40, 174, 128},
                                         {94, 201, 98},
                                         {173, 220, 48},
                                         {253, 231, 37}}};
constexpr const char* no_value = "#d5d9df";
constexpr double bar_left = svg_frame::right + 40, bar_width = 20;

Colour viridis_at(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(viridis.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(at), viridis.size() - 2);
  const Colour &a = viridis[first], &b = viridis[first + 1];
  const double t = at - static_cast<double>(first);
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/// The same map with its values, and the units in its labels, as people write them. Logarithmic axes have powers of
/// ten.
ValueMap in_handy_units(ValueMap map) {
  const auto change = [](std::string& label, std::vector<double>& values) {
    const HandyLabel handy = handy_label(label, largest_magnitude(values));
    label = handy.label;
    for (double& value : values) value /= handy.factor;
  };
  if (map.x_scale == Scale::linear) change(map.x_label, map.x);
  if (map.y_scale == Scale::linear) change(map.y_label, map.y);
  change(map.value_label, map.values);
  return map;
}

struct MapPoint {
  double x, y;  // in axis coordinates
  double value;
};

std::vector<MapPoint> points_of(const ValueMap& map) {
  assert(map.x.size() == map.y.size() && map.x.size() == map.values.size());
  std::vector<MapPoint> points;
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    if (!can_be_shown(map.x[i], map.x_scale) || !can_be_shown(map.y[i], map.y_scale)) continue;
    points.push_back({on_axis(map.x[i], map.x_scale), on_axis(map.y[i], map.y_scale), map.values[i]});
  }
  return points;
}

std::vector<double> distinct(std::vector<double> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

/// Values at every x (varying fastest) with every y.
struct Grid {
  std::vector<double> x, y;
  std::vector<double> values;

  double at(std::size_t i, std::size_t j) const { return values[j * x.size() + i]; }
};

std::optional<Grid> grid_of(const std::vector<MapPoint>& points) {
  std::vector<double> x, y;
  for (const MapPoint& p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  Grid grid{distinct(x), distinct(y), {}};
  const std::size_t size = grid.x.size() * grid.y.size();
  if (grid.x.size() < 2 || grid.y.size() < 2 || points.size() != size) return std::nullopt;
  grid.values.resize(size);
  std::vector<bool> is_set(size, false);
  for (const MapPoint& p : points) {
    const auto i = std::ranges::lower_bound(grid.x, p.x) - grid.x.begin();
    const auto j = std::ranges::lower_bound(grid.y, p.y) - grid.y.begin();
    const std::size_t place = static_cast<std::size_t>(j) * grid.x.size() + static_cast<std::size_t>(i);
    if (is_set[place]) return std::nullopt;
    is_set[place] = true;
    grid.values[place] = p.value;
  }
  return grid;
}

/// Boundaries between values: in the middle, and as far outside of the first and the last.
std::vector<double> boundaries(const std::vector<double>& values) {
  std::vector<double> result{values[0] - 0.5 * (values[1] - values[0])};
  for (std::size_t i = 1; i < values.size(); ++i) result.push_back(0.5 * (values[i - 1] + values[i]));
  result.push_back(values.back() + 0.5 * (values.back() - values[values.size() - 2]));
  return result;
}

/// The range of the values; it is never empty.
AxisSpan range_of(const std::vector<MapPoint>& points) {
  AxisSpan range;
  for (const MapPoint& p : points) {
    if (std::isfinite(p.value)) range.include(p.value);
  }
  return range.low < range.high ? range : range.padded(Scale::linear);
}

class Drawing {
 public:
  explicit Drawing(const ValueMap& map)
      : map_(map), points_(points_of(map)), grid_(grid_of(points_)), range_(range_of(points_)) {
    axes_ = {map.x_scale, map.y_scale, {}, {}};
    if (grid_) {
      const auto x = boundaries(grid_->x), y = boundaries(grid_->y);
      axes_.x = {x.front(), x.back()};
      axes_.y = {y.front(), y.back()};
      return;
    }
    for (const MapPoint& p : points_) {
      axes_.x.include(p.x);
      axes_.y.include(p.y);
    }
    axes_.x = axes_.x.padded(map.x_scale);
    axes_.y = axes_.y.padded(map.y_scale);
  }

  std::string document() const {
    const auto ticks = ticks_of(range_, Scale::linear);
    double longest = 13.0 / 12.0 * text_width(map_.value_label);  // a label has 13 px
    for (const AxisTick& tick : ticks) longest = std::max(longest, 30 + text_width(tick.label));
    const double width = std::ceil(bar_left + longest + 24);
    std::string out = svg_head(width, svg_frame::bottom + 64, map_.title, description());
    out += svg_text(svg_frame::left, svg_frame::top - 20, "heading", map_.title);
    const std::string axes = draw_axes(axes_, map_.x_label, map_.y_label);
    // A heat map covers the lines of the grid, marks stand on them.
    out += grid_ ? axes + heat_map(ticks) : axes + marks();
    return out + colour_bar(ticks) + "</svg>\n";
  }

 private:
  Colour colour(double value) const { return viridis_at((value - range_.low) / range_.length()); }

  std::string fill(double value) const { return std::isfinite(value) ? colour(value).text() : no_value; }

  std::string title(double x, double y, double value) const {
    return fmt::format("<title>{:.6g}, {:.6g}: {}</title>", off_axis(x, map_.x_scale), off_axis(y, map_.y_scale),
                       std::isfinite(value) ? fmt::format("{:.6g}", value) : "no value");
  }

  std::string heat_map(const std::vector<AxisTick>& levels) const {
    const Grid& grid = *grid_;
    const auto x = boundaries(grid.x), y = boundaries(grid.y);
    std::string cells = "<g shape-rendering=\"crispEdges\">\n", numbers;
    for (std::size_t j = 0; j < grid.y.size(); ++j) {
      for (std::size_t i = 0; i < grid.x.size(); ++i) {
        // At whole pixels: no gap between neighbours.
        const double left = std::round(axes_.column(x[i])), top = std::round(axes_.row(y[j + 1])),
                     value = grid.at(i, j);
        const double width = std::round(axes_.column(x[i + 1])) - left, tall = std::round(axes_.row(y[j])) - top;
        cells += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\">{}</rect>\n", left, top,
                             width, tall, fill(value), title(grid.x[i], grid.y[j], value));
        constexpr double least_width = 54, least_height = 24;  // for a number
        if (width < least_width || tall < least_height) continue;
        const bool is_dark = std::isfinite(value) && colour(value).is_dark();
        numbers += fmt::format(
            "<text x=\"{:.2f}\" y=\"{:.2f}\" class=\"middle\" style=\"fill:{};stroke:{};stroke-width:3;"
            "paint-order:stroke\">{}</text>\n",
            axes_.column(grid.x[i]), axes_.row(grid.y[j]) + 4, is_dark ? "white" : "#2d3139", fill(value),
            std::isfinite(value) ? fmt::format("{:.4g}", value) : "none");
      }
    }
    // Contours begin and end at points, which are the middles of rectangles: few large ones have numbers instead.
    return cells + "</g>\n" + (numbers.empty() ? contours(levels) : numbers);
  }

  /// Where the level lies between two points of the grid; nothing if it does not.
  static std::optional<double> crossing(double a, double b, double level) {
    if ((a < level) == (b < level)) return std::nullopt;
    return (level - a) / (b - a);
  }

  std::string contours(const std::vector<AxisTick>& levels) const {
    std::string out;
    for (const AxisTick& level : levels) {
      std::string path;
      for (std::size_t j = 0; j + 1 < grid_->y.size(); ++j) {
        for (std::size_t i = 0; i + 1 < grid_->x.size(); ++i) path += contour_in(i, j, level.at);
      }
      if (path.empty()) continue;
      for (const char* line : {"stroke:black;stroke-width:3.2;stroke-opacity:0.3", "stroke:white;stroke-width:1.4"}) {
        out += fmt::format("<path d=\"{}\" style=\"fill:none;{}\"><title>{}</title></path>\n", path, line, level.label);
      }
    }
    return out;
  }

  /// The lines of one level through the rectangle between the points (i, j) and (i + 1, j + 1): marching squares. At a
  /// saddle the mean of the corners says which of them belong together.
  std::string contour_in(std::size_t i, std::size_t j, double level) const {
    const Grid& grid = *grid_;
    const std::array<std::array<std::size_t, 2>, 4> corners{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
    std::array<double, 4> value{};
    for (std::size_t k = 0; k < 4; ++k) value[k] = grid.at(corners[k][0], corners[k][1]);
    if (!std::ranges::all_of(value, [](double v) { return std::isfinite(v); })) return "";
    std::vector<std::string> ends;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto &a = corners[k], &b = corners[(k + 1) % 4];
      const auto t = crossing(value[k], value[(k + 1) % 4], level);
      if (!t) continue;
      ends.push_back(fmt::format("{:.2f},{:.2f}", axes_.column(grid.x[a[0]] + *t * (grid.x[b[0]] - grid.x[a[0]])),
                                 axes_.row(grid.y[a[1]] + *t * (grid.y[b[1]] - grid.y[a[1]]))));
    }
    if (ends.size() < 2) return "";
    if (ends.size() == 2) return fmt::format("M{} L{} ", ends[0], ends[1]);
    // The sides 3 and 0 meet at corner 0: a line cuts it off unless the middle is like it; then lines cut off 1 and 3.
    const bool is_with_middle = (value[0] < level) == (0.25 * (value[0] + value[1] + value[2] + value[3]) < level);
    return is_with_middle ? fmt::format("M{} L{} M{} L{} ", ends[0], ends[1], ends[2], ends[3])
                          : fmt::format("M{} L{} M{} L{} ", ends[3], ends[0], ends[1], ends[2]);
  }

  std::string marks() const {
    std::string out;
    for (const MapPoint& p : points_) {
      out += fmt::format(
          "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"7\" fill=\"{}\" stroke=\"#2d3139\" "
          "stroke-width=\"0.8\">{}</circle>\n",
          axes_.column(p.x), axes_.row(p.y), fill(p.value), title(p.x, p.y, p.value));
    }
    return out;
  }

  std::string colour_bar(const std::vector<AxisTick>& ticks) const {
    std::string out = "<defs><linearGradient id=\"bar\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">\n";
    for (std::size_t k = 0; k < viridis.size(); ++k) {
      out += fmt::format("<stop offset=\"{}\" stop-color=\"{}\"/>\n",
                         static_cast<double>(k) / static_cast<double>(viridis.size() - 1), viridis[k].text());
    }
    out += fmt::format(
        "</linearGradient></defs>\n<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"url(#bar)\"/>\n", bar_left,
        svg_frame::top, bar_width, svg_frame::height);
    const Axes axes{Scale::linear, Scale::linear, {0.0, 1.0}, range_};
    for (const AxisTick& tick : ticks) {
      const double y = axes.row(tick.at), right = bar_left + bar_width;
      out += svg_line(right, y, right + 5, y, "axis") + svg_text(right + 9, y + 4, "tick", tick.label);
    }
    return out + svg_text(bar_left, svg_frame::top - 12, "label", map_.value_label);
  }

  /// In words, for those who do not see the picture.
  std::string description() const {
    const auto finite = std::ranges::count_if(points_, [](const MapPoint& p) { return std::isfinite(p.value); });
    std::string out = fmt::format("{} as colours over {} and {}: {} of {} points have a value", map_.value_label,
                                  map_.x_label, map_.y_label, finite, points_.size());
    if (finite == 0) return out + ".";
    const auto by_value = [](const MapPoint& a, const MapPoint& b) {
      return std::isfinite(a.value) && (!std::isfinite(b.value) || a.value < b.value);
    };
    const MapPoint least = *std::ranges::min_element(points_, by_value);
    const auto against_value = [](const MapPoint& a, const MapPoint& b) {
      return std::isfinite(a.value) && (!std::isfinite(b.value) || a.value > b.value);
    };
    const MapPoint largest = *std::ranges::min_element(points_, against_value);
    const auto place = [&](const MapPoint& p) {
      return fmt::format("{:.4g} at ({:.4g}, {:.4g})", p.value, off_axis(p.x, map_.x_scale),
                         off_axis(p.y, map_.y_scale));
    };
    return out + fmt::format(", from {} to {}.", place(least), place(largest));
  }

  const ValueMap& map_;
  std::vector<MapPoint> points_;
  std::optional<Grid> grid_;
  AxisSpan range_;
  Axes axes_{};
};

}  // namespace

std::string svg_map(const ValueMap& map) {
  const ValueMap in_units = in_handy_units(map);
  return Drawing(in_units).document();
}

}  // namespace pliant
