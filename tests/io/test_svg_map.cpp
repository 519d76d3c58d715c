// The map is well-formed, has the colours and contours of its values at the right places, and says it in words.
#include "io/svg_map.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "sample.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <regex>
#include <set>
#include <utility>

#include <gtest/gtest.h>

namespace pliant::test_svg_map {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::smatch> all_matches(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  return {std::sregex_iterator(text.begin(), text.end(), expression), std::sregex_iterator()};
}

/// f at every x with every y.
template <typename Function>
ValueMap grid(const std::vector<double>& x, const std::vector<double>& y, Function f) {
  ValueMap map{"title", "x [m]", "y [s]", "value [J]", {}, {}, {}};
  for (const double yj : y) {
    for (const double xi : x) {
      map.x.push_back(xi);
      map.y.push_back(yj);
      map.values.push_back(f(xi, yj));
    }
  }
  return map;
}

const std::vector<double> five{0, 1, 2, 3, 4};
/// So many that their rectangles have no room for numbers.
const std::vector<double> many{0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.25, 2.5, 2.75, 3, 3.25, 3.5, 3.75, 4};

TEST(SvgMap, IsWellFormedWhateverIsInIt) {
  const auto directory = empty_directory(comm, "svg_map");
  if (rank(comm) != 0) return;
  ValueMap odd = grid(five, {1, 2}, [](double, double) { return nan; });
  odd.title = odd.value_label = "</g> & \"quoted\" <x>";
  ValueMap scattered = grid(five, {1, 2}, [](double x, double y) { return x * y; });
  scattered.values[3] = nan;
  scattered.x[4] = 0.5;
  int number = 0;
  for (const ValueMap& map : {odd, scattered, ValueMap{}, grid({1, 2}, {1, 2}, [](double, double) { return 7.0; })}) {
    const auto file = directory / (std::to_string(++number) + ".svg");
    std::ofstream(file) << svg_map(map);
    const std::string command = "/usr/bin/python3 -c 'import sys, xml.dom.minidom as x; x.parse(sys.argv[1])' '";
    EXPECT_EQ(std::system((command + file.string() + "'").c_str()), 0) << number;
  }
}

TEST(SvgMap, ColoursTheRectanglesOfAGrid) {
  ValueMap map = grid(five, {0, 10, 20}, [](double x, double y) { return x + y; });
  map.values[7] = nan;
  const std::string picture = svg_map(map);
  const auto cells =
      all_matches(picture, R"re(<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)" fill="(#\w+)">)re");
  ASSERT_EQ(cells.size(), 15u);
  double area = 0.0;
  for (const auto& cell : cells) area += std::stod(cell[3]) * std::stod(cell[4]);
  EXPECT_EQ(area, svg_frame::width * svg_frame::height);
  EXPECT_EQ(cells[0][5], "#440154");  // the ends of viridis
  EXPECT_EQ(cells[14][5], "#fde725");
  EXPECT_EQ(cells[7][5], "#d5d9df");
  std::set<std::string> colours;
  for (const auto& cell : cells) colours.insert(cell[5]);
  EXPECT_EQ(colours.size(), 15u);
  EXPECT_NE(picture.find("value [J] as colours over x [m] and y [s]: 14 of 15 points have a value, from 0 at (0, 0) to "
                         "24 at (4, 20)."),
            std::string::npos);
}

struct Segment {
  std::array<double, 4> at;  // x, y of both ends in values of the axes
};

/// Of the contour of this level, back from pixels. `half`: of the distance of points, by which the axes are longer.
std::vector<Segment> contour(const std::string& picture, const std::string& level, double low, double high) {
  const double scale_x = (high - low) / svg_frame::width, scale_y = (high - low) / svg_frame::height;
  std::vector<Segment> segments;
  const auto paths =
      all_matches(picture, "<path d=\"([^\"]*)\" style=\"fill:none;stroke:white[^>]*><title>" + level + "</title>");
  if (paths.size() != 1) return segments;
  const std::string path = paths[0][1];
  for (const auto& m : all_matches(path, R"re(M([\d.]+),([\d.]+) L([\d.]+),([\d.]+))re")) {
    Segment s{};
    for (std::size_t k = 0; k < 4; ++k) {
      const double pixel = std::stod(m[k + 1]);
      s.at[k] = k % 2 == 0 ? low + (pixel - svg_frame::left) * scale_x : low + (svg_frame::bottom - pixel) * scale_y;
    }
    segments.push_back(s);
  }
  return segments;
}

TEST(SvgMap, ContoursFollowTheirLevels) {
  const std::string plane = svg_map(grid(many, many, [](double x, double y) { return x + 2.0 * y; }));
  for (const double level : {2.0, 6.0, 10.0}) {
    const auto segments = contour(plane, std::to_string(static_cast<int>(level)), -0.125, 4.125);
    EXPECT_GE(segments.size(), 2u) << level;
    for (const Segment& s : segments) {
      EXPECT_NEAR(s.at[0] + 2.0 * s.at[1], level, 1e-3);
      EXPECT_NEAR(s.at[2] + 2.0 * s.at[3], level, 1e-3);
    }
  }
  // A ring: every end is that of two segments.
  const std::string bowl =
      svg_map(grid(many, many, [](double x, double y) { return (x - 2.1) * (x - 2.1) + (y - 1.9) * (y - 1.9); }));
  const auto segments = contour(bowl, "2", -0.125, 4.125);
  ASSERT_GE(segments.size(), 4u);
  std::map<std::pair<long, long>, int> ends;
  for (const Segment& s : segments) {
    ++ends[{std::lround(100 * s.at[0]), std::lround(100 * s.at[1])}];
    ++ends[{std::lround(100 * s.at[2]), std::lround(100 * s.at[3])}];
  }
  for (const auto& [place, count] : ends) EXPECT_EQ(count, 2);
  // They would strike through numbers.
  EXPECT_EQ(svg_map(grid(five, five, [](double x, double y) { return x + 2.0 * y; })).find("fill:none"),
            std::string::npos);
}

TEST(SvgMap, HasUnitsThatSuitItsValues) {
  const std::string picture = svg_map(grid({0.01, 0.02}, {1, 2}, [](double x, double y) { return 1e5 * x * y; }));
  EXPECT_NE(
      picture.find("value [kJ] as colours over x [mm] and y [s]: 4 of 4 points have a value, from 1 at (10, 1) to "
                   "4 at (20, 2)."),
      std::string::npos);
}

TEST(SvgMap, ASaddleIsCutAsItsMiddleSays) {
  // Corners 0, 10 | 10, 0 with the middle at 5: the level 4 cuts off the corners of 0, the level 6 those of 10.
  // Other points, without values, make the rectangles small.
  std::vector<double> places(17);
  std::iota(places.begin(), places.end(), 0.0);
  const std::string saddle = svg_map(grid(places, places, [](double x, double y) {
    return x > 1.0 || y > 1.0 ? nan : x == y ? 0.0 : 10.0;
  }));
  for (const auto& [level, is_at_equal] : {std::pair{"4", true}, std::pair{"6", false}}) {
    const auto segments = contour(saddle, level, -0.5, 16.5);
    ASSERT_EQ(segments.size(), 2u);
    for (const Segment& s : segments) {
      const double x = 0.5 * (s.at[0] + s.at[2]), y = 0.5 * (s.at[1] + s.at[3]);
      EXPECT_EQ(std::abs(x - y) < 0.3, is_at_equal) << level << ": " << x << ' ' << y;
    }
  }
}

TEST(SvgMap, PointsThatAreNotAGridAreMarks) {
  ValueMap map{"t", "x", "y", "v", {1, 10, 100, -5}, {0, 1, 0.5, 0}, {3, 4, 5, 6}, Scale::logarithmic};
  const auto marks = all_matches(svg_map(map), R"re(<circle cx="([\d.]+)" cy="([\d.]+)" r="7" fill="(#\w+)")re");
  ASSERT_EQ(marks.size(), 3u);  // -5 has no place on a logarithmic axis
  EXPECT_NEAR(std::stod(marks[1][1]), 0.5 * (std::stod(marks[0][1]) + std::stod(marks[2][1])), 0.02);
  EXPECT_EQ(marks[0][3], "#440154");
  EXPECT_EQ(marks[2][3], "#fde725");
}

}  // namespace
}  // namespace pliant::test_svg_map
