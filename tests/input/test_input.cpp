// What a good input becomes.
#include "base/error.hpp"
#include "input/analysis.hpp"
#include "input/examples.hpp"
#include "input/input.hpp"
#include "input/loads.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "places.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_input {
namespace {

namespace fs = std::filesystem;

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
  ASSERT_EQ(c.mesh.sizes.size(), 3u);
  EXPECT_EQ(c.mesh.sizes[0].surface, "clamp");
  EXPECT_EQ(c.mesh.sizes[0].size, 0.005);
  EXPECT_EQ(c.mesh.sizes[0].distance, 0.02);
  EXPECT_EQ(c.mesh.sizes[2].point, "7");
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
  EXPECT_EQ(damped.where.line, 14);
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
  EXPECT_EQ(c.loads[2].where.line, 44);
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
  EXPECT_EQ(c.time.method.where.line, 56);
  EXPECT_EQ(c.time.min_step, 1e-6);
  EXPECT_EQ(c.solver.linear, LinearSolver::cholesky);
  EXPECT_EQ(c.solver.newton.absolute, 1e-3);
  EXPECT_EQ(c.output.directory, "out/here");
  EXPECT_EQ(c.output.every, 0.02);
  EXPECT_EQ(c.probes[0].point[2], 0.1);
  EXPECT_EQ(c.probes[1].name, "the root");
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
                                     {"probes", "[{name: a, point: [0, 0, 0]}, {name: b, point: [0, 0, 0]}]"},
                                     {"probes.b.point.1", "3 mm"},
                                     {"title", ""}});
  EXPECT_EQ(c.bodies[0].density, 900);
  EXPECT_EQ(c.probes[0].point[1], 0);
  EXPECT_EQ(c.probes[1].point[1], 3e-3) << "an entry by its name";
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
    if (entry.path().parent_path().filename() == "fit") continue;  // files of `pliant fit`: tests/study/test_fit.cpp
    EXPECT_NO_THROW(read_input_file(MPI_COMM_WORLD, entry.path().string(), {})) << entry.path();
  }
}

}  // namespace
}  // namespace pliant::test_input
