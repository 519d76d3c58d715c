/// The input file: YAML to Config and back, and its JSON schema.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Whether an analysis without inertia is refused where nothing holds the bodies.
enum class Supports { required, optional };

/// Reads an input from its text; `file` is its name as the user gave it: messages show it and the mesh's file is
/// relative to its directory. Throws InputError with every error, each at its line and column. Not collective.
Config read_input(const std::string& text, const std::string& file, const std::vector<Override>& overrides,
                  Supports supports = Supports::required);

/// Like read_input, but rank 0 reads the text. A file that is missing, unreadable or a directory is an InputError too.
/// Every rank returns the same or throws the same. Collective.
Config read_input_file(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       Supports supports = Supports::required);

/// The text of the file, the same on every rank, for inputs that are read several times. Throws like read_input_file.
/// Collective.
std::string input_text(MPI_Comm comm, const std::string& file);

/// The configuration as YAML: every default spelled out, SI units, the mesh's file absolute. Reading it, from any
/// directory, gives the same configuration.
std::string dump(const Config& config);

/// JSON Schema (draft 7) of the input, from which editors complete and check.
std::string json_schema();

}  // namespace pliant
