// Surfaces that overlap or touch are moved apart.
#include "collision/candidates.hpp"
#include "collision/overlaps.hpp"
#include "energy/body_contact.hpp"
#include "energy/contact/separation.hpp"
#include "energy/near_springs.hpp"

#include <algorithm>
#include <functional>

namespace pliant::test_separation {
namespace {

using test::Scratch;
using test::Solid;
using Place = Vector3<double>;

const MPI_Comm comm = MPI_COMM_SELF;
constexpr double gap = 0.3, between = 1.0 + 0.5 * gap, wanted = 0.01, least = 0.005;

/// Cubes of 1 m, beside each other along x, with 2 x 2 x 2 bricks each.
class TwoCubes : public ::testing::TestWithParam<int> {
 protected:
  TwoCubes() : solid_(comm, file_, GetParam(), 2) {
    surfaces_.push_back(test::surfaces_of(solid_, between, FacetVertices::nodes));
    if (GetParam() == 2) surfaces_.push_back(test::surfaces_of(solid_, between, FacetVertices::mean));
  }

  bool is_second(std::size_t vertex) const { return surface().rest_positions()[vertex][0] > between; }
  const CollisionSurface& surface() const { return surfaces_.front()->surface(); }

  /// With the second one elsewhere.
  std::vector<Place> moved(const std::function<Place(const Place&)>& where) const {
    std::vector<Place> x(surface().rest_positions().begin(), surface().rest_positions().end());
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (is_second(v)) x[v] = where(x[v]);
    }
    return x;
  }

  std::vector<Place> apart(std::vector<Place> x, double depth) const {
    const GapGoal goal{wanted, least, 0.5, depth};
    std::vector<const BodySurfaces*> surfaces;
    for (const auto& of : surfaces_) surfaces.push_back(of.get());
    move_apart(surfaces, ContactSets{}, GapGoals{2, {{}, goal, goal, {}}}, x);
    return x;
  }

  void expect_apart(const std::vector<Place>& nodes) const {
    for (const auto& of : surfaces_) {
      std::vector<Place> x = nodes;
      of->place(x);
      EXPECT_TRUE(find_overlaps(of->surface(), x, ContactSets{}).empty());
      EXPECT_GE(least_distances(of->surface(), x, 2, 1.0)[1], 0.9 * least);
    }
  }

 private:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
  Solid solid_;
  std::vector<std::shared_ptr<const BodySurfaces>> surfaces_;
};

INSTANTIATE_TEST_SUITE_P(Order, TwoCubes, ::testing::Values(1, 2));

TEST_P(TwoCubes, ThatTouchStayFlat) {
  const auto before = moved([](const Place& X) { return X - Place{gap, 0.0, 0.0}; });
  const auto x = apart(before, 0.0);
  expect_apart(x);
  for (std::size_t v = 0; v < x.size(); ++v) {
    const double side = is_second(v) ? 1.0 : -1.0;
    const Place way = std::abs(before[v][0] - 1.0) < 1e-9 ? Place{side * 0.5 * wanted, 0.0, 0.0} : Place{};
    EXPECT_LT(norm(x[v] - before[v] - way), 1e-12) << v;
  }
}

TEST_P(TwoCubes, ThatOverlapAreParted) {
  for (const double depth : {1e-9, 1e-3, 0.03, 0.06}) {
    const auto before = moved([&](const Place& X) { return X - Place{gap + depth, 0.21, 0.13}; });
    const auto x = apart(before, depth);
    expect_apart(x);
    double farthest = 0.0;
    for (std::size_t v = 0; v < x.size(); ++v) farthest = std::max(farthest, norm(x[v] - before[v]));
    EXPECT_LT(farthest, 1.2 * depth + wanted);
  }
}

TEST_P(TwoCubes, ThatCrossEdges) {
  // The edge of the first at x = z = 1 and one of the second across it; no corner is in the other cube.
  const double s = std::sqrt(0.5), depth = 0.03;
  const Place across{s, 0.0, -s}, outwards{s, 0.0, s}, along{0.0, 1.0, 0.0};
  const auto before = moved([&](const Place& X) {
    return Place{1.0, 0.45, 1.0} - depth * outwards + (X[0] - 1.0 - gap - 0.45) * across +
           s * X[1] * (outwards + along) + s * X[2] * (outwards - along);
  });
  EXPECT_FALSE(find_overlaps(surface(), before, ContactSets{}).empty());
  const auto x = apart(before, 0.0);
  expect_apart(x);
  double farthest = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v) farthest = std::max(farthest, norm(x[v] - before[v]));
  EXPECT_LT(farthest, 2.0 * depth);
}

TEST_P(TwoCubes, ThatAreApartStay) {
  const auto before = moved([](const Place& X) { return X - Place{gap - 0.05, 0.0, 0.0}; });
  EXPECT_EQ(apart(before, 0.0), before);
}

TEST_P(TwoCubes, ThatAreTooDeepStay) {
  const auto before = moved([](const Place& X) { return X - Place{gap + 0.99, 0.0, 0.0}; });
  const auto x = apart(before, 0.0);
  EXPECT_FALSE(find_overlaps(surface(), x, ContactSets{}).empty());
}

}  // namespace
}  // namespace pliant::test_separation
