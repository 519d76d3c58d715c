/// Finds commands in files that gmsh interprets. Its language can run programs, write files and load other scripts; a
/// mesh from somebody else must not do so just because someone inspects it with `pliant check`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// What gmsh reads of a file without commands.
struct LoadedFiles {
  std::vector<std::filesystem::path> files;  ///< the file itself, first, and those that it loads
  bool is_all = true;  ///< false if a script also asks for the environment, the time or what other files there are
};

/// Throws MeshDefect, with line and column of each, if `file` or a script that it loads has statements that run
/// programs, write files, or name such statements at run time. Files of other formats pass, but not an option file
/// (`<file>.opt`) that gmsh would load with them. It searches for words and does not interpret: what it accepts is
/// harmless, what it rejects may be harmless too. Not collective.
LoadedFiles require_no_commands(const std::string& file);

}  // namespace pliant
