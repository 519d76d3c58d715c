/// The tendons of the input on a mesh.
#pragma once

#include "energy/load/tendon.hpp"
#include "input/config.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

struct ModelTendon {
  std::string name;
  std::vector<ProbeLocation> points;
  std::unique_ptr<Tendon> term;
};

/// The length of a tendon at displacements u of the local nodes [m]. Collective.
double length_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u);

/// Throws InputError at tendons with a point outside the mesh; `is_left_out`: cells that are not of it. Collective.
std::vector<ModelTendon> make_tendons(const Config& config, const NodeLayout& layout,
                                      std::span<const char> is_left_out);

}  // namespace pliant
