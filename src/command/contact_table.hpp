/// What `pliant check` says of contact.
#pragma once

#include "model/contact_summary.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Lines with aligned columns; none if nothing may touch.
std::vector<std::string> contact_table(const ContactSummary& summary);

}  // namespace pliant
