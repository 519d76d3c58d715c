/// Every elastic law a user can name. A new law is a header, a place in ElasticLawVariant and a row in registry.cpp;
/// the tests, the input file and `pliant materials` read the list from here.
#pragma once

#include "material/law_info.hpp"
#include "material/linear.hpp"
#include "material/neo_hookean.hpp"
#include "material/saint_venant_kirchhoff.hpp"

#include <span>
#include <string_view>
#include <variant>

namespace pliant {

using ElasticLawVariant = std::variant<Linear, SaintVenantKirchhoff, NeoHookean>;

/// One row per law, in the order of ElasticLawVariant.
std::span<const LawInfo> elastic_laws();

/// The law of that name with E [Pa] and nu. Throws InputError, every mistake at `where`.
ElasticLawVariant make_law(std::string_view name, double youngs_modulus, double poissons_ratio,
                           const Location& where = {});

}  // namespace pliant
