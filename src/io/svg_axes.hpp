/// What pictures in SVG have in common: axes with ticks, texts, one look.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace pliant {

enum class Scale { logarithmic, linear };

/// Size of the drawing area and where it is in the document [px].
namespace svg_frame {
inline constexpr double left = 84, top = 52, width = 560, height = 400, right = left + width, bottom = top + height;
}  // namespace svg_frame

/// Limits of an axis, in axis coordinates: decimal logarithms on a logarithmic one.
struct AxisSpan {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value);
  double length() const { return high - low; }
  double magnitude() const;
  /// Adds a margin around the data, and makes the axis long enough for ticks: on a logarithmic axis at least a factor
  /// of 4; on a linear one values that labels of nine digits cannot distinguish make a flat line.
  AxisSpan padded(Scale scale) const;
};

bool can_be_shown(double value, Scale scale);
double on_axis(double value, Scale scale);
double off_axis(double at, Scale scale);

struct AxisTick {
  double at;          ///< in axis coordinates
  std::string label;  ///< empty: a line of the grid only
};

std::vector<AxisTick> ticks_of(const AxisSpan& span, Scale scale);

/// Two axes and where their values are in the document.
struct Axes {
  Scale x_scale, y_scale;
  AxisSpan x, y;

  double column(double at) const { return svg_frame::left + svg_frame::width * (at - x.low) / x.length(); }
  double row(double at) const { return svg_frame::top + svg_frame::height * (y.high - at) / y.length(); }
};

/// A label that ends in a unit in brackets, such as "tip_z [m]", in a unit that suits the values: "tip_z [mm]".
struct HandyLabel {
  std::string label;
  double factor = 1.0;  ///< the new unit in the given one: what values are divided by
};

/// The text with powers as people write them: "density [kg/m³]" for "density [kg/m^3]". Powers that are not whole stay.
std::string with_superscripts(const std::string& text);

/// `largest`: of the magnitudes of the values. Units that are not SI, such as mm, and labels without one stay as they
/// are.
HandyLabel handy_label(const std::string& label, double largest);

/// The largest magnitude of the finite ones among values; 0 if there is none.
double largest_magnitude(const std::vector<double>& values);

std::string svg_line(double x1, double y1, double x2, double y2, const std::string& style);
std::string svg_text(double x, double y, const std::string& style, const std::string& content);

/// Axes with the lines of their grid, and their labels.
std::string draw_axes(const Axes& axes, const std::string& x_label, const std::string& y_label);

/// The width of a text of 12 px in DejaVu Sans, the widest of the fonts, or a little more [px].
double text_width(const std::string& utf8);

/// The document up to its first picture element: `description` is for those who do not see the picture.
std::string svg_head(double width, double height, const std::string& title, const std::string& description);

}  // namespace pliant
