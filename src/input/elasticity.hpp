/// The elastic laws of the bodies, as the input describes them.
#pragma once

#include "input/config.hpp"
#include "input/directions.hpp"
#include "material/constants.hpp"

#include <array>
#include <optional>
#include <string>

namespace pliant {

/// A body's law as a function of the position.
class ElasticityRule {
 public:
  /// Throws InputError if the constants and directions do not determine the law.
  explicit ElasticityRule(const ElasticityConfig& config);

  /// Finds its data on the mesh, which must outlive the object. Throws InputError with all errors.
  void bind(const CellData& data);
  bool is_uniform() const { return is_uniform_; }
  /// At the reference position X in a local cell; a uniform law is the same everywhere. Throws InputError if the
  /// constants or directions are not admissible there.
  ElasticLawSpec law_at(PetscInt cell, const std::array<double, 3>& X) const;
  /// The law if it is the same everywhere, or would be if the body were turned: directions may follow a formula, but
  /// the angle between two of them may not. Throws InputError like law_at().
  std::optional<ElasticLawSpec> up_to_rotation() const;
  /// The law without constants, for what does not depend on them.
  const ElasticLawSpec& kind() const { return kind_; }

 private:
  std::vector<double> constants_at(PetscInt cell, const std::array<double, 3>& X) const;
  std::vector<double> admissible_constants(PetscInt cell, const std::array<double, 3>& X) const;
  void set_directions(PetscInt cell, const std::array<double, 3>& X, ElasticLawSpec& law) const;

  const ElasticityConfig& config_;
  ElasticLawSpec kind_;
  ConstantsRule rule_;
  std::vector<DirectionRule> directions_;  // in the order of the law
  const CellData* data_ = nullptr;
  std::vector<std::size_t> data_of_constant_;  // where the constant is data of the mesh
  bool has_uniform_constants_;
  bool is_uniform_;  // the directions, too
};

/// Does the law have preferred directions, so that its moduli at rest are more than two numbers?
bool has_fibres(const ElasticityConfig& config);

/// The law and its constants in words, with the equivalent moduli at small strain.
std::string describe(const ElasticityConfig& config);

std::string describe(const ElasticLawSpec& law);

/// Stiffness against the fastest and the slowest wave in a body at rest, density times the squared speed [Pa].
struct WaveModuli {
  double largest;
  double smallest;
};
WaveModuli wave_moduli(const ElasticLawSpec& law);

}  // namespace pliant
