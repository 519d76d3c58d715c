/// An elastic law as a value: which one, and with what. What is known of laws without their formulas.
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

/// What the law's type says of it.
struct LawTraits {
  bool is_barrier;
  bool constant_tangent;
  int num_directions;
  int energy_degree;
  bool takes_volumetric_form;
};
/// A law as a value: which one, and with what. Directions are unit vectors.
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

/// Constants as users give them, by their key.
using GivenConstants = std::map<std::string, double, std::less<>>;

/// The law of that name with these constants (material/constants.hpp). Throws InputError, every mistake at `where`.
ElasticLawSpec make_law(std::string_view name, const GivenConstants& constants, const Location& where = {});

/// The same with E [Pa] and nu, and what else the law has at its typical value.
ElasticLawSpec make_law(std::string_view name, double youngs_modulus, double poissons_ratio,
                        const Location& where = {});

/// The law of the row with all parameters at their typical values.
ElasticLawSpec typical_law(std::size_t row);

}  // namespace pliant
