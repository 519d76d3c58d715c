/// Derivatives of a run by the places of the nodes of its mesh.
#pragma once

#include "petsc/handle.hpp"
#include "study/adjoint_run.hpp"

#include <cstddef>
#include <string_view>
#include <vector>

namespace pliant {

/// Key of the field of derivatives by the places of nodes.
inline constexpr std::string_view key_of_nodes = "mesh.nodes";

/// The parameters from which derivatives by nodes are made: where a node moves by dX, cells of straight edges are
/// strained by dX (x) grad N. The work of a cell by a homogeneous strain e_i (x) e_j of the whole mesh is thus, with
/// other factors, that by each of its nodes: nine parameters serve all nodes. `config`: the input.
std::vector<AdjointRun::Parameter> strains_of_mesh(const Config& config);

/// dJ by the places of the vertices, of the owned nodes, whose mid-edge nodes follow [1/m]; `first` of the nine
/// parameters is their place in the run. Probes stay where they are in their cells. Collective.
Handle<Vec> derivatives_by_nodes(const AdjointRun& run, std::size_t first);

}  // namespace pliant
