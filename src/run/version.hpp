/// The program's version and those of the libraries it stands on.
#pragma once

#include <string>

namespace pliant {

/// "pliant 0.1.0" and a line per library.
std::string version_text();

/// The text with "# " before each line.
std::string commented(const std::string& text);

}  // namespace pliant
