#include "base/units.hpp"

#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_units {
namespace {

struct Good {
  const char* text;
  const char* unit;
  double value;
};

class GoodQuantity : public testing::TestWithParam<Good> {};

TEST_P(GoodQuantity, IsTurnedIntoSI) {
  const auto& [text, unit, value] = GetParam();
  // Exactly: powers of ten are applied with one rounding, as the decimal text is.
  EXPECT_EQ(parse_quantity(text, unit), value) << text;
  EXPECT_TRUE(looks_like_quantity(text) || std::string(text).find('/') != std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(Units, GoodQuantity,
                         testing::Values(Good{"5 ms", "s", 0.005}, Good{"5ms", "s", 0.005}, Good{" 5  ms ", "s", 0.005},
                                         Good{"0.7 mm", "m", 0.0007}, Good{"1 MPa", "Pa", 1e6},
                                         Good{"2.5 N/mm^2", "Pa", 2.5e6}, Good{"1.2 g/cm^3", "kg/m^3", 1200},
                                         Good{"20 Pa*s", "Pa*s", 20}, Good{"0.1 s/m", "s/m", 0.1},
                                         Good{"9.81 m/s^2", "m/s^2", 9.81}, Good{"9.81 m s-2", "m/s^2", 9.81},
                                         Good{"40 %", "1", 0.4}, Good{"-2 kPa", "Pa", -2000}, Good{"1e-3 km", "m", 1},
                                         Good{"3 min", "s", 180}, Good{"5 \u00b5m", "m", 5e-6}, Good{"5 um", "m", 5e-6},
                                         Good{"4 1/s", "1/s", 4}, Good{"4 /s", "1/s", 4}, Good{"50 Hz", "1/s", 50},
                                         Good{"7", "Pa", 7}, Good{"-1.5e3", "m", -1500}, Good{"0.3", "1", 0.3},
                                         Good{"2 rad", "1", 2}, Good{"180 deg", "rad", std::numbers::pi}));

struct Bad {
  const char* text;
  const char* unit;
  const char* message;
};

class BadQuantity : public testing::TestWithParam<Bad> {};

TEST_P(BadQuantity, IsRefusedInPlainWords) {
  const auto& [text, unit, message] = GetParam();
  try {
    const double value = parse_quantity(text, unit);
    FAIL() << text << " was read as " << value;
  } catch (const UnitError& error) {
    EXPECT_STREQ(error.what(), message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Units, BadQuantity,
    testing::Values(
        Bad{"5 mm", "s", "'5 mm' is a length, but a time [s] is expected"},
        Bad{"5 ms", "Pa", "'5 ms' is a time, but a pressure [Pa] is expected"},
        Bad{"5 Hz", "s", "'5 Hz' is a frequency, but a time [s] is expected"},
        Bad{"1 m", "1", "'1 m' is a length, but a number without a unit is expected"},
        Bad{"40 %", "m", "'40 %' is a pure number, but a length [m] is expected"},
        Bad{"1 A", "m", "'1 A' is in [A], but a length [m] is expected"},
        Bad{"5 mmm", "m", "'mmm' in '5 mmm' is not a known unit, but a length [m] is expected"},
        Bad{"1 KPa", "Pa",
            "'KPa' in '1 KPa' is not a known unit (did you mean 'kPa'?), but a pressure [Pa] is expected"},
        Bad{"5 degr", "rad", "'5 degr' is a temperature (did you mean 'deg'?), but an angle [rad] is expected"},
        Bad{"5 degress", "rad",
            "'degress' in '5 degress' is not a known unit (did you mean 'deg'?), but an angle [rad] is "
            "expected"},
        Bad{"abc", "m", "'abc' is not a number, but a length [m] is expected"},
        Bad{"", "m", "'' is not a number, but a length [m] is expected"},
        Bad{"1,5 mm", "m", "'1,5 mm' is not a number (a decimal point is written '.')"},
        Bad{"1 000 mm", "m", "'1 000 mm' is neither a number nor a number with a unit, but a length [m] is expected"},
        Bad{"1 2", "m", "'1 2' is neither a number nor a number with a unit, but a length [m] is expected"},
        Bad{"20 degC", "K", "'20 degC' has a unit with an offset, but a temperature [K] is expected"},
        Bad{"5 s since 2000-01-01", "s",
            "'5 s since 2000-01-01' is in [s since 2000-01-01], but a time [s] is expected"},
        Bad{"3 dB", "1", "'dB' in '3 dB' is not a known unit, but a number is expected"},
        Bad{"1e308 km", "m", "'1e308 km' is too large for a number"},
        Bad{"inf", "m", "'inf' is not a number, but a length [m] is expected"}));

TEST(Quantity, HasAFormUnlikeAFormula) {
  for (const char* text : {"5", "5 ms", "2 kPa", "1 nonsense", "-1e3", "2 kPa*sin(t)"}) {
    EXPECT_TRUE(looks_like_quantity(text)) << text;
  }
  for (const char* text : {"", "t", "-100*sin(2*pi*t)", "2*t", "2 * t", "(1)", "1-t", "1/3", "2^3", "-x", "1 < 2"}) {
    EXPECT_FALSE(looks_like_quantity(text)) << text;
  }
}

TEST(Quantity, IsNamedWithItsUnit) {
  EXPECT_EQ(quantity_name("Pa"), "a pressure [Pa]");
  EXPECT_EQ(quantity_name("1"), "a number");
  EXPECT_EQ(quantity_name("A"), "a quantity [A]");
}

}  // namespace
}  // namespace pliant::test_units
