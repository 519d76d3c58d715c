/// Orders cells along a space-filling curve: neighbours in the list are close in space.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Sorts the cells along Morton's space-filling curve through their centroids, with their groups and data, and numbers
/// the nodes in the order in which the cells use them: contiguous blocks of either are compact in space. For
/// first-order geometry without orphan nodes. Not collective.
void sort_along_curve(SerialMesh& mesh);

}  // namespace pliant
