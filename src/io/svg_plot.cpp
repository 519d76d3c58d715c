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

/// Size of the document [px].
constexpr double frame_left = 84, frame_top = 52, frame_width = 560, frame_height = 400;
constexpr double height = frame_top + frame_height + 64;
constexpr double legend_left = frame_left + frame_width + 24, legend_line = 22, letter_width = 6.8;
constexpr double triangle_gap = 16;  // between a series and the triangle below it

/// A point in axis coordinates: decimal logarithms on logarithmic axes.
struct AxisPoint {
  double x, y;
};

/// Limits of an axis.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double length() const { return high - low; }
  double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
  /// Adds a margin around the data, and makes the axis long enough for ticks: on a logarithmic axis at least a factor
  /// of 4; on a linear one values that labels of nine digits cannot distinguish make a flat line.
  Span padded(Scale scale) const {
    if (low > high) return {-1.0, 0.0};
    constexpr double zero = 1e-300;  // so that fractions of it are not denormal numbers
    const bool is_flat = length() <= std::max(1e-7 * magnitude(), zero);
    const double least = scale == Scale::logarithmic ? 0.6 : !is_flat ? 0.0 : magnitude() <= zero ? 1.0 : magnitude();
    const double room = std::max(0.06 * length(), 0.5 * (least - length()));
    return {low - room, high + room};
  }
};

struct Curve {
  std::string name;
  std::vector<AxisPoint> points;
  std::size_t look;  // number of its colour and its mark
  SeriesStyle style;

  const char* colour() const { return colours[look % colours.size()]; }
};

/// The corners at the hypotenuse's ends; the right angle is at (right.x, left.y).
struct SlopeTriangle {
  AxisPoint left, right;
  double order;
};

struct Axes {
  Scale x_scale, y_scale;
  Span x, y;

  double column(double at) const { return frame_left + frame_width * (at - x.low) / x.length(); }
  double row(double at) const { return frame_top + frame_height * (y.high - at) / y.length(); }
};

bool can_be_shown(double value, Scale scale) {
  return std::isfinite(value) && (scale == Scale::linear || value > 0.0);
}

double on_axis(double value, Scale scale) {
  return scale == Scale::logarithmic ? std::log10(value) : value;
}

double off_axis(double at, Scale scale) {
  return scale == Scale::logarithmic ? std::pow(10.0, at) : at;
}

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
  const double gap = axes_of(curves, {}, plot).y.length() * triangle_gap / frame_height;
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

/// "10⁻³".
std::string power_of_ten(int exponent) {
  static constexpr std::array superscripts{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += superscripts[static_cast<std::size_t>(digit - '0')];
  return text;
}

struct Tick {
  double at;          // on the axis
  std::string label;  // empty: a line of the grid only
};

/// Decades are labelled (on long axes every second, third, ...); on short axes so are 2 and 5, and the grid has 2 to 9.
std::vector<Tick> decades_of(const Span& span) {
  constexpr double most_labels = 9, short_axis = 2.0, grid_axis = 4.0;
  const int every = std::max(1, static_cast<int>(std::ceil(span.length() / most_labels)));
  std::vector<Tick> ticks;
  for (int decade = static_cast<int>(std::floor(span.low)); decade <= span.high; ++decade) {
    for (int digit = 1; digit < 10; ++digit) {
      const double at = decade + std::log10(digit);
      if (at < span.low || at > span.high) continue;
      const bool has_label =
          digit == 1 ? decade % every == 0 : span.length() < short_axis && (digit == 2 || digit == 5);
      if (!has_label && (digit == 1 || span.length() > grid_axis)) continue;
      const std::string factor = digit == 1 ? "" : std::to_string(digit) + "·";
      ticks.push_back({at, has_label ? factor + power_of_ten(decade) : ""});
    }
  }
  return ticks;
}

/// Multiples of 1, 2 or 5 times a power of ten, about six of them.
std::vector<Tick> multiples_of(const Span& span) {
  const double power = std::pow(10.0, std::floor(std::log10(span.length() / 6.0)));
  const double ratio = span.length() / 6.0 / power;
  const double distance = power * (ratio < 1.5 ? 1.0 : ratio < 3.5 ? 2.0 : ratio < 7.5 ? 5.0 : 10.0);
  const int digits = std::max(6, 1 + static_cast<int>(std::ceil(std::log10(span.magnitude() / distance))));
  std::vector<Tick> ticks;
  for (double n = std::ceil(span.low / distance); n * distance <= span.high; ++n) {
    ticks.push_back({n * distance, fmt::format("{:.{}g}", n * distance + 0.0, digits)});
  }
  return ticks;
}

std::vector<Tick> ticks_of(const Span& span, Scale scale) {
  return scale == Scale::logarithmic ? decades_of(span) : multiples_of(span);
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" class=\"{}\"/>\n", x1, y1, x2, y2,
                     style);
}

std::string text(double x, double y, const std::string& style, const std::string& content) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" class=\"{}\">{}</text>\n", x, y, style, xml_escaped(content));
}

std::string draw_axes(const Plot& plot, const Axes& axes) {
  const double right = frame_left + frame_width, bottom = frame_top + frame_height;
  std::string out = "<g aria-hidden=\"true\">\n";
  for (const Tick& tick : ticks_of(axes.x, axes.x_scale)) {
    const double x = axes.column(tick.at);
    out += line(x, frame_top, x, bottom, tick.label.empty() ? "minor" : "major");
    if (!tick.label.empty()) out += text(x, bottom + 18, "tick middle", tick.label);
  }
  for (const Tick& tick : ticks_of(axes.y, axes.y_scale)) {
    const double y = axes.row(tick.at);
    out += line(frame_left, y, right, y, tick.label.empty() ? "minor" : "major");
    if (!tick.label.empty()) out += text(frame_left - 8, y + 4, "tick end", tick.label);
  }
  out += line(frame_left, bottom, right, bottom, "axis") + line(frame_left, frame_top, frame_left, bottom, "axis");
  out += "</g>\n" + text(frame_left + frame_width / 2, bottom + 44, "label middle", plot.x_label);
  const double middle = frame_top + frame_height / 2;
  return out + fmt::format("<text transform=\"translate(22,{:.2f}) rotate(-90)\" class=\"label middle\">{}</text>\n",
                           middle, xml_escaped(plot.y_label));
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
  const std::string line = curve.style == SeriesStyle::marks ? "" : "<polyline points=\"" + corners + "\"/>\n";
  return fmt::format("<g class=\"series\" stroke=\"{0}\" fill=\"{0}\">\n{1}{2}</g>\n", curve.colour(), line, marks);
}

std::string draw_legend(const std::vector<Curve>& curves) {
  std::string out;
  double y = frame_top + 12;
  for (const Curve& curve : curves) {
    out += fmt::format("<g class=\"series\" stroke=\"{0}\" fill=\"{0}\">\n", curve.colour());
    if (curve.style != SeriesStyle::marks) out += line(legend_left, y, legend_left + 28, y, "sample");
    if (curve.style != SeriesStyle::line) out += mark(curve.look, legend_left + 14, y) + "/>\n";
    out += "</g>\n";
    out += text(legend_left + 38, y + 4, "name", curve.name);
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
  return text(axes.column(triangle.right.x) + 6, axes.row(middle) + 4, "order",
              fmt::format("order {:g}", triangle.order));
}

/// Letters, not bytes.
std::size_t length(const std::string& utf8) {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

double width_of(const std::vector<Curve>& curves) {
  std::size_t longest = 0;
  for (const Curve& curve : curves) longest = std::max(longest, length(curve.name));
  return std::ceil(legend_left + 38 + letter_width * static_cast<double>(longest) + 16);
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

constexpr const char* style = R"(<style>
text { font-family: "DejaVu Sans", Verdana, Arial, sans-serif; font-size: 12px; fill: #2d3139; }
.heading { font-size: 15px; font-weight: bold; }
.label { font-size: 13px; }
.tick { fill: #5a606b; }
.middle { text-anchor: middle; }
.end { text-anchor: end; }
.major { stroke: #d5d9df; stroke-width: 1; }
.minor { stroke: #eef0f3; stroke-width: 1; }
.axis { stroke: #8b919b; stroke-width: 1; }
.series polyline { fill: none; stroke-width: 2; stroke-linejoin: round; }
.sample { stroke-width: 2; }
.slope { fill: #eceef1; fill-opacity: 0.7; stroke: #6d7580; stroke-width: 1; }
.order { fill: #5a606b; stroke: white; stroke-width: 3; paint-order: stroke; }
</style>
)";

}  // namespace

std::string svg(const Plot& plot) {
  const auto curves = curves_of(plot);
  const auto triangles = triangles_of(plot, curves);
  const Axes axes = axes_of(curves, triangles, plot);
  const double legend_bottom = frame_top + 12 + legend_line * static_cast<double>(curves.size());
  const double width = width_of(curves), tall = std::max(height, legend_bottom);
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  out += fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-labelledby=\"title description\">\n",
      width, tall);
  out += "<title id=\"title\">" + xml_escaped(plot.title) + "</title>\n";
  out += "<desc id=\"description\">" + xml_escaped(description(plot, curves)) + "</desc>\n" + style;
  out += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  out += text(frame_left, frame_top - 20, "heading", plot.title) + draw_axes(plot, axes);
  for (const SlopeTriangle& triangle : triangles) out += draw_triangle(triangle, axes);
  for (const Curve& curve : curves) out += draw_curve(curve, axes);
  for (const SlopeTriangle& triangle : triangles) out += draw_order(triangle, axes);
  return out + draw_legend(curves) + "</svg>\n";
}

void write_svg(MPI_Comm comm, const std::filesystem::path& file, const Plot& plot) {
  on_root(comm, [&] { write_text_atomically(file, svg(plot)); });
}

}  // namespace pliant
