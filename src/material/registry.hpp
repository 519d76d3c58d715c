/// Every elastic law a user can name. A new law is a header, a place in ElasticLaws and a row in registry.cpp; the
/// tests, the input file, the plots and `pliant materials` read the list from here.
#pragma once

#include "material/arruda_boyce.hpp"
#include "material/corotated.hpp"
#include "material/elastic_law.hpp"
#include "material/gent.hpp"
#include "material/guccione.hpp"
#include "material/holzapfel_gasser_ogden.hpp"
#include "material/holzapfel_ogden.hpp"
#include "material/linear.hpp"
#include "material/mooney_rivlin.hpp"
#include "material/neo_hookean.hpp"
#include "material/neo_hookean_isochoric.hpp"
#include "material/ogden.hpp"
#include "material/saint_venant_kirchhoff.hpp"
#include "material/stable_neo_hookean.hpp"
#include "material/yeoh.hpp"

#include <cstddef>
#include <variant>

namespace pliant {

template <template <class> class... L>
struct LawList {
  template <class S>
  using Variant = std::variant<L<S>...>;
  static constexpr std::size_t size = sizeof...(L);
};

using ElasticLaws =
    LawList<Linear, SaintVenantKirchhoff, NeoHookean, NeoHookeanIsochoric, MooneyRivlin, MooneyRivlin5, Yeoh, Gent,
            ArrudaBoyce, Ogden, StableNeoHookean, FixedCorotated, Arap, Guccione, HolzapfelGasserOgden, HolzapfelOgden>;
using ElasticLawVariant = ElasticLaws::Variant<double>;

template <class L>
inline constexpr bool has_volumetric_form = requires(const L& law) {
  law.volumetric;
};

template <ElasticLaw L>
constexpr LawTraits traits_of() {
  return {L::is_barrier, L::constant_tangent, L::num_directions, L::energy_degree, has_volumetric_form<L>};
}

/// The law itself.
ElasticLawVariant instantiate(const ElasticLawSpec& spec);

}  // namespace pliant
