/// Which energy of a change of volume; the energies are in material/volumetric.hpp.
#pragma once

#include <array>
#include <string_view>

namespace pliant {

enum class VolumetricForm { log, quadratic, mixed };

/// As users type them, in the order of VolumetricForm.
inline constexpr std::array<std::string_view, 3> volumetric_form_names{"log", "quadratic", "mixed"};

}  // namespace pliant
