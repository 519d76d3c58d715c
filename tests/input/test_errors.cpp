// Every mistake is told once, at its place, in words that help.
#include "input/bad_input.hpp"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_input_errors {
namespace {

using test::Bad;
using test::mistakes;
using test::processor_time;
using test::told;
using test::with_line;

TEST(InputErrors, TheGoodInputIsGood) {
  EXPECT_EQ(told(mistakes(with_line(6, "title: good"))), "");
}

class BadInput : public ::testing::TestWithParam<Bad> {};

TEST_P(BadInput, IsToldOnceAtItsPlace) {
  test::expect_told_once(GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Keys, BadInput,
    ::testing::Values(
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0, @youngs_modulos: "
            "2}}]",
            "unknown key 'youngs_modulos' in elasticity (did you mean 'youngs_modulus'?)"},
        Bad{6, "@titel: x", "unknown key 'titel' (did you mean 'title'?)"},
        Bad{6, "@colour: red", "unknown key 'colour'; the keys are title, mesh,"},
        Bad{6, "@method: bdf2", "unknown key 'method' (it belongs in time)"},
        Bad{1, "mesh: {file: a.msh, @element: P2}", "unknown key 'element' in mesh (it belongs at the top level)"},
        Bad{2,
            "bodies: [{@volumetric: mixed, density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: "
            "0}}]",
            "unknown key 'volumetric' in bodies[0] (it belongs at the top level)"},
        Bad{2, "bodies: [{@mass: 1, density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "unknown key 'mass' in bodies[0] (it is a key of the top level and of rigid_bodies); the keys here are "
            "volume, density"},
        Bad{6, "output: {@max_iterations: 5}",
            "unknown key 'max_iterations' in output (it is a key of solver.newton); the keys here are directory, "
            "every"},
        Bad{6, "solver: {@max_iterations: 5}", "unknown key 'max_iterations' in solver (it belongs in newton)"},
        Bad{5, "time: {step: 0.01, end: 1, @\"end:2\"}", "the ':' after a key must be followed by a space"},
        Bad{5, "time: {step: 0.01, end: 1, @step: 2}", "key 'step' is given twice (first in line 5)"},
        Bad{6, "@mesh: {file: b.msh}", "key 'mesh' is given twice (first in line 1)"},
        Bad{6, "? @[a, b]\n: c", "a key must be a word, not a list"}, Bad{1, "@title: no mesh", "missing key 'mesh'"},
        Bad{1, "@mesh:", "key 'mesh' has no value"}, Bad{1, "mesh: {@file: }", "key 'file' in mesh has no value"},
        Bad{1, "mesh: @{scale: 2}", "missing key 'file' in mesh"},
        Bad{2, "bodies: [{density: 1, elasticity: @{model: linear, youngs_modulus: 1}}]",
            "linear needs two of youngs_modulus, poissons_ratio"},
        Bad{2, "bodies: [@{density: 1}]", "missing key 'elasticity' in bodies[0]"},
        Bad{6, "contact: @{law: penalty}", "at least one of pairs, obstacles is needed in contact"},
        Bad{6, "contact: {pairs: [@{surface: a}]}", "contact of a part with itself needs 'law: barrier'"},
        Bad{6, "contact: {law: barrier, pairs: @some}",
            "'pairs' must be 'all' or a list such as [{surface: finger, with: ball}], not 'some'"},
        Bad{6, "contact: {pairs: [@[finger, ball], {surface: a, with: b}]}",
            "a pair of 'pairs' is a map, here {surface: finger, with: ball}"},
        Bad{6, "joints: [{name: j, type: @revolute, between: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]}]",
            "not 'revolute' (revolute: 'hinge'; prismatic"},
        Bad{6, "contact: {pairs: @[finger, ball]}", "a pair of 'pairs' is a map, here {surface: finger, with: ball}"},
        Bad{6, "contact: {pairs: [@finger]}", "'pairs[0]' must be a map of keys such as 'surface:', not 'finger'"},
        Bad{6, "contact: {pairs: [{@master: finger, surface: ball, with: a}]}", "unknown key 'master' in pairs[0]"},
        Bad{6, "contact: {law: barrier, pairs: [{surface: a, @name: grip}]}",
            "'name' can only be given with 'with' in pairs[0]"},
        Bad{6, "contact: {law: barrier, @exclude: [[a, b]], obstacles: [{name: a, shape: sphere, radius: 1}]}",
            "'exclude' can only be given with 'pairs' in contact"},
        Bad{6, "contact: {law: barrier, start: @resolve, obstacles: [{name: a, shape: sphere, radius: 1}]}",
            "'start: resolve' moves bodies apart that may touch each other: add 'pairs'"},
        Bad{6, "contact: {surface: a, @where: \"x > 0\", obstacles: [{name: a, shape: sphere, radius: 1}]}",
            "only one of surface, where can be given in contact"},
        Bad{6, "contact: {obstacles: [@{name: a, shape: plane}]}", "missing key 'normal'"},
        Bad{6, "contact: {obstacles: [@{name: a, shape: sphere}]}", "missing key 'radius'"},
        Bad{6, "contact: {obstacles: [@{name: a, shape: surface}]}", "missing key 'file'"},
        Bad{6, "contact: {obstacles: [@{name: a, shape: capsule, axis: [1, 0, 0], radius: 1}]}",
            "missing key 'length' in obstacles[0], which a capsule needs"},
        Bad{6, "contact: {obstacles: [{name: a, shape: sphere, radius: 1, @normal: [0, 0, 1]}]}",
            "only be given with 'shape: plane'"},
        Bad{6, "contact: {obstacles: [{name: a, shape: @cone}]}", "'shape' must be one of"},
        Bad{6, "contact: {obstacles: [{name: a, shape: plane, normal: @[0, 0, 0]}]}", "[0, 0, 0] points nowhere"},
        Bad{6, "contact: {obstacles: [{name: a, shape: sphere, radius: 1}, {name: @a, shape: sphere, radius: 2}]}",
            "the contact name 'a' is given twice"},
        Bad{6, "contact: {obstacles: [{name: @clamp, shape: sphere, radius: 1}]}",
            "the obstacle name 'clamp' is also the name of a constrained part"},
        Bad{5,
            "time: {step: 0.01, end: 1, method: implicit-midpoint}\n"
            "contact: {law: @barrier, obstacles: [{name: a, shape: sphere, radius: 1}]}",
            "a barrier needs a stiffly accurate method"},
        Bad{6, "output: {fields: [displacement, @contact_gap]}", "the field 'contact_gap' needs 'contact'"},
        Bad{6, "checkpoint: {every: @0}", "'every' must be a whole number from 1"},
        Bad{6, "checkpoint: {minutes: @0}", "'minutes' must be > 0"},
        Bad{6, "checkpoint: {@hours: 1}", "unknown key 'hours' in checkpoint"}));

INSTANTIATE_TEST_SUITE_P(
    Values, BadInput,
    ::testing::Values(
        Bad{1, "mesh: @[beam.msh]", "'mesh' must be a map of keys such as 'file:', not a list"},
        Bad{1, "mesh: @beam.msh", "'mesh' must be a map of keys such as 'file:', not 'beam.msh'"},
        Bad{1, "mesh: {file: @[a, b]}", "'file' must be text, not a list"},
        Bad{1, "mesh: {file: beam.msh, refine: @7}", "'refine' must be a whole number from 0 to 6, not '7'"},
        Bad{1, "mesh: {file: beam.msh, refine: @1.5}", "'refine' must be a whole number"},
        Bad{1, "mesh: {file: beam.msh, scale: @0}", "'scale' must be > 0, not '0'"},
        Bad{1, "mesh: {file: beam.msh, size: @5 s}", "'size': '5 s' is a time, but a length [m] is expected"},
        Bad{2, "bodies: @{density: 1}", "'bodies' must be a list (each entry starts with '- '), not a map of keys"},
        Bad{2, "bodies: @[]", "'bodies' must be a list with entries, not an empty list"},
        Bad{2, "bodies: [{density: @-1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'density' must be > 0 [kg/m^3], not '-1'"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: @0 Pa, poissons_ratio: 0}}]",
            "'youngs_modulus' must be > 0 [Pa], not '0 Pa'"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: @0.6}}]",
            "'poissons_ratio' must be between -1 (excluded) and 0.5, not '0.6'"},
        Bad{2, "bodies: [{density: 1, elasticity: @{model: linear, youngs_modulus: 1, poissons_ratio: 0.5}}]",
            "displacements alone cannot represent an incompressible body; add 'volumetric: mixed'"},
        Bad{2, "bodies: [{density: 1, elasticity: @{model: neo-hookean, youngs_modulus: 1, incompressible: true}}]",
            "displacements alone cannot represent an incompressible body; add 'volumetric: mixed'"},
        Bad{2, "bodies: [{density: 1, elasticity: {library: @ecoflex-00-3}}]", "did you mean 'ecoflex-00-30'"},
        Bad{2, "bodies: [{density: 1, elasticity: {@library: ninjaflex, model: ogden}}]",
            "only one of model, library can be given in elasticity"},
        Bad{2, "bodies: [@{elasticity: {library: ninjaflex}}]", "missing key 'density'"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: yeoh, c10: 1, incompressible: true, poissons_ratio: @0.4}}]",
            "'poissons_ratio' contradicts 'incompressible: true', which takes its place; remove one of them"},
        Bad{2,
            "bodies: [{density: 1, elasticity: @{model: holzapfel-ogden, a: 1, b: 1, a_f: 1, b_f: 1, a_s: 1, "
            "bulk_modulus: 9, fibre: [1, 0, 0], sheet: [0, 1, 0]}}]",
            "missing key 'b_s' of holzapfel-ogden"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: @[1], poissons_ratio: 0}}]",
            "'youngs_modulus' must be a pressure [Pa] or a formula, not a list"},
        Bad{2, "bodies: [{density: 1, elasticity: @{model: guccione, C: 1, bf: 1, bt: 1, bfs: 1, bulk_modulus: 1}}]",
            "missing key 'fibre', a direction that guccione needs"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0, fibre: @[1, 0, "
            "0]}}]",
            "'fibre' is not a direction of linear, which has none"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: guccione, C: 1, bf: 1, bt: 1, bfs: 1, bulk_modulus: 1, fibre: "
            "@[0, 0, 0]}}]",
            "'fibre' has no direction: its components are (0, 0, 0)"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: holzapfel-ogden, a: 1, b: 1, a_f: 1, b_f: 1, a_s: 1, b_s: 1, "
            "a_fs: "
            "1, b_fs: 1, bulk_modulus: 1, fibre: [1, 1, 0], sheet: @[-2, -2, 0]}}]",
            "'sheet' is parallel to 'fibre'; choose a direction across it"},
        Bad{2,
            "bodies: [{density: 1, elasticity: @{model: guccione, C: 1, bf: 1, bt: 1, bfs: 1, bulk_modulus: 1, "
            "poissons_ratio: 0.3, "
            "fibre: "
            "[1, 0, 0]}}]",
            "'poissons_ratio' is not a parameter of guccione"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: {cell_data: a, @cell: a}, "
            "poissons_ratio: 0}}]",
            "unknown key 'cell' in youngs_modulus"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, active: "
            "@{stress: 1}}]",
            "missing key 'fibre' in active: the elastic law has no fibres of its own"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, active: "
            "{fibre: [1, 0, 0], stress: 1, @shortening: 0.1}}]",
            "shortening"},
        Bad{2,
            "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, expansion: "
            "{stretch: @1 m}}]",
            "'stretch': '1 m' is a length, but a number without a unit is expected"},
        Bad{6,
            "joints: [{name: a, type: hinge, between: [ground, b], point: [0, 0, 0], axis: [0, 0, 1], spring: "
            "{stiffness: "
            "@3 N/mm}}]",
            "'stiffness': '3 N/mm' is a stiffness, but a torque per angle [N*m/rad] is expected"},
        Bad{6,
            "joints: [{name: a, type: slider, between: [ground, b], point: [0, 0, 0], axis: [0, 0, 1], limits: [0, @30 "
            "deg]}]",
            "'limits[1]': '30 deg' is a pure number, but a length [m] is expected"},
        Bad{6,
            "joints: [{name: a, type: @hing, between: [ground, b], point: [0, 0, 0], axis: [0, 0, 1], limits: [0, 30 "
            "deg]}]",
            "did you mean 'hinge'?"},
        Bad{2, "bodies: [{density: 1, rigid: @yes}]", "'rigid' must be true or false, not 'yes'"},
        Bad{2, "bodies: [{density: 1, rigid: true, expansion: @{stretch: 1.1}}]",
            "bodies[0] is rigid: remove 'expansion'"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: @neohookean, youngs_modulus: 1, poissons_ratio: 0}}]",
            "not 'neohookean' (did you mean 'neo-hookean'?)"},
        Bad{5, "time: {step: @10 mm, end: 1}", "'step': '10 mm' is a length, but a time [s] is expected"},
        Bad{5, "time: {step: @-1, end: 1}", "'step' must be > 0 [s], not '-1'"},
        Bad{5, "time: {step: @\"0,01\", end: 1}", "a decimal point is written '.'"},
        Bad{5, "time: {step: @.nan, end: 1}", "'.nan' is not a number"},
        Bad{5, "time: {step: @1e999, end: 1}", "'1e999' is neither a number nor a number with a unit"},
        Bad{5, "time: {step: 0.01, end: 1, method: @bfd2}", "did you mean 'bdf2'?"},
        Bad{5, "time: {step: 0.01, end: 1, startup: @bdf2}", "'startup' must be one of ramp, dirk33, not 'bdf2'"},
        Bad{5, "time: {step: 0.01, end: 1, events: @0.5}", "'events' must be a list"},
        Bad{5, "time: {step: 0.01, end: 1, events: [0.5, @-1]}", "'events[1]' must be > 0 [s], not '-1'"},
        Bad{5, "time: {step: 0.01, end: 1, events: [0.5, @1 m]}", "'1 m' is a length, but a time [s] is expected"},
        Bad{5, "time: {step: 0.01, end: 1, adaptive: @true}",
            "'adaptive' must be a map of keys such as 'relative:', not 'true'"},
        Bad{5, "time: {step: 0.01, end: 1, adaptive: {relative: @0}}",
            "'relative' must be between 0 (excluded) and 1, not '0'"},
        Bad{5, "time: {step: 0.01, end: 1, adaptive: {absolute: @1 s}}", "'1 s' is a time, but a length [m] is"},
        Bad{5, "time: {step: 0.01, end: 1, adaptive: {absolute_velocity: 1, @min_stp: 1}}", "unknown key 'min_stp'"},
        Bad{6, "element: @P3", "'element' must be one of P1, P2, not 'P3'"},
        Bad{6, "volumetric: @mean-dilatation", "needs quadratic tetrahedra; add 'element: P2'"},
        Bad{2,
            "element: P2\nvolumetric: mean-dilatation\nbodies: [{density: 1, elasticity: @{model: linear, "
            "youngs_modulus: 1, poissons_ratio: 0}}]",
            "model 'linear' is for small strains"},
        Bad{2,
            "element: P2\nvolumetric: mixed\nbodies: [{density: 1, elasticity: @{model: saint-venant-kirchhoff, "
            "youngs_modulus: 1, poissons_ratio: 0}}]",
            "an energy with a separate volumetric part, which model 'saint-venant-kirchhoff' does not have"},
        Bad{2,
            "element: P2\nvolumetric: mixed\nbodies: [{density: 1, elasticity: @{model: neo-hookean, "
            "youngs_modulus: 1, poissons_ratio: 0}}]",
            "needs a volumetric part that resists a change of volume; with these constants, that of model "
            "'neo-hookean' is 0 Pa"},
        Bad{2,
            "element: P2\nvolumetric: mean-dilatation\nbodies: [{density: 1, elasticity: {model: "
            "saint-venant-kirchhoff, "
            "youngs_modulus: 1, poissons_ratio: 0}, viscosity: @{model: prony, ratio: 0.5, relaxation_time: 1}}]",
            "a prony branch relaxes the law without its volumetric part here"},
        Bad{2,
            "volumetric: mixed\nbodies: [{density: 1, elasticity: {model: neo-hookean, youngs_modulus: 1, "
            "poissons_ratio: 0.3}, viscosity: @{model: maxwell, shear_ratio: 0.5, bulk_ratio: 1, relaxation_time: 1}}]",
            "give a 'shear_ratio' only"},
        Bad{5, "time: {method: @petsc:bdf, step: 0.01, end: 1}\nelement: P2\nvolumetric: mixed",
            "needs one of Pliant's own methods"},
        Bad{2, "bodies: [{volume: a, density: 1, rigid: true, mullins: @{r: 2, m: 1}}]", "is rigid: remove 'mullins'"},

        Bad{6, "element: P2\nvolumetric: mixed\nsolver: {linear: @p-multigrid}", "which p-multigrid cannot solve"},
        Bad{6, "solver: {linear: @p-multigrid}",
            "coarsens quadratic elements to linear ones; add 'element: P2', or use 'amg'"},
        Bad{6, "mass: @[lumped]", "'mass' must be one of consistent, lumped, not a list"},
        Bad{6, "solver: {newton: {relative: @-1e-8}}", "'relative' must be from 0 to 0.1"},
        Bad{6, "solver: {newton: {max_iterations: @0}}", "'max_iterations' must be a whole number from 1"},
        Bad{6, "solver: {newton: {relative: @0}}", "one of 'relative' and 'absolute' in newton must be above 0"},
        Bad{6, "output: {every: @-1}", "'every' must be > 0 [s], not '-1'"},
        Bad{6, "output: {fields: [displacement, @stress]}", "'fields[1]' must be one of displacement, velocity,"},
        Bad{6, "output: {fields: [velocity, @velocity]}", "the field 'velocity' is given twice"},
        Bad{6, "probes: [{name: @\"a,b\", point: [0, 0, 0]}]", "'name' must be a name without commas"},
        Bad{6, "probes: [{name: a, point: @[0, 0]}]", "'point' must be a list of 3 values, not of 2"},
        Bad{6, "probes: [{name: a, point: [0, @x, 0]}]", "'point[1]': 'x' is not a number"},
        Bad{6, "probes: [{name: a, point: [0, 0, 0]}, {name: @a, point: [1, 0, 0]}]",
            "the probe name 'a' is given twice"},
        Bad{6, "output: {nodal: @1}", "'nodal' must be true or false"},
        Bad{6, "output: {history: [{name: a, of: @von_mises, take: max}]}",
            "'of' must be a field of the result or a component of one, such as von_mises_stress or displacement_z, not "
            "'von_mises'"},
        Bad{6, "output: {history: [{name: a, of: @displacement_w, take: max}]}", "(did you mean 'displacement_"},
        Bad{6, "output: {history: [{name: a, of: velocity, take: @maxx}]}",
            "'take' must be one of max, min, mean, integral, norm, not 'maxx' (did you mean 'max'?)"},
        Bad{6, "output: {history: [{name: a, of: @cauchy_stress, take: max}]}",
            "'cauchy_stress' has 6 components, of which a column shows one: write cauchy_stress_xx, ..., "
            "cauchy_stress_xz"},
        Bad{6, "output: {history: [{name: a, of: @principal_stress, take: mean}]}", "write principal_stress_1, ..., "},
        Bad{6, "output: {history: [{name: @time, of: velocity, take: max}]}",
            "history.csv has a column 'time' of its own; choose another name"},
        Bad{6, "output: {history: [{name: a, of: velocity, take: max}, {name: @a, of: velocity, take: min}]}",
            "the column name 'a' is given twice"},
        Bad{6, "output: {history: [@{name: a, of: velocity}]}", "one of take, at is needed in history[0]"},
        Bad{6, "output: {history: [{name: a, of: velocity, at: @tip}]}",
            "'at' must be the name of a probe, not 'tip'; this input has no 'probes'"},
        Bad{6, "output: {history: [{name: a, of: @contact_gap, take: min}]}",
            "the field 'contact_gap' needs 'contact', which this input does not have"}));

INSTANTIATE_TEST_SUITE_P(
    Formulas, BadInput,
    ::testing::Values(
        Bad{4, "loads: [{gravity: [0, 0, 9.81*@foo]}]", "'gravity[2]': 'foo' is not known"},
        Bad{4, "loads: [{gravity: [0, 0, \"2*@sine(t)\"]}]", "'sine' is not a function (did you mean 'sin'?)"},
        Bad{4, "loads: [{gravity: [0, 0, \"x @= 3\"]}]", "cannot assign"},
        Bad{4, "loads: [{gravity: [0, 0, \"1@,5*t\"]}]", "one value"},
        Bad{4, "loads: [{gravity: [0, 0, @9.81 m/s]}]",
            "'gravity[2]': '9.81 m/s' is a velocity, but an acceleration [m/s^2] is expected"},
        Bad{4, "loads: [{gravity: [0, 0, @2 kPa*sin(t)]}]", "formulas are in SI without units"},
        Bad{4, "loads: [{gravity: [0, 0, @1/0]}]", "'gravity[2]' must be finite"},
        Bad{4, "loads: [{gravity: [0, 0, @[1]]}]",
            "'gravity[2]' must be an acceleration [m/s^2] or a formula, not a list"},
        Bad{4, "loads: [{surface: tip, pressure: @[0, 0, 1]}]",
            "'pressure' must be a pressure [Pa] or a formula, not a list"},
        Bad{4, "loads: [{surface: tip, pressure: @2 N}]", "'2 N' is a force, but a pressure [Pa] is expected"},
        Bad{4, "loads: [{surface: tip, pressure: 2*@s}]", "'pressure': 's' is not known"},
        Bad{4, "loads: [{gravity: [0, 0, @{}]}]",
            "'gravity[2]' must be an acceleration [m/s^2] or a formula, not a map"},
        Bad{3, "constraints: [{surface: clamp, displacement: [0, @fixed, 0]}]", "'fixed' is not known"},
        Bad{6, "initial: {velocity: [0, 0, @t]}", "'velocity[2]' cannot depend on the time t"},
        Bad{3, "constraints: [{where: @\"x < t\", displacement: [0, 0, 0]}]", "'where' cannot depend on the time t"}));

INSTANTIATE_TEST_SUITE_P(
    Constraints, BadInput,
    ::testing::Values(
        Bad{3, "constraints: [@{surface: a}]",
            "one of displacement, symmetry, normal_displacement, displacement_along, periodic_with, tied_to, rigid, "
            "equation is needed in constraints[0]"},
        Bad{3, "constraints: [{surface: a, symmetry: @true}]", "'symmetry' must be 'plane', not 'true'"},
        Bad{3, "constraints: [{surface: a, symmetry: plane, @normal_displacement: 0}]",
            "only one of symmetry, normal_displacement can be given"},
        Bad{3, "constraints: [@{surface: a, displacement_along: 1}]",
            "missing key 'direction' in constraints[0], which 'displacement_along' needs"},
        Bad{3, "constraints: [{surface: a, displacement_along: 1, direction: @[0, 0, 0]}]", "points nowhere"},
        Bad{3, "constraints: [{surface: a, symmetry: plane, @direction: [0, 0, 1]}]",
            "'direction' can only be given with 'displacement_along'"},
        Bad{3, "constraints: [@{periodic_with: a}]", "is needed in constraints[0] with 'periodic_with'"},
        Bad{3, "constraints: [@{tied_to: a}]", "is needed in constraints[0] with 'tied_to'"},
        Bad{3, "constraints: [{surface: b, tied_to: a, tolerance: @0 mm}]", "'tolerance' must be > 0 [m], not '0 mm'"},
        Bad{3, "constraints: [{surface: b, symmetry: plane, @tolerance: 1 mm}]",
            "'tolerance' can only be given with 'tied_to'"},
        Bad{3, "constraints: [{surface: b, periodic_with: a, difference: [0, @x, 0]}]",
            "'difference[1]' cannot depend on the position x, y, z; it is a function of t"},
        Bad{3, "constraints: [{surface: a, rigid: {rotation: @none}}]", "'rotation' must be"},
        Bad{3, "constraints: [{surface: a, rigid: {rotation: @{axis: [0, 0, 1]}}}]", "missing key 'angle' in rotation"},
        Bad{3, "constraints: [{surface: a, rigid: {rotation: {axis: [0, 0, 1], angle: @1 m}}}]",
            "'1 m' is a length, but an angle [rad] is expected"},
        Bad{3, "constraints: [{surface: a, rigid: {@angle: 1}}]",
            "unknown key 'angle' in rigid (it belongs in rotation)"},
        Bad{3, "constraints: [{equation: [{point: a, component: @w}]}]", "'component' must be one of x, y, z, not 'w'"},
        Bad{3, "constraints: [{equation: [@{component: x}]}]",
            "one of surface, volume, curve, point, box, where is needed in equation[0]"},
        Bad{3, "constraints: [{@surface: a, equation: [{point: a, component: x}]}]",
            "'surface' can only be given with"}));

INSTANTIATE_TEST_SUITE_P(
    Selections, BadInput,
    ::testing::Values(
        Bad{3, "constraints: [@{displacement: [0, 0, 0]}]",
            "one of surface, volume, curve, point, box, where is needed in constraints[0]"},
        Bad{3, "constraints: [{surface: a, @box: [[0, 0, 0], [1, 1, 1]], displacement: [0, 0, 0]}]",
            "only one of surface, box can be given in constraints[0]"},
        Bad{3, "constraints: [{box: [[0, 0, 0], @[1, 1]], displacement: [0, 0, 0]}]", "'box[1]' must be a list of 3"},
        Bad{3, "constraints: [{box: @[[0, 2, 0], [1, 1, 1]], displacement: [0, 0, 0]}]", "the lower corner, then"},
        Bad{3, "constraints: [{surface: @\"\", displacement: [0, 0, 0]}]", "the name or tag of a physical group"},
        Bad{3, "constraints: [{surface: @[a], displacement: [0, 0, 0]}]", "'surface' must be text"},
        Bad{4, "loads: [@{traction: [0, 0, 1]}]", "one of surface, box, where is needed in loads[0] with 'traction'"},
        Bad{4, "loads: [@{surface: tip}]",
            "one of gravity, traction, pressure, force_density, line_force, force, torque, spring, dashpot, "
            "point_spring, point_dashpot is needed in loads[0]"},
        Bad{4, "loads: [{surface: tip, traction: [0, 0, 1], @pressure: 1}]",
            "only one of traction, pressure can be given"},
        Bad{4, "loads: [@{pressure: 1}]", "one of surface, box, where is needed in loads[0] with 'pressure'"},
        Bad{4, "loads: [{pressure: 1, surface: tip, @volume: a}]",
            "'volume' can only be given with 'gravity', 'force_density', 'force' or 'torque' in loads[0]"},
        Bad{4, "loads: [{gravity: [0, 0, 1], @surface: tip}]",
            "'surface' can only be given with 'traction', 'pressure', 'spring', 'dashpot' or 'force' in loads[0]"},
        Bad{4, "loads: [{traction: [0, 0, 1], surface: tip, @volume: a}]", "'volume' can only be given with 'gravity'"},
        Bad{4, "cavities: [@{name: a, surface: b}]", "one of pressure, gas, liquid is needed in cavities[0]"},
        Bad{4, "cavities: [{name: a, surface: b, pressure: 1, @gas: {}}]", "only one of pressure, gas can be given"},
        Bad{4, "cavities: [{name: a, surface: b, pressure: @2*x}]", "'pressure' cannot depend on the position x, y, z"},
        Bad{4, "cavities: [{name: a, surface: b, gas: {}}, {name: @a, surface: c, gas: {}}]",
            "the cavity name 'a' is given twice"},
        Bad{4, "loads: [@{spring: 1}]", "one of surface, box, where is needed in loads[0] with 'spring'"},
        Bad{4, "loads: [{spring: @-1, surface: a}]", "'spring' must be >= 0 [Pa/m], not '-1'"},
        Bad{4, "loads: [{spring: @1 N/m, surface: a}]", "but"},
        Bad{4, "loads: [{@spring: 1, dashpot: 1, surface: a, pressure: 1}]",
            "only one of pressure, spring, dashpot can be given in loads[0]"},
        Bad{4, "loads: [{spring: 1, surface: a, direction: @up}]", "'direction' must be one of all, normal, not 'up'"},
        Bad{4, "loads: [{surface: a, traction: [0, 0, 1], @direction: all}]",
            "'direction' can only be given with 'spring' or 'dashpot' in loads[0]"},
        Bad{4, "loads: [@{point_spring: 1}]", "missing key 'point' in loads[0], which 'point_spring' needs"},
        Bad{4, "loads: [@{line_force: [0, 0, 1]}]", "missing key 'curve' in loads[0], which 'line_force' needs"},
        Bad{4, "loads: [{line_force: [0, 0, @1 N], curve: a}]", "'1 N' is a force, but"},
        Bad{4, "loads: [@{force: [0, 0, 1]}]",
            "one of surface, box, where, curve, point, volume is needed in loads[0] with 'force'"},
        Bad{4, "loads: [@{torque: [0, 0, 1]}]", "missing key 'volume' in loads[0], which 'torque' needs"},
        Bad{4, "loads: [{force: [0, 0, 1], curve: a, @point: b}]", "only one of curve, point can be given in loads[0]"},
        Bad{4, "loads: [{force_density: [0, 0, 1], @surface: a}]", "'surface' can only be given with 'traction',"}));

INSTANTIATE_TEST_SUITE_P(
    Methods, BadInput,
    ::testing::Values(
        Bad{5, "time: {step: 1, end: 1, method: @[bdf2]}", "'method' must be one of backward-euler, bdf2, bdf3,"},
        Bad{5, "time: {step: 1, end: 1, method: @\"petsc:alpha\"}", "(did you mean 'petsc:alpha2'?)"},
        Bad{5, "time: {step: 1, end: 1, method: {petsc: @rk}}",
            "'petsc' must be one of alpha2, bdf, arkimex, not 'rk'"},
        Bad{5, "time: {step: 1, end: 1, method: @{name: mine}}", "one of petsc, A is needed in method"},
        Bad{5, "time: {step: 1, end: 1, method: @{A: [[1]]}}", "missing key 'b' in method, which 'A' needs"},
        Bad{5, "time: {step: 1, end: 1, method: {petsc: bdf, @b: [1]}}", "'b' can only be given with 'A' in method"},
        Bad{5, "time: {step: 1, end: 1, method: {petsc: bdf, @A: [[1]], b: [1]}}", "only one of petsc, A can be given"},
        Bad{5, "time: {step: 1, end: 1, method: {A: @1, b: [1]}}", "'A' must be a list"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [@1], b: [1]}}", "'A[0]' must be a list"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [[1]], b: [@one]}}", "'b[0]': 'one' is not known"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [[1]], b: [@x]}}", "'b[0]' must be a number or formula of numbers"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [[1]], b: [@1/0]}}", "'b[0]' must be finite"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [[1]], b: [1], name: @bdf2}}", "'bdf2' is a method of Pliant"},
        Bad{5, "time: {step: 1, end: 1, method: {A: [[1]], b: [1], name: @\"a,b\"}}", "'name' must be a name without"},
        Bad{5, "time: {step: 1, end: 1, method: @{A: [[1, 1], [0, 1]], b: [0, 1]}}",
            "method 'own' is refused: A is not lower triangular"},
        Bad{5, "time: {step: 1, end: 1, method: @{A: [[1]], b: [0.5], name: half}}",
            "method 'half' is refused: it is inconsistent: b sums to 0.5"}));

INSTANTIATE_TEST_SUITE_P(
    Contradictions, BadInput,
    ::testing::Values(
        Bad{5, "time: {step: @2, end: 1}", "the step of 2 s is longer than the simulation, which ends at 1 s"},
        Bad{5, "time: {step: @1e-12, end: 1}", "would need 1000000000000 steps"},
        Bad{5, "time: {step: 0.1, end: 1, min_step: @1}", "'min_step' is larger than the step of 0.1 s"},
        Bad{5, "time: {step: 0.1, end: 1, adaptive: {}, @min_step: 0.01}", "'min_step' belongs in 'adaptive' where"},
        Bad{5, "time: {step: 0.1, end: 1, adaptive: {min_step: @0.2}}", "is larger than the first step, 0.1 s"},
        Bad{5, "time: {step: 0.1, end: 1, adaptive: {max_step: @0.05}}", "is smaller than the first step, 0.1 s"},
        Bad{5, "time: {end: 1, adaptive: {min_step: @0.2, max_step: 0.1}}", "larger than 'max_step', 0.1 s"},
        Bad{5, "time: {method: implicit-midpoint, step: 0.1, end: 1, adaptive: @{}}",
            "steps cannot adapt: method 'implicit-midpoint' is symplectic"},
        Bad{5, "time: {method: {A: [[0.4]], b: [1]}, step: 0.1, end: 1, adaptive: @{}}",
            "steps cannot adapt: method 'own' has too few stages for an embedded formula"},
        Bad{5, "time: {method: quasistatic, step: 0.1, end: 1, adaptive: @{}}",
            "steps cannot adapt: method 'quasistatic' has no motion"},
        Bad{5, "time: {method: {petsc: bdf}, step: 0.1, end: 1, adaptive: @{}}",
            "steps cannot adapt: method 'petsc:bdf' takes fixed steps"},
        Bad{5, "time: @{adaptive: {}}", "missing key 'end' in time"},
        Bad{5, "time: {step: 0.1, end: 1, events: [0.5, @1]}", "the event at 1 s is not before the end, 1 s"},
        Bad{5, "time: {step: 0.1, end: 1, events: [0.5, @0.2]}", "ascending order, but 0.2 s follows 0.5 s"},
        Bad{5, "time: {step: 0.1, end: 1, events: [0.5, @0.5]}", "ascending order, but 0.5 s follows 0.5 s"},
        Bad{5, "time: {step: 0.1, end: @1 m, events: [0.5]}", "'1 m' is a length"},
        Bad{5, "time: @{end: 1}", "missing key 'step' in time"},
        Bad{5, "time: @{step: 1}", "missing key 'end' in time"},
        Bad{2, "bodies: [@{elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "missing key 'density' in bodies[0], which dynamics needs"},
        Bad{2,
            "bodies:\n  - {density: 1, elasticity: &e {model: linear, youngs_modulus: 1, poissons_ratio: 0}}\n"
            "  - {volume: @a, density: 1, elasticity: *e}",
            "bodies[1] and bodies[0] fill the same volume"},
        Bad{2,
            "bodies:\n  - {volume: a, density: 1, elasticity: &e {model: linear, youngs_modulus: 1, poissons_ratio: "
            "0}}\n"
            "  - {volume: @a, density: 1, elasticity: *e}",
            "bodies[1] and bodies[0] fill the same volume"}));

INSTANTIATE_TEST_SUITE_P(
    Yaml, BadInput,
    ::testing::Values(Bad{6, "title: a@: b", "not valid YAML: ':' is not expected here"},
                      Bad{6, "output:\n@\tdirectory: x", "tabs cannot indent YAML; use spaces"},
                      Bad{6, "title: @'never closed", "this quote is not closed"},
                      Bad{6, "title: @\"never closed \\\"", "this quote is not closed"},
                      Bad{6, "title: @%x", "text cannot start with this character; put it in quotes"},
                      Bad{6, "title: @*none", "an anchor ('&name') that is not defined"},
                      Bad{6, "title: &a [@*a]", "this alias refers to a value that contains it"},
                      Bad{6, "title: @*sin(t)", "a formula that begins with '*' needs quotes"},
                      Bad{6, "probes:\n  - @{name: a, point: [0, 0, \"x]\"]\n  - {name: b}", "the '{' is not closed"},
                      Bad{6, "probes: [{name: it's, point: @[0, 0, 0}]  # ]", "the '[' is not closed"},
                      Bad{6, "probes: [{name: 'it''s [x', point: @[0, 0, 0}]", "the '[' is not closed"},
                      Bad{6, "title: a [Pa\nprobes: [[a], b: {c: 1}@: d]", "not valid YAML"},
                      Bad{6, "title: @]", "this bracket was never opened"},
                      Bad{6, "@---\ntitle: second", "the input ends before this line"},
                      Bad{6, "title: caf@\xE9", "this is not UTF-8 text"},
                      Bad{6, "title: a@\x01z", "the file contains a control character"}));

TEST(InputErrors, AllAreReportedAtOnceInTheOrderOfTheFile) {
  const auto found = mistakes(R"yaml(titel: x
mesh: {size: 5 s}
bodies:
  - elasticity: {model: steel, youngs_modulus: -1, poissons_ratio: 0.7}
loads:
  - gravity: [0, 0, foo]
    surface: a
time: {step: 3, end: 2}
probes: [{name: a}]
)yaml");
  const std::vector<std::string> expected{
      "dir/a.yaml:1:1: unknown key 'titel' (did you mean 'title'?)",
      "dir/a.yaml:2:7: missing key 'file' in mesh",
      "dir/a.yaml:2:14: 'size': '5 s' is a time, but a length [m] is expected",
      "dir/a.yaml:4:5: missing key 'density' in bodies[0], which dynamics needs",
      "dir/a.yaml:4:25: 'model' must be one of linear, saint-venant-kirchhoff, neo-hookean",
      "dir/a.yaml:4:48: 'youngs_modulus' must be > 0 [Pa], not '-1'",
      "dir/a.yaml:4:68: 'poissons_ratio' must be between -1 (excluded) and 0.5, not '0.7'",
      "dir/a.yaml:6:21: 'gravity[2]': 'foo' is not known",
      "dir/a.yaml:7:5: 'surface' can only be given with 'traction', 'pressure', 'spring', 'dashpot' or 'force' in "
      "loads[0]",
      "dir/a.yaml:8:14: the step of 3 s is longer than the simulation, which ends at 2 s",
      "dir/a.yaml:9:10: missing key 'point' in probes[0]"};
  ASSERT_EQ(found.size(), expected.size()) << told(found);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ((to_string(found[i].where) + ": " + found[i].message).find(expected[i]), 0u) << told(found);
  }
}

TEST(InputErrors, StaticProblemsMustBeHeld) {
  for (const std::string method : {"static", "quasistatic"}) {
    const std::string time = "time: {method: " + method + ", step: 0.1, end: 1}";
    const std::vector<Override> set{{"time.method", method}};
    EXPECT_EQ(told(mistakes(with_line(6, "title: held"), set)), "");
    EXPECT_EQ(told(mistakes(with_line(3, ""), set)),
              "--set time.method=" + method + ": a " + method +
                  " analysis needs constraints; without them the bodies can move as a whole\n");
    const auto slides = mistakes(
        with_line(
            3, "constraints: [{surface: a, displacement: [0, 0, free]}, {surface: b, displacement: [0, free, free]}]"),
        set);
    EXPECT_EQ(told(slides), "--set time.method=" + method + ": a " + method +
                                " analysis needs a constraint in every direction; none holds z\n");
  }
  EXPECT_EQ(told(mistakes(with_line(3, ""))), "") << "dynamics needs no constraint";
}

TEST(InputErrors, OfOverridesNameTheBodyOfAVolume) {
  const std::string body = "density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}";
  const std::string two = with_line(2, "bodies: [{volume: a, " + body + ", {volume: b, " + body + "]");
  EXPECT_EQ(told(mistakes(two, {{"bodies.1.density", "2"}})), "");
  EXPECT_EQ(
      told(mistakes(two, {{"bodies.b.density", "2"}})),
      "--set bodies.b.density=2: 'b' does not name an entry of this list; they are numbered from 0 to 1; number 1 "
      "has the volume b\n");
}

TEST(InputErrors, OfOverridesNameTheOverride) {
  const std::string good = with_line(6, "");
  const std::vector<std::pair<Override, std::string>> cases{
      {{"time.step", "-1"}, "'step' must be > 0 [s], not '-1'"},
      {{"time.stp", "1"}, "unknown key 'stp' in time (did you mean 'step'?)"},
      {{"bodies.1.density", "1"}, "'1' does not name an entry of this list; its only entry has the number 0"},
      {{"bodies.first.density", "1"}, "'first' does not name an entry of this list"},
      {{"time.step.size", "1"}, "there is no key 'size' in the value '0.01'"},
      {{"", "1"}, "the path must be keys separated by dots"},
      {{"time..step", "1"}, "the path must be keys separated by dots"},
      {{"time", "[1, 2"}, "the '[' is not closed"},
      {{"time", "{step: 1, step: 2}"}, "key 'step' is given twice"},
      {{"mesh.file", ""}, "key 'file' in mesh has no value"}};
  for (const auto& [change, message] : cases) {
    const auto found = mistakes(good, {change});
    ASSERT_FALSE(found.empty()) << change.path;
    EXPECT_EQ(to_string(found[0].where), "--set " + change.path + "=" + change.value) << told(found);
    EXPECT_NE(found[0].message.find(message), std::string::npos) << told(found);
  }
}

TEST(InputErrors, PlacesHoldAlsoWithWindowsLinesAndLettersBeyondAscii) {
  const std::string text = "\xEF\xBB\xBFtitle: 'caf\u00e9 \u20ac'\r\nmesh: {file: \"b.msh\"}\r\ncolour: 'x'\r\n";
  EXPECT_EQ(told(mistakes(text)).find("dir/a.yaml:1:1: missing key 'time'"), 0u) << told(mistakes(text));
  EXPECT_NE(told(mistakes(text)).find("dir/a.yaml:1:1: missing key 'bodies'"), std::string::npos);
  EXPECT_NE(told(mistakes(text)).find("dir/a.yaml:3:1: unknown key 'colour'"), std::string::npos);
  EXPECT_EQ(told(mistakes(text + "title2: 'open\r\n")), "dir/a.yaml:4:9: this quote is not closed\n");
}

TEST(InputErrors, EmptyInputsSaySo) {
  for (const std::string text : {"", "\n\n", "# only a comment\n", "---\n"}) {
    EXPECT_EQ(told(mistakes(text)), "dir/a.yaml: the input is empty\n") << text;
  }
  EXPECT_NE(told(mistakes("just words")).find("the input must be a map of keys"), std::string::npos);
  EXPECT_NE(told(mistakes("- a\n- b")).find("the input must be a map of keys"), std::string::npos);
  EXPECT_NE(told(mistakes("mesh:1\ntime:2")).find("the ':' after a key must be followed by a space"),
            std::string::npos);
}

/// Text that is repeated.
std::string times(int n, const std::string& text) {
  std::string result;
  for (int i = 0; i < n; ++i) result += text;
  return result;
}

std::string alias_bomb() {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 20; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    const std::string name = "a" + std::to_string(i);
    text += name + ": &" + name + " [" + times(8, alias + ", ") + alias + "]\n";
  }
  return text;
}

TEST(InputErrors, HostileTextIsRefusedQuickly) {
  std::string bytes(5000, '\0');
  std::mt19937 random(1);
  for (char& c : bytes) c = static_cast<char>(random());
  const std::vector<std::string> hostile{times(100000, "["),
                                         times(50000, "{a: "),
                                         times(50000, "{["),
                                         times(50000, "- "),
                                         times(50000, "? "),
                                         times(50000, "\""),
                                         times(50000, "&a "),
                                         times(50000, "*a "),
                                         times(50000, ":"),
                                         alias_bomb(),
                                         times(20000, "a: b\n"),
                                         "[" + times(100000, ",") + "]",
                                         bytes,
                                         std::string("\xFF\xFE"
                                                     "a\0",
                                                     4),
                                         times(5 << 20, "x")};
  for (const std::string& text : hostile) {
    const double start = processor_time();
    const auto found = mistakes(text);
    const double seconds = processor_time() - start;
    EXPECT_FALSE(found.empty()) << text.substr(0, 20);
    EXPECT_LE(found.size(), 60u) << text.substr(0, 20);
    EXPECT_LT(seconds, 10) << text.substr(0, 20);
    for (const auto& d : found) EXPECT_LT(d.message.size(), 400u) << d.message;
  }
}

/// Any damage to a good input gives a configuration or an InputError, never anything else.
TEST(InputErrors, DamagedInputsNeverCrash) {
  const std::string good = with_line(6, "probes: [{name: \"tip\", point: [0, 0, 1 mm]}]\noutput: {every: 20 ms}");
  const std::string pieces = "[]{}:,-#&*!|>'\"%@`\n\t \\x0.e\xC3";
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    std::string text = good;
    for (int i = 0; i < 3; ++i) text[random() % text.size()] = pieces[random() % pieces.size()];
    if (round % 3 == 0) text.resize(random() % text.size());
    EXPECT_NO_THROW(mistakes(text)) << text;
  }
}

}  // namespace
}  // namespace pliant::test_input_errors
