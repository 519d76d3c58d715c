#include "mesh/overlap.hpp"

#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/plex.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <compare>
#include <iterator>
#include <optional>
#include <utility>

namespace pliant {
namespace {

/// A vertex and a rank that has it.
struct Holder {
  std::int64_t vertex = 0;
  int rank = 0;
  auto operator<=>(const Holder&) const = default;
};

/// The other ranks that have cells at this rank's vertices, ascending. Each vertex has a rank where all that have it
/// report. Collective.
std::vector<Holder> other_holders(MPI_Comm comm, std::span<const std::int64_t> vertices) {
  const auto size = static_cast<std::size_t>(num_ranks(comm));
  std::int64_t end = vertices.empty() ? 0 : vertices.back() + 1;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &end, 1, MPI_INT64_T, MPI_MAX, comm));
  const std::int64_t width = end / static_cast<std::int64_t>(size) + 1;
  std::vector<std::vector<Holder>> reports(size), answers(size);
  for (const std::int64_t v : vertices) reports[static_cast<std::size_t>(v / width)].push_back({v, rank(comm)});
  std::vector<Holder> all = exchanged(comm, reports);
  std::ranges::sort(all);
  for (auto first = all.begin(); first != all.end();) {
    const auto last = std::find_if(first, all.end(), [&](const Holder& h) { return h.vertex != first->vertex; });
    for (auto to = first; to != last; ++to) {
      for (auto other = first; other != last; ++other) {
        if (other != to) answers[static_cast<std::size_t>(to->rank)].push_back(*other);
      }
    }
    first = last;
  }
  std::vector<Holder> others = exchanged(comm, answers);
  std::ranges::sort(others);
  return others;
}

/// Which cells go to each other rank: those that share a vertex with one of its cells.
std::vector<std::vector<PetscInt>> cells_near(const CellBlock& own, std::span<const Holder> others, int size) {
  std::vector<std::vector<PetscInt>> cells(static_cast<std::size_t>(size));
  if (others.empty()) return cells;
  std::vector<char> is_shared(own.vertices.size(), 0);
  for (const Holder& other : others) is_shared[index_of(own.vertices, other.vertex)] = 1;
  for (std::size_t c = 0; c < own.num_cells(); ++c) {
    std::vector<int> ranks;
    for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) {
      if (is_shared[index_of(own.vertices, own.corners[i])] == 0) continue;
      for (const Holder& other : std::ranges::equal_range(others, own.corners[i], {}, &Holder::vertex)) {
        ranks.push_back(other.rank);
      }
    }
    std::ranges::sort(ranks);
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    for (const int r : ranks) cells[static_cast<std::size_t>(r)].push_back(static_cast<PetscInt>(c));
  }
  return cells;
}

/// A vertex and where it is [m].
struct Place {
  std::int64_t vertex = 0;
  std::array<double, 3> x{};
};

/// Adds the vertices of the ghosts to those of the own cells. Collective.
void add_vertices(MPI_Comm comm, const std::vector<std::vector<PetscInt>>& cells, CellBlock& block) {
  std::vector<std::vector<Place>> out(cells.size());
  const auto place = [&](std::size_t index) {
    const double* x = &block.coordinates[3 * index];
    return Place{block.vertices[index], {x[0], x[1], x[2]}};
  };
  for (std::size_t r = 0; r < cells.size(); ++r) {
    std::vector<std::size_t> indices;
    for (const PetscInt c : cells[r]) {
      for (std::size_t i = 0; i < 4; ++i) {
        indices.push_back(index_of(block.vertices, block.corners[4 * static_cast<std::size_t>(c) + i]));
      }
    }
    std::ranges::sort(indices);
    indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
    std::ranges::transform(indices, std::back_inserter(out[r]), place);
  }
  std::vector<Place> all = exchanged(comm, out);
  for (std::size_t i = 0; i < block.vertices.size(); ++i) all.push_back(place(i));
  std::ranges::sort(all, {}, &Place::vertex);
  const auto repeated = std::ranges::unique(all, {}, &Place::vertex);
  all.erase(repeated.begin(), repeated.end());
  block.vertices.clear();
  block.coordinates.clear();
  for (const auto& [vertex, x] : all) {
    block.vertices.push_back(vertex);
    block.coordinates.insert(block.coordinates.end(), x.begin(), x.end());
  }
}

void append(CellBlock& block, const CellBlock& more) {
  const auto first = static_cast<PetscInt>(block.num_cells());
  std::ranges::copy(more.corners, std::back_inserter(block.corners));
  std::ranges::copy(more.numbers, std::back_inserter(block.numbers));
  std::ranges::copy(more.values, std::back_inserter(block.values));
  for (CellMark mark : more.marks) {
    mark.cell += first;
    block.marks.push_back(mark);
  }
}

/// A point of the closure of a cell, for the rank that has the cell as its own. The order of closures depends on the
/// numbers of the whole mesh only.
struct Question {
  PetscInt cell = 0;
  PetscInt slot = 0;
};

/// A point of the closure of a ghost cell.
struct GhostPoint {
  PetscInt point = 0;
  int rank = 0;  // of the cell
  Question question;
  auto operator<=>(const GhostPoint& other) const {
    return std::pair(point, rank) <=> std::pair(other.point, other.rank);
  }
  bool operator==(const GhostPoint& other) const { return (*this <=> other) == 0; }
};

/// All points of ghost cells, once for each rank that has cells around them, by ascending points and ranks.
std::vector<GhostPoint> points_of_ghosts(DM dm, const OverlappingCells& cells) {
  std::vector<GhostPoint> points;
  for (std::size_t g = 0; g < cells.ghost_cells.size(); ++g) {
    const Closure closure(dm, cells.num_own + static_cast<PetscInt>(g));
    for (std::size_t slot = 0; slot < closure.size(); ++slot) {
      points.push_back({closure[slot], cells.ghost_ranks[g], {cells.ghost_cells[g], static_cast<PetscInt>(slot)}});
    }
  }
  std::ranges::stable_sort(points);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// A number of the point that is the same on every rank, without a pattern.
std::uint64_t hash_of(DM dm, PetscInt point, std::span<const std::int64_t> vertices) {
  const PointRange range = stratum(dm, 0);
  std::uint64_t sum = 0;
  for (const PetscInt p : Closure(dm, point)) {
    if (!range.contains(p)) continue;
    auto x = static_cast<std::uint64_t>(vertices[static_cast<std::size_t>(p - range.begin)]) + 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;  // splitmix64 (Steele et al. 2014)
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    sum += x ^ (x >> 31);
  }
  return sum;
}

/// The owner of the first vertex of the point that belongs to one of `ranks`: it has a node of the point, where that is
/// possible. Nothing for cells, which have owners.
std::optional<int> owner_of_ends(DM dm, PetscInt point, std::span<const int> owner_of_vertex,
                                 std::span<const int> ranks) {
  const PointRange vertices = stratum(dm, 0);
  std::vector<PetscInt> ends;
  for (const PetscInt p : Closure(dm, point)) {
    if (vertices.contains(p)) ends.push_back(p);
  }
  std::ranges::sort(ends);
  for (const PetscInt v : ends) {
    const int owner = owner_of_vertex[static_cast<std::size_t>(v - vertices.begin)];
    if (std::ranges::find(ranks, owner) != ranks.end()) return owner;
  }
  return std::nullopt;
}

/// Asks `rank_to_ask` of each of these points about it, if that is one (>= 0); its answers become their owners.
/// Collective.
template <class Rank, class Answer>
void learn_owners(MPI_Comm comm, std::span<const GhostPoint> points, Rank rank_to_ask, Answer answer,
                  std::vector<PetscSFNode>& owners) {
  std::vector<std::vector<Question>> questions(static_cast<std::size_t>(num_ranks(comm)));
  std::vector<std::vector<PetscInt>> asked_about(questions.size());
  for (const GhostPoint& ghost : points) {
    const int r = rank_to_ask(ghost);
    if (r < 0) continue;
    questions[static_cast<std::size_t>(r)].push_back(ghost.question);
    asked_about[static_cast<std::size_t>(r)].push_back(ghost.point);
  }
  const std::vector<PetscSFNode> answers = answered(comm, questions, answer);
  auto next = answers.begin();
  for (const auto& list : asked_about) {
    for (const PetscInt p : list) owners[static_cast<std::size_t>(p)] = *next++;
  }
}

}  // namespace

OverlappingCells with_ghosts(MPI_Comm comm, CellBlock own) {
  OverlappingCells result;
  result.num_own = static_cast<PetscInt>(own.num_cells());
  const std::vector<Holder> others = other_holders(comm, own.vertices);
  const std::vector<std::vector<PetscInt>> near = cells_near(own, others, num_ranks(comm));
  std::vector<int> num_in;
  const CellBlock ghosts = sent(comm, own, near, num_in);
  result.ghost_cells = exchanged(comm, near);
  for (std::size_t r = 0; r < num_in.size(); ++r) {
    result.ghost_ranks.insert(result.ghost_ranks.end(), static_cast<std::size_t>(num_in[r]), static_cast<int>(r));
  }
  for (const auto& list : near) result.border.insert(result.border.end(), list.begin(), list.end());
  std::ranges::sort(result.border);
  result.border.erase(std::unique(result.border.begin(), result.border.end()), result.border.end());
  add_vertices(comm, near, own);
  append(own, ghosts);
  result.block = std::move(own);
  return result;
}

void set_owners(MPI_Comm comm, DM dm, const OverlappingCells& cells) {
  const int me = rank(comm);
  PetscInt num_points = 0;
  check(DMPlexGetChart(dm, nullptr, &num_points));
  std::vector<PetscSFNode> owners(static_cast<std::size_t>(num_points));
  for (PetscInt p = 0; p < num_points; ++p) owners[static_cast<std::size_t>(p)] = {me, p};
  std::vector<char> touches_own(static_cast<std::size_t>(num_points), 0);
  for (const PetscInt c : cells.border) {
    for (const PetscInt p : Closure(dm, c)) touches_own[static_cast<std::size_t>(p)] = 1;
  }
  const std::vector<GhostPoint> ghosts = points_of_ghosts(dm, cells);
  // The owner of a point of own cells is one of the ranks around it, all of which know this.
  std::vector<int> owner_of_touching(ghosts.size(), -1);
  const PointRange vertices = stratum(dm, 0);  // before edges and facets, in ascending order of numbers
  std::vector<int> owner_of_vertex(static_cast<std::size_t>(vertices.size()), me);
  for (std::size_t first = 0, last = 0; first < ghosts.size(); first = last) {
    std::vector<int> ranks{me};
    for (; last < ghosts.size() && ghosts[last].point == ghosts[first].point; ++last)
      ranks.push_back(ghosts[last].rank);
    if (touches_own[static_cast<std::size_t>(ghosts[first].point)] == 0) continue;
    std::ranges::sort(ranks);
    int owner = ranks[hash_of(dm, ghosts[first].point, cells.block.vertices) % ranks.size()];
    if (vertices.contains(ghosts[first].point)) {
      owner_of_vertex[static_cast<std::size_t>(ghosts[first].point - vertices.begin)] = owner;
    } else {
      owner = owner_of_ends(dm, ghosts[first].point, owner_of_vertex, ranks).value_or(owner);
    }
    for (std::size_t i = first; i < last; ++i) {
      if (ghosts[i].rank == owner) owner_of_touching[i] = owner;
    }
  }
  const auto point_of = [&](const Question& q) { return Closure(dm, q.cell)[static_cast<std::size_t>(q.slot)]; };
  learn_owners(
      comm, ghosts,
      [&](const GhostPoint& g) { return owner_of_touching[static_cast<std::size_t>(&g - ghosts.data())]; },
      [&](const Question& q) {
        return PetscSFNode{me, point_of(q)};
      },
      owners);
  // Points of ghost cells alone: the ranks of the cells know by now.
  learn_owners(
      comm, ghosts,
      [&](const GhostPoint& g) { return touches_own[static_cast<std::size_t>(g.point)] != 0 ? -1 : g.rank; },
      [&](const Question& q) { return owners[static_cast<std::size_t>(point_of(q))]; }, owners);
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  for (PetscInt p = 0; p < num_points; ++p) {
    const PetscSFNode& owner = owners[static_cast<std::size_t>(p)];
    if (owner.rank == me) continue;
    leaves.push_back(p);
    roots.push_back(owner);
  }
  PetscSF sf = nullptr;
  check(DMGetPointSF(dm, &sf));
  check(PetscSFSetGraph(sf, num_points, static_cast<PetscInt>(leaves.size()), leaves.data(), PETSC_COPY_VALUES,
                        roots.data(), PETSC_COPY_VALUES));
}

}  // namespace pliant
