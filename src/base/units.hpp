/// Numbers with units, as users write them, turned into SI.
#pragma once

#include <stdexcept>
#include <string>

namespace pliant {

/// A text is not a number with a fitting unit; `what()` says why in plain words.
class UnitError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The value in SI of a text such as "5 ms", "1.2 g/cm^3" or "20 Pa*s"; a bare number is SI already. Units are those of
/// udunits2 (metric prefixes, powers, products, quotients), but never with an offset (degrees Celsius) or a reciprocal
/// (Hz for s). `unit`: the SI unit that is expected, "1" for a pure number. Throws UnitError; its database missing:
/// std::runtime_error.
double parse_quantity(const std::string& text, const std::string& unit);

/// Does the text have the form of a bare number or of a number and a unit (known or not), rather than of a formula?
bool looks_like_quantity(const std::string& text);

/// "a pressure [Pa]" for "Pa", "a number" for "1"; for messages.
std::string quantity_name(const std::string& unit);

}  // namespace pliant
