/// @file
/// Where the tests find what they read and write, and how long they may take. Told to one file alone (main.cpp): on the
/// command lines of all, the names of the folders would keep compiler caches from sharing between clones.
#pragma once

#include <filesystem>

namespace pliant {

/// The clone.
std::filesystem::path source_root();

/// The build folder, for what tests write.
std::filesystem::path build_root();

/// Whether tests may take minutes: PLIANT_LONG_TESTS.
bool has_time();

}  // namespace pliant
