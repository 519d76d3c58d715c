// The picture is well-formed, shows what it was given at the right places, and says it in words.
#include "base/error.hpp"
#include "base/limits.hpp"
#include "io/svg_plot.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "sample.hpp"

#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_svg_plot {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;
/// Errors c h^p at h = 0.02, 0.01, ...
PlotSeries power_law(const std::string& name, double c, double p, int num_points = 5) {
  PlotSeries series{name, {}, {}};
  for (int k = 0; k < num_points; ++k) {
    series.x.push_back(0.02 * std::pow(0.5, k));
    series.y.push_back(c * std::pow(series.x.back(), p));
  }
  return series;
}

Plot study() {
  return {"Convergence",
          "time step [s]",
          "error [m]",
          {power_law("backward-euler", 1, 1), power_law("bdf2", 2, 2), power_law("dirk33", 0.5, 3)},
          {1, 2, 3}};
}

/// Groups of every match.
std::vector<std::vector<std::string>> all_matches(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  std::vector<std::vector<std::string>> found;
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it) {
    found.emplace_back(it->begin(), it->end());
  }
  return found;
}

struct Pixel {
  double x, y;
};

/// The corners of each series' line.
std::vector<std::vector<Pixel>> polylines(const std::string& picture) {
  std::vector<std::vector<Pixel>> lines;
  for (const auto& line : all_matches(picture, R"re(<polyline points="([^"]*)")re")) {
    lines.emplace_back();
    for (const auto& p : all_matches(line[1], R"re(([-\d.]+),([-\d.]+))re")) {
      lines.back().push_back({std::stod(p[1]), std::stod(p[2])});
    }
  }
  return lines;
}

/// The frame by its two axes: the bottom, then the left side.
struct Frame {
  Pixel low, high;
  bool contains(const Pixel& p) const { return p.x >= low.x && p.x <= high.x && p.y >= high.y && p.y <= low.y; }
};

Frame frame_of(const std::string& picture) {
  const auto axes =
      all_matches(picture, R"re(<line x1="([\d.]+)" y1="([\d.]+)" x2="([\d.]+)" y2="([\d.]+)" class="axis"/>)re");
  EXPECT_EQ(axes.size(), 2u);
  return {{std::stod(axes[0][1]), std::stod(axes[0][2])}, {std::stod(axes[0][3]), std::stod(axes[1][2])}};
}

/// Is it XML, by Python's parser? On rank 0.
bool is_xml(const std::string& picture, const std::filesystem::path& file) {
  std::ofstream(file) << picture;
  const std::string command = "/usr/bin/python3 -c 'import sys, xml.dom.minidom as x; x.parse(sys.argv[1])' '";
  return std::system((command + file.string() + "'").c_str()) == 0;
}

TEST(SvgPlot, IsWellFormedWhateverTheTexts) {
  const auto file = empty_directory(comm, "svg_texts") / "plot.svg";
  Plot plot = study();
  plot.title = "a < b & \"c\" > 'd' \x01 caf\u00e9";
  plot.x_label = plot.y_label = "<x> & [m]";
  plot.series[0].name = "</g> & \"quoted\"";
  if (rank(comm) != 0) return;
  const std::string picture = svg(plot);
  EXPECT_TRUE(is_xml(picture, file)) << picture;
  EXPECT_NE(picture.find("&lt;/g&gt; &amp; &quot;quoted&quot;"), std::string::npos);
  EXPECT_TRUE(is_xml(svg({}), file)) << "nothing to draw";
  EXPECT_TRUE(is_xml(svg({"one", "x", "y", {{"point", {3}, {4}}, {"none", {}, {}}}, {2}}), file));
}

TEST(SvgPlot, ShowsEverySeriesInsideTheFrameAndInTheLegend) {
  const Plot plot = study();
  const std::string picture = svg(plot);
  const auto lines = polylines(picture);
  const Frame frame = frame_of(picture);
  ASSERT_EQ(lines.size(), plot.series.size());
  for (std::size_t s = 0; s < lines.size(); ++s) {
    EXPECT_EQ(lines[s].size(), plot.series[s].x.size());
    for (const Pixel& p : lines[s]) EXPECT_TRUE(frame.contains(p)) << p.x << ' ' << p.y;
    EXPECT_EQ(all_matches(picture, "class=\"name\">" + plot.series[s].name + "<").size(), 1u);
  }
  EXPECT_NE(picture.find("<title id=\"title\">Convergence</title>"), std::string::npos);
  EXPECT_NE(picture.find(">time step [s]</text>"), std::string::npos);
  EXPECT_NE(picture.find(">error [m]</text>"), std::string::npos);
  EXPECT_NE(picture.find("dirk33: 5 points of mean slope 3.00"), std::string::npos) << "in words too";
}

TEST(SvgPlot, HasRoomForTheNamesInItsLegend) {
  Plot plot = study();
  plot.series.front().name = "01_mu1=100_kPa,size=8_mm";
  constexpr double measured = 182.5;  // in DejaVu Sans of 12 px
  const auto width = all_matches(svg(plot), R"re(<svg [^>]*width="([0-9]+)")re");
  const auto name = all_matches(svg(plot), R"re(<text x="([0-9.]+)"[^>]*>01_mu1)re");
  ASSERT_EQ(name.size(), 1u);
  EXPECT_GT(std::stod(width.front()[1]) - std::stod(name.front()[1]), measured);
}

/// A power law is a straight line, and all are drawn to the same scale.
TEST(SvgPlot, PlacesPointsByTheirLogarithms) {
  const Plot plot = study();
  const auto lines = polylines(svg(plot));
  const double column = lines[0][1].x - lines[0][0].x, row = lines[0][1].y - lines[0][0].y;  // of one halving
  for (std::size_t s = 0; s < lines.size(); ++s) {
    const double order = static_cast<double>(s + 1);
    for (std::size_t k = 1; k < lines[s].size(); ++k) {
      EXPECT_NEAR(lines[s][k].x - lines[s][k - 1].x, column, 0.02) << "two decimals are written";
      EXPECT_NEAR(lines[s][k].y - lines[s][k - 1].y, order * row, 0.05);
    }
  }
}

struct AxisRange {
  double low, high;
  std::vector<std::string> labels;  ///< of the x axis, in this order
};

class SvgTicks : public testing::TestWithParam<AxisRange> {};

TEST_P(SvgTicks, StandAtRoundValues) {
  const auto& [low, high, labels] = GetParam();
  const std::string picture = svg({"ticks", "x", "y", {{"s", {low, high}, {1, 2}}}, {}});
  const auto ticks = all_matches(picture, R"re(<text x="([\d.]+)" y="[\d.]+" class="tick middle">([^<]*)<)re");
  const auto ends = polylines(picture).at(0);
  ASSERT_EQ(ticks.size(), labels.size()) << picture;
  const std::vector<std::string> superscripts{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    EXPECT_EQ(ticks[i][2], labels[i]);
    std::string number = std::regex_replace(labels[i], std::regex("·10|^10"), labels[i][0] == '1' ? "1e" : "e");
    number = std::regex_replace(number, std::regex("⁻"), "-");
    for (std::size_t d = 0; d < 10; ++d) {
      number = std::regex_replace(number, std::regex(superscripts[d]), std::to_string(d));
    }
    const double at = std::log(std::stod(number) / low) / std::log(high / low);
    EXPECT_NEAR(std::stod(ticks[i][1]), ends[0].x + at * (ends[1].x - ends[0].x), 0.02) << number;
    EXPECT_EQ(all_matches(picture, "<line x1=\"" + ticks[i][1] + "\" [^>]*class=\"major\"").size(), 1u) << "its line";
  }
}

INSTANTIATE_TEST_SUITE_P(
    Ranges, SvgTicks,
    testing::Values(AxisRange{1e-3, 1, {"10⁻³", "10⁻²", "10⁻¹", "10⁰"}},
                    AxisRange{0.00125, 0.02, {"0.002", "0.005", "0.01", "0.02"}},
                    AxisRange{1e-12, 1e3, {"10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰", "10²"}},
                    AxisRange{0.99, 1.01, {"1"}}));

/// A column of a history may be constant but for rounding; its ticks must be few, end, and be told apart.
class SvgFlatLine : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(SvgFlatLine, HasAFewTicksWithLabelsOfTheirOwn) {
  const auto [low, high] = GetParam();
  Plot plot{"total_energy", "time [s]", "total_energy", {{"run", {0.0, 1.0, 2.0}, {low, high, low}}}, {}};
  plot.scale = Scale::linear;
  std::set<std::string> labels;
  const auto ticks = all_matches(svg(plot), R"re(class="tick end">([^<]*)<)re");
  for (const auto& tick : ticks) labels.insert(tick[1]);
  EXPECT_GE(ticks.size(), 2U);
  EXPECT_LE(ticks.size(), 12U);
  EXPECT_EQ(labels.size(), ticks.size());
}

INSTANTIATE_TEST_SUITE_P(Values, SvgFlatLine,
                         ::testing::Values(std::pair(0.0, 0.0), std::pair(3.5, 3.5), std::pair(-1e20, -1e20),
                                           std::pair(1e-5, std::nextafter(1e-5, 1.0)),
                                           std::pair(-7e3, std::nextafter(-7e3, 0.0)),
                                           std::pair(std::nextafter(0.0, -1.0), std::nextafter(0.0, 1.0)),
                                           std::pair(2.0, 2.0 + 1e-9), std::pair(2.0, 2.0 + 1e-6),
                                           std::pair(0.0, 1e-300), std::pair(-1e300, 1e300)));

TEST(SvgPlot, LinearAxesHaveUnitsThatSuitTheirValues) {
  Plot plot{"a title", "time [s]", "tip_z [m]", {{"run", {0.0, 1.0}, {0.0, -0.05}}}};
  plot.scale = Scale::linear;
  const std::string picture = svg(plot);
  EXPECT_NE(picture.find(">time [s]</text>"), std::string::npos);
  EXPECT_NE(picture.find(">tip_z [mm]</text>"), std::string::npos);
  EXPECT_NE(picture.find(">-40</text>"), std::string::npos);
  const std::vector<std::array<std::string, 2>> units{
      {"[Pa]", "[kPa]"},      {"[m^3]", "[cm³]"}, {"[kg/m^3]", "[kg/m³]"}, {"[m s^-2]", "[m s⁻²]"},
      {"[m^2.5]", "[m^2.5]"}, {"[kg]", "[kg]"},   {"[mm]", "[mm]"}};
  for (const auto& [given, shown] : units) {
    plot.y_label = "value " + given;
    plot.series[0].y = {0.0, given == "[m^3]" ? 2e-6 : 5e3};
    EXPECT_NE(svg(plot).find(">value " + shown + "</text>"), std::string::npos) << given;
  }
}

TEST(SvgPlot, LinesOfTheSameColourHaveOtherDashes) {
  Plot plot{"a title", "x", "y", {}};
  plot.scale = Scale::linear;
  for (int k = 0; k < 24; ++k) plot.series.push_back({std::to_string(k), {0.0, 1.0}, {0.0, 1.0 + k}});
  const std::string picture = svg(plot);
  std::set<std::string> looks;
  for (const auto& m : all_matches(picture, R"re(stroke="(#\w+)" fill="#\w+">\n<polyline points="[^"]*"([^>]*)/>)re")) {
    looks.insert(m[1] + m[2]);
  }
  EXPECT_EQ(looks.size(), 24u);
}

TEST(SvgPlot, LeavesOutWhatHasNoLogarithm) {
  const std::string picture =
      svg({"holes",
           "x",
           "y",
           {{"holes", {1, 0.1, 0, -1, 0.01, infinity, 1e-3}, {1, std::nan(""), 1, 1, 0.0, 1, 0.1}}, {"none", {0}, {1}}},
           {1}});
  const auto lines = polylines(picture);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].size(), 2u);
  EXPECT_TRUE(lines[1].empty());
  EXPECT_EQ(picture.find("nan"), std::string::npos);
  EXPECT_EQ(picture.find("inf"), std::string::npos);
}

TEST(SvgPlot, TrianglesHaveTheirSlopesAndLieBelowTheirSeries) {
  const Plot plot = study();
  const std::string picture = svg(plot);
  const Frame frame = frame_of(picture);
  const auto triangles = all_matches(
      picture, R"re(<path d="M([\d.]+),([\d.]+) L([\d.]+),([\d.]+) L([\d.]+),([\d.]+) z" class="slope"/>)re");
  const auto orders = all_matches(picture, R"re(class="order">order ([\d.]+)<)re");
  const auto lines = polylines(picture);
  const double scale = (lines[0][1].y - lines[0][0].y) / (lines[0][1].x - lines[0][0].x);  // of slope 1
  ASSERT_EQ(triangles.size(), plot.slopes.size());
  ASSERT_EQ(orders.size(), plot.slopes.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto number = [&](std::size_t k) { return std::stod(triangles[i][k]); };
    const Pixel left{number(1), number(2)}, corner{number(3), number(4)}, right{number(5), number(6)};
    EXPECT_EQ(std::stod(orders[i][1]), plot.slopes[i]);
    EXPECT_NEAR((right.y - left.y) / (right.x - left.x), plot.slopes[i] * scale, 1e-3);
    for (const Pixel& p : {left, corner, right}) EXPECT_TRUE(frame.contains(p));
    const Pixel &a = lines[i].front(), &b = lines[i].back();
    const double line_at_left = b.y + (a.y - b.y) * (left.x - b.x) / (a.x - b.x);
    EXPECT_NEAR(left.y - line_at_left, 16.0, 1.5) << "below its series, by a little";
  }
}

TEST(SvgPlot, IsWrittenInOneGo) {
  const auto directory = empty_directory(comm, "svg");
  write_svg(comm, directory / "plot.svg", study());
  on_root(comm, [&] {
    std::ifstream stream(directory / "plot.svg");
    EXPECT_EQ((std::string{std::istreambuf_iterator<char>(stream), {}}), svg(study()));
    EXPECT_FALSE(std::filesystem::exists(directory / "plot.svg.part"));
  });
  EXPECT_THROW(write_svg(comm, directory / "missing" / "plot.svg", study()), FileError) << "on every rank";
}

TEST(SvgPlot, MeasurementsAreMarksAndTheirCurveHasTheSameColour) {
  Plot plot{"fit", "time [s]", "stress [kPa]", {}};
  plot.scale = Scale::linear;
  plot.x_scale = Scale::logarithmic;
  plot.series = {{"measured", {1.0, 10.0, 100.0}, {3.0, 2.0, 1.0}, SeriesStyle::marks, 1},
                 {"fitted", {1.0, 100.0}, {3.0, 1.0}, SeriesStyle::line, 1}};
  const std::string picture = svg(plot);
  ASSERT_EQ(polylines(picture).size(), 1u);
  const auto marks =
      all_matches(picture, R"re(<rect x="([\d.]+)" y="([\d.]+)" width="7.2" height="7.2"><title>([^<]*))re");
  ASSERT_EQ(marks.size(), 3u);
  EXPECT_EQ(marks[1][3], "measured: 10, 2");
  // Decades are equally far apart, and so are stresses.
  for (const std::size_t axis : {1u, 2u}) {
    EXPECT_NEAR(std::stod(marks[1][axis]), 0.5 * (std::stod(marks[0][axis]) + std::stod(marks[2][axis])), 0.02);
  }
  EXPECT_EQ(all_matches(picture, "<g class=\"series\" stroke=\"(#[0-9a-f]+)\"").size(), 4u);
  std::set<std::string> colours;
  for (const auto& match : all_matches(picture, "<g class=\"series\" stroke=\"(#[0-9a-f]+)\""))
    colours.insert(match[1]);
  EXPECT_EQ(colours.size(), 1u);
}

}  // namespace
}  // namespace pliant::test_svg_plot
