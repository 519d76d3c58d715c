// Samples: one in each interval of each range, the same each time; and how ranges are written.
#include "study/latin_hypercube.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pliant::test_latin_hypercube {
namespace {

TEST(LatinHypercube, HasOnePointInEachIntervalOfEachRange) {
  for (const std::size_t count : {1u, 7u, 100u}) {
    const auto points = latin_hypercube(count, 3, 5);
    ASSERT_EQ(points.size(), count);
    for (std::size_t d = 0; d < 3; ++d) {
      std::set<int> intervals;
      for (const auto& point : points) {
        EXPECT_GE(point[d], 0.0);
        EXPECT_LT(point[d], 1.0);
        intervals.insert(static_cast<int>(point[d] * static_cast<double>(count)));
      }
      EXPECT_EQ(intervals.size(), count);
    }
  }
}

TEST(LatinHypercube, IsRepeatableAndDependsOnTheSeed) {
  EXPECT_EQ(latin_hypercube(20, 2, 1), latin_hypercube(20, 2, 1));
  EXPECT_NE(latin_hypercube(20, 2, 1), latin_hypercube(20, 2, 2));
}

TEST(LatinHypercube, MixesItsRanges) {
  // Correlated ranges would show in the mean of the products; of 1000 independent pairs it has the deviation 0.0026.
  double product = 0.0;
  for (const auto& p : latin_hypercube(1000, 2, 3)) product += (p[0] - 0.5) * (p[1] - 0.5) / 1000.0;
  EXPECT_LT(std::abs(product), 0.012);
}

TEST(NumberRange, IsReadWithItsUnit) {
  const auto plain = parse_range("900..1100");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->low, 900.0);
  EXPECT_EQ(plain->high, 1100.0);
  EXPECT_EQ(plain->unit, "");
  for (const char* text : {"-1e3 kPa..2 kPa", "-1e3..2 kPa", " -1000kPa .. 2kPa"}) {
    const auto range = parse_range(text);
    ASSERT_TRUE(range) << text;
    EXPECT_EQ(range->low, -1000.0);
    EXPECT_EQ(range->high, 2.0);
    EXPECT_EQ(range->unit, "kPa");
  }
  for (const char* text : {"", "5", "1..", "..2", "../meshes/a.msh", "a..b", "1..2*t", "sin(t)..2"}) {
    EXPECT_FALSE(parse_range(text)) << text;
  }
  for (const char* text : {"2..1", "1..1", "1 ms..2 s", "1 kg..2"}) {
    EXPECT_THROW((void)parse_range(text), std::invalid_argument) << text;
  }
}

TEST(NumberRange, ValuesStayInsideAndHaveFewDigits) {
  EXPECT_EQ((NumberRange{1.0, 2.0, "MPa"}).at(0.25), "1.25 MPa");
  EXPECT_EQ((NumberRange{1.0, 2.0, ""}).at(1.0 / 3.0), "1.33333");
  EXPECT_EQ((NumberRange{1.0, 100.0, "", true}).at(0.5), "10");
  EXPECT_EQ((NumberRange{0.1234563, 0.2, ""}).at(0.0), "0.1234563");  // would be rounded to below the range
  std::set<std::string> texts;
  for (int i = 0; i < 100; ++i) texts.insert((NumberRange{1e6, 1e6 + 1.0, ""}).at(i / 100.0));
  EXPECT_EQ(texts.size(), 100u);
}

}  // namespace
}  // namespace pliant::test_latin_hypercube
