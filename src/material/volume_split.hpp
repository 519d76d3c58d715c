/// Laws whose energy has a part of the volume alone, psi = rest + kappa U(J), taken apart.
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

/// Nothing if the law has no such part.
std::optional<VolumeSplit> split_volume(const ElasticLawSpec& law);

/// The laws that have one, separated by commas.
std::string names_of_split_laws();

}  // namespace pliant
