/// Two neighbouring inputs, of which central differences are taken.
#pragma once

#include "base/error.hpp"

#include <array>
#include <string>
#include <utility>

namespace pliant {

/// The change of a number, as a part of it: where h^2 and the rounding errors over h are about equal. Smaller parts are
/// tried where the input does not take the larger change.
inline constexpr std::array parts_of_number{1e-5, 1e-6};

/// What `make(value)` makes of a number that is a little smaller and of one that is a little larger. `spacing`: their
/// difference.
template <class Made>
struct Neighbours {
  Made below, above;
  double spacing = 0.0;
};

/// `size`: of the number, of which a small part is a small change. A number at the end of its range is changed to one
/// side alone. Throws the InputError of `make` where it takes neither larger nor smaller values.
template <class Make>
auto neighbours_of(double value, double size, const Make& make) {
  using Result = Neighbours<decltype(make(value))>;
  for (const double part : parts_of_number) {
    for (const auto& [down, up] : {std::pair(-1.0, 1.0), std::pair(0.0, 0.01), std::pair(-0.01, 0.0)}) {
      const double low = value + down * part * size, high = value + up * part * size;
      try {
        return Result{make(low), make(high), high - low};
      } catch (const InputError&) {
        if (part == parts_of_number.back() && up == 0.0) throw;
      }
    }
  }
  throw InputError({}, "a number has no neighbours");
}

/// The size of a number of an input that is not 0, of which a small part is a small change: that of its distance to 1/2
/// for Poisson's ratio, where stiffness depends on that.
double size_of_number(const std::string& key, double value);

/// For a number whose value is 0 and whose size is unknown.
InputError without_neighbours(const std::string& file, const std::string& key);

}  // namespace pliant
