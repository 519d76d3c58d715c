#include "mesh/measure.hpp"

#include "mesh/rod_chain.hpp"
#include "mesh/tetrahedron.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/plex.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <limits>

#include <petscdmplex.h>

namespace pliant {
namespace {

using tetrahedron::Point;

/// True for the points that this rank owns.
std::vector<bool> owned_points(DM dm) {
  PetscInt begin = 0, end = 0;
  check(DMPlexGetChart(dm, &begin, &end));
  std::vector<bool> owned(static_cast<std::size_t>(end), true);
  PetscSF sf = nullptr;
  PetscInt num_leaves = 0;
  const PetscInt* leaves = nullptr;
  check(DMGetPointSF(dm, &sf));
  check(PetscSFGetGraph(sf, nullptr, &num_leaves, &leaves, nullptr));
  for (PetscInt i = 0; i < num_leaves; ++i) owned[static_cast<std::size_t>(leaves != nullptr ? leaves[i] : i)] = false;
  return owned;
}

/// Corners of local points: the vertices of their closures and their positions.
class Geometry {
 public:
  explicit Geometry(const Mesh& mesh)
      : mesh_(mesh),
        dm_(mesh.dm.get()),
        vertices_(stratum(dm_, 0)),
        cells_(stratum(dm_, 3)),
        coordinates_(local_coordinates(dm_)) {
    check(DMGetCoordinateSection(dm_, &section_));
  }
  tetrahedron::Corners corners(PetscInt cell) const {
    const PetscInt* vertices = &mesh_.corners[4 * static_cast<std::size_t>(cell - cells_.begin)];
    const auto corner = [&](std::size_t i) { return position(vertices_.begin + vertices[i]); };
    return {corner(0), corner(1), corner(2), corner(3)};
  }
  /// Length, area or volume.
  double measure(PetscInt point) const {
    if (cells_.contains(point)) return tetrahedron::volume(corners(point));
    std::vector<Point> x;
    for (const PetscInt p : Closure(dm_, point)) {
      if (vertices_.contains(p)) x.push_back(position(p));
    }
    if (x.size() == 2) return norm(x[1] - x[0]);
    return x.size() == 3 ? 0.5 * norm(cross(x[1] - x[0], x[2] - x[0])) : 0.0;
  }

 private:
  Point position(PetscInt vertex) const {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(section_, vertex, &offset));
    return {coordinates_[offset], coordinates_[offset + 1], coordinates_[offset + 2]};
  }
  static Vec local_coordinates(DM dm) {
    Vec v = nullptr;
    check(DMGetCoordinatesLocal(dm, &v));
    return v;
  }
  const Mesh& mesh_;
  DM dm_;
  PointRange vertices_, cells_;
  ConstArrayView coordinates_;
  PetscSection section_ = nullptr;
};

long long num_owned(const std::vector<bool>& owned, PointRange s) {
  long long n = 0;
  for (PetscInt p = s.begin; p < s.end; ++p) n += owned[static_cast<std::size_t>(p)] ? 1 : 0;
  return n;
}

long long sum_of(MPI_Comm comm, long long x) {
  return sum(comm, static_cast<PetscInt64>(x));
}

/// What a cell is, or stands for.
enum class Meaning : char { tetrahedron, segment, triangle, rigid_body };

Meaning meaning_of(const MeshSource& source, const std::string& volume) {
  for (const AddedRod& rod : source.added_rods) {
    if (volume == rod.name) return Meaning::segment;
    if (volume == name_of_end(rod.name, 0) || volume == name_of_end(rod.name, 1)) return Meaning::rigid_body;
  }
  if (std::ranges::find(source.added_shells, volume, &AddedShell::name) != source.added_shells.end()) {
    return Meaning::triangle;
  }
  const bool is_mass =
      std::ranges::find(source.added_tetrahedra, volume, &AddedTetrahedron::name) != source.added_tetrahedra.end();
  return is_mass ? Meaning::rigid_body : Meaning::tetrahedron;
}

PetscInt first_cell(DM dm) {
  return stratum(dm, 3).begin;
}

/// What each local cell is; marks the groups of those that are not tetrahedra.
std::vector<Meaning> meanings_of_cells(const MeshSource& source, const Mesh& mesh, std::vector<GroupReport>& reports) {
  DM dm = mesh.dm.get();
  const PointRange cells = stratum(dm, 3);
  std::vector<Meaning> meanings(static_cast<std::size_t>(cells.end - cells.begin), Meaning::tetrahedron);
  for (std::size_t g = 0; g < mesh.groups.size() && source.num_added() > 0; ++g) {
    const Meaning meaning = meaning_of(source, mesh.groups[g].name);
    if (mesh.groups[g].dimension != 3 || meaning == Meaning::tetrahedron) continue;
    reports[g].is_added = true;
    DMLabel label = nullptr;
    check(DMGetLabel(dm, label_name(mesh.groups[g]).c_str(), &label));
    for (PetscInt c = cells.begin; c < cells.end; ++c) {
      PetscInt value = -1;
      check(DMLabelGetValue(label, c, &value));
      if (value == 1) meanings[static_cast<std::size_t>(c - cells.begin)] = meaning;
    }
  }
  return meanings;
}

/// `meanings`: only tetrahedra count, but for the bounds; empty: all cells do.
void measure_cells(MPI_Comm comm, const Mesh& mesh, const std::vector<bool>& owned,
                   const std::vector<Meaning>& meanings, MeshReport& report) {
  constexpr double large = std::numeric_limits<double>::max();
  const Geometry geometry(mesh);
  const PointRange cells = stratum(mesh.dm.get(), 3);
  std::array<long long, 10> histogram{};
  double min_quality = 1.0, min_edge2 = large, max_edge2 = 0.0, volume = 0.0;
  std::array<double, 3> lower{large, large, large}, upper{-large, -large, -large};
  for (PetscInt c = cells.begin; c < cells.end; ++c) {
    if (!owned[static_cast<std::size_t>(c)]) continue;
    const tetrahedron::Corners corners = geometry.corners(c);
    for (const Point& p : corners) {
      for (std::size_t k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], p[k]);
        upper[k] = std::max(upper[k], p[k]);
      }
    }
    if (!meanings.empty() && meanings[static_cast<std::size_t>(c - cells.begin)] != Meaning::tetrahedron) continue;
    const double q = tetrahedron::mean_ratio(corners);
    ++histogram[static_cast<std::size_t>(std::min(9.0, std::max(0.0, std::floor(10.0 * q))))];
    min_quality = std::min(min_quality, q);
    for (const double l2 : tetrahedron::squared_edges(corners)) {
      min_edge2 = std::min(min_edge2, l2);
      max_edge2 = std::max(max_edge2, l2);
    }
    volume += tetrahedron::volume(corners);
  }
  for (std::size_t i = 0; i < histogram.size(); ++i) report.quality_histogram[i] = sum_of(comm, histogram[i]);
  report.min_quality = minimum(comm, min_quality);
  report.min_edge = std::sqrt(minimum(comm, min_edge2));
  report.max_edge = std::sqrt(maximum(comm, max_edge2));
  report.volume = sum(comm, volume);
  for (std::size_t k = 0; k < 3; ++k) {
    report.bounds[k] = minimum(comm, lower[k]);
    report.bounds[3 + k] = maximum(comm, upper[k]);
  }
}

void measure_groups(MPI_Comm comm, const Mesh& mesh, const std::vector<bool>& owned,
                    std::vector<GroupReport>& reports) {
  DM dm = mesh.dm.get();
  const Geometry geometry(mesh);
  for (const auto& group : mesh.groups) {
    DMLabel label = nullptr;
    Handle<IS> points;
    check(DMGetLabel(dm, label_name(group).c_str(), &label));
    check(DMLabelGetStratumIS(label, 1, points.out()));
    long long count = 0;
    double size = 0.0;
    if (points) {
      PetscInt n = 0;
      const PetscInt* p = nullptr;
      check(ISGetLocalSize(points.get(), &n));
      check(ISGetIndices(points.get(), &p));
      for (PetscInt i = 0; i < n; ++i) {
        if (!owned[static_cast<std::size_t>(p[i])]) continue;
        ++count;
        size += geometry.measure(p[i]);
      }
      check(ISRestoreIndices(points.get(), &p));
    }
    reports.push_back({group.dimension, group.tag, group.name, sum_of(comm, count), sum(comm, size)});
  }
}

/// Broadcasts what only rank 0 knows.
void share_file_facts(MPI_Comm comm, MeshReport& report) {
  std::array<long long, 4> counts{report.num_orphan_nodes, report.num_inverted_cells, report.edge_cut,
                                  report.is_straightened ? 1 : 0};
  check_mpi(MPI_Bcast(counts.data(), static_cast<int>(counts.size()), MPI_LONG_LONG, 0, comm));
  report.num_orphan_nodes = counts[0];
  report.num_inverted_cells = counts[1];
  report.edge_cut = counts[2];
  report.is_straightened = counts[3] != 0;
  std::string text;
  for (const auto& notice : report.notices) text += notice + '\0';
  text = broadcast(comm, std::move(text));
  report.notices.clear();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\0', at);
    report.notices.push_back(text.substr(at, end - at));
    at = end + 1;
  }
}

}  // namespace

void measure(MPI_Comm comm, const MeshSource& source, Mesh& mesh) {
  MeshReport& report = mesh.report;
  DM dm = mesh.dm.get();
  const std::vector<bool> owned = owned_points(dm);
  long long num_cells = num_owned(owned, stratum(dm, 3));
  report.num_cells = sum_of(comm, num_cells);
  report.num_vertices = sum_of(comm, num_owned(owned, stratum(dm, 0)));
  report.num_edges = sum_of(comm, num_owned(owned, stratum(dm, 1)));
  report.cells_per_rank.resize(static_cast<std::size_t>(num_ranks(comm)));
  check_mpi(MPI_Allgather(&num_cells, 1, MPI_LONG_LONG, report.cells_per_rank.data(), 1, MPI_LONG_LONG, comm));
  report.geometry_order = mesh.geometry_order;
  measure_groups(comm, mesh, owned, report.groups);
  const std::vector<Meaning> meanings = meanings_of_cells(source, mesh, report.groups);
  const auto count = [&](Meaning wanted) {
    long long n = 0;
    for (PetscInt c = 0; c < static_cast<PetscInt>(meanings.size()); ++c) {
      n += meanings[static_cast<std::size_t>(c)] == wanted && owned[static_cast<std::size_t>(first_cell(dm) + c)] ? 1
                                                                                                                  : 0;
    }
    return sum_of(comm, n);
  };
  report.elements = {count(Meaning::tetrahedron), count(Meaning::segment), count(Meaning::triangle)};
  measure_cells(comm, mesh, owned, report.elements.tetrahedra > 0 ? meanings : std::vector<Meaning>(), report);
  share_file_facts(comm, report);
}

}  // namespace pliant
