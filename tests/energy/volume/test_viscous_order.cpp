// Orders in time of a spinning, vibrating viscous body: every method with every law of viscosity in every form.
#include "energy/motion.hpp"
#include "material/viscosity_registry.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <map>
#include <ostream>

#include <gtest/gtest.h>

namespace pliant::test_viscous_order {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

/// Mechanisms that act side by side.
struct Damping {
  std::string name;
  std::vector<ViscosityVariant> laws;
  double decay_rate = 0.0;           ///< of mass-proportional damping [1/s]
  std::vector<Prony> branches = {};  ///< with the stress of the elastic law
};

struct OrderCase {
  Method method;
  Damping damping;
  BodySpec body;
};

std::string name_of(const OrderCase& c) {
  std::string name = test::name_of(c.body) + c.damping.name + "_" + c.method.name;
  std::erase(name, '-');
  return name;
}

std::ostream& operator<<(std::ostream& out, const OrderCase& c) {
  return out << name_of(c);
}

/// A cube of 1 m and 5 Pa: it vibrates at some rad/s, damped by some hundredths to some tenths of critical.
constexpr double density = 1.0, shear = 0.1, bulk = 0.07;
const Maxwell branch{3.0, 2.0, 0.1};

Damping kelvin_voigt(StrainRate rate) {
  const WithStrainRate law{KelvinVoigt{shear, bulk}, rate};
  return {test::name_of(law), {law}};
}

Damping maxwell() {
  return {"Maxwell", {branch}};
}

Damping prony() {
  return {"Prony", {}, 0.0, {{0.6, 0.1}, {0.4, 0.4}}};
}

Damping every_mechanism(StrainRate rate) {
  return {"EveryMechanism",
          {WithStrainRate{KelvinVoigt{0.5 * shear, 0.5 * bulk}, rate}, branch, Maxwell{0.5, 0.8, 0.4},
           WithStrainRate{StiffnessProportional{1e-4}, rate}},
          0.3};
}

std::vector<OrderCase> every_case() {
  std::vector<OrderCase> cases;
  const auto add = [&](const Method& method, const Damping& damping, int order) {
    cases.push_back({method, damping, {order, Shape::straight, 1}});
  };
  for (const Method& method : methods()) {
    for (const auto& form : strain_rates()) add(method, kelvin_voigt(form.rate), 1);
    add(method, maxwell(), 1);
    add(method, prony(), 1);
    add(method, every_mechanism(strain_rate_for(method)), 1);
    add(method, kelvin_voigt(strain_rate_for(method)), 2);
  }
  return cases;
}

double expected_order(const OrderCase& c) {
  const auto rate = c.damping.laws.empty() ? std::nullopt : test::rate_of(c.damping.laws[0]);
  if (!rate || rate == StrainRate::exact) return c.method.order;
  return rate == StrainRate::secant ? 1 : c.method.reconstructed_rate_order;
}

/// On one rank alone.
struct Motion {
  Motion(const std::string& file, const BodySpec& body, const Damping& damping)
      : solid(MPI_COMM_SELF, file, body.order, 2 * (body.order - 1)),
        elastic(solid.elastic(make_law("neo-hookean", 5.0, 0.3))),
        inertia(solid.inertia(density, Mass::consistent)),
        dampers(dampers_of(solid, damping)),
        potential(solid.layout(), solid.pattern(), all_terms(), solid.nothing_prescribed()) {}

  static std::vector<std::unique_ptr<EnergyTerm>> dampers_of(const Solid& solid, const Damping& damping) {
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    for (const auto& law : damping.laws) terms.push_back(solid.viscous(law));
    if (!damping.branches.empty()) terms.push_back(solid.prony(damping.branches, "neo-hookean", 5.0, 0.3));
    if (damping.decay_rate > 0.0) terms.push_back(solid.mass_damping(damping.decay_rate * density, Mass::consistent));
    return terms;
  }

  std::vector<const EnergyTerm*> all_terms() const {
    std::vector<const EnergyTerm*> terms{elastic.get(), inertia.get()};
    for (const auto& term : dampers) terms.push_back(term.get());
    return terms;
  }

  /// (q, v) at the end of `num_steps` steps.
  std::array<std::vector<double>, 2> end(const Method& method, int num_steps) {
    const auto q = solid.vector([](const Point& x) { return Point{0.08 * x[0], -0.03 * x[1], 0.05 * x[0] * x[2]}; });
    const auto v = solid.vector([](const Point& x) {
      const Point spin{-3.0 * (x[1] - 0.5) + 1.0 * x[2], 3.0 * (x[0] - 0.5), -1.0 * x[0]};
      return Point{spin[0] + 0.4 * x[0], spin[1] - 0.3 * x[1] * x[2], spin[2] + 0.5 * x[2]};
    });
    const Handle<Vec> z = potential.make_internal();
    return test::end_of_motion(potential, method, {0.0, q.get(), v.get(), z.get(), {}}, end_time, num_steps);
  }

  static constexpr double end_time = 0.5;
  Solid solid;
  std::unique_ptr<ElasticTerm> elastic;
  std::unique_ptr<Inertia> inertia;
  std::vector<std::unique_ptr<EnergyTerm>> dampers;
  IncrementalPotential potential;
};

constexpr int num_fine = 192;

class ViscousOrders : public ::testing::TestWithParam<OrderCase> {
 protected:
  /// The same for all forms of the rate: the exact one by dirk33, with steps so short that its error, of third order,
  /// is some hundredth of the least one measured.
  static const std::array<std::vector<double>, 2>& reference(const std::string& file, const OrderCase& c) {
    static std::map<std::string, std::array<std::vector<double>, 2>> known;
    Damping damping = c.damping;
    if (damping.laws.size() > 1) {
      damping = every_mechanism(StrainRate::exact);
    } else if (!damping.laws.empty() && test::rate_of(damping.laws[0])) {
      damping = kelvin_voigt(StrainRate::exact);
    }
    auto& result = known[test::name_of(c.body) + damping.name];
    if (result[0].empty()) result = Motion(file, c.body, damping).end(*find_method("dirk33"), 4 * num_fine);
    return result;
  }

  Scratch scratch_{MPI_COMM_SELF};
};

INSTANTIATE_TEST_SUITE_P(Registry, ViscousOrders, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

TEST_P(ViscousOrders, AreThoseOfTheTable) {
  const OrderCase& c = GetParam();
  if (num_ranks(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "the motion is that of one rank";
  const std::string file = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, c.body); });
  const auto& exact = reference(file, c);
  Motion motion(file, c.body, c.damping);
  std::array<std::array<double, 2>, 2> errors;
  for (const int level : {0, 1}) {
    const auto end = motion.end(c.method, level == 0 ? num_fine / 2 : num_fine);
    for (const int part : {0, 1}) errors[level][part] = test::distance(end[part], exact[part]);
  }
  for (const int part : {0, 1}) {
    const double order = std::log2(errors[0][part] / errors[1][part]);
    EXPECT_NEAR(order, expected_order(c), 0.15)
        << (part == 0 ? "q" : "v") << ": errors " << errors[0][part] << ", " << errors[1][part];
    RecordProperty(part == 0 ? "order_q" : "order_v", std::to_string(order));
  }
}

}  // namespace
}  // namespace pliant::test_viscous_order
