/// `pliant check --html`: the model as one page of HTML, before it runs.
#pragma once

#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/model.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// Writes the page: bodies, obstacles and mechanisms at the start, a list of what else the model consists of, and the
/// `lines` of the check. Returns a line for the terminal. The model of `config` is on the mesh. FileError on every rank
/// if the page cannot be written, or the program was built without the viewer. Collective.
std::string write_model_page(const Mesh& mesh, const Config& config, Model& model,
                             const std::vector<std::string>& lines, const std::filesystem::path& output);

}  // namespace pliant
