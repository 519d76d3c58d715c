/// The forms of the volumetric energy, which material/volumetric.hpp defines.
#pragma once

#include <array>
#include <string_view>

namespace pliant {

enum class VolumetricForm { log, quadratic, mixed };

/// Names that users type, in the order of VolumetricForm.
inline constexpr std::array<std::string_view, 3> volumetric_form_names{"log", "quadratic", "mixed"};

}  // namespace pliant
