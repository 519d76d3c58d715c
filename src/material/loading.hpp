/// Homogeneous deformations of a specimen, as in material tests: the stress of its law at a stretch.
#pragma once

#include "base/tensor.hpp"
#include "material/elastic_law.hpp"
#include "material/law.hpp"
#include "material/law_field.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace pliant {

enum class Loading {
  uniaxial,      ///< stretched along x, sides free
  equibiaxial,   ///< stretched along x and y, free along z
  simple_shear,  ///< x moves by the amount times y, y and z are fixed
  pure_shear,    ///< planar tension: stretched along x, y is fixed, free along z
  volumetric,    ///< stretched alike along x, y and z
};

struct LoadingInfo {
  std::string_view name;
  std::string_view stress;  ///< what is plotted
};
/// One row per loading, in its order.
inline constexpr std::array<LoadingInfo, 5> loadings{{{"uniaxial", "P_xx"},
                                                      {"equibiaxial", "P_xx = P_yy"},
                                                      {"simple shear", "P_xy"},
                                                      {"pure shear", "P_xx"},
                                                      {"volumetric", "P_xx = P_yy = P_zz"}}};

struct LoadedState {
  Tensor3<double> H;
  Tensor3<double> P;  ///< [Pa]; the component of the loading is the force per reference area
  Tangent<double> A;  ///< dP/dH [Pa]
};

/// Diagonal entries of H that the loading leaves free: their sides carry no traction.
std::vector<int> free_entries(Loading loading);

/// A specimen that is loaded from amount to amount, beginning at rest. The amount is the stretch, 1 + the amount of
/// shear, or the volume ratio. Newton's method finds the free stretches in increments.
class LoadingPath {
 public:
  LoadingPath(const ElasticLawSpec& law, Loading loading);

  /// nullopt if the law has no such state, or none that is found from the amount before.
  std::optional<LoadedState> to(double amount);

 private:
  std::unique_ptr<LawField> law_;
  Loading loading_;
  double amount_ = 1.0;
  Tensor3<double> H_{};
};

/// The state of a specimen deformed from rest to `amount`: the stretch, or 1 + the amount of shear. Newton's method
/// finds the free stretches in increments. An incompressible law keeps the volume. nullopt if there is no such state.
std::optional<LoadedState> loaded(const ElasticLawSpec& law, Loading loading, double amount);

/// H of an incompressible body (J = 1), whose free sides deform alike, whatever its law. Not for volumetric loading.
Tensor3<double> incompressible_state(Loading loading, double amount);

/// The state of the same body: P is the law's stress and a pressure, P - p F^-T, that leaves the free sides without
/// traction, and A its derivative at that pressure p. What volume-preserving changes see of them does not depend on the
/// law's resistance to a change of volume.
LoadedState loaded_incompressible(const ElasticLawSpec& law, Loading loading, double amount);

/// dP/dH at rest [Pa].
Tangent<double> tangent_at_rest(const ElasticLawSpec& law);

/// The component of P that characterises the loading [Pa].
double nominal_stress(const LoadedState& state, Loading loading);

}  // namespace pliant
