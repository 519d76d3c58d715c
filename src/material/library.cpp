#include "material/library.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::array ecoflex_10{LibraryConstant{"c10", 3.982e3}, LibraryConstant{"c20", 0.1099e3}};
constexpr std::array ecoflex_30{LibraryConstant{"c10", 8.002e3}, LibraryConstant{"c20", 0.0808e3}};
constexpr std::array ecoflex_50{LibraryConstant{"c10", 11.46e3}, LibraryConstant{"c20", 0.1617e3}};
constexpr std::array dragon_skin_10{LibraryConstant{"c10", 24.99e3}, LibraryConstant{"c20", 1.818e3}};
constexpr std::array dragon_skin_20{LibraryConstant{"c10", 72.58e3}, LibraryConstant{"c20", 4.212e3}};
constexpr std::array dragon_skin_30{LibraryConstant{"c10", 103.1e3}, LibraryConstant{"c20", 5.102e3}};
constexpr std::array mold_star_16{LibraryConstant{"c10", 43.22e3}, LibraryConstant{"c20", 2.472e3}};
constexpr std::array sorta_clear_40{LibraryConstant{"c10", 139.8e3}, LibraryConstant{"c20", 5.435e3}};
constexpr std::array rtv615{LibraryConstant{"c10", 166.3e3}, LibraryConstant{"c20", 12.15e3},
                            LibraryConstant{"c30", 1.179e3}};
// Ogden's mu_p alpha_p / 2 of his 0.63, 0.0012 and -0.01 MPa.
constexpr std::array treloar{LibraryConstant{"mu1", 409.5e3}, LibraryConstant{"alpha1", 1.3},
                             LibraryConstant{"mu2", 3e3},     LibraryConstant{"alpha2", 5.0},
                             LibraryConstant{"mu3", 10e3},    LibraryConstant{"alpha3", -2.0}};
constexpr std::array ninjaflex{LibraryConstant{"mu1", 5.733e6}, LibraryConstant{"alpha1", -0.0733}};

constexpr std::string_view to_failure =
    "uniaxial tension to failure, ASTM D412, 450 mm/min, first loading; strain from the crosshead, length 33 mm";
constexpr std::string_view database =
    "Marechal, Balland, Lindenroth, Petrou, Kontovounisios & Bello, Soft Robotics 8 (2021), no. 3, "
    "doi:10.1089/soro.2019.0115; data: Soft Robotics Materials Database (Open Database License)";
constexpr std::string_view database_and_bulletin =
    "Marechal, Balland, Lindenroth, Petrou, Kontovounisios & Bello, Soft Robotics 8 (2021), no. 3, "
    "doi:10.1089/soro.2019.0115; data: Soft Robotics Materials Database (Open Database License); density: Smooth-On's "
    "technical bulletin";

/// All fits of Yeoh's law: least squares of the nominal stress at 200 stretches, equally spaced from 1.02, with the
/// coefficients of the higher terms not below 0, so that the law is stable in every kind of loading.
constexpr std::array library{
    LibraryMaterial{"ecoflex-00-10", "yeoh", ecoflex_10, 1040.0, 5.0, to_failure,
                    "least squares of the nominal stress; off by 1.2 % of the largest (rms), at most 2.9 %",
                    database_and_bulletin},
    LibraryMaterial{"ecoflex-00-30", "yeoh", ecoflex_30, 1070.0, 5.0, to_failure,
                    "least squares of the nominal stress; off by 0.3 % of the largest (rms), at most 1.1 %",
                    database_and_bulletin},
    LibraryMaterial{"ecoflex-00-50", "yeoh", ecoflex_50, 1070.0, 5.0, to_failure,
                    "least squares of the nominal stress; off by 0.7 % of the largest (rms), at most 2.0 %",
                    database_and_bulletin},
    LibraryMaterial{"dragon-skin-10", "yeoh", dragon_skin_10, 1070.0, 3.0, to_failure,
                    "least squares of the nominal stress; off by 1.4 % of the largest (rms), at most 4.3 %",
                    database_and_bulletin},
    LibraryMaterial{"dragon-skin-20", "yeoh", dragon_skin_20, 1080.0, 3.0, to_failure,
                    "least squares of the nominal stress; off by 1.5 % of the largest (rms), at most 3.0 %",
                    database_and_bulletin},
    LibraryMaterial{"dragon-skin-30", "yeoh", dragon_skin_30, 1080.0, 3.0, to_failure,
                    "least squares of the nominal stress; off by 1.3 % of the largest (rms), at most 3.0 %",
                    database_and_bulletin},
    LibraryMaterial{"mold-star-16", "yeoh", mold_star_16, std::nullopt, 3.0, to_failure,
                    "least squares of the nominal stress; off by 0.6 % of the largest (rms), at most 1.7 %", database},
    LibraryMaterial{"sorta-clear-40", "yeoh", sorta_clear_40, std::nullopt, 3.0, to_failure,
                    "least squares of the nominal stress; off by 0.2 % of the largest (rms), at most 1.1 %", database},
    LibraryMaterial{"rtv615", "yeoh", rtv615, std::nullopt, 2.5, to_failure,
                    "least squares of the nominal stress; off by 0.1 % of the largest (rms), at most 1.1 %", database},
    LibraryMaterial{"natural-rubber-treloar", "ogden", treloar, std::nullopt, 7.0,
                    "uniaxial and equibiaxial tension and pure shear of vulcanized natural rubber",
                    "the constants of Ogden, Proc. R. Soc. Lond. A 326 (1972) 565-584, doi:10.1098/rspa.1972.0026",
                    "Treloar, Trans. Faraday Soc. 40 (1944) 59-70, doi:10.1039/TF9444000059"},
    LibraryMaterial{
        "ninjaflex", "ogden", ninjaflex, std::nullopt, 2.0,
        "uniaxial tension to failure, mean of 8 printed specimens, first loading; later ones are softer, and "
        "a permanent set remains",
        "least squares of the nominal stress; off by 0.6 % of the largest (rms), at most 1.3 %",
        "3D Printing and Additive Manufacturing (2023), doi:10.1089/3dp.2023.0010; data: SoRoForge of the Matter "
        "Assembly Computation Lab"},
};

}  // namespace

std::span<const LibraryMaterial> material_library() {
  return library;
}

const LibraryMaterial* find_material(std::string_view name) {
  const auto* found = std::ranges::find(library, name, &LibraryMaterial::name);
  return found == library.end() ? nullptr : found;
}

GivenConstants constants_of(const LibraryMaterial& material, double poissons_ratio) {
  GivenConstants constants{{"poissons_ratio", poissons_ratio}};
  for (const auto& [key, value] : material.constants) constants.emplace(key, value);
  return constants;
}

std::string library_text() {
  std::string text =
      "MEASURED MATERIALS (bodies[].elasticity: {library: NAME})\n\n" +
      fmt::format("{:<24}{:<8}{:>10}{:>15}{:>15}\n", "name", "law", "E [MPa]", "rho [kg/m^3]", "stretch up to");
  for (const LibraryMaterial& m : library) {
    const auto rest = make_law(m.law, constants_of(m)).at_rest().value();
    text += fmt::format("{:<24}{:<8}{:>10.3g}{:>15}{:>15}\n", m.name, m.law, 3e-6 * rest.mu,
                        m.density ? fmt::format("{:g}", *m.density) : "-", m.highest_stretch);
  }
  text += fmt::format(
      "\nE: at small strain. poissons_ratio is {} unless the input gives it: the tests say nothing about the volume.\n"
      "Batches, curing and mixing change a modulus by some tens of per cent; the first loading is stiffer than later "
      "ones.\n\n",
      library_poissons_ratio);
  for (const LibraryMaterial& m : library) {
    text += fmt::format("{}\n ", m.name);
    for (const auto& [key, value] : m.constants) text += fmt::format(" {} = {:g}", key, value);
    text += fmt::format("\n  tests: {}\n  fit: {}\n  source: {}\n\n", m.tests, m.fit, m.source);
  }
  return text;
}

}  // namespace pliant
