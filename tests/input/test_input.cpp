// What a good input becomes, and that it is the same after writing and reading.
#include "base/error.hpp"
#include "input/analysis.hpp"
#include "input/input.hpp"
#include "input/keys.hpp"
#include "input/loads.hpp"
#include "input/parse.hpp"
#include "material/elastic_law.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "places.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_input {
namespace {

namespace fs = std::filesystem;

const std::string smallest = R"yaml(
mesh: {file: beam.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
time: {step: 10 ms, end: 1}
)yaml";

const std::string everything = R"yaml(title: "cantilever: under \"gravity\""
mesh:
  file: ../meshes/cantilever.geo
  size: 20 mm
  scale: 1e-3
  refine: 2
element: P2
mass: lumped
bodies:
  - volume: beam
    density: 1.2 g/cm^3
    elasticity: &soft {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 40 %}
    viscosity: {model: kelvin-voigt, shear: 20 Pa*s, bulk: 1 mPa*s, rate: exact}
  - volume: 7
    density: 900
    elasticity:
      <<: *soft
      model: linear
    viscosity:
      - {model: maxwell, shear_modulus: 1 kPa, bulk_modulus: 2 kPa, relaxation_time: 5 ms}
      - {model: maxwell, shear_ratio: 30 %, bulk_ratio: 0.1, relaxation_time: 1 min}
      - {model: stiffness-proportional, time: 1 us, rate: secant}
      - {model: mass-proportional, decay_rate: 2 Hz}
constraints:
  - {surface: clamp, displacement: [0, free, "0.1*t"]}
  - {volume: 3, displacement: [0, 0, 0]}
  - {curve: edge, displacement: [1 mm, 0, 0]}
  - {point: "corner one", displacement: [0, 0, 0]}
  - {box: [[0, 0, 0], [1 mm, 1, 1]], displacement: [0, 0, 0]}
  - {where: "x < 1e-9 && y > 0", displacement: [0, 0, 0]}
  - {surface: half, symmetry: plane}
  - {surface: lid, normal_displacement: "-0.1*t"}
  - {curve: rail, displacement_along: 1 mm, direction: [1, 1, 0]}
  - {surface: right, periodic_with: left, difference: [0.1, free, "t"]}
  - {surface: grip, rigid: {translation: [0, free, "0.01*t"], rotation: {axis: [0, 0, 2], angle: 90 degree}, center: [1, 0, 0]}}
  - {box: [[0, 0, 0], [1, 1, 1]], rigid: {translation: [1 mm, 0, 0], rotation: fixed}}
  - {equation: [{point: a, component: x}, {surface: b, component: z, coefficient: -0.5}], value: "t^2"}
  - {equation: [{volume: a, component: x}, {curve: b, component: y}, {box: [[0, 0, 0], [1, 1, 1]], component: z}, {where: "x > 1", component: z}]}
  - {surface: foot, tied_to: floor, tolerance: 2 mm}
loads:
  - {gravity: [0, 0, -9.81 m/s^2]}
  - {gravity: ["sin(t)", 0, 0], volume: beam}
  - {surface: tip, traction: [0, 2 kPa, "-100*sin(2*pi*t)"]}
  - {box: [[0, 0, 0], [1, 1, 1]], traction: [0, 0, 1/3]}
  - {where: "x > 1 - 1e-9", traction: [0, 0, 1]}
  - {surface: inside, pressure: 2 kPa}
  - {where: "z > 1 - 1e-9", pressure: "1e3*t*x"}
  - {force_density: [0, "x*t", 5 N/m^3], volume: beam}
  - {curve: edge, line_force: [0, 0, 2 N/mm]}
  - {point: "corner one", force: [3 N, 0, 0]}
  - {surface: tip, force: [0, "4*t", 0]}
  - {surface: tip, spring: 2 kPa/mm, dashpot: 5, direction: normal}
  - {point: 9, point_spring: 3 N/mm, point_dashpot: 2 N*s/m}
initial: {displacement: ["0.01*x", 0, 0], velocity: [0, "-y", 3 km/h]}
time: {method: bdf2, step: 10 ms, end: 2 s, startup: ramp, min_step: 1 us}
solver: {linear: cholesky, newton: {relative: 1e-6, absolute: 1 mN, max_iterations: 20}}
output: {directory: out/here, every: 20 ms, fields: [velocity, von_mises_stress]}
checkpoint: {every: 100, minutes: 10}
probes: [{name: tip, point: [1, 0.1, 100 mm]}, {name: "the root", point: [0, 0, 0]}]
cavities:
  - {name: left, surface: inside, pressure: "2e3*t"}
  - {name: middle, box: [[0, 0, 0], [1, 1, 1]], volume: 3 cm^3, gas: {pressure: 5 kPa, ambient: 1 bar, exponent: 1.4, amount: "1 + t"}}
  - {name: right, where: "x > 1", liquid: {bulk_modulus: 2 GPa, pressure: 1 kPa, added_volume: "1e-6*t", flow: 2 cm^3/s}}
contact:
  surface: sole
  law: penalty
  stiffness: 2 MPa/mm
  width: 0.1 mm
  threshold: 1 um
  friction_update: iterated
  stick_velocity: 2 mm/s
  obstacles:
    - {name: floor, shape: plane, point: [0, 0, -1], normal: [0, 0, 2], friction: 50 %, normal_damping: 0.1 s/m}
    - {name: rod, shape: cylinder, point: [0, 0, 1], axis: [0, 1, 0], radius: 20 mm, length: 2, motion: {translate: [0, 0, "0.1*t"], rotate: {axis: [0, 1, 0], angle: "2*pi*t", center: [0, 0, 1]}}}
    - {name: ball, shape: sphere, point: [0, 0, 3], radius: 1 cm, side: inside, viscous_friction: 0.2 s/m}
    - {name: crate, shape: box, point: [5, 0, 0], size: [1, 2, 3 cm]}
    - {name: part, shape: surface, file: part.stl, scale: 1e-3}
)yaml";

/// What stands for `time` in `everything` otherwise; together they give every key of the table.
const std::vector<std::string> other_times{
    "{method: bdf3, end: 2 s, adaptive: {}}",
    "{method: dirk22, step: 1 ms, end: 2 s, events: [0.5, 800 ms], adaptive: {relative: 1e-3, absolute: 1 um, "
    "absolute_velocity: 1 cm/s, min_step: 2 us, max_step: 50 ms}}",
    "{method: {petsc: arkimex}, step: 1 ms, end: 2 s}",
    "{method: \"petsc:bdf\", step: 1 ms, end: 2 s}",
    "{method: {name: bdf2 of mine, alpha: [4/3, -1/3], beta: 2/3, A: [[1]], b: [1]}, startup: dirk33, step: 1 ms, end: "
    "1 s}",
    "{method: {A: [[1 - sqrt(2)/2, 0], [sqrt(2)/2, 1 - sqrt(2)/2]], b: [sqrt(2)/2, 1 - sqrt(2)/2]}, step: 1 ms, end: "
    "2 s}"};

Config read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_input(text, "input/a.yaml", overrides);
}

/// A constant of the body's elastic law.
double constant(const BodyConfig& body, std::string_view key) {
  for (const auto& c : body.elasticity->constants) {
    if (c.key == key) return c.value(0, 0, 0, 0);
  }
  ADD_FAILURE() << "no constant " << key;
  return 0.0;
}

TEST(Input, DefaultsAreThoseOfTheTable) {
  const Config c = read(smallest);
  EXPECT_EQ(c.file, "input/a.yaml");
  EXPECT_EQ(c.title, "");
  EXPECT_EQ(c.mesh.file.value, "input/beam.msh") << "relative to the input file";
  EXPECT_EQ(c.mesh.file.where.line, 2);
  EXPECT_EQ(c.mesh.file.where.column, 14);
  EXPECT_FALSE(c.mesh.size);
  EXPECT_EQ(c.mesh.scale, 1);
  EXPECT_EQ(c.mesh.refine, 0);
  EXPECT_EQ(c.element, ElementOrder::p1);
  EXPECT_EQ(c.mass, MassKind::consistent);
  ASSERT_EQ(c.bodies.size(), 1u);
  EXPECT_EQ(c.bodies[0].part.kind, Selection::Kind::everything);
  EXPECT_EQ(c.bodies[0].part.where.line, 3);
  EXPECT_TRUE(c.bodies[0].viscosity.empty());
  EXPECT_TRUE(c.constraints.empty());
  EXPECT_TRUE(c.loads.empty());
  EXPECT_TRUE(c.initial.velocity[2].is_zero());
  EXPECT_EQ(method_name(c.time.method), "backward-euler");
  EXPECT_EQ(c.time.step, 0.01);
  EXPECT_EQ(c.time.min_step, 0.01 / 1024);
  EXPECT_EQ(c.time.load_steps, 1);
  EXPECT_EQ(c.time.startup, Startup::ramp);
  EXPECT_EQ(c.solver.linear, LinearSolver::automatic);
  EXPECT_EQ(c.solver.newton.relative, 1e-8);
  EXPECT_EQ(c.solver.newton.absolute, 0);
  EXPECT_EQ(c.solver.newton.max_iterations, 50);
  EXPECT_EQ(c.output.directory, "out/a");
  EXPECT_FALSE(c.output.every);
  EXPECT_EQ(c.output.fields, (std::vector<std::string>{"displacement", "velocity", "cauchy_stress"}));
  EXPECT_TRUE(c.probes.empty());
}

TEST(Input, EveryValueArrivesInSI) {
  const Config c = read(everything);
  EXPECT_EQ(c.title, "cantilever: under \"gravity\"");
  EXPECT_EQ(c.mesh.file.value, "input/../meshes/cantilever.geo");
  EXPECT_EQ(c.mesh.size, 0.02);
  EXPECT_EQ(c.mesh.scale, 1e-3);
  EXPECT_EQ(c.mesh.refine, 2);
  EXPECT_EQ(c.element, ElementOrder::p2);
  EXPECT_EQ(c.mass, MassKind::lumped);
  ASSERT_EQ(c.bodies.size(), 2u);
  EXPECT_EQ(c.bodies[0].part.name, "beam");
  EXPECT_EQ(c.bodies[0].density, 1200);
  EXPECT_EQ(constant(c.bodies[0], "youngs_modulus"), 1e6);
  EXPECT_EQ(constant(c.bodies[0], "poissons_ratio"), 0.4);
  EXPECT_EQ(c.bodies[1].part.name, "7");
  EXPECT_EQ(c.bodies[1].elasticity->model, "linear");
  EXPECT_EQ(constant(c.bodies[1], "youngs_modulus"), 1e6) << "merged from the anchor";
  ASSERT_EQ(c.bodies[0].viscosity.size(), 1u);
  ASSERT_EQ(c.bodies[1].viscosity.size(), 4u);
  const ViscosityConfig &damped = c.bodies[0].viscosity[0], &rayleigh = c.bodies[1].viscosity[2];
  const auto& kelvin_voigt = std::get<KelvinVoigt>(damped.law);
  const auto& maxwell = std::get<Maxwell>(c.bodies[1].viscosity[0].law);
  const auto& share = std::get<MaxwellRatios>(c.bodies[1].viscosity[1].law);
  EXPECT_EQ(kelvin_voigt.shear, 20);
  EXPECT_EQ(kelvin_voigt.bulk, 1e-3);
  EXPECT_EQ(damped.rate, StrainRate::exact);
  EXPECT_EQ(damped.where.line, 13);
  EXPECT_EQ(maxwell.shear_modulus, 1000);
  EXPECT_EQ(maxwell.bulk_modulus, 2000);
  EXPECT_EQ(maxwell.relaxation_time, 5e-3);
  EXPECT_EQ(maxwell.moduli, Moduli::absolute);
  EXPECT_EQ(share.shear_ratio, 0.3);
  EXPECT_EQ(share.bulk_ratio, 0.1);
  EXPECT_EQ(share.relaxation_time, 60);
  EXPECT_EQ(std::get<StiffnessProportional>(rayleigh.law).time, 1e-6);
  EXPECT_EQ(rayleigh.rate, StrainRate::secant);
  EXPECT_EQ(std::get<MassProportional>(c.bodies[1].viscosity[3].law).decay_rate, 2);
  EXPECT_EQ(c.bodies[1].viscosity[3].where.line, c.bodies[1].viscosity[0].where.line + 3);
  ASSERT_EQ(c.constraints.size(), 15u);
  const auto given = [&](std::size_t i) {
    return std::get<ConstraintConfig::Displacement>(c.constraints.at(i).kind).value;
  };
  EXPECT_FALSE(given(0)[1]) << "free";
  EXPECT_EQ((*given(0)[2])(0, 0, 0, 2), 0.2);
  EXPECT_EQ((*given(2)[0])(0, 0, 0, 0), 1e-3);
  EXPECT_EQ(c.constraints[3].part.name, "corner one");
  EXPECT_EQ(c.constraints[4].part.box, (std::array<double, 6>{0, 0, 0, 1e-3, 1, 1}));
  EXPECT_EQ((*c.constraints[5].part.region)(0, 1, 0, 0), 1);
  EXPECT_EQ((*c.constraints[5].part.region)(1, 1, 0, 0), 0);
  EXPECT_TRUE(std::holds_alternative<ConstraintConfig::Displacement>(c.constraints[5].kind));
  EXPECT_TRUE(std::holds_alternative<ConstraintConfig::Symmetry>(c.constraints[6].kind));
  EXPECT_EQ(std::get<ConstraintConfig::Normal>(c.constraints[7].kind).displacement(0, 0, 0, 2), -0.2);
  const auto& along = std::get<ConstraintConfig::Along>(c.constraints[8].kind);
  EXPECT_EQ(along.displacement(0, 0, 0, 0), 1e-3);
  EXPECT_EQ(along.direction, (std::array<double, 3>{1, 1, 0}));
  const auto& periodic = std::get<ConstraintConfig::Periodic>(c.constraints[9].kind);
  EXPECT_EQ(periodic.partner.name, "left");
  EXPECT_FALSE(periodic.difference[1]);
  EXPECT_EQ((*periodic.difference[2])(0, 0, 0, 3), 3);
  const auto& tied = std::get<ConstraintConfig::Tied>(c.constraints.back().kind);
  EXPECT_EQ(tied.partner.name, "floor");
  EXPECT_EQ(tied.tolerance, 2e-3);
  const auto& grip = std::get<ConstraintConfig::Rigid>(c.constraints[10].kind);
  EXPECT_FALSE(grip.translation[1]);
  const auto& turn = std::get<RotationConfig::AboutAxis>(grip.rotation.kind);
  EXPECT_EQ(turn.axis, (std::array<double, 3>{0, 0, 2}));
  EXPECT_NEAR((*turn.angle)(0, 0, 0, 0), 1.5707963267948966, 1e-15);
  EXPECT_EQ(grip.center, (std::array<double, 3>{1, 0, 0}));
  const auto& other = std::get<ConstraintConfig::Rigid>(c.constraints[11].kind);
  EXPECT_TRUE(std::holds_alternative<RotationConfig::Fixed>(other.rotation.kind));
  EXPECT_FALSE(other.center);
  const auto& equation = std::get<ConstraintConfig::Equation>(c.constraints[12].kind);
  ASSERT_EQ(equation.terms.size(), 2u);
  EXPECT_EQ(equation.terms[0].coefficient, 1);
  EXPECT_EQ(equation.terms[1].component, 2);
  EXPECT_EQ(equation.terms[1].coefficient, -0.5);
  EXPECT_EQ(equation.value(0, 0, 0, 3), 9);
  using L = LoadConfig;
  ASSERT_EQ(c.loads.size(), 13u);
  EXPECT_EQ(c.loads[0].part.kind, Selection::Kind::everything);
  EXPECT_EQ(std::get<L::Gravity>(c.loads[0].kind).acceleration[2](0, 0, 0, 0), -9.81);
  EXPECT_EQ(c.loads[1].part.kind, Selection::Kind::volume);
  const VectorExpression& traction = std::get<L::Traction>(c.loads[2].kind).value;
  EXPECT_EQ(traction[1](0, 0, 0, 0), 2000);
  EXPECT_TRUE(traction[2].depends_on_time());
  EXPECT_EQ(c.loads[2].where.line, 43);
  EXPECT_EQ(c.loads[3].part.kind, Selection::Kind::box);
  EXPECT_EQ(std::get<L::Traction>(c.loads[3].kind).value[2](0, 0, 0, 0), 1.0 / 3.0);
  EXPECT_EQ(c.loads[5].part.name, "inside");
  EXPECT_EQ(std::get<L::Pressure>(c.loads[5].kind).value(0, 0, 0, 0), 2000);
  EXPECT_EQ(std::get<L::Pressure>(c.loads[6].kind).value(2, 0, 0, 3), 6000);
  EXPECT_EQ(std::get<L::ForceDensity>(c.loads[7].kind).value[1](2, 0, 0, 3), 6);
  EXPECT_EQ(c.loads[8].part.kind, Selection::Kind::curve);
  EXPECT_DOUBLE_EQ(std::get<L::LineForce>(c.loads[8].kind).value[2](0, 0, 0, 0), 2000);
  EXPECT_TRUE(std::holds_alternative<L::Force>(c.loads[9].kind));
  EXPECT_EQ(c.loads[9].part.kind, Selection::Kind::point);
  EXPECT_EQ(c.loads[10].part.kind, Selection::Kind::surface);
  const auto& foundation = std::get<L::Foundation>(c.loads[11].kind);
  EXPECT_DOUBLE_EQ(foundation.spring.value(), 2e6);
  EXPECT_EQ(foundation.dashpot, 5.0);
  EXPECT_EQ(foundation.direction, FoundationDirection::normal);
  EXPECT_DOUBLE_EQ(std::get<L::PointFoundation>(c.loads[12].kind).spring.value(), 3000);
  ASSERT_EQ(c.cavities.size(), 3u);
  EXPECT_EQ(c.cavities[0].part.name, "inside");
  EXPECT_EQ(std::get<CavityConfig::GivenPressure>(c.cavities[0].content).value(0, 0, 0, 2), 4000);
  EXPECT_DOUBLE_EQ(c.cavities[1].volume.value(), 3e-6);
  const auto& gas = std::get<CavityConfig::Gas>(c.cavities[1].content);
  EXPECT_EQ(gas.ambient, 1e5);
  EXPECT_EQ(gas.exponent, 1.4);
  EXPECT_EQ(gas.amount(0, 0, 0, 2), 3);
  const auto& liquid = std::get<CavityConfig::Liquid>(c.cavities[2].content);
  EXPECT_EQ(liquid.bulk_modulus, 2e9);
  EXPECT_EQ(liquid.added_volume(0, 0, 0, 2), 2e-6);
  EXPECT_DOUBLE_EQ(liquid.flow(0, 0, 0, 2), 2e-6);
  EXPECT_EQ(c.initial.velocity[1](0, 2, 0, 0), -2);
  EXPECT_DOUBLE_EQ(c.initial.velocity[2](0, 0, 0, 0), 3 / 3.6);
  EXPECT_EQ(method_name(c.time.method), "bdf2");
  EXPECT_EQ(c.time.method.where.line, 55);
  EXPECT_EQ(c.time.min_step, 1e-6);
  EXPECT_EQ(c.solver.linear, LinearSolver::cholesky);
  EXPECT_EQ(c.solver.newton.absolute, 1e-3);
  EXPECT_EQ(c.output.directory, "out/here");
  EXPECT_EQ(c.output.every, 0.02);
  EXPECT_EQ(c.probes[0].point[2], 0.1);
  EXPECT_EQ(c.probes[1].name, "the root");
}

/// Every path of keys that a tree gives.
void collect_paths(const InputNode& node, const std::string& path, std::vector<std::string>& paths) {
  for (const InputNode& child : node.children) {
    const std::string own = child.key.empty() ? path : path.empty() ? child.key : path + "." + child.key;
    paths.push_back(own);
    collect_paths(child, own, paths);
  }
}

void collect_paths(const std::vector<KeyInfo>& keys, const std::string& path, std::vector<std::string>& paths) {
  for (const KeyInfo& key : keys) {
    const std::string own = path.empty() ? key.key : path + "." + key.key;
    paths.push_back(own);
    collect_paths(key.children, own, paths);
  }
}

TEST(Dump, SpellsOutEveryKeyOfTheTable) {
  std::vector<std::string> expected, written;
  collect_paths(input_keys(), "", expected);
  Diagnostics none;
  collect_paths(parse_yaml(dump(read(everything)), "dump", none), "", written);
  for (const std::string part : {"box: [[0, 0, 0], [1, 1, 1]]", "where: \"z < 0.1\""}) {
    const std::string contact = "{" + part + ", obstacles: [{name: ball, shape: sphere, radius: 1}]}";
    collect_paths(parse_yaml(dump(read(smallest, {{"contact", contact}})), "dump", none), "", written);
  }
  const std::string between =
      "{law: barrier, friction: 0.1, viscous_friction: 1, normal_damping: 2, pairs: [{name: grip, surface: a, with: b, "
      "law: penalty, stiffness: 1, width: 1, thickness: 1, friction: 0.5, viscous_friction: 0, normal_damping: 0}], "
      "exclude: [[c, "
      "d]]}";
  collect_paths(parse_yaml(dump(read(smallest, {{"contact", between}})), "dump", none), "", written);
  for (const std::string& time : other_times) {
    collect_paths(parse_yaml(dump(read(everything, {{"time", time}})), "dump", none), "", written);
  }
  collect_paths(parse_yaml(dump(read(everything, {{"bodies",
                                                   "[{density: 1, elasticity: {model: neo-hookean, youngs_modulus: 1, "
                                                   "poissons_ratio: 0}, viscosity: {model: prony, ratio: 0.3, "
                                                   "relaxation_time: 1}}]"}})),
                           "dump", none),
                "", written);
  const std::vector<Override> mechanism{
      {"rigid_bodies",
       "[{name: r, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0], velocity: [1, 0, 0], angular_velocity: "
       "[0, 0, 1], surface: {file: r.stl, scale: 1, size: 1}, attached: [a], coupled: [b], coupling_stiffness: 1}]"},
      {"bodies", "[{volume: v, density: 1, rigid: true, attached: [a], coupled: [b], coupling_stiffness: 1}]"},
      {"loads", "[{torque: [t, 0, 0], volume: r}]"},
      {"joints",
       "[{name: j, type: hinge, between: [ground, r], point: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 1, "
       "rest: 1}, damping: 1, motor: {target: t, stiffness: 1, damping: 1, limit: 1, effort: t}, limits: [-1, 1], "
       "limit_stiffness: 1, friction: 1, stick_rate: 1}, {name: k, type: "
       "universal, between: [ground, r], point: [0, 0, 0], axis: [0, 0, 1], second_axis: [1, 0, 0]}, {name: l, "
       "type: distance, between: [ground, r], point: [0, 0, 0], second_point: [1, 0, 0], motion: t}]"},
      {"tendons",
       "[{name: s, points: [[0, 0, 0], {body: r, point: [1, 0, 0]}], tension: t}, {name: u, curve: c, pulled_at: "
       "[0, 0, 0], pull: t, stiffness: 1, friction: 0.1, stick_velocity: 1}]"},
      {"springs",
       "[{name: d, points: [[0, 0, 0], {body: r, point: [1, 0, 0]}], stiffness: 1, rest: 1, damping: 1, "
       "tension_only: false}]"}};
  collect_paths(parse_yaml(dump(read(everything, mechanism)), "dump", none), "", written);
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    const ElasticLawSpec law = typical_law(row);
    std::string body = "[{density: 1, elasticity: {model: " + std::string(law.info().name);
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      body += fmt::format(", {}: {}", law.info().parameters[p].name, law.parameters[p]);
    }
    for (std::size_t d = 0; d < law.info().directions.size(); ++d) {
      body += fmt::format(", {}: [x, {}, 0]", law.info().directions[d], d);
    }
    collect_paths(parse_yaml(dump(read(everything, {{"bodies", body + "}}]"}})), "dump", none), "", written);
  }
  for (const char* active : {"{stress: 20 kPa, fibre: {cell_data: f}}", "{shortening: 0.1*t, fibre: [1, y, 0]}"}) {
    const std::string body =
        "[{density: 1, elasticity: {model: linear, youngs_modulus: {cell_data: \"the E\"}, "
        "poissons_ratio: 0}, active: ";
    collect_paths(parse_yaml(dump(read(everything, {{"bodies", body + active + "}]"}})), "dump", none), "", written);
  }
  for (const auto& path : expected) {
    EXPECT_NE(std::find(written.begin(), written.end(), path), written.end()) << path << " is not written";
  }
}

TEST(Input, DirectionsAndDataOfTheMesh) {
  const Config c = read(everything, {{"bodies",
                                      "[{density: 1, elasticity: {model: holzapfel-gasser-ogden, "
                                      "shear_modulus: {cell_data: \"mu of it\"}, bulk_modulus: 1 MPa, k1: 1, "
                                      "k2: 1, fibre: {cell_data: f}, fibre2: [y, 2, -x]}}]"}});
  const ElasticityConfig& e = *c.bodies[0].elasticity;
  ASSERT_EQ(e.constants.size(), 4u);
  EXPECT_EQ(e.constants[0].cell_data, "mu of it");
  EXPECT_TRUE(e.constants[1].cell_data.empty());
  ASSERT_EQ(e.directions.size(), 2u);
  EXPECT_EQ(e.directions[0].key, "fibre");
  EXPECT_EQ(e.directions[0].cell_data, "f");
  EXPECT_EQ(e.directions[1].key, "fibre2");
  EXPECT_TRUE(e.directions[1].cell_data.empty());
  EXPECT_EQ(e.directions[1].value[2](3, 0, 0, 0), -3);
}

class RoundTrip : public testing::TestWithParam<std::string> {};

TEST_P(RoundTrip, KeepsTheConfiguration) {
  const Config original = read(GetParam());
  const std::string text = dump(original);
  const Config again = read_input(text, "quite/elsewhere/run.yaml", {});
  EXPECT_EQ(dump(again), text);
  EXPECT_EQ(again.output.directory, original.output.directory);
  EXPECT_TRUE(fs::path(again.mesh.file.value).is_absolute());
  ASSERT_EQ(again.constraints.size(), original.constraints.size());
  for (std::size_t i = 0; i < again.constraints.size(); ++i) {
    EXPECT_EQ(again.constraints[i].part.kind, original.constraints[i].part.kind);
    EXPECT_EQ(again.constraints[i].part.name, original.constraints[i].part.name);
    EXPECT_EQ(again.constraints[i].part.box, original.constraints[i].part.box);
    ASSERT_EQ(again.constraints[i].kind.index(), original.constraints[i].kind.index());
    const auto* a = std::get_if<ConstraintConfig::Displacement>(&again.constraints[i].kind);
    const auto* b = std::get_if<ConstraintConfig::Displacement>(&original.constraints[i].kind);
    for (std::size_t k = 0; a != nullptr && k < 3; ++k) {
      ASSERT_EQ(a->value[k].has_value(), b->value[k].has_value());
      if (a->value[k]) {
        EXPECT_EQ((*a->value[k])(0.1, 0.2, 0.3, 0.4), (*b->value[k])(0.1, 0.2, 0.3, 0.4));
      }
    }
  }
  ASSERT_EQ(again.loads.size(), original.loads.size());
  for (std::size_t i = 0; i < again.loads.size(); ++i) {
    const LoadConfig &a = again.loads[i], &b = original.loads[i];
    ASSERT_EQ(a.kind.index(), b.kind.index());
    EXPECT_EQ(a.part.kind, b.part.kind);
    if (const VectorExpression* value = vector_of(a)) {
      EXPECT_EQ((*value)[2](0.1, 0.2, 0.3, 0.4), (*vector_of(b))[2](0.1, 0.2, 0.3, 0.4));
    }
    if (const auto* pressure = std::get_if<LoadConfig::Pressure>(&a.kind)) {
      EXPECT_EQ(pressure->value(0.1, 0.2, 0.3, 0.4), std::get<LoadConfig::Pressure>(b.kind).value(0.1, 0.2, 0.3, 0.4));
    }
    if (const auto foundation = foundation_of(a)) {
      EXPECT_EQ(foundation->spring, foundation_of(b)->spring);
      EXPECT_EQ(foundation->dashpot, foundation_of(b)->dashpot);
    }
    if (const auto* foundation = std::get_if<LoadConfig::Foundation>(&a.kind)) {
      EXPECT_EQ(foundation->direction, std::get<LoadConfig::Foundation>(b.kind).direction);
    }
  }
  EXPECT_EQ(again.time.step, original.time.step);
  EXPECT_EQ(again.time.min_step, original.time.min_step);
}

INSTANTIATE_TEST_SUITE_P(Inputs, RoundTrip,
                         testing::Values(smallest, everything,
                                         smallest + "title: \"line\\none\\ttab \\\\ caf\u00e9\"\n",
                                         smallest + "constraints: [{surface: \"null\", displacement: [0, 0, 0]}]\n",
                                         smallest + "constraints: [{surface: \"~\", displacement: [0, 0, 0]}]\n",
                                         smallest +
                                             "constraints: [{surface: \"a: b # c\", displacement: [0, 0, 1e-17]}]\n",
                                         R"yaml(
mesh: {file: /absolute/beam.msh}
bodies: [{elasticity: {model: linear, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: 1, displacement: [0, 0, 0]}]
time: {method: static, load_steps: 4}
)yaml"));

TEST(Input, TimesOfAllKindsKeepThroughWritingAndReading) {
  for (const std::string& time : other_times) {
    const Config original = read(everything, {{"time", time}});
    const Config again = read_input(dump(original), "run.yaml", {});
    EXPECT_EQ(dump(again), dump(original)) << time;
    EXPECT_EQ(method_name(again.time.method), method_name(original.time.method));
    EXPECT_EQ(again.time.step, original.time.step);
    EXPECT_EQ(again.time.min_step, original.time.min_step);
    EXPECT_EQ(again.time.startup, original.time.startup);
    EXPECT_EQ(again.time.events, original.time.events);
    ASSERT_EQ(again.time.adaptive.has_value(), original.time.adaptive.has_value());
    if (again.time.adaptive) {
      const AdaptiveConfig &a = *again.time.adaptive, &b = *original.time.adaptive;
      EXPECT_EQ(std::tie(a.relative, a.absolute, a.absolute_velocity, a.min_step, a.max_step),
                std::tie(b.relative, b.absolute, b.absolute_velocity, b.min_step, b.max_step));
    }
    ASSERT_EQ(again.time.method.kind.index(), original.time.method.kind.index());
    if (method_of(again.time) != nullptr) {
      const Method &a = *method_of(again.time), &b = *method_of(original.time);
      EXPECT_EQ(std::tie(a.alpha, a.beta, a.A, a.b), std::tie(b.alpha, b.beta, b.A, b.b)) << "to the last bit";
    }
  }
}

TEST(Input, ViscosityHasDefaults) {
  const auto viscosity = [](const std::string& text) {
    const Config c = read(smallest, {{"bodies.0.viscosity", text}});
    EXPECT_EQ(dump(read_input(dump(c), "run.yaml", {})), dump(c));
    return c.bodies[0].viscosity.at(0);
  };
  const ViscosityConfig kelvin_voigt = viscosity("{model: kelvin-voigt, shear: 1}");
  EXPECT_EQ(std::get<KelvinVoigt>(kelvin_voigt.law).bulk, 0);
  EXPECT_FALSE(kelvin_voigt.rate) << "auto";
  EXPECT_EQ(std::get<Maxwell>(viscosity("{model: maxwell, shear_modulus: 1, relaxation_time: 2}").law).bulk_modulus, 0);
  EXPECT_EQ(std::get<MaxwellRatios>(viscosity("[{model: maxwell, shear_ratio: 1, relaxation_time: 2}]").law).bulk_ratio,
            0);
  EXPECT_FALSE(viscosity("{model: stiffness-proportional, time: 1}").rate) << "auto";
}

// A law that the registry has is read, written and refused without a line of its own in the input.
TEST(Input, EveryFormOfViscosityIsTakenWithItsParametersAndRefusedWithoutThem) {
  for (const ViscosityForm& form : viscosity_forms()) {
    const std::string name(name_of(form.blank));
    const auto text = [&](std::size_t left_out) {
      std::string keys = "{model: " + name;
      for (std::size_t k = 0; k < form.parameters.size(); ++k) {
        if (k != left_out) keys += ", " + std::string(form.parameters[k].name) + ": " + std::to_string(k + 2);
      }
      return keys + "}";
    };
    const std::size_t none = form.parameters.size();
    const Config c = read(smallest, {{"bodies.0.viscosity", text(none)}});
    ViscosityLaw law = c.bodies[0].viscosity.at(0).law;
    ASSERT_EQ(law.index(), form.blank.index()) << text(none);
    for (std::size_t k = 0; k < form.parameters.size(); ++k) {
      EXPECT_EQ(form.members[k](law), static_cast<double>(k + 2)) << form.parameters[k].name;
      const std::vector<Override> without{{"bodies.0.viscosity", text(k)}};
      if (form.parameters[k].fallback) {
        EXPECT_NO_THROW(read(smallest, without)) << text(k);
      } else {
        EXPECT_THROW(read(smallest, without), InputError) << text(k);
      }
    }
    EXPECT_EQ(dump(read_input(dump(c), "run.yaml", {})), dump(c));
    const std::vector<Override> with_rate{{"bodies.0.viscosity", text(none)}, {"bodies.0.viscosity.rate", "secant"}};
    if (has_strain_rate(form.blank)) {
      EXPECT_EQ(read(smallest, with_rate).bodies[0].viscosity.at(0).rate, StrainRate::secant);
    } else {
      EXPECT_THROW(read(smallest, with_rate), InputError) << name;
    }
  }
}

TEST(Input, EveryMethodOfTheTableIsTaken) {
  for (const Method& method : methods()) {
    const Config c = read(smallest, {{"time.method", method.name}});
    EXPECT_EQ(method_name(c.time.method), method.name);
    ASSERT_NE(method_of(c.time), nullptr);
    EXPECT_EQ(method_of(c.time)->A, method.A);
    EXPECT_EQ(c.time.startup, Startup::ramp);
    EXPECT_FALSE(c.time.adaptive);
    EXPECT_TRUE(c.time.events.empty());
  }
}

TEST(Input, OwnCoefficientsBecomeAMethod) {
  const Config c = read(smallest, {{"time.method", "{A: [[1/2]], b: [1]}"}});
  EXPECT_EQ(method_name(c.time.method), "own");
  const Method* own = method_of(c.time);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->alpha, std::vector<double>{1.0});
  EXPECT_EQ(own->order, 2);
  EXPECT_TRUE(own->symplectic);
}

TEST(Input, IntegratorsOfPetscHaveTwoSpellings) {
  for (const std::string method : {"petsc:alpha2", "{petsc: alpha2}"}) {
    const Config c = read(smallest, {{"time.method", method}});
    EXPECT_EQ(method_name(c.time.method), "petsc:alpha2");
    EXPECT_EQ(method_of(c.time), nullptr);
  }
  EXPECT_EQ(method_name(read(everything, {{"time", "{method: petsc:bdf, step: 1, end: 1}"}}).time.method), "petsc:bdf")
      << "without quotes, too";
}

TEST(Input, AdaptiveStepsHaveDefaults) {
  const auto adaptive = [](const std::string& time) { return read(smallest, {{"time", time}}).time; };
  const TimeConfig plain = adaptive("{end: 2, adaptive: {}}");
  EXPECT_EQ(plain.step, 2e-3) << "the first one";
  EXPECT_EQ(plain.adaptive->relative, 1e-4);
  EXPECT_EQ(plain.adaptive->absolute, 1e-6);
  EXPECT_EQ(plain.adaptive->absolute_velocity, 1e-6 / 2e-3);
  EXPECT_EQ(plain.adaptive->min_step, 2e-3 / (1 << 20));
  EXPECT_EQ(plain.adaptive->max_step, 0.2);
  EXPECT_EQ(plain.min_step, plain.adaptive->min_step);
  EXPECT_EQ(plain.startup, Startup::ramp) << "one past state needs no other";
  EXPECT_EQ(adaptive("{method: bdf2, end: 2, adaptive: {}}").startup, Startup::dirk33);
  EXPECT_EQ(adaptive("{method: bdf2, end: 2, startup: ramp, adaptive: {}}").startup, Startup::ramp);

  const TimeConfig given = adaptive("{step: 0.5, end: 2, adaptive: {min_step: 1 us}}");
  EXPECT_EQ(given.adaptive->max_step, 0.5) << "not below the first step";
  EXPECT_EQ(given.adaptive->absolute_velocity, 2e-6);
  EXPECT_EQ(given.min_step, 1e-6);
  EXPECT_EQ(adaptive("{end: 2, adaptive: {max_step: 1 us}}").step, 1e-6) << "the first step keeps to the bounds";
  EXPECT_EQ(adaptive("{end: 2, adaptive: {min_step: 1 s, max_step: 1.5 s}}").step, 1);
  EXPECT_FALSE(adaptive("{step: 0.5, end: 2, adaptive: }").adaptive) << "a value left empty is the default";
}

TEST(Input, StaticNeedsNoStep) {
  const Config c = read(R"yaml(
mesh: {file: b.msh}
bodies: [{elasticity: {model: linear, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: 1, displacement: [0, 0, 0]}]
time: {method: static, load_steps: 4}
)yaml");
  EXPECT_EQ(c.time.load_steps, 4);
  EXPECT_EQ(c.time.end, 0);
}

TEST(Input, AValueLeftEmptyIsTheDefault) {
  const Config c = read(smallest + "loads:\nsolver:\n  newton:\ntitle:\nmass: ~\n");
  EXPECT_TRUE(c.loads.empty());
  EXPECT_EQ(c.solver.newton.max_iterations, 50);
  EXPECT_EQ(c.mass, MassKind::consistent);
}

TEST(Override, ChangesAndAddsValues) {
  const Config c = read(everything, {{"bodies.0.density", "900"},
                                     {"time.step", "1 ms"},
                                     {"solver.newton.max_iterations", "7"},
                                     {"loads.2.traction", "[0, 0, \"t\"]"},
                                     {"loads.2.traction.0", "5 Pa"},
                                     {"output", "{directory: there}"},
                                     {"title", ""}});
  EXPECT_EQ(c.bodies[0].density, 900);
  EXPECT_EQ(c.time.step, 1e-3);
  EXPECT_EQ(c.solver.newton.max_iterations, 7);
  const VectorExpression& traction = std::get<LoadConfig::Traction>(c.loads[2].kind).value;
  EXPECT_EQ(traction[0](0, 0, 0, 0), 5);
  EXPECT_TRUE(traction[2].depends_on_time());
  EXPECT_EQ(c.output.directory, "there");
  EXPECT_FALSE(c.output.every) << "the whole section was replaced";
  EXPECT_EQ(c.title, "");
  EXPECT_EQ(read(smallest, {{"output.every", "1 s"}}).output.every, 1) << "a section that was not there";
}

TEST(Override, MendsWhatTheFileHasWrong) {
  EXPECT_THROW(read(smallest + "element: P7\n"), InputError);
  EXPECT_EQ(read(smallest + "element: P7\n", {{"element", "P2"}}).element, ElementOrder::p2);
}

TEST(InputFile, EveryRankReadsTheSame) {
  const std::string file = testing::TempDir() + "pliant_input.yaml";
  on_root(MPI_COMM_WORLD, [&] { std::ofstream(file) << smallest; });
  const Config c = read_input_file(MPI_COMM_WORLD, file, {{"title", "set"}});
  EXPECT_EQ(c.file, file);
  EXPECT_EQ(c.title, "set");
  on_root(MPI_COMM_WORLD, [&] { std::ofstream(file) << "mesh: [\n"; });
  EXPECT_THROW(read_input_file(MPI_COMM_WORLD, file, {}), InputError);
  on_root(MPI_COMM_WORLD, [&] { fs::remove(file); });
}

TEST(InputFile, ThatCannotBeReadIsTheUsersMistakeOnEveryRank) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"no/such/file.yaml", "no/such/file.yaml: there is no such input file; check its name and the working directory"},
      {testing::TempDir(), testing::TempDir() + ": this is a directory; name the input file in it"},
      {"/dev/null", "/dev/null: the input is empty"},
      {"", "there is no such input file; check its name and the working directory"}};
  for (const auto& [file, message] : cases) {
    try {
      read_input_file(MPI_COMM_WORLD, file, {});
      FAIL() << file;
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), message);
    }
  }
  EXPECT_THROW(read_input_file(MPI_COMM_WORLD, "/dev/zero", {}), InputError);
}

TEST(InputFile, ShippedInputsAreGood) {
  const fs::path inputs = source_root() / "input";
  ASSERT_TRUE(fs::exists(inputs));
  for (const auto& entry : fs::recursive_directory_iterator(inputs)) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(read_input_file(MPI_COMM_WORLD, entry.path().string(), {})) << entry.path();
  }
}

}  // namespace
}  // namespace pliant::test_input
