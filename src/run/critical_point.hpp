/// Points of a path of equilibria at which stability may change.
#pragma once

#include <string>

namespace pliant {

/// A limit point, where the load factor is largest or smallest, or a bifurcation, where another path crosses: there the
/// number of unstable modes changes although the load factor does not turn back.
struct CriticalPoint {
  enum class Kind { maximum, minimum, bifurcation };
  Kind kind = Kind::maximum;
  double load_factor = 0.0;  ///< at a limit point; of a bifurcation, at the end of the step that has passed it

  bool operator==(const CriticalPoint&) const = default;
};

/// "maximum", "minimum" or "bifurcation".
const char* name_of(CriticalPoint::Kind kind);

/// For the log: "a limit point: the load factor has a maximum of 1.85".
std::string in_words(const CriticalPoint& point);

}  // namespace pliant
