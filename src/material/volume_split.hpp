/// The split of laws whose energy has a volumetric part, psi = rest + kappa U(J).
#pragma once

#include "material/elastic_law.hpp"
#include "material/law_field.hpp"

#include <optional>
#include <string>

namespace pliant {

struct VolumeSplit {
  ElasticLawSpec rest;  ///< with kappa = 0
  double kappa;         ///< [Pa]
  VolumetricForm form;
};

/// The form of a law's volumetric part, whatever its constants; nullopt if it has none.
std::optional<VolumetricForm> volumetric_form_of(const ElasticLawSpec& law);

/// The split of a law; nullopt if it has no volumetric part.
std::optional<VolumeSplit> split_volume(const ElasticLawSpec& law);

/// Whether a law does not feel a change of volume: without their volumetric part most laws do not.
bool is_isochoric(const LawField& law);

/// Whether a branch of a Prony series may follow the law (energy/volume/branch_law.hpp), which is then either isochoric
/// or stiff in every direction.
bool can_relax(const ElasticLawSpec& law);

/// The names of the laws with a volumetric part, separated by commas.
std::string names_of_split_laws();

}  // namespace pliant
