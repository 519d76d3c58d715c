/// The page that a report fills, built from src/viewer/ (cmake/viewer.cmake).
#pragma once

#include <string_view>

namespace pliant {

/// Empty in a program that was built without it.
std::string_view report_page();

}  // namespace pliant
