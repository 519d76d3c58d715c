#include "model/couplings.hpp"

#include "model/rigid_bodies.hpp"
#include "model/touching_surfaces.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The default stiffness in units of that of the body at the surface.
constexpr double stiffness_ratio = 1000.0;

/// The largest shear modulus of the bodies that have the facets [Pa]. Collective.
double shear_modulus_at(const BodiesOnMesh& bodies, const FacetList& facets, std::span<const double> shear_moduli) {
  const CellOfFacets cells(bodies.layout, facets, {});
  double largest = 0.0;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto cell = cells(facets.nodes_of(f));
    if (!cell) continue;
    const int body = bodies.body_of_cell[static_cast<std::size_t>(*cell)];
    if (body >= 0) largest = std::max(largest, shear_moduli[static_cast<std::size_t>(body)]);
  }
  return maximum(bodies.layout.comm, largest);
}

/// Why the surface has no mean motion of its own, as words that follow its name; nothing if it has. Collective.
std::optional<std::string> why_not_coupled(const NodeLayout& layout, const FacetList& facets, const SurfaceMean& mean,
                                           const std::vector<int>& rigid_parts) {
  const bool is_rigid = std::ranges::any_of(
      facets.nodes, [&](PetscInt node) { return rigid_parts[static_cast<std::size_t>(node)] != 0; });
  if (any_rank(layout.comm, is_rigid)) {
    return "has nodes that move rigidly already, with a rigid body, what is attached to one, or a constraint `rigid`: "
           "couple a surface without them, or list it in `attached`";
  }
  if (mean.is_line()) return "lies on one line, about which its mean rotation is undefined; couple a wider one";
  return std::nullopt;
}

}  // namespace

std::vector<ModelCoupling> make_couplings(const BodiesOnMesh& bodies, std::span<const double> shear_moduli,
                                          const std::vector<int>& rigid_parts, Selections& selections) {
  std::vector<ModelCoupling> result;
  const auto& [config, layout, body_of_cell, is_left_out] = bodies;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    const std::string name = body.part.name.empty() ? "body" : body.part.name;
    for (const Selection& surface : coupled_surfaces(body)) {
      const FacetList facets = selections.facets(surface);
      if (sum(layout.comm, static_cast<PetscInt64>(facets.size())) == 0) continue;  // already an error
      const SurfaceMean mean = mean_of_surface(layout, facets);
      if (const auto reason = why_not_coupled(layout, facets, mean, rigid_parts)) {
        selections.report(surface.where, fmt::format("{}, which is `coupled` with rigid body '{}', {}",
                                                     describe(surface), name, *reason));
        continue;
      }
      const double E = 3.0 * shear_modulus_at(bodies, facets, shear_moduli);
      const double k = body.coupling_stiffness.value_or(stiffness_ratio * E * std::sqrt(mean.area));
      const JointBody corners = joint_body(layout, body_of_cell, static_cast<int>(b));
      const auto num_nodes = sum(layout.comm, static_cast<PetscInt64>(mean.nodes.size()));
      result.push_back({std::make_unique<DistributingCoupling>(layout, mean, corners, k),
                        note(fmt::format("rigid body '{}' follows the mean of {} ({} nodes), coupling stiffness "
                                         "{:.3g} N/m",
                                         name, describe(surface), num_nodes, k))});
    }
  }
  selections.throw_if_errors();
  return result;
}

}  // namespace pliant
