#include "io/svg_axes.hpp"

#include "io/xdmf.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace pliant {
namespace {

/// "10⁻³".
std::string power_of_ten(int exponent) {
  static constexpr std::array superscripts{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += superscripts[static_cast<std::size_t>(digit - '0')];
  return text;
}

/// Decades are labelled (on long axes every second, third, ...); on short axes so are 2 and 5, and the grid has 2 to 9.
std::vector<AxisTick> decades_of(const AxisSpan& span) {
  constexpr double most_labels = 9, short_axis = 2.0, grid_axis = 4.0;
  constexpr double smallest_plain = -3.0, largest_plain = 4.0;  // of numbers that read better than powers
  const int every = std::max(1, static_cast<int>(std::ceil(span.length() / most_labels)));
  const bool is_plain = span.length() < short_axis && span.low > smallest_plain && span.high < largest_plain;
  std::vector<AxisTick> ticks;
  for (int decade = static_cast<int>(std::floor(span.low)); decade <= span.high; ++decade) {
    for (int digit = 1; digit < 10; ++digit) {
      const double at = decade + std::log10(digit);
      if (at < span.low || at > span.high) continue;
      const bool has_label =
          digit == 1 ? decade % every == 0 : span.length() < short_axis && (digit == 2 || digit == 5);
      if (!has_label && (digit == 1 || span.length() > grid_axis)) continue;
      const std::string factor = digit == 1 ? "" : std::to_string(digit) + "·";
      const std::string label =
          is_plain ? fmt::format("{:g}", digit * std::pow(10.0, decade)) : factor + power_of_ten(decade);
      ticks.push_back({at, has_label ? label : ""});
    }
  }
  return ticks;
}

/// Multiples of 1, 2 or 5 times a power of ten, about six of them.
std::vector<AxisTick> multiples_of(const AxisSpan& span) {
  const double power = std::pow(10.0, std::floor(std::log10(span.length() / 6.0)));
  const double ratio = span.length() / 6.0 / power;
  const double distance = power * (ratio < 1.5 ? 1.0 : ratio < 3.5 ? 2.0 : ratio < 7.5 ? 5.0 : 10.0);
  const int digits = std::max(6, 1 + static_cast<int>(std::ceil(std::log10(span.magnitude() / distance))));
  std::vector<AxisTick> ticks;
  for (double n = std::ceil(span.low / distance); n * distance <= span.high; ++n) {
    ticks.push_back({n * distance, fmt::format("{:.{}g}", n * distance + 0.0, digits)});
  }
  return ticks;
}

struct Prefix {
  const char* name;
  double factor;
};

constexpr std::array<Prefix, 6> prefixes{{{"µ", 1e-6}, {"m", 1e-3}, {"", 1.0}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}}};
constexpr std::array<Prefix, 3> volumes{{{"mm^3", 1e-9}, {"cm^3", 1e-6}, {"m^3", 1.0}}};

/// The first whose thousandfold is more than `largest`, or the last.
template <std::size_t n>
const Prefix& fitting(const std::array<Prefix, n>& all, double largest) {
  const auto found = std::ranges::find_if(all, [&](const Prefix& p) { return largest < 1000.0 * p.factor; });
  return found == all.end() ? all.back() : *found;
}

/// Units that take prefixes. No kilometres and kiloseconds.
bool takes_prefix(std::string_view unit, double factor) {
  constexpr std::array<std::string_view, 11> all{"m", "m/s", "m/s^2", "s", "Pa", "N", "J", "W", "N m", "N s", "N/m"};
  return std::ranges::find(all, unit) != all.end() && (factor <= 1.0 || (unit[0] != 'm' && unit[0] != 's'));
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

void AxisSpan::include(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

double AxisSpan::magnitude() const {
  return std::max(std::abs(low), std::abs(high));
}

AxisSpan AxisSpan::padded(Scale scale) const {
  if (low > high) return {-1.0, 0.0};
  constexpr double zero = 1e-300;  // so that fractions of it are not denormal numbers
  const bool is_flat = length() <= std::max(1e-7 * magnitude(), zero);
  const double least = scale == Scale::logarithmic ? 0.6 : !is_flat ? 0.0 : magnitude() <= zero ? 1.0 : magnitude();
  const double room = std::max(0.06 * length(), 0.5 * (least - length()));
  return {low - room, high + room};
}

bool can_be_shown(double value, Scale scale) {
  return std::isfinite(value) && (scale == Scale::linear || value > 0.0);
}

double on_axis(double value, Scale scale) {
  return scale == Scale::logarithmic ? std::log10(value) : value;
}

double off_axis(double at, Scale scale) {
  return scale == Scale::logarithmic ? std::pow(10.0, at) : at;
}

std::vector<AxisTick> ticks_of(const AxisSpan& span, Scale scale) {
  return scale == Scale::logarithmic ? decades_of(span) : multiples_of(span);
}

HandyLabel handy_label(const std::string& label, double largest) {
  constexpr double shortest_in_seconds = 0.1;
  const std::size_t open = label.rfind(" [");
  if (open == std::string::npos || label.back() != ']' || !(largest > 0.0)) return {label};
  const std::string unit = label.substr(open + 2, label.size() - open - 3), before = label.substr(0, open + 2);
  if (unit == "m^3") {
    const Prefix& volume = fitting(volumes, largest);
    return {before + volume.name + "]", volume.factor};
  }
  const Prefix& prefix = fitting(prefixes, largest);
  if (!takes_prefix(unit, prefix.factor) || (unit == "s" && largest >= shortest_in_seconds)) return {label};
  return {before + prefix.name + unit + "]", prefix.factor};
}

double largest_magnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  return largest;
}

std::string with_superscripts(const std::string& text) {
  static constexpr std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const auto is_digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const bool is_negative = at + 1 < text.size() && text[at + 1] == '-';
    const std::size_t first = at + (is_negative ? 2 : 1);
    std::size_t end = first;
    while (is_digit(end)) ++end;
    const bool is_whole = end > first && !(end < text.size() && text[end] == '.' && is_digit(end + 1));
    if (text[at] != '^' || !is_whole) {
      result += text[at++];
      continue;
    }
    if (is_negative) result += "⁻";
    for (std::size_t k = first; k < end; ++k) result += digits[static_cast<std::size_t>(text[k] - '0')];
    at = end;
  }
  return result;
}

std::string svg_line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" class=\"{}\"/>\n", x1, y1, x2, y2,
                     style);
}

std::string svg_text(double x, double y, const std::string& style, const std::string& content) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" class=\"{}\">{}</text>\n", x, y, style,
                     xml_escaped(with_superscripts(content)));
}

std::string draw_axes(const Axes& axes, const std::string& x_label, const std::string& y_label) {
  constexpr double left = svg_frame::left, top = svg_frame::top, right = svg_frame::right, bottom = svg_frame::bottom;
  std::string out = "<g aria-hidden=\"true\">\n";
  for (const AxisTick& tick : ticks_of(axes.x, axes.x_scale)) {
    const double x = axes.column(tick.at);
    out += svg_line(x, top, x, bottom, tick.label.empty() ? "minor" : "major");
    if (!tick.label.empty()) out += svg_text(x, bottom + 18, "tick middle", tick.label);
  }
  for (const AxisTick& tick : ticks_of(axes.y, axes.y_scale)) {
    const double y = axes.row(tick.at);
    out += svg_line(left, y, right, y, tick.label.empty() ? "minor" : "major");
    if (!tick.label.empty()) out += svg_text(left - 8, y + 4, "tick end", tick.label);
  }
  out += svg_line(left, bottom, right, bottom, "axis") + svg_line(left, top, left, bottom, "axis");
  out += "</g>\n" + svg_text((left + right) / 2, bottom + 44, "label middle", x_label);
  const double middle = (top + bottom) / 2;
  return out + fmt::format("<text transform=\"translate(22,{:.2f}) rotate(-90)\" class=\"label middle\">{}</text>\n",
                           middle, xml_escaped(with_superscripts(y_label)));
}

double text_width(const std::string& utf8) {
  double width = 0.0;
  for (const char c : utf8) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;  // a letter's first byte counts
    const auto is_in = [c](std::string_view letters) { return letters.find(c) != std::string_view::npos; };
    width += is_in("ijlI.,:;()|! '[]/-") ? 4.7 : is_in("mwMW%@=+<>~GOQ") ? 11.9 : 'A' <= c && c <= 'Z' ? 9.3 : 7.7;
  }
  return width;
}

std::string svg_head(double width, double height, const std::string& title, const std::string& description) {
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  out += fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-labelledby=\"title description\">\n",
      width, height);
  out += "<title id=\"title\">" + xml_escaped(with_superscripts(title)) + "</title>\n";
  out += "<desc id=\"description\">" + xml_escaped(with_superscripts(description)) + "</desc>\n" + style;
  out += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  return out;
}

}  // namespace pliant
