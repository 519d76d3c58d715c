// Orders in time of a body that bounces and slides in soft contact with two obstacles, one of which moves, and of two
// bodies that do so with each other: every method without drags, with drags frozen at the step's start, and with
// iterated ones.
#include "energy/body_contact.hpp"
#include "energy/contact/contact.hpp"
#include "energy/motion.hpp"
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <map>
#include <optional>
#include <ostream>

#include <gtest/gtest.h>

namespace pliant::test_contact_order {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

enum class Scene { obstacles, bodies, sinking_bodies };
enum class Drags { none, frozen, iterated };

struct OrderCase {
  Scene scene;
  Method method;
  Drags drags;
};

std::string name_of(const OrderCase& c) {
  constexpr std::array names{"Smooth", "Frozen", "Iterated"};
  constexpr std::array scenes{"Obstacles", "Bodies", "SinkingBodies"};
  std::string name = scenes[static_cast<std::size_t>(c.scene)];
  name += names[static_cast<std::size_t>(c.drags)] + ("_" + std::string(c.method.name));
  std::erase(name, '-');
  return name;
}

std::ostream& operator<<(std::ostream& out, const OrderCase& c) {
  return out << name_of(c);
}

std::vector<OrderCase> every_case() {
  std::vector<OrderCase> cases;
  for (const Scene scene : {Scene::obstacles, Scene::bodies, Scene::sinking_bodies}) {
    for (const Method& method : methods()) {
      for (const Drags drags : {Drags::none, Drags::frozen, Drags::iterated}) {
        if (scene == Scene::sinking_bodies && drags == Drags::frozen) continue;
        cases.push_back({scene, method, drags});
      }
    }
  }
  return cases;
}

const Friction friction{0.8, 0.05, 3.0};
const NormalDamping damping{0.2};

/// On one rank alone: a cube of 1 m, 5 Pa and 1 kg/m^3, or two of them.
struct Motion {
  Motion(const std::string& file, Scene in, Drags drags)
      : scene(in),
        solid(MPI_COMM_SELF, file, 1, 0),
        elastic(solid.elastic(make_law("neo-hookean", 5.0, 0.3))),
        inertia(solid.inertia(1.0, Mass::consistent)),
        contacts(in == Scene::obstacles ? with_obstacles(solid, drags) : between_bodies(solid, in, drags)),
        potential(solid.layout(), solid.pattern(), all_terms(), solid.nothing_prescribed()) {}

  static FrictionUpdate update_of(Drags drags) {
    return drags == Drags::iterated ? FrictionUpdate::iterated : FrictionUpdate::frozen;
  }

  static std::vector<std::unique_ptr<EnergyTerm>> between_bodies(const Solid& solid, Scene scene, Drags drags) {
    const NormalLaw law =
        scene == Scene::bodies ? test::barrier(4.0, 0.4) : NormalLaw{NormalKind::penalty, 20.0, 0.2, 0.4};
    const auto bodies = test::touching(solid, between, law, update_of(drags));
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(make_body_contact(bodies));
    if (drags == Drags::none) return terms;
    terms.push_back(make_body_friction(bodies, friction, damping, update_of(drags)));
    terms.push_back(make_body_damping(bodies, damping, update_of(drags)));
    return terms;
  }

  static std::vector<std::unique_ptr<EnergyTerm>> with_obstacles(const Solid& solid, Drags drags) {
    auto facets = surface_facets(solid.mesh(), solid.layout(), [](const Point&) { return true; });
    const auto surface = std::make_shared<const ContactSurface>(solid.layout(), solid.pattern(), std::move(facets),
                                                                NormalLaw{NormalKind::penalty, 20.0, 0.6, 0.6});
    const RigidMotion still{{Expression(), Expression(), Expression()}, {0.0, 0.0, 1.0}, Expression(), {}};
    const RigidMotion turning{
        {Expression("0.2*sin(3*t)"), Expression(), Expression()}, {0.0, 1.0, 0.0}, Expression("0.8*t"), {}};
    const std::array obstacles{
        std::make_shared<const Obstacle>(make_distance(PlaneShape{{}, {0.0, 0.0, 1.0}}), still),
        std::make_shared<const Obstacle>(make_distance(SphereShape{{-0.8, 0.5, 0.5}, 0.7}), turning)};
    const FrictionUpdate update = update_of(drags);
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    for (const auto& obstacle : obstacles) {
      terms.push_back(std::make_unique<Contact>(surface, obstacle));
      if (drags == Drags::none) continue;
      terms.push_back(make_friction(surface, obstacle, friction, damping, update));
      terms.push_back(make_normal_damping(surface, obstacle, damping, update));
    }
    return terms;
  }

  std::vector<const EnergyTerm*> all_terms() const {
    std::vector<const EnergyTerm*> terms{elastic.get(), inertia.get()};
    for (const auto& term : contacts) terms.push_back(term.get());
    return terms;
  }

  /// (q, v) at the end of `num_steps` steps.
  std::array<std::vector<double>, 2> end(const Method& method, int num_steps) {
    if (scene != Scene::obstacles) {
      const auto q = solid.vector([](const Point& x) { return Point{0.05 * x[1], -0.03 * x[1], 0.05 * x[0]}; });
      const auto v = solid.vector([](const Point& x) {
        return x[0] > between ? Point{-0.4 + 0.2 * (x[2] - 0.5), 0.1, -0.2 - 0.1 * x[0]} : Point{0.1, 0.0, 0.1 * x[1]};
      });
      return test::end_of_motion(potential, method, {0.0, q.get(), v.get(), nullptr, {}}, end_time, num_steps);
    }
    const auto q = solid.vector([](const Point& x) { return Point{0.05 * x[0], -0.03 * x[1], 0.1 + 0.05 * x[0]}; });
    const auto v = solid.vector([](const Point& x) {
      return Point{0.3 - 0.5 * (x[2] - 0.5), 0.6 + 0.2 * x[0], -1.0 + 0.5 * (x[0] - 0.5)};
    });
    return test::end_of_motion(potential, method, {0.0, q.get(), v.get(), nullptr, {}}, end_time, num_steps);
  }

  static constexpr double end_time = 0.5, gap = 0.3, between = 1.0 + 0.5 * gap;
  Scene scene;
  Solid solid;
  std::unique_ptr<ElasticTerm> elastic;
  std::unique_ptr<Inertia> inertia;
  std::vector<std::unique_ptr<EnergyTerm>> contacts;
  IncrementalPotential potential;
};

constexpr int num_fine = 128;

class ContactOrders : public ::testing::TestWithParam<OrderCase> {
 protected:
  /// Without approximation: by dirk33 with iterated drags, and steps so short that its error does not count.
  static const std::array<std::vector<double>, 2>& reference(const std::string& file, Scene scene, Drags drags) {
    static std::map<std::pair<Scene, bool>, std::array<std::vector<double>, 2>> known;
    auto& result = known[{scene, drags == Drags::none}];
    if (result[0].empty()) {
      Motion motion(file, scene, drags == Drags::none ? drags : Drags::iterated);
      result = motion.end(*find_method("dirk33"), 4 * num_fine);
    }
    return result;
  }

  Scratch scratch_{MPI_COMM_SELF};
};

INSTANTIATE_TEST_SUITE_P(Registry, ContactOrders, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

TEST_P(ContactOrders, AreThoseOfTheTable) {
  const OrderCase& c = GetParam();
  if (num_ranks(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "the motion is that of one rank";
  const std::string file = scratch_.file("body.msh", [&](const std::string& f) {
    if (c.scene != Scene::obstacles) return test::write_two_cubes(f, Motion::gap, 1);
    test::write_body(f, {1, Shape::straight, 1});
  });
  Motion motion(file, c.scene, c.drags);
  // What freezing adds shows against iterated drags with the same steps, before it outgrows the method's own error.
  const bool is_frozen = c.drags == Drags::frozen;
  Motion iterated(file, c.scene, Drags::iterated);
  std::array<std::array<double, 2>, 2> errors;
  for (const int level : {0, 1}) {
    const int num_steps = level == 0 ? num_fine / 2 : num_fine;
    const auto end = motion.end(c.method, num_steps);
    const auto exact = is_frozen ? iterated.end(c.method, num_steps) : reference(file, c.scene, c.drags);
    for (const int part : {0, 1}) errors[level][part] = test::distance(end[part], exact[part]);
  }
  for (const int part : {0, 1}) {
    const double order = std::log2(errors[0][part] / errors[1][part]);
    EXPECT_NEAR(order, is_frozen ? 1.0 : c.method.order, 0.2)
        << (part == 0 ? "q" : "v") << ": errors " << errors[0][part] << ", " << errors[1][part];
    RecordProperty(part == 0 ? "order_q" : "order_v", std::to_string(order));
  }
}

}  // namespace
}  // namespace pliant::test_contact_order
