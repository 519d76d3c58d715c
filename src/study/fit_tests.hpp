/// Tests of a specimen: what was measured, and what a material with given constants would have shown.
#pragma once

#include "study/fit_config.hpp"
#include "study/fit_material.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

struct TestKindInfo {
  std::string_view name;      ///< as users type it
  Loading loading;            ///< of the elastic tests
  std::string_view abscissa;  ///< for plots, with its unit
  std::string_view ordinate;
};

/// One row per kind, in the order of TestKind.
std::span<const TestKindInfo> test_kinds();

/// One measured curve with the axis over which it was measured. All in SI.
struct MaterialTest {
  FitTestConfig config;
  std::string name;       ///< for tables: the kind and the file
  std::vector<double> x;  ///< stretch, 1 + amount of shear, volume ratio, time [s], angular frequency [1/s]
  std::vector<double> y;  ///< nominal stress, pressure, or storage and then loss modulus: two for each x [Pa]
  std::string note;       ///< on what the table does not say; empty if there is none

  bool is_elastic() const { return config.kind < TestKind::relaxation; }
  /// The amount at which a relaxing specimen is held.
  double held_amount() const;
  /// What the material shows at each place of the axis, in the order of `y` [Pa].
  std::vector<Sensitive> predicted(const FitMaterial& material, std::span<const double> all,
                                   std::span<const double> at) const;
};

/// Reads the table of a test; `directory`: of the input. Throws InputError with every error. Not collective.
MaterialTest read_test(const FitTestConfig& config, const std::string& directory);

}  // namespace pliant
