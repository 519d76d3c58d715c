/// Finds commands in files that gmsh interprets. Its language can run programs, write files and load other scripts; a
/// mesh from somebody else must not do so just because someone inspects it with `pliant check`.
#pragma once

#include <string>

namespace pliant {

/// Throws MeshDefect, with line and column of each, if `file` or a script that it loads has statements that run
/// programs, write files, or name such statements at run time. Files of other formats pass, but not an option file
/// (`<file>.opt`) that gmsh would load with them. It searches for words and does not interpret: what it accepts is
/// harmless, what it rejects may be harmless too. Not collective.
void require_no_commands(const std::string& file);

}  // namespace pliant
