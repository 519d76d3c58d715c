/// An input of which some numbers are varied.
#pragma once

#include "input/input.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A number of the input, named as for --set.
struct VariedNumber {
  std::string key;
  double value = 0.0;  ///< that the input gives it [SI]
  std::string unit;    ///< SI; "1" for numbers without a unit
};

/// The SI unit of bare numbers at a key of the input, as the table of keys has it; "1" for a pure number, and where the
/// table does not say.
std::string unit_of_key(const std::string& key);

class VariedInput {
 public:
  /// `text`: of the input, `file`: its name for messages. Throws InputError if the input is wrong, or a key is none of
  /// a single number, or of one on which the mesh, the steps or the output depend. `option`: where the keys were given,
  /// for messages. Not collective.
  VariedInput(std::string text, std::string file, std::vector<Override> changes, const std::vector<std::string>& keys,
              const std::string& option);

  const std::string& file() const { return file_; }
  const Config& given() const { return given_; }
  const std::vector<VariedNumber>& numbers() const { return numbers_; }
  /// The input with these values of the numbers. Throws InputError if it does not take them.
  Config at(std::span<const double> values) const;

 private:
  std::string text_, file_;
  std::vector<Override> changes_;
  Config given_;
  std::vector<VariedNumber> numbers_;
};

}  // namespace pliant
