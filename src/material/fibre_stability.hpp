/// The stretches at which a law with fibres is stable, for a body that keeps its volume.
///
/// A specimen is stretched along a direction e and narrows alike in the two others:
///
///     F(l) = l e (x) e + l^-1/2 (I - e (x) e)
///
/// A state is stable if
///   1. the law is rank-one convex there: small shear waves of all directions have real speeds,
///          (m (x) N) : A : (m (x) N) > 0 for all N and all m with m . F^-T N = 0,  A = dP/dF,
///      which a pressure does not change; elsewhere the deformation may localise in bands, and the solution depends on
///      the mesh;
///   2. and the force of the specimen grows with the stretch, d2W/dl2 > 0.
/// Sources: Ogden, Non-Linear Elastic Deformations (1984), section 6.2; Merodio & Ogden, Int. J. Solids Struct. 40
/// (2003) 4707-4727, of fibres that are pressed.
#pragma once

#include "material/elastic_law.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The ends of the stable range along the fibres and across them. Where no end is found, the end of the search:
/// `searched` or its inverse.
struct StableFibreStretches {
  static constexpr double searched = 4.0;
  struct Way {
    std::string along;  ///< "along the fibres"
    double tension = searched, compression = 1.0 / searched;
  };
  std::vector<Way> ways;
};

/// Nothing for a law without fibres.
std::optional<StableFibreStretches> stable_fibre_stretches(const ElasticLawSpec& law);

/// The ends that lie between `low` and `high`, in words: "along the fibres down to a stretch of 0.6, ..."; empty if
/// there are none.
std::string in_words(const StableFibreStretches& stable, double low, double high);

}  // namespace pliant
