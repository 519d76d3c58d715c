/// The versions of the program and of the libraries that it uses.
#pragma once

#include <string>

namespace pliant {

/// "pliant 0.1.0" and a line per library.
std::string version_text();

/// The text with "# " before each line.
std::string commented(const std::string& text);

}  // namespace pliant
