#include "run/critical_point.hpp"

#include <fmt/format.h>

namespace pliant {

const char* name_of(CriticalPoint::Kind kind) {
  switch (kind) {
    case CriticalPoint::Kind::maximum:
      return "maximum";
    case CriticalPoint::Kind::minimum:
      return "minimum";
    case CriticalPoint::Kind::bifurcation:
      return "bifurcation";
  }
  return "";
}

std::string in_words(const CriticalPoint& point) {
  if (point.kind == CriticalPoint::Kind::bifurcation) {
    return fmt::format(
        "a bifurcation before the load factor {:.6g}: another path of equilibria crosses this one, and the number of "
        "unstable modes changes; a small imperfection of the shape or the load leads to it",
        point.load_factor);
  }
  return fmt::format("a limit point: the load factor has a {} of {:.6g}", name_of(point.kind), point.load_factor);
}

}  // namespace pliant
