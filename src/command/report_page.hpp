/// The empty page of a report, built from src/viewer/ (cmake/viewer.cmake).
#pragma once

#include <string_view>

namespace pliant {

/// Empty if the program was built without the viewer.
std::string_view report_page();

}  // namespace pliant
