/// The laws as a page of the documentation.
#pragma once

#include <string>

namespace pliant {

/// docs/laws.md, from the registries of laws.
std::string material_reference();

}  // namespace pliant
