#include "mesh/surface_file.hpp"

#include "mesh/gmsh_module.hpp"
#include "mesh/isolated.hpp"
#include "mesh/script_commands.hpp"
#include "mesh/source_checks.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Checks that the numbers can be used to compute a volume; NaN would also break the sorting of nodes.
void require_finite(const std::vector<double>& corners, double scale) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double x = scale * corners[i];
    if (std::isfinite(x * x * x)) continue;
    throw MeshDefect(
        fmt::format("a corner of triangle {} is not finite, or too far away: write it again, or choose "
                    "another 'scale'",
                    i / 9 + 1));
  }
}

/// Merges nodes at the same place and drops triangles without area.
SurfaceMesh joined(const std::vector<double>& corners, double scale) {
  SurfaceMesh surface;
  std::map<std::array<double, 3>, PetscInt> known;
  for (std::size_t c = 0; c + 9 <= corners.size(); c += 9) {
    std::array<PetscInt, 3> triangle{};
    for (std::size_t a = 0; a < 3; ++a) {
      std::array<double, 3> x{};
      for (std::size_t i = 0; i < 3; ++i) x[i] = scale * corners[c + 3 * a + i];
      const auto [at, is_new] = known.insert({x, static_cast<PetscInt>(surface.nodes.size())});
      if (is_new) surface.nodes.push_back(x);
      triangle[a] = at->second;
    }
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    surface.triangles.push_back(triangle);
  }
  return surface;
}

/// The enclosed volume, positive if the triangles face outwards.
double enclosed_volume(const SurfaceMesh& surface) {
  double volume = 0.0;
  for (const auto& [a, b, c] : surface.triangles) {
    const auto &A = surface.nodes[a], &B = surface.nodes[b], &C = surface.nodes[c];
    volume +=
        (A[0] * (B[1] * C[2] - B[2] * C[1]) + A[1] * (B[2] * C[0] - B[0] * C[2]) + A[2] * (B[0] * C[1] - B[1] * C[0])) /
        6.0;
  }
  return volume;
}

void require_closed(const SurfaceMesh& surface) {
  if (surface.triangles.empty()) throw MeshDefect("it contains no triangles: export the surface of a solid");
  std::map<std::pair<PetscInt, PetscInt>, int> directed;
  for (const auto& t : surface.triangles) {
    for (std::size_t a = 0; a < 3; ++a) ++directed[{t[a], t[(a + 1) % 3]}];
  }
  std::size_t num_open = 0, num_wrong = 0;
  for (const auto& [edge, number] : directed) {
    const auto back = directed.find({edge.second, edge.first});
    if (number > 1) {
      ++num_wrong;
    } else if (back == directed.end()) {
      ++num_open;
    }
  }
  if (num_wrong > 0) {
    throw MeshDefect(
        fmt::format("at {} edges two triangles face opposite sides, or more than two triangles meet: it "
                    "is not the surface of a solid",
                    num_wrong));
  }
  if (num_open > 0) {
    throw MeshDefect(fmt::format("the surface is not closed: {} edges belong to one triangle only", num_open));
  }
}

/// Orients the triangles outwards.
void orient(SurfaceMesh& surface) {
  constexpr double rounding = 1e-12;
  double largest = 0.0;
  const auto& origin = surface.nodes[surface.triangles[0][0]];
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) largest = std::max(largest, std::abs(surface.nodes[t[0]][i] - origin[i]));
  }
  const double volume = enclosed_volume(surface);
  if (!(std::abs(volume) > rounding * largest * largest * largest)) {
    throw MeshDefect("its surface is flat and encloses no volume: export the surface of a solid");
  }
  if (volume > 0.0) return;
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
}

}  // namespace

SurfaceMesh closed_surface(const std::vector<double>& corners, double scale) {
  require_finite(corners, scale);
  SurfaceMesh surface = joined(corners, scale);
  require_closed(surface);
  orient(surface);
  return surface;
}

SurfaceMesh read_surface(MPI_Comm comm, const MeshSource& source) {
  SurfaceMesh surface;
  on_root(comm, [&] {
    telling_the_user(source, [&] {
      require_readable(source.file);
      require_no_commands(source.file);
      const SerialMesh corners =
          isolated(gmsh_isolation(source), [&] { return gmsh_module().triangle_corners(source.file); });
      surface = closed_surface(corners.coordinates, source.scale);
    });
  });
  std::array<PetscInt, 2> sizes{static_cast<PetscInt>(surface.nodes.size()),
                                static_cast<PetscInt>(surface.triangles.size())};
  check_mpi(MPI_Bcast(sizes.data(), 2, MPIU_INT, 0, comm));
  surface.nodes.resize(static_cast<std::size_t>(sizes[0]));
  surface.triangles.resize(static_cast<std::size_t>(sizes[1]));
  check_mpi(MPI_Bcast(surface.nodes.data(), static_cast<int>(3 * sizes[0]), MPI_DOUBLE, 0, comm));
  check_mpi(MPI_Bcast(surface.triangles.data(), static_cast<int>(3 * sizes[1]), MPIU_INT, 0, comm));
  return surface;
}

}  // namespace pliant
