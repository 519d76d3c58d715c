/// A small input and one with every section, for the tests of what reads and writes them.
#pragma once

#include "input/input.hpp"

#include <string>
#include <vector>

namespace pliant::test_input {

inline const std::string smallest = R"yaml(
mesh: {file: beam.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
time: {step: 10 ms, end: 1}
)yaml";

inline const std::string everything = R"yaml(title: "cantilever: under \"gravity\""
mesh:
  file: ../meshes/cantilever.geo
  size: 20 mm
  sizes: [{surface: clamp, size: 5 mm, distance: 20 mm}, {curve: edge, size: 1 mm, distance: 2 mm}, {point: 7, size: 1 mm, distance: 1 mm}]
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
  - {name: wall, surface: clamp, displacement: [0, free, "0.1*t"]}
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
output:
  directory: out/here
  every: 20 ms
  fields: [velocity, von_mises_stress, discretization_error]
  nodal: true
  history:
    - {name: peak, of: cauchy_stress_xx, in: beam, take: max}
    - {name: "whole body", of: displacement, take: norm}
    - {name: "at the tip", of: von_mises_stress, at: tip}
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
inline const std::vector<std::string> other_times{
    "{method: bdf3, end: 2 s, adaptive: {}}",
    "{method: dirk22, step: 1 ms, end: 2 s, events: [0.5, 800 ms], adaptive: {relative: 1e-3, absolute: 1 um, "
    "absolute_velocity: 1 cm/s, min_step: 2 us, max_step: 50 ms}}",
    "{method: {petsc: arkimex}, step: 1 ms, end: 2 s}",
    "{method: \"petsc:bdf\", step: 1 ms, end: 2 s}",
    "{method: {name: bdf2 of mine, alpha: [4/3, -1/3], beta: 2/3, A: [[1]], b: [1]}, startup: dirk33, step: 1 ms, end: "
    "1 s}",
    "{method: {A: [[1 - sqrt(2)/2, 0], [sqrt(2)/2, 1 - sqrt(2)/2]], b: [sqrt(2)/2, 1 - sqrt(2)/2]}, step: 1 ms, end: "
    "2 s}"};

inline Config read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_input(text, "input/a.yaml", overrides);
}

}  // namespace pliant::test_input
