/// An elastic law as a value: its row in the registry and its parameters. Needs none of the laws' formulas.
#pragma once

#include "material/lame.hpp"
#include "material/law_info.hpp"
#include "material/volumetric_form.hpp"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// One row per law, in the order of ElasticLaws (material/registry.hpp); the parameters are those of LawData.
std::span<const LawInfo> elastic_laws();

/// Properties that the law's type declares.
struct LawTraits {
  bool is_barrier;
  bool constant_tangent;
  int num_directions;
  int energy_degree;
  bool takes_volumetric_form;
};
/// A law as a value: its row and its parameters. Directions are unit vectors.
struct ElasticLawSpec {
  std::size_t row = 0;             ///< in elastic_laws()
  std::vector<double> parameters;  ///< in the row's order
  VolumetricForm volumetric = VolumetricForm::mixed;
  std::array<std::array<double, 3>, 2> directions{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}};

  const LawInfo& info() const { return elastic_laws()[row]; }
  LawTraits traits() const;
  /// Hooke's constants at rest of an isotropic law.
  std::optional<Lame> at_rest() const;
};

/// Constants as users give them, by key.
using GivenConstants = std::map<std::string, double, std::less<>>;

/// The law `name` with these constants (material/constants.hpp). Throws InputError with every error, at `where`.
ElasticLawSpec make_law(std::string_view name, const GivenConstants& constants, const Location& where = {});

/// Likewise with E [Pa] and nu; other parameters have their typical values.
ElasticLawSpec make_law(std::string_view name, double youngs_modulus, double poissons_ratio,
                        const Location& where = {});

/// The law of the row with all parameters at their typical values.
ElasticLawSpec typical_law(std::size_t row);

}  // namespace pliant
