/// Errors of an input that only the mesh reveals (for others see input/checks).
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "fem/components.hpp"
#include "fem/layout.hpp"
#include "fem/probe.hpp"
#include "input/config.hpp"
#include "material/elastic_law.hpp"
#include "material/volume_split.hpp"
#include "model/selections.hpp"

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <petscvec.h>

namespace pliant {

/// Throws InputError at `where` if the law is incompressible, for bodies without pressures.
void require_compressible(const ElasticLawSpec& law, const Location& where);

/// Throws InputError if the law of a body with pressures does not resist a change of volume.
void require_volumetric_stiffness(const VolumeSplit& law, const ElasticityConfig& elasticity);

/// What the points of a body on this rank are like.
struct VolumeOfPoints {
  bool some_compressible = false, some_incompressible = false;
};

/// Whether a body with pressures is incompressible: at all points that the ranks found, or at none. Throws InputError
/// otherwise, or if the method cannot be used with it. Collective.
bool is_incompressible(MPI_Comm comm, VolumeOfPoints found, const Config& config, std::size_t body);

/// Throws InputError: the pressures of incompressible bodies are not determined.
[[noreturn]] void reject_undetermined_pressures(const Config& config);

/// Throws InputError if algebraic multigrid cannot solve for the pressures: `is_plain` if the unknowns are those of the
/// nodes, and no pairs of surfaces couple them.
void require_factorization(const Config& config, bool is_plain);

/// A note if nothing holds some component and loads move it away; without inertia throws InputError at the load.
/// `held`: nodes with constraints; `components`: those that constraints connect are joined. Collective.
std::optional<Diagnostic> check_support(const Config& config, const NodeLayout& layout, const Components& components,
                                        std::span<const PetscInt> held, Selections& selections);

/// Throws InputError at a constraint if incompressible bodies do not start undeformed. Collective.
void require_undeformed(const Config& config, Vec q, const std::array<double, 6>& bounds);

/// Throws InputError at each probe that is far from the mesh, because it was given in another unit or for another body.
/// A probe that is off by rounding, or by the flat facets of a round surface, is not. `bounds` of the mesh; `locations`
/// of the probes; `is_left_out`: per local cell, or empty. Collective.
void require_near(const NodeLayout& layout, const std::array<double, 6>& bounds,
                  const std::vector<ProbeLocation>& locations, const std::vector<ProbeConfig>& probes,
                  const std::vector<char>& is_left_out);

/// Where the shape of elements and that of the bodies are curved differently.
std::vector<Diagnostic> notes_of_curved_sides(const Config& config, const Mesh& mesh);

/// A note for each probe that lies outside the mesh, where the nearest node is recorded.
std::vector<Diagnostic> notes_of_distant_probes(const std::vector<ProbeLocation>& locations,
                                                const std::vector<ProbeConfig>& probes);

/// Throws InputError at columns that take a field of bodies at a probe on something without tetrahedra: `stands_in`,
/// per local cell. Collective.
void require_bodies_at_probes(const Config& config, MPI_Comm comm, const std::vector<ProbeLocation>& locations,
                              const std::vector<char>& stands_in);

/// Throws InputError if an initial displacement or velocity (`what`) is not finite at a node. Collective.
void require_finite_initial(const Config& config, const NodeLayout& layout, const char* what, Vec values);

}  // namespace pliant
