#include "command/material_reference.hpp"

#include "material/constants.hpp"
#include "material/elastic_law.hpp"
#include "material/library.hpp"
#include "material/viscosity_registry.hpp"

#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr const char* laws_introduction = R"md(# The laws

<!-- Written by `pliant materials --markdown` from the registries of laws in src/material; change it there. -->

Every law that an input can name: [elastic ones](#elastic-laws) under `elasticity`, [viscous ones](#viscous-laws) under `viscosity`.
[Materials](materials.md) explains how to choose and how to give the constants.

`F = I + grad u`, `J = det F`, `C = F^T F`, `E = (C - I)/2`; `I1b = J^(-2/3) I1(C)` and `I2b = J^(-4/3) I2(C)` are the invariants of the part
of `C` that keeps the volume; `kappa` is the `bulk_modulus`. `U(J)` is one of

| `volumetric_energy` | U(J) | |
|---|---|---|
| `mixed` (the default) | `(J^2 - 1 - 2 ln J)/4` | convex; grows without bound at `J = 0` |
| `log` | `(ln J)^2/2` | softens beyond `J = e` |
| `quadratic` | `(J - 1)^2/2` | finite at `J = 0` |

The pictures are drawn by `pliant materials plot LAW` with the typical values of the tables; `--set KEY=VALUE` draws another material.
)md";

std::string parameter_table(std::span<const ParameterInfo> parameters, bool has_typical) {
  std::string text = has_typical ? "| key | unit | admissible | typical | meaning |\n|---|---|---|---|---|\n"
                                 : "| key | unit | admissible | meaning |\n|---|---|---|---|\n";
  for (const auto& p : parameters) {
    const std::string typical = has_typical ? fmt::format(" {:g} |", p.typical) : "";
    text += fmt::format("| `{}` | {} | {} |{} {}{} |\n", p.name, p.unit, admissible(p), typical, p.meaning,
                        fallback_words(p));
  }
  return text;
}

std::string heading(const LawInfo& law) {
  return fmt::format("\n### {}\n\n    {}\n\nUse: {}.\nSource: {}.\n\n", law.name, law.formula, law.when_to_use,
                     law.source);
}

std::string library_table() {
  std::string text =
      "`elasticity: {library: NAME}` gives a body a law and constants that were fitted to published tests "
      "([how to use them](materials.md#measured-materials)).\n\n"
      "| name | law | constants | E at small strain | density | stretch up to |\n|---|---|---|---|---|---|\n";
  for (const LibraryMaterial& m : material_library()) {
    std::string constants;
    for (const auto& [key, value] : m.constants) {
      constants += fmt::format("{}`{}` {:g}", constants.empty() ? "" : ", ", key, value);
    }
    const double mu = make_law(m.law, constants_of(m)).at_rest().value().mu;
    text += fmt::format("| `{}` | `{}` | {} | {:.3g} MPa | {} | {:g} |\n", m.name, m.law, constants, 3e-6 * mu,
                        m.density ? fmt::format("{:g} kg/m^3", *m.density) : "", m.highest_stretch);
  }
  text += "\n";
  for (const LibraryMaterial& m : material_library()) {
    text += fmt::format("- **{}**: {}. Fit: {}. Source: {}.\n", m.name, m.tests, m.fit, m.source);
  }
  return text;
}

}  // namespace

std::string material_reference() {
  std::string text = laws_introduction;
  text +=
      "\n## Elastic laws\n\nWhere a law has two of these constants, any other two may be given; instead of a "
      "`bulk_modulus` alone a `poissons_ratio`, unless the law has fibres: stiffness that differs between directions "
      "has no one such ratio.\n\n";
  text += parameter_table(elastic_constants(), false);
  for (const auto& law : elastic_laws()) {
    text += heading(law) + parameter_table(law.parameters, true);
    text += fmt::format("\n![{0}: nominal stress over stretch](images/law-{0}.svg)\n", law.name);
  }
  text += "\n## Measured materials\n\n" + library_table();
  text += "\n## Viscous laws\n";
  for (const auto& law : viscosity_laws()) text += heading(law) + parameter_table(law.parameters, false);
  return text;
}

}  // namespace pliant
