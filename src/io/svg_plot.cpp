#include "io/svg_plot.hpp"

#include "base/file.hpp"
#include "io/xdmf.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Those of `pliant plot`.
constexpr std::array colours{"#3b6fb6", "#d1603d", "#3f9c6b", "#8a63b8", "#c79a2b", "#4aa5b5", "#b5507c", "#6d7580"};

constexpr double height = svg_frame::bottom + 64;
constexpr double legend_left = svg_frame::right + 24, legend_line = 22;
constexpr double triangle_gap = 16;  // between a series and the triangle below it

/// The same plot with its values, and the units in its labels, as people write them. Logarithmic axes have powers of
/// ten.
Plot in_handy_units(Plot plot) {
  const auto change = [&](std::string& label, Scale scale, std::vector<double> PlotSeries::*values) {
    if (scale == Scale::logarithmic) return;
    double largest = 0.0;
    for (const PlotSeries& series : plot.series) largest = std::max(largest, largest_magnitude(series.*values));
    const HandyLabel handy = handy_label(label, largest);
    label = handy.label;
    for (PlotSeries& series : plot.series) {
      for (double& value : series.*values) value /= handy.factor;
    }
  };
  change(plot.x_label, plot.x_scale.value_or(plot.scale), &PlotSeries::x);
  change(plot.y_label, plot.scale, &PlotSeries::y);
  return plot;
}

/// A point in axis coordinates: decimal logarithms on logarithmic axes.
struct AxisPoint {
  double x, y;
};

struct Curve {
  std::string name;
  std::vector<AxisPoint> points;
  std::size_t look;  // number of its colour and its mark
  SeriesStyle style;

  const char* colour() const { return colours[look % colours.size()]; }
  /// Dashes of its line: after the last colour the first one comes again, with others.
  std::string dashes() const {
    constexpr std::array all{"", " stroke-dasharray=\"9 5\"", " stroke-dasharray=\"2 4\""};
    return all[look / colours.size() % all.size()];
  }
};

/// The corners at the hypotenuse's ends; the right angle is at (right.x, left.y).
struct SlopeTriangle {
  AxisPoint left, right;
  double order;
};

Scale x_scale_of(const Plot& plot) {
  return plot.x_scale.value_or(plot.scale);
}

std::vector<Curve> curves_of(const Plot& plot) {
  const auto by_scale = plot.scale == Scale::linear ? SeriesStyle::line : SeriesStyle::by_scale;
  const Scale across = x_scale_of(plot);
  std::vector<Curve> curves;
  for (const PlotSeries& series : plot.series) {
    assert(series.x.size() == series.y.size());
    Curve curve{series.name,
                {},
                series.look.value_or(curves.size()),
                series.style == SeriesStyle::by_scale ? by_scale : series.style};
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!can_be_shown(series.x[i], across) || !can_be_shown(series.y[i], plot.scale)) continue;
      curve.points.push_back({on_axis(series.x[i], across), on_axis(series.y[i], plot.scale)});
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

Axes axes_of(const std::vector<Curve>& curves, const std::vector<SlopeTriangle>& triangles, const Plot& plot) {
  Axes axes{x_scale_of(plot), plot.scale, {}, {}};
  for (const Curve& curve : curves) {
    for (const AxisPoint& p : curve.points) {
      axes.x.include(p.x);
      axes.y.include(p.y);
    }
  }
  for (const SlopeTriangle& t : triangles) {
    axes.y.include(t.left.y);
    axes.y.include(t.right.y);
  }
  return {axes.x_scale, axes.y_scale, axes.x.padded(axes.x_scale), axes.y.padded(axes.y_scale)};
}

/// Slope of the least-squares line; nothing if all points have the same x.
std::optional<double> slope_of(const std::vector<AxisPoint>& points) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const AxisPoint& p : points) {
    x += p.x / static_cast<double>(points.size());
    y += p.y / static_cast<double>(points.size());
  }
  for (const AxisPoint& p : points) {
    xx += (p.x - x) * (p.x - x);
    xy += (p.x - x) * (p.y - y);
  }
  return xx > 0.0 ? std::optional(xy / xx) : std::nullopt;
}

/// The lowest of the curves whose slopes are about as close to the order as any; nullptr if none has a slope.
const Curve* nearest_curve(const std::vector<Curve>& curves, double order) {
  constexpr double about = 0.25;
  const auto distance = [&](const Curve& curve) {
    const auto slope = slope_of(curve.points);
    return slope ? std::abs(*slope - order) : std::numeric_limits<double>::infinity();
  };
  double least = std::numeric_limits<double>::infinity();
  for (const Curve& curve : curves) least = std::min(least, distance(curve));
  const auto lowest = [](const Curve& curve) { return std::ranges::min(curve.points, {}, &AxisPoint::y).y; };
  const Curve* nearest = nullptr;
  for (const Curve& curve : curves) {
    if (!std::isfinite(distance(curve)) || distance(curve) > least + about) continue;
    if (nearest == nullptr || lowest(curve) < lowest(*nearest)) nearest = &curve;
  }
  return nearest;
}

/// Height of the line through points that ascend in x, at an x between their ends.
double interpolated(const std::vector<AxisPoint>& points, double x) {
  const auto right = std::ranges::lower_bound(points, x, {}, &AxisPoint::x);
  if (right == points.begin()) return points.front().y;
  if (right == points.end()) return points.back().y;
  const AxisPoint &a = *(right - 1), &b = *right;
  return a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
}

/// Below the curve by `gap` decades, its right angle pointing away. Centre and width are parts of the curve's width.
SlopeTriangle triangle_below(std::vector<AxisPoint> curve, double order, double gap, double centre, double width) {
  std::ranges::sort(curve, {}, &AxisPoint::x);
  const double length = curve.back().x - curve.front().x, half = 0.5 * width * length;
  centre = curve.front().x + centre * length;
  // The line y = base + order (x - centre) touches the curve from below between the triangle's ends.
  double base =
      std::min(interpolated(curve, centre - half) + order * half, interpolated(curve, centre + half) - order * half);
  for (const AxisPoint& p : curve) {
    if (std::abs(p.x - centre) <= half) base = std::min(base, p.y - order * (p.x - centre));
  }
  return {{centre - half, base - gap - order * half}, {centre + half, base - gap + order * half}, order};
}

std::vector<SlopeTriangle> triangles_of(const Plot& plot, const std::vector<Curve>& curves) {
  std::vector<const Curve*> owners;
  for (const double order : plot.slopes) owners.push_back(nearest_curve(curves, order));
  const double gap = axes_of(curves, {}, plot).y.length() * triangle_gap / svg_frame::height;
  std::vector<SlopeTriangle> triangles;
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (owners[i] == nullptr) continue;
    const auto same = [&](std::size_t end) {
      return static_cast<double>(
          std::count(owners.begin(), owners.begin() + static_cast<std::ptrdiff_t>(end), owners[i]));
    };
    const double parts = same(owners.size()) + 1.0;
    triangles.push_back(
        triangle_below(owners[i]->points, plot.slopes[i], gap, (same(i) + 1.0) / parts, std::min(0.25, 0.7 / parts)));
  }
  return triangles;
}

/// Marks differ in form too, for eyes and printers without colours.
std::string mark(std::size_t number, double x, double y) {
  switch (number % 4) {
    case 0:
      return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"4\"", x, y);
    case 1:
      return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"7.2\" height=\"7.2\"", x - 3.6, y - 3.6);
    case 2:
      return fmt::format("<path d=\"M{:.2f},{:.2f} l5.2,5.2 l-5.2,5.2 l-5.2,-5.2 z\"", x, y - 5.2);
    default:
      return fmt::format("<path d=\"M{:.2f},{:.2f} l5,8.6 l-10,0 z\"", x, y - 5.4);
  }
}

std::string draw_curve(const Curve& curve, const Axes& axes) {
  std::string corners, marks;
  for (const AxisPoint& p : curve.points) {
    const double x = axes.column(p.x), y = axes.row(p.y);
    corners += fmt::format("{}{:.2f},{:.2f}", corners.empty() ? "" : " ", x, y);
    if (curve.style == SeriesStyle::line) continue;  // a curve, not a few measurements
    marks += mark(curve.look, x, y) + fmt::format("><title>{}: {:.4g}, {:.4g}</title>", xml_escaped(curve.name),
                                                  off_axis(p.x, axes.x_scale), off_axis(p.y, axes.y_scale));
    marks += curve.look % 4 == 0 ? "</circle>\n" : curve.look % 4 == 1 ? "</rect>\n" : "</path>\n";
  }
  const std::string line =
      curve.style == SeriesStyle::marks ? "" : "<polyline points=\"" + corners + "\"" + curve.dashes() + "/>\n";
  return fmt::format("<g class=\"series\" stroke=\"{0}\" fill=\"{0}\">\n{1}{2}</g>\n", curve.colour(), line, marks);
}

std::string draw_legend(const std::vector<Curve>& curves) {
  std::string out;
  double y = svg_frame::top + 12;
  for (const Curve& curve : curves) {
    out += fmt::format("<g class=\"series\" stroke=\"{0}\" fill=\"{0}\"{1}>\n", curve.colour(), curve.dashes());
    if (curve.style != SeriesStyle::marks) out += svg_line(legend_left, y, legend_left + 28, y, "sample");
    if (curve.style != SeriesStyle::line) out += mark(curve.look, legend_left + 14, y) + "/>\n";
    out += "</g>\n";
    out += svg_text(legend_left + 38, y + 4, "name", curve.name);
    y += legend_line;
  }
  return out;
}

std::string draw_triangle(const SlopeTriangle& triangle, const Axes& axes) {
  const double x1 = axes.column(triangle.left.x), y1 = axes.row(triangle.left.y);
  const double x2 = axes.column(triangle.right.x), y2 = axes.row(triangle.right.y);
  return fmt::format("<path d=\"M{:.2f},{:.2f} L{:.2f},{:.2f} L{:.2f},{:.2f} z\" class=\"slope\"/>\n", x1, y1, x2, y1,
                     x2, y2);
}

/// The labels of the vertical axis.
std::string draw_order(const SlopeTriangle& triangle, const Axes& axes) {
  const double middle = 0.5 * (triangle.left.y + triangle.right.y);
  return svg_text(axes.column(triangle.right.x) + 6, axes.row(middle) + 4, "order",
                  fmt::format("order {:g}", triangle.order));
}

double width_of(const std::vector<Curve>& curves) {
  double longest = 0.0;
  for (const Curve& curve : curves) longest = std::max(longest, text_width(curve.name));
  return std::ceil(legend_left + 38 + longest + 16);
}

/// A description in words, for those who do not see the picture.
std::string description(const Plot& plot, const std::vector<Curve>& curves) {
  const bool is_logarithmic = plot.scale == Scale::logarithmic && x_scale_of(plot) == Scale::logarithmic;
  std::string out = plot.y_label + " over " + plot.x_label + (is_logarithmic ? ", both logarithmic." : ".");
  for (const Curve& curve : curves) {
    out += " " + curve.name + ": " + std::to_string(curve.points.size()) + " points";
    const auto slope = is_logarithmic ? slope_of(curve.points) : std::nullopt;
    if (slope) out += fmt::format(" of mean slope {:.2f}", *slope);
    out += ".";
  }
  return out;
}

}  // namespace

std::string svg(const Plot& given) {
  const Plot plot = in_handy_units(given);
  const auto curves = curves_of(plot);
  const auto triangles = triangles_of(plot, curves);
  const Axes axes = axes_of(curves, triangles, plot);
  const double legend_bottom = svg_frame::top + 12 + legend_line * static_cast<double>(curves.size());
  const double width = width_of(curves), tall = std::max(height, legend_bottom);
  std::string out = svg_head(width, tall, plot.title, description(plot, curves));
  out += svg_text(svg_frame::left, svg_frame::top - 20, "heading", plot.title) +
         draw_axes(axes, plot.x_label, plot.y_label);
  for (const SlopeTriangle& triangle : triangles) out += draw_triangle(triangle, axes);
  for (const Curve& curve : curves) out += draw_curve(curve, axes);
  for (const SlopeTriangle& triangle : triangles) out += draw_order(triangle, axes);
  return out + draw_legend(curves) + "</svg>\n";
}

void write_svg(MPI_Comm comm, const std::filesystem::path& file, const Plot& plot) {
  on_root(comm, [&] { write_text_atomically(file, svg(plot)); });
}

}  // namespace pliant
