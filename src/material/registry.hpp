/// The elastic laws that come with Pliant. A new one takes a header, an entry in ElasticLaws and a row in registry.cpp;
/// the tests, the input file, the plots and `pliant materials` read this list. Another program adds its own laws with
/// add_elastic_law (material/law_kind.hpp).
#pragma once

#include "material/arruda_boyce.hpp"
#include "material/corotated.hpp"
#include "material/elastic_law.hpp"
#include "material/gent.hpp"
#include "material/guccione.hpp"
#include "material/holzapfel_gasser_ogden.hpp"
#include "material/holzapfel_ogden.hpp"
#include "material/law_kind.hpp"
#include "material/linear.hpp"
#include "material/mooney_rivlin.hpp"
#include "material/mooney_rivlin_coupled.hpp"
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

using ElasticLaws = LawList<Linear, SaintVenantKirchhoff, NeoHookean, NeoHookeanIsochoric, MooneyRivlin, MooneyRivlin5,
                            MooneyRivlinCoupled, Yeoh, Gent, ArrudaBoyce, Ogden, StableNeoHookean, FixedCorotated, Arap,
                            Guccione, HolzapfelGasserOgden, HolzapfelOgden>;
using ElasticLawVariant = ElasticLaws::Variant<double>;

/// The law itself, one of ElasticLaws.
ElasticLawVariant instantiate(const ElasticLawSpec& spec);

/// Adds a row to elastic_laws(): the part of add_elastic_law that does not depend on a type.
void add_row(const LawInfo& info);

}  // namespace pliant
