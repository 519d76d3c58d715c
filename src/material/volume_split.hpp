/// The split of laws whose energy has a volumetric part, psi = rest + kappa U(J).
#pragma once

#include "material/elastic_law.hpp"

#include <optional>
#include <string>

namespace pliant {

struct VolumeSplit {
  ElasticLawSpec rest;  ///< with kappa = 0
  double kappa;         ///< [Pa]
  VolumetricForm form;
};

/// The split of a law; nullopt if it has no volumetric part.
std::optional<VolumeSplit> split_volume(const ElasticLawSpec& law);

/// The names of the laws with a volumetric part, separated by commas.
std::string names_of_split_laws();

}  // namespace pliant
