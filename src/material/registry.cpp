#include "material/registry.hpp"

#include "material/lame.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr std::array isotropic{
    ParameterInfo{"youngs_modulus", "Pa", 0.0, infinity, "stiffness in simple tension at small strain"},
    ParameterInfo{"poissons_ratio", "1", -1.0, 0.5, "lateral contraction per extension at small strain"},
};

constexpr std::array<LawInfo, std::variant_size_v<ElasticLawVariant>> laws{{
    {Linear::name, "psi = mu eps:eps + lambda/2 (tr eps)^2, eps = (H + H^T)/2, H = grad u", isotropic,
     "Hooke's law; Holzapfel, Nonlinear Solid Mechanics (2000)",
     "small strains and small rotations; a rotation of more than a few degrees raises false stresses"},
    {SaintVenantKirchhoff::name, "psi = mu E:E + lambda/2 (tr E)^2, E = (F^T F - I)/2", isotropic,
     "Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5",
     "large rotations with small strains (slender beams, shells); not for strong compression: it softens and lets "
     "cells invert"},
    {NeoHookean::name, "psi = mu/2 (tr(F^T F) - 3) - mu ln J + lambda/2 (ln J)^2, J = det F", isotropic,
     "Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008), section 6.4.3",
     "large rotations and large strains, the usual choice for soft bodies; never lets a cell invert"},
}};

template <std::size_t... i>
std::optional<ElasticLawVariant> find_law(std::string_view name, const Lame& c, std::index_sequence<i...>) {
  std::optional<ElasticLawVariant> found;
  const auto consider = [&]<class L>(std::type_identity<L>) {
    if (L::name == name) found = L{c.mu, c.lambda};
  };
  (consider(std::type_identity<std::variant_alternative_t<i, ElasticLawVariant>>{}), ...);
  return found;
}

}  // namespace

std::span<const LawInfo> elastic_laws() {
  return laws;
}

ElasticLawVariant make_law(std::string_view name, double youngs_modulus, double poissons_ratio, const Location& where) {
  std::vector<Diagnostic> mistakes;
  const auto law = find_law(name, lame(youngs_modulus, poissons_ratio),
                            std::make_index_sequence<std::variant_size_v<ElasticLawVariant>>{});
  if (!law) mistakes.push_back({where, fmt::format("unknown model '{}'; the models are {}", name, names_of(laws))});
  for (const auto& [parameter, value] : {std::pair{isotropic[0], youngs_modulus}, {isotropic[1], poissons_ratio}}) {
    if (const auto text = complaint(parameter, value)) mistakes.push_back({where, *text});
  }
  if (!mistakes.empty()) throw InputError(std::move(mistakes));
  return *law;
}

}  // namespace pliant
