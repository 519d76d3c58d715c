// Pairs of patches over all ranks, in motions at random, compared with brute force and with a search on one rank.
#include "energy/near_springs.hpp"
#include "energy/pairs/pair_assembly.hpp"
#include "energy/pairs/patch_search.hpp"
#include "petsc/session.hpp"

#include <map>
#include <random>
#include <set>

namespace pliant::test_patch_search {
namespace {

using test::Scratch;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3, between = 1.0 + 0.5 * gap;

/// Whether the triangles of a body see one another too.
enum class Seen { other_bodies, all };

/// What a patch is the hull of: its nodes, or combinations of them that reach beyond.
enum class Hull { nodes, points };

struct Kind {
  Seen seen;
  Hull hull;
};

/// The surface triangles of two bodies, with keys and tags that do not depend on the ranks.
class Triangles final : public PairCoupling {
 public:
  Triangles(const Solid& solid, double reach, Kind kind) : reach_(reach), seen_(kind.seen) {
    const NodeLayout& layout = solid.layout();
    const FacetList facets = surface_facets(solid.mesh(), layout, [](const auto&) { return true; });
    patches_.nodes_per_patch = 3;
    patches_.nodes = facets.nodes;
    patches_.is_owned = facets.is_owned;
    for (PetscInt n = 0; n < facets.size(); ++n) {
      std::array<std::int64_t, 3> vertices;
      for (std::size_t a = 0; a < 3; ++a) {
        vertices[a] = layout.vertex_numbers[patches_.nodes[3 * static_cast<std::size_t>(n) + a]];
      }
      std::ranges::sort(vertices);
      patches_.keys.push_back((vertices[0] * 10000 + vertices[1]) * 10000 + vertices[2]);
      patches_.tags.push_back(layout.position(patches_.nodes[3 * static_cast<std::size_t>(n)])[0] < between ? -7 : 40);
      if (kind.hull == Hull::nodes) continue;
      patches_.points_per_patch = 2;
      patches_.points.push_back({{1}});
      patches_.points.push_back({{2, 0, 1}, {3.0, -1.0, -1.0}});
    }
  }

  const Patches& patches() const override { return patches_; }
  double reach() const override { return reach_; }
  bool may_couple(int tag, int other) const override { return seen_ == Seen::all || tag != other; }

 private:
  Patches patches_;
  double reach_;
  Seen seen_;
};

/// A displacement of each vertex at random; the second body moves away by `apart` in all.
std::vector<double> random_displacements(const NodeLayout& layout, unsigned seed, double size, double apart) {
  std::vector<double> q(3 * static_cast<std::size_t>(layout.num_local_nodes));
  for (PetscInt node = 0; node < layout.num_local_nodes; ++node) {
    std::mt19937 engine(seed + 7919 * static_cast<unsigned>(layout.vertex_numbers[node]));
    std::uniform_real_distribution<double> uniform(-size, size);
    for (PetscInt k = 0; k < 3; ++k) q[3 * node + k] = uniform(engine);
    if (layout.position(node)[0] > between) q[3 * node] += apart;
  }
  return q;
}

/// A triangle by its corners on the way, at t = 0 and t = 1; those of a patch of two points coincide in part.
struct Moving {
  std::array<Vector3<double>, 3> at, by;
};

Moving moving(const Solid& solid, const Patches& patches, std::size_t patch, const Path& path) {
  const auto nodes = patches.nodes_of(patch);
  Moving triangle;
  for (std::size_t a = 0; a < 3; ++a) {
    const Vector3<double> X = solid.layout().position(nodes[a]);
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.at[a][k] = X[k] + path.q[3 * nodes[a] + k];
      triangle.by[a][k] = path.end * path.d[3 * nodes[a] + k];
    }
  }
  if (patches.points_per_patch == 0) return triangle;
  Moving hull{};
  for (std::size_t a = 0; a < 3; ++a) {
    const PatchPoint& point = patches.points[2 * patch + std::min<std::size_t>(a, 1)];
    for (std::size_t b = 0; b < 3; ++b) {
      hull.at[a] = hull.at[a] + point.weights[b] * triangle.at[point.nodes[b]];
      hull.by[a] = hull.by[a] + point.weights[b] * triangle.by[point.nodes[b]];
    }
  }
  return hull;
}

/// The least distance of corners and centres at some times: at least the least distance of the triangles.
double sampled_distance(const Moving& a, const Moving& b) {
  const auto points = [](const Moving& triangle, double t) {
    std::array<Vector3<double>, 4> x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = triangle.at[k] + t * triangle.by[k];
    x[3] = (1.0 / 3.0) * (x[0] + x[1] + x[2]);
    return x;
  };
  double least = std::numeric_limits<double>::infinity();
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    for (const auto& x : points(a, t)) {
      for (const auto& y : points(b, t)) least = std::min(least, dot(x - y, x - y));
    }
  }
  return std::sqrt(least);
}

using KeyPair = std::pair<std::int64_t, std::int64_t>;

/// The keys of pairs, which are to be in order, each once.
std::vector<KeyPair> keys_of(const FoundPatches& found) {
  std::vector<KeyPair> pairs;
  for (const PatchPair& pair : found.pairs) pairs.emplace_back(found.keys[pair.first], found.keys[pair.second]);
  for (const KeyPair& pair : pairs) EXPECT_LT(pair.first, pair.second);
  EXPECT_TRUE(std::ranges::is_sorted(pairs));
  EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end());
  return pairs;
}

/// Two bodies on all ranks, and on this one alone.
class PatchSearches : public ::testing::TestWithParam<Kind> {
 protected:
  static constexpr double reach = 0.08;

  PatchSearches() {
    for (const std::int64_t key : here_.patches().keys) keys_here_.insert(key);
  }

  /// Searches on all ranks and alone, and compares: the same pairs where this rank has a patch, and none missed.
  void expect_pairs_of_brute_force(unsigned seed, double size, double apart, double length) {
    const auto q = random_displacements(many_.layout(), seed, size, apart),
               d = random_displacements(many_.layout(), seed + 1, length, -apart),
               q_alone = random_displacements(alone_.layout(), seed, size, apart),
               d_alone = random_displacements(alone_.layout(), seed + 1, length, -apart);
    const Path path_alone{q_alone, d_alone, search_alone_.searchable_part(d_alone)};
    const Path path{q, d, path_alone.end};
    ASSERT_GE(path.end, 0.0);
    ASSERT_LE(path.end, (1.0 + 1e-12) * search_.searchable_part(d));
    const FoundPatches found = search_.search(path), found_alone = search_alone_.search(path_alone);
    EXPECT_TRUE(search_.covers(path));

    const auto pairs = keys_of(found);
    std::vector<KeyPair> expected;
    for (const KeyPair& pair : keys_of(found_alone)) {
      if (keys_here_.contains(pair.first) || keys_here_.contains(pair.second)) expected.push_back(pair);
    }
    EXPECT_EQ(pairs, expected);
    EXPECT_EQ(found.global_nodes.size(), 3 * (found.keys.size() - keys_here_.size()));

    const Patches& patches = there_.patches();
    std::set<KeyPair> all;
    for (const KeyPair& pair : pairs) all.insert(pair);
    for (std::size_t i = 0; i < patches.size(); ++i) {
      for (std::size_t j = 0; j < patches.size(); ++j) {
        const KeyPair pair{patches.keys[i], patches.keys[j]};
        if (pair.first >= pair.second || !there_.may_couple(patches.tags[i], patches.tags[j])) continue;
        if (!keys_here_.contains(pair.first) && !keys_here_.contains(pair.second)) continue;
        const double distance =
            sampled_distance(moving(alone_, patches, i, path_alone), moving(alone_, patches, j, path_alone));
        if (distance >= reach) continue;
        ++num_near_;
        EXPECT_TRUE(all.contains(pair)) << pair.first << " " << pair.second;
      }
    }
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap, 3); });
  Solid many_{comm, file_, 1, 1}, alone_{MPI_COMM_SELF, file_, 1, 1};
  Triangles here_{many_, reach, GetParam()}, there_{alone_, reach, GetParam()};
  PatchSearch search_{many_.layout(), here_}, search_alone_{alone_.layout(), there_};
  std::set<std::int64_t> keys_here_;
  std::size_t num_near_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Bodies, PatchSearches,
                         ::testing::Values(Kind{Seen::other_bodies, Hull::nodes}, Kind{Seen::all, Hull::nodes},
                                           Kind{Seen::other_bodies, Hull::points}));

TEST_P(PatchSearches, FindThePairsOfBruteForceInMotionsAtRandom) {
  unsigned seed = 1;
  for (const double size : {0.0, 0.02, 0.1, 0.4}) {
    for (const double apart : {0.0, -0.25, 1.0}) {
      for (const double length : {0.0, 0.05, 0.5}) expect_pairs_of_brute_force(seed += 2, size, apart, length);
    }
  }
  // A rank that has none of the nearest patches has no pair of two bodies.
  EXPECT_GT(sum(comm, static_cast<PetscInt64>(num_near_)), 1000);
}

TEST_P(PatchSearches, FindThePairsOnThePartOfALongPath) {
  expect_pairs_of_brute_force(101, 0.05, 0.0, 1e3);
  expect_pairs_of_brute_force(103, 0.05, -0.3, 1e9);
}

TEST_P(PatchSearches, HoldWhileNodesStayInTheirBoxes) {
  const NodeLayout& layout = many_.layout();
  const auto q = random_displacements(layout, 1, 0.05, 0.0), near = random_displacements(layout, 2, 0.03, 0.0);
  auto moved = q, far = q, broken = q;
  for (std::size_t i = 0; i < q.size(); ++i) moved[i] += near[i];
  EXPECT_FALSE(search_.covers({q}));
  (void)search_.search({q});
  EXPECT_TRUE(search_.covers({q}));
  EXPECT_TRUE(search_.covers({moved}));  // less than half of the least skin
  EXPECT_TRUE(search_.covers({q, near}));
  const auto surface_node = static_cast<std::size_t>(here_.patches().nodes[0]);
  far[3 * surface_node + 1] += 1.01 * reach;
  broken[3 * surface_node + 1] = std::nan("");
  EXPECT_FALSE(search_.covers({far}));
  EXPECT_FALSE(search_.covers({broken}));
  std::vector<double> away(q.size(), 0.0);
  away[3 * surface_node + 1] = 1.01 * reach;
  EXPECT_FALSE(search_.covers({q, away}));
  (void)search_.search({q, away});
  EXPECT_TRUE(search_.covers({q, away}));
}

// What was met on a long path is not kept for what moves little.
TEST_P(PatchSearches, AreMadeAnewAfterALongPath) {
  const NodeLayout& layout = many_.layout();
  const auto q = random_displacements(layout, 1, 0.01, 0.0), d = random_displacements(layout, 2, 1.0, 0.0);
  const Path path{q, d, minimum(comm, search_.searchable_part(d))};
  const auto num_pairs = [](const FoundPatches& found) {
    return sum(comm, static_cast<PetscInt64>(found.pairs.size()));
  };
  const auto num_on_path = num_pairs(search_.search(path));
  EXPECT_TRUE(search_.covers(path));
  EXPECT_FALSE(search_.covers({q}));
  const auto num_there = num_pairs(search_.search({q}));
  EXPECT_TRUE(search_.covers({q}));
  EXPECT_LT(2 * num_there, num_on_path);
}

// The matrix has room for what is near, wherever the bodies go; what it has room for already does not renew it.
TEST_P(PatchSearches, AreInThePatternOfTheAssembly) {
  const NodeLayout& layout = many_.layout();
  const std::vector<char> nothing_prescribed(3 * static_cast<std::size_t>(layout.num_local_nodes), 0);
  PairAssembly pairs(layout, {&here_}, nothing_prescribed);
  const auto missing = [&] {
    const NearPatches& near = pairs.near(0);
    PetscInt64 number = 0;
    const auto is_missing = [&](PetscInt a, PetscInt b) { return near.is_owned(a) && !pairs.pattern().contains(a, b); };
    for (const PatchPair& pair : near.pairs) {
      for (const PetscInt a : near.patches.nodes_of(pair.first)) {
        for (const PetscInt b : near.patches.nodes_of(pair.second)) number += is_missing(a, b) + is_missing(b, a);
      }
    }
    return sum(comm, number);
  };
  int num_renewed = 0;
  for (unsigned seed = 1; seed < 9; ++seed) {
    const double apart = seed % 2 == 0 ? -0.25 : 0.1;
    const auto q = random_displacements(layout, seed, 0.05, apart);
    (void)pairs.follow({q});
    num_renewed += pairs.fit() ? 1 : 0;
    EXPECT_EQ(missing(), 0) << seed;
    EXPECT_FALSE(pairs.fit());
  }
  EXPECT_GT(num_renewed, 1);
  const auto q = random_displacements(layout, 8, 0.05, -0.25);
  pairs.forget();
  (void)pairs.follow({q});
  EXPECT_TRUE(pairs.fit());
  EXPECT_EQ(missing(), 0);
}

// However long the displacement is, the number of pairs is bounded by that of the patches; and the path that is
// searched is the same for all lengths.
TEST(SearchablePart, BoundsTheNumberOfPairs) {
  const Scratch scratch(comm);
  std::map<int, double> lengths;
  for (const int cubes : {4, 8}) {
    const std::string file =
        scratch.file("fine.msh", [&](const std::string& f) { test::write_two_cubes(f, gap, cubes); });
    const Solid solid(comm, file, 1, 1);
    const Triangles triangles(solid, 0.01, {Seen::all, Hull::nodes});
    PatchSearch search(solid.layout(), triangles);
    const auto q = random_displacements(solid.layout(), 1, 0.01, 0.0);
    PetscInt64 num_owned = 0, num_pairs = -1;
    for (const char owned : triangles.patches().is_owned) num_owned += owned;
    num_owned = sum(comm, num_owned);
    for (const double length : {1e2, 1e6, 1e200}) {
      const auto d = random_displacements(solid.layout(), 2, length, 0.0);
      const double end = minimum(comm, search.searchable_part(d));
      EXPECT_GT(end, 0.0);
      const FoundPatches found = search.search({q, d, end});
      PetscInt64 num_counted = 0;  // each once
      for (const PatchPair& pair : found.pairs) {
        if (pair.first < triangles.patches().size()) num_counted += triangles.patches().is_owned[pair.first];
      }
      num_counted = sum(comm, num_counted);
      EXPECT_LT(num_counted, 160 * num_owned);
      if (num_pairs >= 0) {
        EXPECT_NEAR(static_cast<double>(num_counted), static_cast<double>(num_pairs), 0.2 * num_pairs);
      }
      num_pairs = num_counted;
      lengths[cubes] = end * length;
    }
    EXPECT_EQ(search.searchable_part(random_displacements(solid.layout(), 3, 0.2, 0.0)), 1.0);
  }
  // It is in proportion to the triangles.
  EXPECT_NEAR(lengths[4] / lengths[8], (0.25 + 0.01) / (0.125 + 0.01), 0.1);
}

/// Nodes along the diagonal of a plane on every rank, each rank a little beside the one before, as points of one kind.
struct Diagonals {
  static constexpr int num_points = 1000;
  static constexpr double beside = 10.0;

  Diagonals() {
    layout.comm = comm;
    layout.num_owned_nodes = layout.num_local_nodes = num_points;
    layout.first_global_node = num_points * rank(comm);
    for (int n = 0; n < num_points; ++n) {
      const double s = 0.1 * n;
      points.all.nodes.push_back(n);
      points.all.keys.push_back(layout.first_global_node + n);
      points.all.tags.push_back(0);
      points.all.is_owned.push_back(1);
      layout.coordinates.insert(layout.coordinates.end(), {s, s + beside * rank(comm), 0.0});
    }
  }

  struct Points final : PairCoupling {
    const Patches& patches() const override { return all; }
    double reach() const override { return 0.01; }
    bool may_couple(int, int) const override { return true; }
    Patches all;
  };
  NodeLayout layout;
  Points points;
};

// The boxes around all points of two ranks overlap in nearly all of their volume; no point is near another rank's.
TEST(ForeignPatches, AreThoseNearPatchesOfThisRankAlone) {
  Diagonals diagonals;
  const PatchKinds kinds(comm, diagonals.points);
  const std::vector<std::int32_t> kind_of_patch(Diagonals::num_points, 0);
  const auto foreign = [&] {
    std::vector<Box> boxes;
    std::vector<KindTree> trees(1);
    for (PetscInt n = 0; n < Diagonals::num_points; ++n) {
      boxes.push_back(box_of(0.005, diagonals.layout.position(n)));
      trees[0].patches.push_back(n);
    }
    trees[0].tree = Bvh(boxes);
    return foreign_patches_near(diagonals.layout, kinds, {diagonals.points.all, kind_of_patch, boxes, trees});
  };
  EXPECT_TRUE(foreign().patches.empty());
  // The first point of every other rank comes to one of rank 0.
  constexpr std::int64_t place = 500;
  if (rank(comm) > 0) std::ranges::copy(std::array{50.0, 50.0, 0.0}, diagonals.layout.coordinates.begin());
  const ForeignPatches found = foreign();
  EXPECT_LT(found.patches.size(), 200U);
  std::map<std::int64_t, PetscInt> node_of_key;
  for (const ForeignPatch& patch : found.patches) node_of_key[patch.key] = found.global_nodes[patch.place];
  for (PetscMPIInt r = 0; r < num_ranks(comm); ++r) {
    const std::int64_t key = r == 0 ? place : std::int64_t{Diagonals::num_points} * r;
    if (r == rank(comm)) continue;
    ASSERT_TRUE(node_of_key.contains(key)) << key;
    EXPECT_EQ(node_of_key[key], key);
  }
}

}  // namespace
}  // namespace pliant::test_patch_search
