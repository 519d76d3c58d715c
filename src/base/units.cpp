#include "base/units.hpp"

#include "base/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include <udunits2.h>

namespace pliant {
namespace {

struct Deleter {
  void operator()(ut_system* x) const { ut_free_system(x); }
  void operator()(ut_unit* x) const { ut_free(x); }
  void operator()(cv_converter* x) const { cv_free(x); }
};
using UnitSystem = std::unique_ptr<ut_system, Deleter>;
using Unit = std::unique_ptr<ut_unit, Deleter>;
using Converter = std::unique_ptr<cv_converter, Deleter>;

struct Dimension {
  const char* unit;
  const char* name;
};

/// Names of the most common dimensions; the first entry with the same dimension names a quantity.
constexpr std::array dimensions{
    Dimension{"m", "a length"},
    Dimension{"s", "a time"},
    Dimension{"kg", "a mass"},
    Dimension{"Pa", "a pressure"},
    Dimension{"kg/m^3", "a density"},
    Dimension{"m/s", "a velocity"},
    Dimension{"m/s^2", "an acceleration"},
    Dimension{"N", "a force"},
    Dimension{"J", "an energy"},
    Dimension{"W", "a power"},
    Dimension{"Pa*s", "a viscosity"},
    Dimension{"s/m", "an inverse velocity"},
    Dimension{"m^2", "an area"},
    Dimension{"m^3", "a volume"},
    Dimension{"m^3/s", "a volume flow"},
    Dimension{"1/s", "a frequency"},
    Dimension{"Hz", "a frequency"},
    Dimension{"N/m", "a stiffness"},
    Dimension{"K", "a temperature"},
    Dimension{"1", "a pure number"},
    Dimension{"rad", "an angle"},
    // These have the dimensions of others above.
    Dimension{"rad/s", "an angular velocity"},
    Dimension{"N*m", "a torque"},
    Dimension{"N*m/rad", "a torque per angle"},
    Dimension{"N*m*s/rad", "a torque per angular velocity"},
    Dimension{"N*s/m", "a force per velocity"},
};

UnitSystem loaded_system() {
  ut_set_error_message_handler(ut_ignore);  // udunits writes to stderr otherwise
  UnitSystem system(ut_read_xml(nullptr));
  if (!system)
    throw FileError("the database of units cannot be read; install udunits2's data (Debian: libudunits2-data)");
  const Unit degree(ut_parse(system.get(), "degree", UT_ASCII));
  (void)ut_map_name_to_unit("deg", UT_ASCII, degree.get());  // commonly written, but unknown to udunits
  return system;
}

ut_system* system_of_units() {
  static const UnitSystem system = loaded_system();
  return system.get();
}

Unit parsed_unit(const std::string& text) {
  return Unit(ut_parse(system_of_units(), text.c_str(), UT_UTF8));
}

/// Equal dimensions; unlike ut_are_convertible this distinguishes s from Hz.
bool same_dimension(const ut_unit* a, const ut_unit* b) {
  const Unit quotient(ut_divide(a, b));
  return quotient && ut_is_dimensionless(quotient.get()) != 0 && ut_are_convertible(a, b) != 0;
}

/// The factor from `unit` to `expected`; nothing if the conversion is not a plain factor.
std::optional<double> conversion_factor(ut_unit* unit, ut_unit* expected) {
  const Converter converter(ut_get_converter(unit, expected));
  if (!converter || cv_convert_double(converter.get(), 0.0) != 0.0) return {};
  return cv_convert_double(converter.get(), 1.0);
}

/// value * factor, rounded only once for factors that are whole numbers or their reciprocals (1000, 1/1000), so that
/// "0.7 mm" is 0.0007.
double scaled(double value, double factor) {
  constexpr double tolerance = 1e-14;  // udunits' own rounding of g/cm^3 is 1e-16
  const double whole = std::round(factor);
  if (std::abs(factor - whole) <= tolerance * whole) return value * whole;
  const double reciprocal = std::round(1 / factor);
  if (std::abs(factor * reciprocal - 1) <= tolerance) return value / reciprocal;
  return value * factor;
}

struct NumberAndUnit {
  double number;
  std::string unit;  // empty if the text has none
};

/// Splits a text into its longest leading number and the rest without blanks.
std::optional<NumberAndUnit> split_quantity(std::string_view text) {
  text = trimmed(text);
  const std::size_t digits = text.find_first_not_of("+-.0123456789eE");
  for (std::size_t end = std::min(digits, text.size()); end > 0; --end) {
    if (const auto number = parse_number(text.substr(0, end))) {
      return NumberAndUnit{*number, std::string(trimmed(text.substr(end)))};
    }
  }
  return {};
}

bool starts_unit(const std::string& text) {
  const auto first = static_cast<unsigned char>(text.front());
  return std::isalpha(first) != 0 || first >= 0x80 || first == '%';
}

/// " (did you mean 'MPa'?)" for "Mpa", as units are case-sensitive, and 'deg' for "degr" of an angle; else empty.
std::string meant_unit(const std::string& text, const std::string& wanted) {
  if (wanted == "rad" && text.starts_with("deg")) return " (did you mean 'deg'?)";
  constexpr std::array units{"Pa", "kPa", "MPa", "GPa", "N",  "kN",   "mm",    "cm",
                             "um", "ms",  "us",  "kg",  "Hz", "Pa*s", "kg/m^3"};
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  const auto* const meant =
      std::ranges::find_if(units, [&](std::string_view unit) { return std::ranges::equal(unit, text, same); });
  return meant == units.end() ? "" : " (did you mean '" + std::string(*meant) + "'?)";
}

/// "a length", or the unit itself where the dimension has no name.
std::string dimension_of(const ut_unit* unit, const std::string& text) {
  for (const auto& d : dimensions) {
    if (same_dimension(unit, parsed_unit(d.unit).get())) return d.name;
  }
  return "in [" + text + "]";
}

}  // namespace

std::string quantity_name(const std::string& unit) {
  if (unit == "1") return "a number";
  for (const auto& d : dimensions) {
    if (unit == d.unit) return std::string(d.name) + " [" + unit + "]";
  }
  return "a quantity [" + unit + "]";
}

bool looks_like_quantity(const std::string& text) {
  const auto parts = split_quantity(text);
  return parts && (parts->unit.empty() || starts_unit(parts->unit));
}

double parse_quantity(const std::string& text, const std::string& unit) {
  const std::string wanted = quantity_name(unit) + " is expected";
  const auto parts = split_quantity(text);
  const std::string quoted = "'" + excerpt(text) + "'";
  if (!parts) throw UnitError(quoted + " is not a number, but " + wanted);
  if (parts->unit.empty()) return parts->number;

  constexpr std::size_t longest_unit = 200;  // udunits follows brackets of any depth on the stack
  if (parts->unit.size() > longest_unit) throw UnitError(quoted + " is not a number with a unit, but " + wanted);
  const bool quotient = parts->unit.starts_with('/') || parts->unit.starts_with("1/");
  if (parts->unit.starts_with(',')) throw UnitError(quoted + " is not a number (a decimal point is written '.')");
  if (!quotient && !starts_unit(parts->unit)) {
    throw UnitError(quoted + " is neither a number nor a number with a unit, but " + wanted);
  }
  const Unit given = parsed_unit(parts->unit.starts_with('/') ? "1" + parts->unit : parts->unit);
  if (!given) {
    throw UnitError("'" + excerpt(parts->unit) + "' in " + quoted + " is not a known unit" +
                    meant_unit(parts->unit, unit) + ", but " + wanted);
  }
  const Unit expected = parsed_unit(unit);
  if (!same_dimension(given.get(), expected.get())) {
    throw UnitError(quoted + " is " + dimension_of(given.get(), excerpt(parts->unit)) +
                    (unit == "rad" ? meant_unit(parts->unit, unit) : "") + ", but " +
                    (unit == "1" ? "a number without a unit is expected" : wanted));
  }
  const auto factor = conversion_factor(given.get(), expected.get());
  if (!factor) throw UnitError(quoted + " has a unit with an offset, but " + wanted);
  const double value = scaled(parts->number, *factor);
  if (!std::isfinite(value)) throw UnitError(quoted + " is too large for a number");
  return value;
}

}  // namespace pliant
