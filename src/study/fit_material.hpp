/// The material that is fitted: its parameters, some of which are unknown, and its response to tests of a specimen with
/// the derivatives by the unknown ones.
#pragma once

#include "base/dual.hpp"
#include "material/constants.hpp"
#include "material/loading.hpp"
#include "study/fit_config.hpp"
#include "study/fit_problem.hpp"

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// A parameter under the name of its key in an input, relative to the body: `c10`, `viscosity.0.ratio`.
struct FitParameter {
  std::string name;
  std::string unit;  ///< SI
  double lower;      ///< least and largest admissible values
  double upper;
  double typical;  ///< of the law: for the first start
  bool is_free = true;
  double held = 0.0;  ///< its value if it is not free
};

class FitMaterial {
 public:
  /// Throws InputError, at the places in the input, where the constants do not fit the law.
  FitMaterial(const FitMaterialConfig& material, const std::optional<FitViscosityConfig>& viscosity);

  /// The constants of the law, then those of its branches (ratio and relaxation time of each).
  const std::vector<FitParameter>& parameters() const { return parameters_; }
  const std::vector<std::size_t>& free() const { return free_; }
  std::size_t num_free() const { return free_.size(); }
  std::size_t num_branches() const { return num_branches_; }
  bool is_incompressible() const { return is_incompressible_; }

  /// Values of all parameters from those of the free ones.
  std::vector<double> all_values(std::span<const double> free_values) const;
  double ratio(std::span<const double> all, std::size_t branch) const { return all[num_constants_ + 2 * branch]; }
  double relaxation_time(std::span<const double> all, std::size_t branch) const {
    return all[num_constants_ + 2 * branch + 1];
  }
  /// The place of a parameter among the free ones; nullopt if it is held.
  std::optional<std::size_t> free_place(std::size_t parameter) const;
  std::size_t ratio_index(std::size_t branch) const { return num_constants_ + 2 * branch; }

  /// The elastic law. That of an incompressible material has an arbitrary resistance to changes of volume.
  ElasticLawSpec law(std::span<const double> all) const;
  /// The constants of the law as an input gives them; `poissons_ratio: 0.5` of an incompressible material.
  std::vector<std::pair<std::string, double>> constants(std::span<const double> all) const;

  /// The stress of the elastic law at rest at each amount [Pa]: the nominal stress of the loading (force per reference
  /// area), or the pressure of volumetric loading. NaN where the law has no such state.
  std::vector<Sensitive> stress(std::span<const double> all, Loading loading, std::span<const double> amounts) const;
  /// For an incompressible material with free sides: lambda S_x and lambda S_f at each amount [Pa], with the stresses S
  /// (second Piola-Kirchhoff) of the law alone, before a pressure, along the specimen and across its free sides, and
  /// the stretch lambda along it.
  std::vector<std::array<Sensitive, 2>> stresses_of_law(std::span<const double> all, Loading loading,
                                                        std::span<const double> amounts) const;
  /// Young's modulus (uniaxial) or the shear modulus (simple_shear) at rest [Pa].
  Sensitive modulus(std::span<const double> all, Loading loading) const;

 private:
  void add_constants(const FitMaterialConfig& material);
  void add_branches(const FitViscosityConfig& viscosity);
  /// Parameters of the law as duals whose slope is by the parameter `seed`; of no parameter: none.
  std::vector<Dual<double>> dual_parameters(std::span<const double> all, std::optional<std::size_t> seed) const;
  /// Without free constants of the law: one set, whose slopes are 0.
  using SeededParameters = std::vector<std::vector<Dual<double>>>;
  SeededParameters seeded(std::span<const double> all) const;
  Sensitive incompressible_stress(const SeededParameters& seeded, Loading loading, double amount) const;
  Sensitive stress_at(const SeededParameters& seeded, Loading loading, const LoadedState& state) const;

  ElasticLawSpec kind_;
  std::vector<FitParameter> parameters_;
  std::vector<std::size_t> free_;
  std::size_t num_constants_ = 0;
  std::size_t num_branches_ = 0;
  bool is_incompressible_ = false;
  std::optional<ConstantsRule> rule_;  // from the constants, and a bulk modulus if incompressible
};

}  // namespace pliant
