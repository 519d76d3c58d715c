/// The stretches at which an isotropic law of rubber is stable, for a body that keeps its volume.
///
/// A state is stable if
///   1. the law satisfies Drucker's criterion: the power of the stress rate is positive for every strain rate,
///          sum_ij K_ij de_i de_j > 0 where de_1 + de_2 + de_3 = 0,  K_ij = l_i A_iijj l_j + d_ij l_i P_ii
///      with the logarithmic strains e_i = ln l_i and the tangent A = dP/dF;
///   2. and the force of a specimen that is stretched in this way grows with the stretch: beyond the maximum of the
///      nominal stress a specimen under a force has no equilibrium, or necks.
/// Sources: Drucker, J. Appl. Mech. 26 (1959) 101-106; Considere, Ann. Ponts Chauss. 9 (1885) 574-775; the criterion in
/// this form: Ogden, Non-Linear Elastic Deformations (1984), section 6.2.
#pragma once

#include "material/elastic_law.hpp"

#include <array>
#include <optional>
#include <string>

namespace pliant {

/// The ends of the stable range along the ways of stretching a specimen. Where no end is found, the end of the search:
/// `searched` or its inverse.
struct StableStretches {
  static constexpr double searched = 10.0;

  double tension = searched;            ///< uniaxial, above 1
  double compression = 1.0 / searched;  ///< uniaxial, below 1
  double pure_shear = searched;         ///< of a wide sheet, above 1
  double equibiaxial = searched;        ///< above 1

  /// The largest principal stretch that is stable in a state with these principal stretches, in descending order and
  /// above 0, whose volume change is left aside. Between uniaxial tension, pure shear and equibiaxial tension (which is
  /// uniaxial compression) its logarithm is interpolated in ln l_2 / ln l_1.
  double limit(const std::array<double, 3>& stretches) const;
};

/// nullopt if the law is not isotropic or has no volumetric part to leave aside (material/volume_split.hpp). A limit of
/// stretch, beyond which a law has no energy, is not an instability.
std::optional<StableStretches> stable_stretches(const ElasticLawSpec& law);

/// The ends that lie between `low` and `high`, in words: "in uniaxial tension up to a stretch of 1.6, ..."; empty if
/// there are none.
std::string in_words(const StableStretches& stable, double low, double high);

}  // namespace pliant
