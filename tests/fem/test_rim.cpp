// Where a surface ends: the edges, what may move there, and the volume that the surface looks into.
#include "fem/body.hpp"
#include "fem/rim.hpp"
#include "petsc/collective.hpp"

namespace pliant::test_rim {
namespace {

using test::Body;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class Rims : public test::OnBodies {
 protected:
  static bool is_on(const Point& x, int axis, double value) { return std::abs(x[axis] - value) < 1e-9; }

  FacetList face(int axis, double value) const {
    return surface_facets(body_.mesh, layout_, [=](const Point& x) { return is_on(x, axis, value); });
  }
  static FacetList joined(FacetList a, const FacetList& b) {
    a.nodes.insert(a.nodes.end(), b.nodes.begin(), b.nodes.end());
    a.is_owned.insert(a.is_owned.end(), b.is_owned.begin(), b.is_owned.end());
    a.is_outer.insert(a.is_outer.end(), b.is_outer.begin(), b.is_outer.end());
    return a;
  }
  PetscInt64 count(const std::vector<RimEdge>& edges) const { return sum(comm, static_cast<PetscInt64>(edges.size())); }

  /// Flags and displacements of all local entries, from functions of place and direction.
  struct Samples {
    std::vector<char> flags;
    PrescribedSamples view;
  };
  template <class IsHeld, class Displacement>
  Samples samples(IsHeld is_held, Displacement displacement) const {
    Samples result;
    auto& u = result.view.displacements.emplace_back();
    for (PetscInt a = 0; a < layout_.num_local_nodes; ++a) {
      for (int i = 0; i < 3; ++i) {
        const bool held = is_held(layout_.position(a), i);
        result.flags.push_back(held);
        u.push_back(held ? displacement(layout_.position(a), i) : 0.0);
      }
    }
    result.view.flags = result.flags;
    return result;
  }
  static double at_rest(const Point&, int) { return 0.0; }
  static bool on_rollers(const Point& x, int i) { return is_on(x, i, 0.0); }
};

INSTANTIATE_TEST_SUITE_P(Bodies, Rims,
                         ::testing::Values(BodySpec{1, Shape::straight, 1}, BodySpec{1, Shape::jittered, 5},
                                           BodySpec{2, Shape::jittered, 3}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Rims, AClosedSurfaceHasNone) {
  const auto facets = surface_facets(body_.mesh, layout_, [](const Point&) { return true; });
  auto edges = rim_edges(layout_, facets);
  EXPECT_EQ(count(edges), 0);
  const Samples free = samples([](const Point&, int) { return false; }, at_rest);
  EXPECT_EQ(classify(layout_, edges, free.view), Rim::none);
  EXPECT_NEAR(std::get<double>(volume_behind(layout_, facets, edges)), -1.0, 1e-13);  // they look away from the body
}

TEST_P(Rims, OfAFaceAreItsFourSides) {
  auto edges = rim_edges(layout_, face(0, 1.0));
  EXPECT_EQ(count(edges), 4 * GetParam().n);
  Point around{};  // int x cross dx of the loop: twice the area, along the normal
  for (const RimEdge& edge : edges) {
    const auto a = layout_.position(edge.nodes[0]), b = layout_.position(edge.nodes[1]);
    for (int i = 0; i < 3; ++i) around[i] += a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    if (GetParam().order == 2) {
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(layout_.position(edge.nodes[2])[i], 0.5 * (a[i] + b[i]), 1e-14);
    }
  }
  EXPECT_NEAR(sum(comm, around[0]), 2.0, 1e-13);
}

TEST_P(Rims, AreClassifiedByWhatTheyMayDo) {
  auto edges = rim_edges(layout_, face(0, 1.0));
  const auto of = [&](auto is_held, auto displacement) {
    return classify(layout_, edges, samples(is_held, displacement).view);
  };
  const auto all = [](const Point&, int) { return true; };
  const auto along = [](int axis) { return [axis](const Point&, int i) { return i == axis; }; };
  const auto but = [](int axis) { return [axis](const Point&, int i) { return i != axis; }; };
  EXPECT_EQ(of([](const Point&, int) { return false; }, at_rest), Rim::free);
  EXPECT_EQ(of(all, at_rest), Rim::still);
  EXPECT_EQ(of(all, [](const Point& x, int i) { return i == 0 ? x[1] : 0.0; }), Rim::moving);
  EXPECT_EQ(of(along(0), at_rest), Rim::still);  // slides in its plane
  for (const RimEdge& edge : edges) EXPECT_EQ(edge.plane, 0);
  EXPECT_EQ(of(along(0), [](const Point&, int) { return 0.1; }), Rim::free);  // the plane does work on what it cuts
  EXPECT_EQ(of(but(1), [](const Point&, int i) { return i == 2 ? 0.1 : 0.0; }), Rim::moving);  // within the plane x = 1
  EXPECT_EQ(of(along(0), [](const Point& x, int) { return 0.1 * x[1]; }), Rim::free);          // no plane any more
  EXPECT_EQ(of(along(1), at_rest), Rim::free);
  EXPECT_EQ(of(but(0), at_rest), Rim::still);                                          // a piston in a square tube
  EXPECT_EQ(of([](const Point& x, int) { return x[1] > 1e-9; }, at_rest), Rim::free);  // one side is loose
}

// Three faces at the far corner on rollers in the planes through the origin, which close what is behind them.
TEST_P(Rims, PlanesCloseWhatTheyCut) {
  const auto facets = joined(joined(face(0, 1.0), face(1, 1.0)), face(2, 1.0));
  auto edges = rim_edges(layout_, facets);
  EXPECT_EQ(count(edges), 6 * GetParam().n);
  EXPECT_EQ(classify(layout_, edges, samples(on_rollers, at_rest).view), Rim::still);
  EXPECT_NEAR(std::get<double>(volume_behind(layout_, facets, edges)), -1.0, 1e-13);
}

TEST_P(Rims, ParallelPlanesLeaveTheVolumeOpen) {
  const auto facets = face(1, 1.0);
  auto edges = rim_edges(layout_, facets);
  const auto sides =
      samples([](const Point& x, int i) { return i != 1 && (is_on(x, i, 0.0) || is_on(x, i, 1.0)); }, at_rest);
  EXPECT_EQ(classify(layout_, edges, sides.view), Rim::still);
  const auto behind = volume_behind(layout_, facets, edges);
  ASSERT_TRUE(std::holds_alternative<UnknownLid>(behind));
  const UnknownLid unknown = std::get<UnknownLid>(behind);
  ASSERT_TRUE(unknown.direction.has_value());
  EXPECT_NEAR(std::abs(unknown.places[1] - unknown.places[0]), 1.0, 1e-12);
}

// The end of a square tube slides along its walls; a piston in it has its walls around it.
TEST_P(Rims, AnEndThatSlidesAlongItsWallsIsOpen) {
  FacetList tube = joined(joined(face(1, 0.0), face(1, 1.0)), joined(face(2, 0.0), face(2, 1.0)));
  const auto held = [](auto is_free) { return [is_free](const Point& x, int i) { return !is_free(x, i); }; };
  const auto along = held([](const Point& x, int i) { return i == 0 && is_on(x, 0, 1.0); });
  const auto across = held([](const Point& x, int i) { return i != 0 && is_on(x, 0, 1.0); });
  const auto closes = [&](const FacetList& facets, auto is_held) {
    auto edges = rim_edges(layout_, facets);
    EXPECT_EQ(classify(layout_, edges, samples(is_held, at_rest).view), Rim::still);
    return planes_close(layout_, edges);
  };
  EXPECT_FALSE(closes(tube, along));
  EXPECT_TRUE(closes(tube, across));
  EXPECT_TRUE(closes(tube, [](const Point&, int) { return true; }));
  EXPECT_TRUE(closes(joined(tube, face(0, 1.0)), [](const Point&, int) { return true; }));
  EXPECT_TRUE(closes(face(0, 1.0), along));
}

// Five faces of the cube, the sixth closed by the cone to the middle of its sides.
TEST_P(Rims, AHeldLoopIsClosedByALid) {
  auto facets = face(0, 1.0);
  for (const auto& [axis, value] : {std::pair{1, 0.0}, {1, 1.0}, {2, 0.0}, {2, 1.0}}) {
    facets = joined(facets, face(axis, value));
  }
  auto edges = rim_edges(layout_, facets);
  EXPECT_EQ(classify(layout_, edges, samples([](const Point&, int) { return true; }, at_rest).view), Rim::still);
  EXPECT_NEAR(std::get<double>(volume_behind(layout_, facets, edges)), -1.0, 1e-13);
}

// Half a cup: its mount is held, and its wall slides in the plane of symmetry. The lid lies in both planes.
TEST_P(Rims, AHeldPartOfALoopIsAPlaneLikeTheOthers) {
  auto facets = face(1, 1.0);
  for (const auto& [axis, value] : {std::pair{0, 0.0}, {0, 1.0}, {2, 0.0}}) facets = joined(facets, face(axis, value));
  auto edges = rim_edges(layout_, facets);
  const auto cup = [](const Point& x, int i) { return is_on(x, 2, 1.0) || (i == 1 && is_on(x, 1, 0.0)); };
  EXPECT_EQ(classify(layout_, edges, samples(cup, at_rest).view), Rim::still);
  EXPECT_NEAR(std::get<double>(volume_behind(layout_, facets, edges)), -1.0, 1e-13);
  // Held further down, along the plane of symmetry too.
  const auto deeper = [](const Point& x, int i) { return x[2] > 0.5 || (i == 1 && is_on(x, 1, 0.0)); };
  EXPECT_EQ(classify(layout_, edges, samples(deeper, at_rest).view), Rim::still);
  EXPECT_NEAR(std::get<double>(volume_behind(layout_, facets, edges)), -1.0, 1e-13);
}

// A quarter of a cup meets three planes in one point; half a tube and a quarter of one have a lid at either end.
TEST_P(Rims, EachHeldPartOfALoopHasItsLid) {
  if (GetParam().n == 1) GTEST_SKIP() << "all nodes of the tubes would be held";
  const auto volume = [&](const FacetList& facets, auto is_held) {
    auto edges = rim_edges(layout_, facets);
    EXPECT_EQ(classify(layout_, edges, samples(is_held, at_rest).view), Rim::still);
    return volume_behind(layout_, facets, edges);
  };
  const auto quarter = [](bool is_tube) {
    return [is_tube](const Point& x, int i) {
      return is_on(x, 2, 1.0) || (is_tube && is_on(x, 2, 0.0)) || (i != 2 && is_on(x, i, 0.0));
    };
  };
  const auto corner = joined(face(0, 1.0), face(1, 1.0));
  EXPECT_NEAR(std::get<double>(volume(joined(corner, face(2, 0.0)), quarter(false))), -1.0, 1e-13);
  EXPECT_NEAR(std::get<double>(volume(corner, quarter(true))), -1.0, 1e-13);
  const auto half = [](const Point& x, int i) {
    return is_on(x, 2, 0.0) || is_on(x, 2, 1.0) || (i == 1 && is_on(x, 1, 0.0));
  };
  EXPECT_NEAR(std::get<double>(volume(joined(corner, face(0, 0.0)), half)), -1.0, 1e-13);
  // Two faces of a corner: what is held bends, and no lid follows from it.
  const auto bent = [](const Point& x, int i) {
    const bool is_corner = (is_on(x, 0, 1.0) && is_on(x, 2, 0.0)) || (is_on(x, 0, 0.0) && is_on(x, 2, 1.0));
    return !is_on(x, 1, 0.0) || is_corner || i == 1;
  };
  const auto behind = volume(joined(face(0, 1.0), face(2, 1.0)), bent);
  ASSERT_TRUE(std::holds_alternative<UnknownLid>(behind));
  EXPECT_FALSE(std::get<UnknownLid>(behind).direction.has_value());
}

}  // namespace
}  // namespace pliant::test_rim
