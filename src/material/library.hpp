/// Measured materials: constants of laws that were fitted to published tests.
#pragma once

#include "material/elastic_law.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

struct LibraryConstant {
  std::string_view key;  ///< a parameter of the law
  double value;          ///< in the parameter's unit
};

/// A material, as a body without change of volume: what the tests say nothing about.
struct LibraryMaterial {
  std::string_view name;  ///< as users type it
  std::string_view law;
  std::span<const LibraryConstant> constants;  ///< all that the law needs, except that of the volume
  std::optional<double> density;               ///< [kg/m^3], if the source gives it
  double highest_stretch;                      ///< that was measured and fitted; the lowest is 1
  std::string_view tests;
  std::string_view fit;     ///< how the constants follow from the tests, and how well they describe them
  std::string_view source;  ///< of the tests, and of the density
};

std::span<const LibraryMaterial> material_library();

/// nullptr if the library does not contain it.
const LibraryMaterial* find_material(std::string_view name);

/// Poisson's ratio where users give nothing about the volume.
inline constexpr double library_poissons_ratio = 0.499;

/// The constants as users would give them, and a Poisson's ratio.
GivenConstants constants_of(const LibraryMaterial& material, double poissons_ratio = library_poissons_ratio);

/// A table of all materials, then the sources, as text for a terminal.
std::string library_text();

}  // namespace pliant
