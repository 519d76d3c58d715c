/// `pliant materials plot LAW`: the response of a law in the standard material tests.
#pragma once

#include "io/svg_plot.hpp"
#include "material/elastic_law.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Nominal stress over stretch (over 1 + the amount of shear) from `lowest` to `highest`, or up to the limit of the
/// law.
Plot stress_stretch_plot(const ElasticLawSpec& law, double lowest, double highest);

/// The law, or the material of the library, as the command line describes it: typical parameters, some of them replaced
/// by `settings`, each "key=value", where the value may have a unit. Throws InputError.
ElasticLawSpec law_for_plot(const std::string& name, const std::vector<std::string>& settings);

}  // namespace pliant
