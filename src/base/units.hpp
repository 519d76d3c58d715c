/// Numbers with units, as users write them, converted to SI.
#pragma once

#include <stdexcept>
#include <string>

namespace pliant {

/// A text that is not a number with a fitting unit; `what()` explains why.
class UnitError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The SI value of a text such as "5 ms", "1.2 g/cm^3" or "20 Pa*s"; a bare number is SI already. Units are those of
/// udunits2 (metric prefixes, powers, products, quotients), without offsets (degrees Celsius) and reciprocals (Hz for
/// s). `unit`: the expected SI unit, "1" for a pure number. Throws UnitError; std::runtime_error if the database of
/// units is missing.
double parse_quantity(const std::string& text, const std::string& unit);

/// Whether the text has the form of a bare number or of a number and a unit (known or not), rather than of a formula.
bool looks_like_quantity(const std::string& text);

/// "a pressure [Pa]" for "Pa", "a number" for "1"; used in messages.
std::string quantity_name(const std::string& unit);

}  // namespace pliant
