/// What may touch what, with which law, and how far apart it starts: for `pliant check`.
#pragma once

#include "base/vector3.hpp"
#include "material/contact_law.hpp"

#include <limits>
#include <string>
#include <vector>

namespace pliant {

/// The least gap of two surfaces: their distance less the threshold.
struct StartGap {
  double gap = std::numeric_limits<double>::infinity();  ///< [m]; infinite: nothing is near
  Vector3<double> place{};                               ///< current [m]
};

/// An entry of `contact.pairs`, two bodies of `pairs: all`, or an obstacle and the body nearest to it.
struct ContactRow {
  std::string name;           ///< in the input; may be empty
  std::string first, second;  ///< surfaces, volumes or bodies; empty: an obstacle, or with itself
  double num_facets = 0.0, num_other_facets = 0.0;
  NormalLaw law;  ///< of the nearest two bodies
  double friction = 0.0;
  StartGap start;
};

struct ContactSummary {
  std::vector<ContactRow> pairs;
  int num_far_pairs = 0;  ///< two bodies of `pairs: all` that are farther apart than `far`
  double far = 0.0;       ///< [m]
  std::vector<ContactRow> obstacles;
};

/// Coordinates and distances that are 0 but for rounding, relative to `size`, as 0: they would look different on other
/// numbers of ranks.
Vector3<double> without_rounding(const Vector3<double>& x, double size);

std::string place_text(const Vector3<double>& x);

/// The nearer of two; of equally near ones that at the lower place, so that ranks agree (collision/triangle_tree).
StartGap nearer(const StartGap& a, const StartGap& b);

}  // namespace pliant
