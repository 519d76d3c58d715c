/// Homogeneous deformations of a specimen, as in material tests: the stress of its law at a stretch.
#pragma once

#include "base/tensor.hpp"
#include "material/elastic_law.hpp"
#include "material/law.hpp"

#include <array>
#include <optional>
#include <string_view>

namespace pliant {

enum class Loading {
  uniaxial,      ///< stretched along x, sides free
  equibiaxial,   ///< stretched along x and y, free along z
  simple_shear,  ///< x moves by the amount times y, y and z are fixed
};

struct LoadingInfo {
  std::string_view name;
  std::string_view stress;  ///< what is plotted
};
/// One row per loading, in its order.
inline constexpr std::array<LoadingInfo, 3> loadings{
    {{"uniaxial", "P_xx"}, {"equibiaxial", "P_xx = P_yy"}, {"simple shear", "P_xy"}}};

struct LoadedState {
  Tensor3<double> H;
  Tensor3<double> P;  ///< [Pa]; the component of the loading is the force per reference area
};

/// The state of a specimen deformed from rest to `amount`: the stretch, or 1 + the amount of shear. Newton's method
/// finds the free stretches in increments. An incompressible law keeps the volume. nullopt if there is no such state.
std::optional<LoadedState> loaded(const ElasticLawSpec& law, Loading loading, double amount);

/// dP/dH at rest [Pa].
Tangent<double> tangent_at_rest(const ElasticLawSpec& law);

/// The component of P that characterises the loading [Pa].
double nominal_stress(const LoadedState& state, Loading loading);

}  // namespace pliant
