#!/usr/bin/python3
"""Rigid bodies and joints, as users type them: motions that are known, orders, ranks, restart, soft bodies between them."""
import itertools
import unittest

import numpy as np

from program import LONG, ALL_OR_SOME, ROOT, ProgramTest, box, read_history, swept, write_box, write_mesh

CHAIN = """rigid_bodies:
  - {name: one, mass: 1, inertia: [0.01, 0.02, 0.03], center: [0.5, 0, 0]}
  - {name: two, mass: 2, inertia: [0.02, 0.03, 0.04, 0.005, 0, 0.002], center: [1.5, 0.1, 0]}
joints:
  - {name: a, type: hinge, between: [ground, one], point: [0, 0, 0], axis: [0, 1, 0.2]}
  - {name: b, type: TYPE, between: [one, two], point: [1, 0, 0], MORE}
loads: [{gravity: [0, 0, -9.81]}]
"""
# A joint of each type between the bodies of the chain.
TYPES = {
    "fixed": "",
    "ball": "",
    "hinge": "axis: [0.1, 1, 0]",
    "slider": "axis: [1, 0.2, 0]",
    "cylindrical": "axis: [1, 0.2, 0]",
    "universal": "axis: [0, 1, 0], second_axis: [1, 0, 1]",
    "planar": "axis: [0, 0.6, 0.8]",
    "distance": "second_point: [1.4, 0.2, 0.3]",
}
DRIVEN = {"hinge": '0.5*sin(9*t)', "slider": '0.1*sin(9*t)', "distance": '0.1*sin(9*t)'}
METHODS = {"backward-euler": 1, "bdf2": 2, "bdf3": 3, "dirk22": 2, "dirk23": 3, "dirk33": 3, "implicit-midpoint": 2, "symplectic-dirk22": 2}
SOFT_MESH = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.2, 0.1, 0.1};
Box(2) = {0.2, 0, 0, 0.2, 0.1, 0.1};
Box(3) = {0.4, 0, 0, 0.2, 0.1, 0.1};
BooleanFragments{ Volume{1, 2, 3}; Delete; }{}
MeshSize{ PointsOf{ Volume{1, 2, 3}; } } = 0.1;
Physical Volume("palm") = {1};
Physical Volume("bar") = {2};
Physical Volume("tip") = {3};
"""
SOFT = """mesh: {file: soft.geo}
bodies:
  - {volume: palm, density: 2000, rigid: true}
  - {volume: bar, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}}
  - {volume: tip, density: 2000, rigid: true}
rigid_bodies:
  - {name: ball, mass: 1, inertia: [0.001, 0.001, 0.001], center: [0.8, 0.05, 0.05]}
joints:
  - {name: knuckle, type: hinge, between: [ground, palm], point: [0, 0.05, 0.05], axis: [0, 1, 0]}
  - {name: link, type: ball, between: [tip, ball], point: [0.6, 0.05, 0.05]}
loads: [{gravity: [0, 0, -9.81]}]
"""


def turned(history, name, vector, row=-1):
    """A vector of the body at the start, where the body is now."""
    w, *n = (history[f"{name}_q{axis}"][row] for axis in "wxyz")
    return vector + 2 * (w * np.cross(n, vector) + np.cross(n, np.cross(n, vector)))


def place(history, name, start, center, row=-1):
    """Where the point of the body is that was at `start`."""
    return np.array([history[f"{name}_{axis}"][row] for axis in "xyz"]) + turned(history, name, np.subtract(start, center), row)

BLOCK = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.1, 0.1, 0.1};
MeshSize{ PointsOf{ Volume{1}; } } = 0.1;
Physical Volume("block") = {1};
Physical Surface("foot") = {1};
Physical Surface("top") = {2};
"""


class Mechanisms(ProgramTest):
    def chain(self, kind, more=""):
        return CHAIN.replace("TYPE", kind).replace("MORE", TYPES[kind] + more)

    def test_joints_hold_what_they_say(self):
        one, two = [0.5, 0, 0], [1.5, 0.1, 0]
        for kind, more in TYPES.items():
            with self.subTest(kind):
                h = self.solve(self.chain(kind), "method: bdf2, step: 10 ms, end: 0.5")
                at = {name: place(h, name, [1, 0, 0], center) for name, center in (("one", one), ("two", two))}
                apart = at["two"] - at["one"]
                axis = np.array([0.1, 1, 0]) if kind == "hinge" else np.array([1, 0.2, 0])
                if kind in ("fixed", "ball", "hinge", "universal"):
                    np.testing.assert_allclose(apart, 0, atol=1e-13)
                if kind in ("hinge", "cylindrical", "slider"):
                    np.testing.assert_allclose(turned(h, "one", axis), turned(h, "two", axis), atol=1e-13)
                if kind in ("slider", "cylindrical"):
                    np.testing.assert_allclose(np.cross(apart, turned(h, "one", axis)), 0, atol=1e-13)
                    self.assertGreater(np.linalg.norm(apart), 0.01)
                if kind in ("slider", "fixed"):
                    for vector in np.eye(3):
                        np.testing.assert_allclose(turned(h, "one", vector), turned(h, "two", vector), atol=1e-13)
                if kind == "universal":
                    self.assertAlmostEqual(turned(h, "one", np.array([0, 1, 0])) @ turned(h, "two", np.array([1, 0, 1])), 0, delta=1e-13)
                if kind == "planar":
                    self.assertAlmostEqual(turned(h, "one", np.array([0, 0.6, 0.8])) @ apart, 0, delta=1e-13)
                if kind == "distance":
                    self.assertAlmostEqual(np.linalg.norm(place(h, "two", [1.4, 0.2, 0.3], two) - at["one"]),
                                           np.linalg.norm([0.4, 0.2, 0.3]), delta=1e-13)
                scale = h["kinetic_energy"].max()
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-12 * scale)

    def test_what_holds_a_body_carries_what_hangs_from_it(self):
        # A carrier of 1 kg that is held at its center, a bob of 3 kg on a hinge, whose axis is to the side; and a tied finger.
        text = '''rigid_bodies:
  - {name: carrier, mass: 1, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0]}
  - {name: bob, mass: 3, inertia: [0.1, 0.1, 0.1], center: [0.2, 0, -1]}
joints: [{name: pin, type: hinge, between: BODIES, point: [0.2, 0, -0.5], axis: [0, 1, 0]}]
constraints: [{name: held, volume: carrier, rigid: {translation: [0, 0, 0], rotation: ROTATION}}]
loads: [{gravity: [0, 0, -9.81]}]
'''
        for bodies in ("[carrier, bob]", "[bob, carrier]"):
            with self.subTest(bodies=bodies):
                h = self.solve(text.replace("BODIES", bodies).replace("ROTATION", "{axis: [1, 0, 0], angle: free}"), "method: backward-euler, step: 10 ms, end: 20 ms")
                self.assertAlmostEqual(h["held_fz"][-1], 4 * 9.81, delta=1e-8)
                self.assertAlmostEqual(h["held_ty"][-1], -0.2 * 3 * 9.81, delta=1e-8)
        points, sides, cells = box((1, 1, 2), (0.1, 0.1, 0.1))
        upper = box((2, 2, 2), (0.1, 0.1, 0.2), (0, 0, 0.1))
        write_mesh(self.directory / "tied.msh", np.vstack([points, upper[0]]),
                   [sides[0], upper[1][0] + len(points), *sides[2:4], upper[1][4] + len(points), sides[5]],
                   np.vstack([cells, upper[2] + len(points)]), (["palm", "finger"], np.repeat([0, 1], [len(cells), len(upper[2])])))
        text = '''mesh: {file: tied.msh}
bodies:
  - {volume: palm, density: 1000, rigid: true}
  - {volume: finger, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}
constraints:
  - {name: held, volume: palm, rigid: {translation: [0, 0, 0], rotation: fixed}}
  - {name: tie, surface: bottom, tied_to: top}
loads: [{gravity: [3, 0, -9.81]}]
'''
        for ranks in (1, 2):
            h = self.solve(text, "method: static, load_steps: 2", ranks)
            self.assertAlmostEqual(h["tie_fz"][-1], 2 * 9.81, delta=1e-6)
            self.assertAlmostEqual(h["held_fz"][-1], 3 * 9.81, delta=1e-6)
            self.assertAlmostEqual(h["held_fx"][-1], -3 * 3, delta=1e-6)
            self.assertAlmostEqual(h["held_ty"][-1], -2 * 3 * 0.15, delta=0.03)  # the finger bends a little

    def test_motions_are_exact(self):
        for kind, formula in DRIVEN.items():
            with self.subTest(kind):
                h = self.solve(self.chain(kind, f', motion: "{formula}"'), "method: dirk33, step: 10 ms, end: 0.2")
                amplitude = float(formula.split("*")[0])
                column = "b_angle" if kind == "hinge" else "b_travel"
                np.testing.assert_allclose(h[column], amplitude * np.sin(9 * h["time"]), atol=1e-13)
                np.testing.assert_allclose(h["b_rate"], 9 * amplitude * np.cos(9 * h["time"]), atol=1e-11)

    def test_given_distances_grow_with_the_load(self):
        h = self.solve(self.chain("distance", ', motion: "0.2"').replace("loads: [{gravity: [0, 0, -9.81]}]\n", "")
                       .replace("name: a, type: hinge", "name: a, type: fixed").replace(", axis: [0, 1, 0.2]", "")
                       + "constraints: [{volume: two, rigid: {translation: [free, 0, 0], rotation: {axis: [1, 0, 0], angle: free}}}]\n"
                       + "loads: [{gravity: [-1, 0, 0]}]\n", "method: static, load_steps: 4")
        np.testing.assert_allclose(h["b_travel"], [0, 0.05, 0.1, 0.15, 0.2], atol=1e-12)

    def test_a_body_of_the_whole_mesh_has_a_name(self):
        write_box(self.directory / "box.msh", (2, 2, 2))
        h = self.solve("""mesh: {file: box.msh}
bodies: [{density: 1000, rigid: true}]
joints: [{name: j, type: hinge, between: [ground, body], point: [0, 0.5, 0.5], axis: [0, 1, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
""", "method: dirk33, step: 5 ms, end: 0.05")
        # A cube about the middle of a side: I = m (1/6 + 1/4).
        np.testing.assert_allclose(h["j_rate"][-1], 0.5 * 9.81 / (1 / 6 + 1 / 4) * 0.05, rtol=1e-3)

    def test_every_method_keeps_its_order(self):
        self.write("in.yaml", self.chain("universal") + "time: {method: bdf2, step: 10 ms, end: 80 ms}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", ALL_OR_SOME)

    def test_springs_dampers_and_motors(self):
        wheel = """rigid_bodies:
  - {name: wheel, mass: 2, inertia: [0.1, 0.1, 0.05], center: [0, 0, 0]}
joints:
  - {name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], MORE}
"""
        cart = """rigid_bodies:
  - {name: cart, mass: 2, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0], velocity: [0.5, 0, 0]}
joints:
  - {name: rail, type: slider, between: [ground, cart], point: [0, 0, 0.1], axis: [1, 0, 0], MORE}
"""
        time = "method: dirk33, step: 2 ms, end: 0.4"
        with self.subTest("spring and damper"):
            h = self.solve(cart.replace("MORE", "spring: {stiffness: 200, rest: 0.03}, damping: 4"), time)
            decay, omega = 4 / (2 * 2), np.sqrt(200 / 2 - 1)
            t = h["time"]
            exact = 0.03 + np.exp(-decay * t) * (-0.03 * np.cos(omega * t) + (0.5 - 0.03 * decay) / omega * np.sin(omega * t))
            np.testing.assert_allclose(h["rail_travel"], exact, atol=1e-7)
            np.testing.assert_allclose(h["rail_spring"], 200 * (0.03 - h["rail_travel"]), atol=1e-12)
            np.testing.assert_allclose(h["rail_damping"], -4 * h["rail_rate"], atol=1e-12)
            # All that acts along the rail; forces of the joint are across it.
            np.testing.assert_allclose(np.gradient(h["rail_rate"], t)[1:-1], (h["rail_spring"] + h["rail_damping"])[1:-1] / 2, atol=5e-4)
            lost = h["kinetic_energy"][0] + 0.5 * 200 * 0.03**2 - h["kinetic_energy"][-1] - h["elastic_energy"][-1]
            self.assertAlmostEqual(h["dissipated_joint_dampers"][-1], lost, delta=1e-5 * lost)
        with self.subTest("turned spring"):
            h = self.solve(wheel.replace("MORE", "spring: {stiffness: 5, rest: 0.4}"), time)
            np.testing.assert_allclose(h["axle_angle"], 0.4 * (1 - np.cos(10 * h["time"])), atol=1e-6)
        with self.subTest("effort"):
            h = self.solve(wheel.replace("MORE", 'motor: {effort: "0.3*t"}'), time)
            np.testing.assert_allclose(h["axle_angle"], 0.3 * h["time"] ** 3 / 6 / 0.05, atol=1e-9)
            np.testing.assert_allclose(h["axle_effort"], 0.3 * h["time"], atol=1e-15)
            self.assertAlmostEqual(h["load_work"][-1], h["kinetic_energy"][-1], delta=1e-9)
        with self.subTest("control"):
            # Against a weight on an arm, the integral part missing: the angle lags by weight / stiffness.
            arm = wheel.replace("center: [0, 0, 0]", "center: [0.1, 0, 0]") + "loads: [{gravity: [0, -9.81, 0]}]\n"
            h = self.solve(arm.replace("MORE", "motor: {target: 0.5, stiffness: 100, damping: 5}"), "method: bdf2, step: 5 ms, end: 3")
            angle = h["axle_angle"][-1]
            self.assertAlmostEqual(100 * (0.5 - angle), 2 * 9.81 * 0.1 * np.cos(angle), delta=1e-6)
            self.assertAlmostEqual(h["axle_effort"][-1], 2 * 9.81 * 0.1 * np.cos(angle), delta=1e-6)
        with self.subTest("limit"):
            h = self.solve(wheel.replace("MORE", "motor: {target: 1, stiffness: 1000, limit: 0.2}"), "method: dirk33, step: 5 ms, end: 0.1")
            np.testing.assert_allclose(h["axle_angle"], 0.5 * 0.2 / 0.05 * h["time"] ** 2, atol=1e-9)
        # Between two bodies that turn, of all methods, on several ranks.
        both = self.chain("hinge", ", spring: {stiffness: 30, rest: 0.3}, damping: 0.5, friction: 0.3, stick_rate: 2, motor: {target: \"0.4*sin(5*t)\", stiffness: 20, damping: 1, limit: 3}")
        self.write("in.yaml", both + "time: {method: bdf2, step: 5 ms, end: 40 ms}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", ALL_OR_SOME)
        one, *others = [self.solve(both, "method: bdf2, step: 5 ms, end: 0.1", ranks) for ranks in swept((1, 2, 3), (1,))]
        self.assertGreater(np.abs(one["b_effort"]).max(), 0.5)
        np.testing.assert_allclose(one["b_spring"], 30 * (0.3 - one["b_angle"]), atol=1e-12)
        np.testing.assert_allclose(one["b_damping"], -0.5 * one["b_rate"], atol=1e-12)
        np.testing.assert_allclose(one["b_friction"], -0.3 * np.tanh(one["b_rate"] / 2), atol=1e-12)
        for other in others:
            self.assert_same_history(other, one, 1e-9)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-9 * one["kinetic_energy"].max())

    def test_whole_turns_count(self):
        """Of springs that are wound up, motors that lag behind by turns, and stops turns apart; after a restart and a static path, too."""
        wheel = """rigid_bodies: [{name: wheel, mass: 2, inertia: [0.1, 0.1, 0.05], center: [0, 0, 0]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], MORE}]
"""
        spring = wheel.replace("MORE", "spring: {stiffness: 5, rest: 6}")
        whole = self.solve(spring, "method: dirk33, step: 1 ms, end: 0.4")
        np.testing.assert_allclose(whole["axle_angle"], 6 * (1 - np.cos(10 * whole["time"])), atol=2e-3)
        np.testing.assert_allclose(whole["kinetic_energy"] + whole["elastic_energy"], 90, rtol=1e-3)
        self.solve(spring + "checkpoint: {}\n", "method: dirk33, step: 1 ms, end: 0.2")
        self.pliant("resume", "out", "--quiet", "--set", "time.end=0.4", ranks=2)
        np.testing.assert_allclose(read_history(self.directory / "out")["axle_angle"], whole["axle_angle"], rtol=1e-9)
        h = self.solve(wheel.replace("MORE", "motor: {target: 20, stiffness: 5, damping: 1}"), "method: bdf2, step: 10 ms, end: 3")
        self.assertAlmostEqual(h["axle_angle"][-1], 20, delta=1e-6)
        np.testing.assert_allclose(h["axle_effort"], 5 * (20 - h["axle_angle"]) - h["axle_rate"], atol=1e-9)
        h = self.solve(wheel.replace("MORE", "motor: {effort: 1}, limits: [-3, 15], limit_stiffness: 100, damping: 0.5"), "method: bdf2, step: 10 ms, end: 12")
        self.assertAlmostEqual(h["axle_angle"][-1], 15 + 1 / 100, delta=0.01)
        h = self.solve(wheel.replace("MORE", "motor: {effort: 12}, spring: {stiffness: 1}"), "method: static, load_steps: 10")
        np.testing.assert_allclose(h["axle_angle"], 1.2 * h["step"], atol=1e-9)
        np.testing.assert_allclose(h["axle_spring"] + h["axle_effort"], 0, atol=1e-8)

    def test_stops_do_not_depend_on_one_another(self):
        """One of them may be far away; both begin smoothly within the same small range."""
        cart = """rigid_bodies: [{name: cart, mass: 1, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0]}]
joints: [{name: rail, type: slider, between: [ground, cart], point: [0, 0, 0], axis: [1, 0, 0], limits: [LOW, 0.01], limit_stiffness: 1e4, motor: {effort: 1}}]
"""
        travel = {low: self.solve(cart.replace("LOW", low), "method: static")["rail_travel"][-1] for low in ("-1", "-1e3", "-1e6")}
        for low, value in travel.items():
            self.assertAlmostEqual(value, travel["-1"], delta=1e-9, msg=low)
            self.assertLess(abs(value - 0.0101), 3e-4, low)

    def test_what_nothing_holds_has_no_equilibrium(self):
        """Far away, rounding errors are as large as the loads; that is no balance."""
        rig = """rigid_bodies:
  - {name: shank, mass: 100 g, inertia: [1e-4, 1e-4, 1e-5], center: [0, 0, 0.08]}
  - {name: arm, mass: 10 g, inertia: [1e-5, 1e-5, 1e-6], center: [0.05, 0, 0.1]}
joints:
  - {name: guide, type: slider, between: [ground, shank], point: [0, 0, 0.08], axis: [0, 0, 1]}
  - {name: knee, type: hinge, between: [shank, arm], point: [0, 0, 0.1], axis: [0, 1, 0], spring: {stiffness: 4}}
loads: [{gravity: [0, 0, -9.81]}]
"""
        for time in ("method: static", "method: quasistatic, step: 10 ms, end: 20 ms"):
            with self.subTest(time):
                self.write("in.yaml", rig + f"time: {{{time}}}\n")
                told = self.pliant("run", "in.yaml", "--output", "out", status=3).stderr
                self.assertIn("nothing holds the bodies against the loads", told)
                self.assertIn("a method with inertia", told)
                self.assertLess(np.abs(read_history(self.directory / "out")["shank_z"]).max(), 1)

    def test_units_are_those_of_an_angle_or_a_travel(self):
        body = "rigid_bodies: [{name: a, mass: 1, inertia: [1, 1, 1], center: [1, 0, 0]}]\n"
        joint = "joints: [{{name: j, type: {}, between: [ground, a], point: [0, 0, 0], axis: [0, 0, 1], spring: {{stiffness: {}, rest: {}}}, motor: {{effort: {}}}, limits: {}, limit_stiffness: {}}}]\n"
        for kind, *given, place in (("hinge", "0.5 N*m/deg", "20 deg", "5 N*m", "[-10 deg, 40 deg]", "1 kN*m/rad", np.deg2rad(30)),
                                    ("slider", "2 N/mm", "3 mm", "4 N", "[0 mm, 1 cm]", "1 kN/mm", 5e-3)):
            with self.subTest(kind):
                h = self.solve(body + joint.format(kind, *given), "method: static")
                np.testing.assert_allclose(h["j_angle" if kind == "hinge" else "j_travel"][-1], place, rtol=1e-6)

    def test_small_bodies_go_far(self):
        """A point on a guide has almost no size; its equilibrium may be anywhere."""
        h = self.solve("""rigid_bodies: [{name: cart, mass: 1, inertia: [1e-10, 1e-10, 1e-10], center: [0, 0, 0]}]
joints: [{name: rail, type: slider, between: [ground, cart], point: [0, 0, 0], axis: [1, 0, 0], motor: {target: 100, stiffness: 100}}]
""", "method: static")
        self.assertAlmostEqual(h["rail_travel"][-1], 100, delta=1e-6)

    def test_kinks_of_motions_are_events(self):
        # The hinge turns at 1 rad/s until 0.033 s, between two nominal steps, and rests from then on.
        h = self.solve(self.chain("hinge", ', motion: "min(t, 0.033)"'), "method: dirk33, step: 10 ms, end: 0.06")
        self.assertIn(0.033, h["time"])
        np.testing.assert_allclose(h["b_angle"], np.minimum(h["time"], 0.033), atol=1e-13)
        self.assertAlmostEqual(h["b_rate"][-1], 0, delta=1e-10)

    def test_stops(self):
        swing = """rigid_bodies: [{name: bob, mass: 1, inertia: [0, 0, 0], center: [1, 0, 0]}]
joints: [{name: pivot, type: hinge, between: [ground, bob], point: [0, 0, 0], axis: [0, 0, 1], limits: [-0.8, 0.4]MORE}]
loads: [{gravity: [0, -9.81, 0]}]
"""
        for method in swept(("backward-euler", "bdf2", "dirk22", "dirk33", "implicit-midpoint"), ("bdf2", "dirk33")):
            with self.subTest(method):
                h = self.solve(swing.replace("MORE", ""), f"method: {method}, step: 5 ms, end: 1")
                self.assertGreater(h["pivot_angle"].min(), -0.84)
                self.assertLess(h["pivot_angle"].min(), -0.8)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-10)
        # Thrown back elastically: it comes up again.
        h = self.solve(swing.replace("MORE", ", limit_stiffness: 1e5"), "method: dirk33, step: 1 ms, end: 1")
        self.assertGreater(h["pivot_angle"].min(), -0.82)
        again = h["pivot_angle"][len(h["time"]) // 2:].max()
        self.assertGreater(again, -0.01)
        with self.subTest("static"):
            pushed = swing.replace("MORE", ", limit_stiffness: 1000, motor: {effort: 2}").replace("loads: [{gravity: [0, -9.81, 0]}]\n", "")
            h = self.solve(pushed, "method: static, load_steps: 2")
            np.testing.assert_allclose(h["pivot_angle"][-1], 0.4 + 2 / 1000 + 0.5e-3, rtol=1e-9)
            np.testing.assert_allclose(h["pivot_stops"], -h["pivot_effort"], rtol=1e-6)
        with self.subTest("far beyond"):
            fast = swing.replace("MORE", ", limit_stiffness: 1")
            self.write("fast.yaml", fast + "time: {method: bdf2, step: 10 ms, end: 1}\n")
            told = self.pliant("run", "fast.yaml", "--quiet").stderr
            self.assertEqual(told.count("joint 'pivot' is beyond its limits by"), 1, told)
            self.write("fast.yaml", fast.replace("0.4]", "1e6]") + "time: {method: bdf2, step: 10 ms, end: 1}\n")
            told = self.pliant("run", "fast.yaml", "--quiet").stderr
            self.assertRegex(told, r"joint 'pivot' is beyond its limits by 0\.\d+ rad")
        with self.subTest("beyond half a turn"):
            wheel = """rigid_bodies: [{name: wheel, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0], angular_velocity: [0, 0, 8]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], limits: [0, 4], damping: 1}]
"""
            h = self.solve(wheel, "method: bdf2, step: 2 ms, end: 1")
            self.assertLess(h["axle_angle"].max(), 4.05)
            self.assertGreater(h["axle_angle"].max(), 4)
        with self.subTest("stops half a turn on both sides"):
            h = self.solve("""rigid_bodies: [{name: wheel, mass: 1, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0], angular_velocity: [0, 0, 10]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], limits: [-3.1, 3.1]}]
""", "method: dirk33, step: 5 ms, end: 1.2")
            self.assertLess(h["axle_angle"].max(), 3.2)
            self.assertLess(h["axle_rate"].min(), -9.7)
            self.assertAlmostEqual(h["axle_angle"].min(), -h["axle_angle"].max(), delta=0.01)

    def test_adaptive_steps_are_as_long_as_the_tolerance_allows(self):
        swing = """rigid_bodies: [{name: bob, mass: 1, inertia: [0.01, 0.01, 0.01], center: [1, 0, 0]}]
joints: [{name: pivot, type: hinge, between: [ground, bob], point: [0, 0, 0], axis: [0, 0, 1]}]
loads: [{gravity: [0, -9.81, 0]}]
"""
        exact = self.solve(swing, "method: dirk33, step: 1 ms, end: 0.5")["pivot_angle"][-1]
        for method, most_steps in swept({"bdf2": 100, "bdf3": 50, "dirk22": 80, "dirk33": 30}.items(), {"bdf2": 100, "dirk22": 80}.items()):
            with self.subTest(method):
                h = self.solve(swing, f"method: {method}, step: 10 ms, end: 0.5, adaptive: {{relative: 1e-3}}")
                self.assertLess(abs(h["pivot_angle"][-1] - exact), 2e-3)
                self.assertLess(len(h["time"]), most_steps)

    def test_joints_that_nothing_moves_do_no_work(self):
        h = self.solve("""rigid_bodies: [{name: wheel, mass: 2, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0], angular_velocity: [0, 0, 30]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1]}]
""", "method: backward-euler, step: 5 ms, end: 0.05")
        lost = h["kinetic_energy"][0] - h["kinetic_energy"][-1]
        self.assertGreater(lost, 1)
        np.testing.assert_allclose(h["numerical_dissipation"][-1], lost, rtol=1e-9)
        self.assertEqual(np.abs(h["load_work"]).max(), 0)

    def test_friction(self):
        wheel = """rigid_bodies: [{name: wheel, mass: 1, inertia: [0.1, 0.1, 0.05], center: [0, 0, 0], angular_velocity: [0, 0, 3]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], friction: 0.2}]
"""
        h = self.solve(wheel, "method: bdf2, step: 10 ms, end: 1")  # it stops at 0.75 s
        t = h["time"]
        np.testing.assert_allclose(h["wheel_wz"], np.maximum(3 - 0.2 / 0.05 * t, 0), atol=5e-3)
        np.testing.assert_allclose(h["dissipated_joint_friction"][-1] / (0.5 * 0.05 * 9), 1, rtol=0.01)
        # What it can hold it holds.
        held = wheel.replace(", angular_velocity: [0, 0, 3]", "").replace("friction: 0.2", "friction: 0.2, motor: {effort: 0.15}")
        h = self.solve(held, "method: dirk22, step: 10 ms, end: 1")
        self.assertLess(abs(h["axle_angle"][-1]), 2e-3)

    def test_friction_where_loads_reverse(self):
        """Springs and dry friction: play operators, within what friction creeps."""
        def play(forces, largest, stiffness):
            x = [0.0]
            for force in forces[1:]:
                x.append(min(max(x[-1], (force - largest) / stiffness), (force + largest) / stiffness))
            return x

        cart = """rigid_bodies: [{name: cart, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0]}]
joints: [{name: rail, type: slider, between: [ground, cart], point: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 100}, friction: 2, stick_rate: RATE}]
loads: [{volume: cart, force: ["5*sin(2*pi*t)", 0, 0]}]
"""
        for rate in (1e-3, 1e-5, 1e-7):
            h = self.solve(cart.replace("RATE", str(rate)), "method: quasistatic, step: 10 ms, end: 1.2")
            self.assertEqual(len(h["time"]), 121, "no step is repeated")
            np.testing.assert_allclose(h["rail_travel"], play(5 * np.sin(2 * np.pi * h["time"]), 2, 100), atol=rate + 1e-8)
        bearings = """rigid_bodies:
  - {name: first, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0]}
  - {name: second, mass: 2, inertia: [1, 1, 1], center: [0, 0, 0.1]}
joints:
  - {name: lower, type: slider, between: [ground, first], point: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 400}, bearing: {friction: 0.2}, stick_rate: RATE}
  - {name: upper, type: slider, between: [first, second], point: [0, 0, 0.1], axis: [1, 0, 0], spring: {stiffness: 300}, bearing: {friction: 0.25}, stick_rate: RATE}
loads: [{gravity: [0, 0, -10]}, {volume: second, force: ["12*sin(2*pi*t)", 0, 0]}]
"""
        for rate in (1e-3, 1e-5, 1e-7):
            h = self.solve(bearings.replace("RATE", str(rate)), "method: quasistatic, step: 10 ms, end: 1.2")
            self.assertEqual(len(h["time"]), 121, "no step is repeated")
            force = 12 * np.sin(2 * np.pi * h["time"])
            np.testing.assert_allclose(h["lower_travel"], play(force, 6, 400), atol=rate + 1e-8)
            np.testing.assert_allclose(h["upper_travel"], play(force, 5, 300), atol=rate + 1e-8)

    def test_bearings_rub_by_the_load_that_they_carry(self):
        with self.subTest("a wheel on a horizontal axle"):
            wheel = """rigid_bodies: [{name: wheel, mass: 4, inertia: [0.1, 0.1, 0.05], center: [0, 0, 0], angular_velocity: [0, 0, 3]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], bearing: {friction: 0.2, radius: 10 mm}}]
loads: [{gravity: [0, -10, 0]}]
"""
            h = self.solve(wheel, "method: dirk33, step: 10 ms, end: 1")
            np.testing.assert_allclose(h["wheel_wz"], 3 - 0.2 * 0.01 * 40 / 0.05 * h["time"], atol=1e-5)
            lost = h["kinetic_energy"][0] - h["kinetic_energy"][-1]
            self.assertAlmostEqual(h["dissipated_bearing_friction"][-1], lost, delta=1e-4 * lost)
            self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-10)
            np.testing.assert_allclose(h["axle_bearing"][1:], -0.2 * 0.01 * 40, rtol=1e-9)
            self.assertEqual(h["axle_bearing"][0], 0)
            # A thrust is carried at the same radius.
            h = self.solve(wheel.replace("[0, -10, 0]", "[0, 0, -10]"), "method: dirk33, step: 10 ms, end: 0.2")
            np.testing.assert_allclose(h["wheel_wz"], 3 - 0.2 * 0.01 * 40 / 0.05 * h["time"], atol=1e-5)
        with self.subTest("a block on a slope"):
            slope, mu = 0.5, 0.3
            down = np.array([np.cos(slope), 0, -np.sin(slope)])
            block = f"""rigid_bodies: [{{name: block, mass: 2, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0]}}]
joints: [{{name: guide, type: slider, between: [ground, block], point: [0, 0, 0], axis: {list(down)}, bearing: {{friction: {mu}MORE}}}}]
loads: [{{gravity: [0, 0, -9.81]}}]
"""
            for method in swept(METHODS, ("dirk33", "implicit-midpoint")):
                h = self.solve(block.replace("MORE", ""), f"method: {method}, step: 10 ms, end: 0.5")
                # Until the rate is many times stick_rate, friction grows.
                np.testing.assert_allclose(np.diff(h["guide_rate"])[3:] / 0.01, 9.81 * (np.sin(slope) - mu * np.cos(slope)), rtol=1e-9)
            h = self.solve(block.replace("MORE", "").replace(f"friction: {mu}", "friction: 0.6"), "method: bdf2, step: 10 ms, end: 1")
            # tan(0.5) < 0.6: it sticks, and creeps.
            self.assertAlmostEqual(h["guide_rate"][-1], 1e-3 * np.arctanh(np.tan(slope) / 0.6), delta=1e-8)
            # A weight at the end of an arm: a couple at two shoes 0.1 m apart, and a torque about the axis.
            arm = block.replace("center: [0, 0, 0]", f"center: {list(0.3 * down)}").replace("MORE", ", length: 0.1")
            h = self.solve(arm, "method: dirk22, step: 1 ms, end: 0.05")
            shoes = abs(0.5 + 0.3 / 0.1) + abs(0.5 - 0.3 / 0.1)
            slope_of_rate = np.diff(h["guide_rate"])[-1] / 1e-3
            self.assertLess(slope_of_rate, 0.1)  # mu shoes cos > sin: it jams
            slight = arm.replace(f"friction: {mu}", "friction: 0.05")
            h = self.solve(slight, "method: dirk22, step: 1 ms, end: 0.2")
            np.testing.assert_allclose(np.diff(h["guide_rate"])[-1] / 1e-3, 9.81 * (np.sin(slope) - 0.05 * shoes * np.cos(slope)), rtol=1e-6)
            aside = block.replace("center: [0, 0, 0]", "center: [0, 0.2, 0]").replace("MORE", ", radius: 0.4")
            h = self.solve(aside, "method: dirk22, step: 1 ms, end: 0.2")
            np.testing.assert_allclose(np.diff(h["guide_rate"])[-1] / 1e-3,
                                       9.81 * (np.sin(slope) - mu * (1 + 0.2 / 0.4) * np.cos(slope)), rtol=1e-6)
        with self.subTest("a pendulum"):
            bob = """rigid_bodies: [{name: bob, mass: 1, inertia: [0, 0, 0], center: [1, 0, 0]}]
joints: [{name: pivot, type: hinge, between: [ground, bob], point: [0, 0, 0], axis: [0, 0, 1], bearing: {friction: 0.3, radius: 0.1}, stick_rate: 0.05}]
loads: [{gravity: [0, -9.81, 0]}]
"""
            h = self.solve(bob, "method: dirk33, step: 2 ms, end: 2")
            np.testing.assert_allclose(h["pivot_angle"], self.pendulum_in_a_bearing(0.03, 0.05, h["time"]), atol=2e-4)

    @staticmethod
    def pendulum_in_a_bearing(lever, stick_rate, times):
        """The angle below the horizontal of a mass point at 1 m from a pin whose friction has the lever mu r (Runge-Kutta)."""
        def acceleration(angle, rate):
            found = -9.81 * np.cos(angle)
            for _ in range(30):  # the load depends on the acceleration
                load = np.hypot(found + 9.81 * np.cos(angle), rate**2 + 9.81 * np.sin(-angle))
                found = -9.81 * np.cos(angle) - lever * load * np.tanh(rate / stick_rate)
            return np.array([rate, found])
        y, result = np.array([0.0, 0.0]), [0.0]
        for start, end in zip(times, times[1:]):
            parts = 4
            dt = (end - start) / parts
            for _ in range(parts):
                a = acceleration(*y)
                b = acceleration(*(y + 0.5 * dt * a))
                c = acceleration(*(y + 0.5 * dt * b))
                d = acceleration(*(y + dt * c))
                y = y + dt / 6 * (a + 2 * b + 2 * c + d)
            result.append(y[0])
        return np.array(result)

    def test_bearings_on_ranks_and_after_a_restart(self):
        text = self.chain("hinge", ", bearing: {friction: 0.2, radius: 0.05, length: 0.1}").replace(
            "axis: [0, 1, 0.2]", "axis: [0, 1, 0.2], bearing: {friction: 0.1, radius: 0.05}")
        time = "method: dirk22, step: 5 ms, end: 0.05"
        one, *others = [self.solve(text, time, ranks) for ranks in (1, 2, *swept((3,), ()))]
        self.assertGreater(one["dissipated_bearing_friction"][-1], 0.002)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-9 * one["kinetic_energy"].max())
        for other in others:
            self.assert_same_history(other, one, 1e-9)
        self.solve(text + "checkpoint: {}\n", time.replace("0.05", "25 ms"))
        self.pliant("resume", "out", "--quiet", "--set", "time.end=0.05")
        self.assert_same_history(read_history(self.directory / "out"), one, 1e-8)

    def test_motions_of_the_bodies_of_a_joint_are_seen(self):
        # A slider on a body that is led: what is recorded is where the bodies are.
        text = """rigid_bodies:
  - {name: base, mass: 1, inertia: [0.1, 0.1, 0.1], center: [0, 0, 0]}
  - {name: cart, mass: 1, inertia: [0.1, 0.1, 0.1], center: [0, 0, 1]}
constraints: [{volume: base, rigid: {translation: ["0.3*t^2", 0, 0], rotation: free}}]
joints: [{name: rail, type: slider, between: [base, cart], point: [0, 0, 1], axis: [1, 0, 0]}]
"""
        h = self.solve(text, "method: dirk33, step: 5 ms, end: 0.2")
        np.testing.assert_allclose(h["rail_travel"], h["cart_x"] - h["base_x"], atol=1e-12)
        np.testing.assert_allclose(h["rail_rate"], h["cart_vx"] - h["base_vx"], atol=1e-11)
        np.testing.assert_allclose(h["base_x"], 0.3 * h["time"] ** 2, atol=1e-12)

    def test_restart_on_more_ranks_than_bodies(self):
        text = self.chain("ball") + "checkpoint: {}\n"
        self.solve(text, "method: bdf2, step: 5 ms, end: 20 ms")
        self.pliant("resume", "out", "--quiet", "--set", "time.end=40ms", ranks=4)
        resumed = read_history(self.directory / "out")
        whole = self.solve(self.chain("ball"), "method: bdf2, step: 5 ms, end: 40 ms")
        self.assert_same_history(resumed, whole, 1e-7)

    def test_loops_close(self):
        crank = """rigid_bodies:
  - {name: crank, mass: 0.5, inertia: [1e-4, 1e-3, 1e-3], center: [0.065818692, 0, 0.035956915]}
  - {name: rod, mass: 1, inertia: [1e-4, 0.017, 0.017], center: [0.353745692, 0, 0.035956915]}
  - {name: slider, mass: 2, inertia: [1e-3, 1e-3, 1e-3], center: [0.575853999, 0, 0]}
joints:
  - {name: shaft, type: hinge, between: [ground, crank], point: [0, 0, 0], axis: [0, -1, 0]MOTION}
  - {name: crankpin, type: ball, between: [crank, rod], point: [0.131637384, 0, 0.071913831]}
  - {name: gudgeon, type: cylindrical, between: [rod, slider], point: [0.575853999, 0, 0], axis: [0, 1, 0]}
  - {name: guide, type: slider, between: [ground, slider], point: [0.575853999, 0, 0], axis: [1, 0, 0]}
"""
        # Driven: the slider's place by its formula. Free under its weight: what it keeps is its energy.
        h = self.solve(crank.replace("MOTION", ', motion: "20*t"'), "method: bdf2, step: 5 ms, end: 0.4")
        angle = 20 * h["time"] + 0.5
        x = 0.15 * np.cos(angle) + np.sqrt(0.45**2 - (0.15 * np.sin(angle)) ** 2)
        np.testing.assert_allclose(h["slider_x"], x, atol=1e-9)
        np.testing.assert_allclose(h["guide_travel"], x - x[0], atol=1e-9)
        h = self.solve(crank.replace("MOTION", "") + "loads: [{gravity: [0, 0, -9.81]}]\n", "method: symplectic-dirk22, step: 2 ms, end: 0.4")
        energy = h["kinetic_energy"] + h["load_potential"]
        self.assertGreater(h["kinetic_energy"].max(), 0.3)
        np.testing.assert_allclose(energy, energy[0], atol=2e-3)

    def test_energy_stays_over_many_steps(self):
        # Three hinges with skew axes and a pendulum, their inputs as they are shipped. What is left is the tolerance of Newton's method.
        for name, step in (("hinge_chain", 2), ("pendulum", 5)):
            text = (ROOT / f"input/verification/{name}.yaml").read_text(encoding="utf-8").split("time:")[0]
            for method in ("implicit-midpoint", "symplectic-dirk22"):
                with self.subTest(name, method=method):
                    h = self.solve(text, f"method: {method}, step: {step} ms, end: {(10000 if LONG else 500) * step * 1e-3}")
                    energy, scale = h["kinetic_energy"] + h["load_potential"], h["kinetic_energy"].max()
                    np.testing.assert_allclose(energy, energy[0], atol=1e-9 * scale)
                    np.testing.assert_allclose(h["numerical_dissipation"], 0, atol=1e-9 * scale)
                    if name == "pendulum":
                        np.testing.assert_allclose(np.hypot(h["bob_x"], h["bob_y"]), 1, atol=1e-13)
                        continue
                    elbow = place(h, "upper", [1, 0, 0], [0.5, 0, 0]) - place(h, "middle", [1, 0, 0], [1.5, 0.1, 0])
                    np.testing.assert_allclose(elbow, 0, atol=1e-13)

    def test_energy_of_springs_does_not_drift(self):
        # Not quadratic: the energy varies by the second power of the step, and stays where it was.
        text = self.chain("ball", "") + """springs:
  - {name: pull, points: [{body: ground, point: [1, 1, 0.5]}, {body: two, point: [2, 0, 0.1]}], stiffness: 40, rest: 0.5}
"""
        variations = []
        for step in (10, 5):
            h = self.solve(text, f"method: implicit-midpoint, step: {step} ms, end: {20 if LONG else 4}")
            energy = h["kinetic_energy"] + h["load_potential"] + h["elastic_energy"]
            variations.append(np.abs(energy - energy[0]).max() / h["kinetic_energy"].max())
            halves = np.array_split(energy - energy[0], 4)
            self.assertLess(abs(halves[3].mean() - halves[1].mean()), variations[-1] * h["kinetic_energy"].max())
        self.assertLess(variations[1], 1e-3)
        self.assertAlmostEqual(variations[0] / variations[1], 4, delta=1)

    def test_moved_joints_have_their_velocities(self):
        for method in swept(METHODS, ("implicit-midpoint", "dirk33")):
            with self.subTest(method):
                h = self.solve(self.chain("hinge", ', motion: "0.5*sin(9*t)"'), f"method: {method}, step: 10 ms, end: 0.2")
                np.testing.assert_allclose(h["b_rate"], 4.5 * np.cos(9 * h["time"]), atol=1e-11)

    def test_bearings_in_loops(self):
        """Other joints determine the rate of a bearing, and there are more bearings than free motions."""

        def lost(h, friction, joint, *forces):
            power = friction * np.hypot(*(h[f"{joint}_{force}"] for force in forces)) * np.abs(h[f"{joint}_rate"])
            return np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(h["time"]))

        crank = (ROOT / "input/verification/slider_crank.yaml").read_text(encoding="utf-8").split("time:")[0]
        h = self.solve(crank.replace("axis: [1, 0, 0]}", "axis: [1, 0, 0], bearing: {friction: 0.1}}"), "method: dirk33, step: 2 ms, end: 0.32")
        self.assertAlmostEqual(h["dissipated_bearing_friction"][-1] / lost(h, 0.1, "guide", "fy", "fz"), 1, delta=5e-3)
        bearing = ", bearing: {friction: 0.1, radius: 0.01}"
        h = self.solve(f"""rigid_bodies:
  - {{name: one, mass: 1, inertia: [0.01, 0.01, 0.01], center: [0, 0.25, 0]}}
  - {{name: bar, mass: 1, inertia: [0.02, 0.02, 0.02], center: [0.4, 0.5, 0]}}
  - {{name: two, mass: 1, inertia: [0.01, 0.01, 0.01], center: [0.8, 0.25, 0]}}
joints:
  - {{name: a, type: hinge, between: [ground, one], point: [0, 0, 0], axis: [0, 0, 1]{bearing}}}
  - {{name: b, type: ball, between: [one, bar], point: [0, 0.5, 0]}}
  - {{name: c, type: cylindrical, between: [bar, two], point: [0.8, 0.5, 0], axis: [0, 0, 1]}}
  - {{name: d, type: hinge, between: [two, ground], point: [0.8, 0, 0], axis: [0, 0, 1]{bearing}}}
loads: [{{gravity: [1, -9.81, 0]}}]
""", "method: dirk33, step: 2 ms, end: 0.1")
        both = sum(lost(h, 1e-3, joint, "fx", "fy") for joint in "ad")
        self.assertAlmostEqual(h["dissipated_bearing_friction"][-1] / both, 1, delta=0.01)

    def test_a_body_that_a_formula_moves_has_its_velocity(self):
        text = """rigid_bodies:
  - {name: a, mass: 1, inertia: [0.01, 0.01, 0.01], center: [0, 0, 0]}
  - {name: b, mass: 1, inertia: [0.01, 0.01, 0.01], center: [0.5, 0, 0]}
joints: [{name: h, type: hinge, between: [a, b], point: [0.2, 0, 0], axis: [0, 0, 1]}]
constraints: [{volume: a, rigid: {translation: ["0.3*sin(5*t)", 0, 0], rotation: free}}]
loads: [{gravity: [0, -9.81, 0]}]
"""
        self.write("in.yaml", text + "time: {method: dirk33, step: 5 ms, end: 0.5}\n")
        self.assertNotIn("forbid", self.pliant("check", "in.yaml").stderr)
        spin = [self.solve(text, f"method: {method}, step: 5 ms, end: 0.5")["a_wz"][-1] for method in ("dirk33", "symplectic-dirk22")]
        self.assertAlmostEqual(spin[1], spin[0], delta=2e-3 * abs(spin[0]))

    def test_starts_that_joints_forbid_are_told(self):
        fist = """rigid_bodies: [{name: fist, mass: 20 g, inertia: [1e-6, 1e-6, 1e-6], center: [0, 0, 0.02]MORE}]
joints: [{name: guide, type: KIND, between: [ground, fist], point: [0, 0, POINT], axis: AXIS}]
"""
        time = "time: {method: bdf2, step: 1 ms, end: 3 ms}\n"

        def told(more="", kind="cylindrical", initial="", point="0.02", axis="[0, 0, 1]"):
            text = fist.replace("MORE", more).replace("KIND", kind).replace("POINT", point).replace("AXIS", axis)
            self.write("in.yaml", text + initial + time)
            return self.pliant("run", "in.yaml", "--quiet").stderr

        places = told(initial="initial: {displacement: [0.001, 0, 0.002]}\n")
        self.assertIn("in.yaml:2", places)
        self.assertIn("moves bodies as their joints forbid: 'guide' of ground and fist by 0.001 m", places)
        self.assertEqual(told(initial="initial: {displacement: [0, 0, 0.002]}\n"), "")
        self.assertEqual(told(", angular_velocity: [0, 0, 20], velocity: [0, 0, 1]"), "")
        self.assertIn("joints forbid the velocities at the start: 'guide' of ground and fist by 2 m/s", told(", velocity: [2, 0, 1]"))
        # About a point beside the center: the velocity that belongs to the rotation is missing.
        beside = told(", angular_velocity: [5, 0, 0]", "hinge", point="0.12", axis="[1, 0, 0]")
        self.assertIn("velocity = angular_velocity x arm", beside)
        self.assertIn("'guide' of ground and fist by 0.5 m/s", beside)
        pair = """rigid_bodies:
  - {name: one, mass: 1, inertia: [0.01, 0.01, 0.01], center: [0, 0, 0]}
  - {name: two, mass: 1, inertia: [0.01, 0.01, 0.01], center: [1, 0, 0]}
joints: [{name: elbow, type: ball, between: [one, two], point: [0.5, 0, 0]}]
initial: {displacement: ["x > 0.5 ? 0.0003 : 0", "x > 0.5 ? 0.0004 : 0", 0]}
"""
        self.write("in.yaml", pair + time)
        self.assertIn("'elbow' of one and two by 0.0005 m", self.pliant("run", "in.yaml", "--quiet").stderr)

    def test_static_searches_that_turn_far(self):
        # A link hangs from its joint, wherever the search begins: almost upright, too.
        joints = {"hinge": "", "universal": ", second_axis: [0, 0, 1]"}
        for joint, start in itertools.product(joints, ([0.5, 0, 0], [0.4, 0.1, -0.3], [0.4, 0, 0.3], [0.05, 0, 0.5])):
            with self.subTest(joint=joint, start=start):
                h = self.solve(f"""rigid_bodies: [{{name: link, mass: 1, inertia: [1e-3, 1e-2, 1e-2], center: {start}}}]
joints: [{{name: top, type: {joint}, between: [ground, link], point: [0, 0, 0], axis: [0, 1, 0]{joints[joint]}}}]
loads: [{{gravity: [0.1, 0, -9.81]}}]
""", "method: static, load_steps: 2")
                np.testing.assert_allclose([h[f"top_f{i}"][-1] for i in "xyz"], [-0.1, 0, 9.81], atol=1e-6)
                self.assertAlmostEqual(h["link_x"][-1] * 9.81, -h["link_z"][-1] * 0.1, delta=1e-6)
                self.assertLess(h["link_z"][-1], 0)

    def test_a_static_search_does_not_stop_at_a_stiff_body(self):
        # The link turns by a quarter turn on a hinge that an elastic block carries, soft or as stiff as steel.
        self.write("block.geo", BLOCK)
        for modulus, held in itertools.product((3e5, 2e11), ("attached", "coupled")):
            with self.subTest(modulus=modulus, held=held):
                h = self.solve(f"""mesh: {{file: block.geo}}
bodies: [{{volume: block, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: {modulus}, poissons_ratio: 0.3}}}}]
constraints: [{{surface: foot, displacement: [0, 0, 0]}}]
rigid_bodies:
  - {{name: hub, center: [0.1, 0.05, 0.05], {held}: [top]}}
  - {{name: arm, mass: 0.3, inertia: [1e-4, 5e-4, 6e-4], center: [0.2, 0.05, 0.05]}}
joints: [{{name: hinge, type: hinge, between: [hub, arm], point: [0.12, 0.05, 0.05], axis: [0, 1, 0]}}]
loads: [{{gravity: [0, 0, -9.81]}}]
""", "method: static")
                self.assertAlmostEqual(abs(h["hinge_angle"][-1]), np.pi / 2, delta=0.3 if modulus < 1e6 else 1e-3)
                self.assertLess(h["newton_iterations"].sum(), 15)

    def test_a_point_of_reference_without_inertia_moves_with_its_surface(self):
        self.write("block.geo", BLOCK)
        h = self.solve("""mesh: {file: block.geo}
bodies: [{volume: block, density: 2000, elasticity: {model: neo-hookean, youngs_modulus: 2e5, poissons_ratio: 0.3}}]
constraints: [{surface: foot, displacement: [0, 0, 0]}]
rigid_bodies:
  - {name: hub, center: [0.1, 0.05, 0.08], coupled: [top]}
  - {name: arm, mass: 0.2, inertia: [1e-3, 1e-3, 1e-3], center: [0.2, 0.05, 0.05]}
joints: [{name: hinge, type: hinge, between: [hub, arm], point: [0.12, 0.05, 0.05], axis: [0, 1, 0]}]
loads: [{gravity: [0.1, 0.5, -9.81]}]
""", "method: bdf2, step: 4 ms, end: 80 ms")
        for place, rate, delta in (("hub_x", "hub_vx", 2e-4), ("hub_z", "hub_vz", 2e-4), ("hinge_angle", "hinge_rate", 5e-3)):
            self.assertAlmostEqual(np.gradient(h[place], h["time"], edge_order=2)[-1], h[rate][-1], delta=delta, msg=rate)

    def test_a_static_search_with_a_motor_ends_below_its_hinge(self):
        # Above it there is another equilibrium, which is unstable and closer to the start.
        for motor in ("effort: 0", "effort: 0.5", "effort: 2", "effort: 3", "target: 0.3, stiffness: 4", "target: 0.3, stiffness: 4, limit: 1.5"):
            with self.subTest(motor=motor):
                h = self.solve(f"""rigid_bodies: [{{name: link, mass: 1, inertia: [1e-3, 1e-2, 1e-2], center: [0.4, 0, 0.3]}}]
joints: [{{name: top, type: hinge, between: [ground, link], point: [0, 0, 0], axis: [0, 1, 0], motor: {{{motor}}}}}]
loads: [{{gravity: [0.1, 0, -9.81]}}]
""", "method: static")
                x, z, effort = (h[name][-1] for name in ("link_x", "link_z", "top_effort"))
                self.assertLess(z, 0)
                self.assertAlmostEqual(effort, -9.81 * x - 0.1 * z, delta=1e-6)
                self.assertLess(h["newton_iterations"].sum(), 15)

    def test_a_given_motion_is_that_of_the_center(self):
        self.write("bar.geo", 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 0.2, 0.05, 0.05};\nMeshSize{ PointsOf{ Volume{1}; } } = 0.05;\n'
                   'Physical Volume("bar") = {1};\nPhysical Surface("left") = {1};\nPhysical Surface("right") = {2};\n')
        h = self.solve("""mesh: {file: bar.geo}
bodies: [{volume: bar, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 3e5, poissons_ratio: 0.3}}]
rigid_bodies: [{name: hub, center: [0.25, 0.02, 0.03], attached: [right]}]
constraints:
  - {surface: left, displacement: [0, 0, 0]}
  - {volume: hub, rigid: {translation: [0.01, 0, 0], rotation: {axis: [1, 0, 0], angle: 60 deg}}}
""", "method: static, load_steps: 2")
        np.testing.assert_allclose([h[f"hub_{i}"][-1] for i in "xyz"], [0.26, 0.02, 0.03], atol=1e-12)

    def test_jumps_of_motions_are_not_called_obstacles(self):
        self.write("in.yaml", self.chain("ball").replace("axis: [0, 1, 0.2]", "axis: [0, 1, 0.2], motion: 't > 0.02 ? 3 : 0'")
                   + "time: {method: dirk33, step: 10 ms, end: 0.05, min_step: 5 ms}\n")
        told = self.pliant("run", "in.yaml", status=3).stderr
        self.assertIn("a prescribed motion, of a surface or of a joint, is too large for one step", told)
        self.assertNotIn("obstacle", told)

    def test_static_analyses_tell_of_free_rotations(self):
        strut = """rigid_bodies:
  - {name: strut, mass: 1, inertia: [1e-3, 1e-2, 1e-2], center: [0.5, 0, 0]}
  - {name: bob, mass: 1, inertia: [1e-3, 1e-3, 1e-3], center: [1, 0, -0.5]}
joints:
  - {name: top, type: ball, between: [ground, strut], point: [0, 0, 0]}
  - {name: tip, type: fixed, between: [strut, bob], point: [1, 0, 0]}
springs: [{name: coil, points: [{body: ground, point: [1, 0, 1]}, {body: HELD, point: [1, 0, 0]}], stiffness: 100}]
loads: [{gravity: [0.1, 0, -9.81]}]
"""
        link = """rigid_bodies: [{name: link, mass: 1, inertia: [1e-3, 1e-2, 1e-2], center: [0.5, 0, 0]}]
joints: [{name: top, type: KIND, between: [ground, link], point: [0, 0, 0]}]
loads: [{gravity: [0.1, 0, -9.81]}]
"""
        time = "time: {method: static}\n"
        for ranks in (1, 2):
            self.write("in.yaml", link.replace("KIND", "ball") + time)
            told = self.pliant("run", "in.yaml", status=2, ranks=ranks).stderr
            self.assertIn("in.yaml:1", told)
            self.assertIn("nothing resists a rotation of 'link' about the axis [1, 0, 0] through the center of mass", told)
        self.write("in.yaml", link.replace("KIND", "ball").replace("between: [ground, link], point: [0, 0, 0]}]", "between: [ground, link], point: [0.5, 0, 0]}]") + time)
        self.assertIn("nothing resists a rotation of 'link' through", self.pliant("check", "in.yaml", status=2).stderr)
        floating = self.chain("hinge").replace("joints:", "  - {name: post, mass: 1, inertia: [1, 1, 1], center: [0, 0, 1]}\njoints:")
        self.write("in.yaml", floating.replace("[ground, one]", "[ground, post]") + time)
        self.assertIn("nothing holds 'one', 'two':", self.pliant("check", "in.yaml", status=2).stderr)
        # A motor without stiffness turns a body and does not hold it.
        driven = link[:link.index("loads:")].replace("KIND", "hinge").replace("point: [0, 0, 0]}]", "point: [0.5, 0, 0], axis: [0, 0, 1], motor: {MOTOR}}]")
        for motor, status in (("effort: 1", 2), ("target: 1, damping: 3", 2), ("effort: 1, stiffness: 10", 0)):
            self.write("in.yaml", driven.replace("MOTOR", motor) + time)
            told = self.pliant("check", "in.yaml", status=status).stderr
            self.assertEqual("nothing resists a rotation of 'link' about the axis [0, 0, 1]" in told, status == 2, told)
        # Held: by joints that leave no such rotation, or by a spring that may hold it.
        held = link.replace("KIND", "universal").replace("point: [0, 0, 0]}]", "point: [0, 0, 0], axis: [0, 1, 0], second_axis: [0, 0, 1]}]")
        h = self.solve(held.replace("[0.1, 0, -9.81]", "[9.81, 0, -1]"), "method: static, load_steps: 2")
        self.assertAlmostEqual(h["link_z"][-1] / h["link_x"][-1], -1 / 9.81, delta=1e-6)
        self.write("in.yaml", strut.replace("HELD", "bob") + time)
        self.pliant("check", "in.yaml")

    def test_a_free_body_keeps_its_momenta(self):
        body = """rigid_bodies:
  - {name: brick, mass: 2, inertia: [0.01, 0.02, 0.025, 0.001, 0, 0.002], center: [1, 2, 3], velocity: [1, -1, 0.5], angular_velocity: [3, 1, 2]}
"""
        for method in ("implicit-midpoint", "symplectic-dirk22", "bdf3"):
            with self.subTest(method):
                h = self.solve(body, f"method: {method}, step: 10 ms, end: 1")
                J = np.array([[0.01, 0.001, 0.002], [0.001, 0.02, 0], [0.002, 0, 0.025]])
                spin = J @ [3, 1, 2] + np.cross([1, 2, 3], 2 * np.array([1, -1, 0.5]))
                np.testing.assert_allclose([h[f"L{a}"][0] for a in "xyz"], spin, rtol=1e-12)
                self.assertAlmostEqual(h["kinetic_energy"][0], 0.5 * 2 * 2.25 + 0.5 * np.array([3, 1, 2]) @ J @ [3, 1, 2], delta=1e-12)
                if method == "bdf3":
                    continue
                for column in ("px", "py", "pz", "Lx", "Ly", "Lz"):
                    np.testing.assert_allclose(h[column], h[column][0], atol=1e-11)

    def test_reactions_carry_the_weight(self):
        # At rest, the ball of a plumb line and a slider across gravity carry weights and moments.
        h = self.solve("""rigid_bodies:
  - {name: beam, mass: 3, inertia: [0.01, 0.1, 0.1], center: [0.5, 0, 0]}
  - {name: bob, mass: 2, inertia: [1e-6, 1e-6, 1e-6], center: [1, 0, -1]}
joints:
  - {name: wall, type: fixed, between: [ground, beam], point: [0, 0, 0]}
  - {name: hook, type: ball, between: [beam, bob], point: [1, 0, 0]}
loads: [{gravity: [0, 0, -10]}]
""", "method: bdf2, step: 10 ms, end: 0.1")
        expected = {"wall_fz": 50, "wall_ty": -3 * 10 * 0.5 - 2 * 10 * 1, "hook_fz": 20, "wall_fx": 0, "hook_tx": 0}
        for column, value in expected.items():
            np.testing.assert_allclose(h[column][1:], value, atol=1e-8, err_msg=column)

    def test_ranks_and_restart_do_not_matter(self):
        self.write("soft.geo", SOFT_MESH)
        texts = (self.chain("universal"), "element: P2\nvolumetric: mixed\n" + SOFT.replace("0.3}", "0.49}"), SOFT)
        for text in swept(texts, texts[::2]):
            time = "method: bdf2, step: 4 ms, end: 40 ms"
            one, *others = [self.solve(text, time, ranks) for ranks in swept((1, 2, 3), (1, 2))]
            for other in others:
                self.assert_same_history(other, one, 1e-7)
        self.write("in.yaml", SOFT + "time: {method: bdf2, step: 4 ms, end: 20 ms}\n")
        self.pliant("run", "in.yaml", "--quiet", "--output", "half", "--set", "checkpoint={}")
        self.pliant("resume", "half", "--quiet", "--set", "time.end=40ms", ranks=2)
        self.assert_same_history(read_history(self.directory / "half"), one, 1e-7)  # of the last text

    def test_soft_bodies_between_rigid_ones_keep_the_order(self):
        self.write("soft.geo", SOFT_MESH)
        self.write("in.yaml", SOFT + "time: {method: bdf2, step: 0.5 ms, end: 8 ms}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", "bdf2,dirk22,dirk33,implicit-midpoint")

    def test_linear_systems_of_mechanisms(self):
        """Conjugate gradients solve them while the mechanism's rows are nearly symmetric, and GMRES what these cannot."""
        self.write("soft.geo", SOFT_MESH)
        self.write("in.yaml", SOFT + "time: {method: bdf2, step: 2 ms, end: 40 ms}\n")
        for file, more, fails in (("in.yaml", "mesh.refine=1", False), (ROOT / "input/coil_spring.yaml", "output.every=0.04", True)):
            with self.subTest(file):
                settings = ["--set", "time.end=40 ms", "--set", "solver.newton.relative=1e-10", "--set", more]
                viewed = self.pliant("run", file, *settings, "-o", "one", "--", "-ksp_view").stdout
                self.assertIn("  type: cg\n", viewed)
                self.assertEqual("  type: fgmres\n" in viewed, fails)
                other = self.pliant("run", file, *settings, "-o", "other", "--", "-ksp_type", "fgmres", "-ksp_view").stdout
                self.assertNotIn("  type: cg\n", other)
                histories = [read_history(self.directory / name) for name in ("one", "other")]
                for history in histories:
                    for work in ("newton_iterations", "linear_iterations", "energy_balance_error"):
                        del history[work]
                self.assert_same_history(*histories, 1e-6)
        # Which of them comes next depends on how often the first has failed; nothing of that outlives a checkpoint.
        self.pliant("run", ROOT / "input/coil_spring.yaml", "--set", "time.end=60 ms", "--set", "checkpoint.every=6", "-o", "whole")
        history = self.directory / "whole/history.csv"
        whole = history.read_text()
        self.pliant("resume", "whole/checkpoint-000006.h5")
        self.assertEqual(history.read_text(), whole)

    def test_rigid_bodies_touch(self):
        self.write("drop.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.4};
Box(2) = {0.3, 0.3, 0.42, 0.4, 0.4, 0.3};
MeshSize{ PointsOf{ Volume{1, 2}; } } = 0.3;
Physical Volume("pad") = {1};
Physical Volume("brick") = {2};
Physical Surface("bottom") = {5};
""")
        h = self.solve("""mesh: {file: drop.geo}
bodies:
  - {volume: pad, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}
  - {volume: brick, density: 2000, rigid: true}
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
contact: {law: barrier, pairs: all, friction: 0.3}
loads: [{gravity: [0, 0, -9.81]}]
""", "method: bdf2, step: 5 ms, end: 0.15")
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertLess(h["brick_vz"].min(), -0.3)
        self.assertGreater(h["brick_vz"].max(), 0.05)

    def test_a_motor_turns_the_root_of_a_soft_body(self):
        """Through a point of reference: a constraint does not have the rotation that the motor needs."""
        write_box(self.directory / "bar.msh", (6, 2, 2), (0.4, 0.05, 0.05))
        soft = """mesh: {file: bar.msh}
bodies:
  - {density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 0.5 MPa, poissons_ratio: 0.4}, viscosity: [{model: kelvin-voigt, shear: 100}]}
ROOT
joints:
  - {name: knuckle, type: hinge, between: [ground, root], point: [0, 0.025, 0.025], axis: [0, 1, 0],
     motor: {target: "0.5*min(t/0.2, 1)", stiffness: 5, damping: 0.1}, limits: [-1, 0.3], limit_stiffness: 100}
"""
        time = "method: bdf2, step: 5 ms, end: 0.3"
        root = "rigid_bodies: [{name: root, center: [0, 0.025, 0.025], attached: [left]}]"
        histories = [self.solve(soft.replace("ROOT", root), time, ranks=ranks) for ranks in (1, 2)]
        for h in histories:
            self.assertGreater(h["knuckle_angle"].max(), 0.3)  # on its stop
            self.assertLess(h["knuckle_angle"].max(), 0.33)
            self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-5 * h["elastic_energy"].max())
        np.testing.assert_allclose(histories[0]["knuckle_effort"], histories[1]["knuckle_effort"], atol=1e-6)

        as_constraint = soft.replace("ROOT", "constraints: [{volume: body, rigid: {}}]").replace("[ground, root]", "[ground, body]")
        self.write("in.yaml", as_constraint + f"time: {{{time}}}\n")
        self.assertIn("a volume by 'rigid: true'", self.pliant("check", "in.yaml", status=2).stderr)

        for name in ("body", "left"):
            named = soft.replace("ROOT", root).replace("- {density", "- {volume: body, density").replace("[ground, root]", f"[ground, {name}]")
            self.write("in.yaml", named + f"time: {{{time}}}\n")
            self.assertRegex(self.pliant("check", "in.yaml", status=2).stderr, f"connects '{name}', which is not a rigid body, .*`attached: \\[surface\\]` or `coupled")

    def test_mistakes_are_told(self):
        chain = self.chain("ball")
        cases = {
            "no body has these moments of inertia": chain.replace("inertia: [0.01, 0.02, 0.03]", "inertia: [0.01, 0.02, 0.04]"),
            "connects 'tow', which is not a rigid body": chain.replace("[one, two]", "[one, tow]"),
            "missing key 'axis' in joints[1]": chain.replace("type: ball", "type: hinge"),
            "repeat or contradict one another: 3 motions that they forbid are forbidden already": chain.replace("loads:", "  - {name: c, type: hinge, between: [one, two], point: [1, 0, 0], axis: [0, 1, 0]}\nloads:"),
            "must be at right angles": chain.replace("type: ball", "type: universal").replace("point: [1, 0, 0], }", "point: [1, 0, 0], axis: [1, 0, 0], second_axis: [1, 1, 0]}"),
            "the bearing of joint 'a' needs the radius of its pin": chain.replace("axis: [0, 1, 0.2]", "axis: [0, 1, 0.2], bearing: {friction: 0.1}"),
            "connects 'one' with itself": chain.replace("[one, two]", "[one, one]"),
            "'motion' can only be given with": chain.replace("point: [1, 0, 0], }", 'point: [1, 0, 0], motion: "t"}'),
            "is given twice": chain.replace("name: two", "name: one"),
            "begins at 0.5": chain.replace("type: ball", "type: hinge").replace("point: [1, 0, 0], }", 'point: [1, 0, 0], axis: [0, 0, 1], motion: "0.5+t"}'),
            "the points of joint 'b' are one": chain.replace("type: ball", "type: distance").replace("point: [1, 0, 0], }", "point: [1, 0, 0], second_point: [1, 0, 0]}"),
            "is not finite": chain.replace("type: ball", "type: hinge").replace("point: [1, 0, 0], }", 'point: [1, 0, 0], axis: [0, 0, 1], motor: {effort: "1/t"}}'),
            "names what does not move": chain.replace("name: one,", "name: ground,"),
            "has no moment of inertia": chain.replace("inertia: [0.02, 0.03, 0.04, 0.005, 0, 0.002]", "inertia: [0, 0, 0]"),
            "whose rotation is lost in rounding errors": chain.replace("inertia: [0.02, 0.03, 0.04, 0.005, 0, 0.002]", "inertia: [1e-20, 1e-20, 1e-20]"),
            "no surface that could touch": chain + "contact: {law: barrier, pairs: all}\n",
            "outside of its limits": chain.replace("type: ball", "type: slider").replace("point: [1, 0, 0], }", 'point: [1, 0, 0], axis: [0, 0, 1], limits: [1, 2]}'),
            "the first must be smaller": chain.replace("type: ball", "type: slider").replace("point: [1, 0, 0], }", 'point: [1, 0, 0], axis: [0, 0, 1], limits: [1, -2]}'),
            "only one of motion, limits can be given": chain.replace("type: ball", "type: slider").replace("point: [1, 0, 0], }", 'point: [1, 0, 0], axis: [0, 0, 1], limits: [-1, 2], motion: "t"}'),
            "'inertia' must be a list of 3 principal moments or of 6 numbers xx, yy, zz, xy, yz, zx, not of 5": chain.replace("inertia: [0.01, 0.02, 0.03]", "inertia: [0.01, 0.02, 0.03, 5e-3,0]"),
            "at least one of stiffness, damping, effort is needed": chain.replace("type: ball", "type: hinge").replace("point: [1, 0, 0], }", "point: [1, 0, 0], axis: [0, 0, 1], motor: {target: 1}}"),
            "missing key 'mesh'": chain + "bodies: [{density: 1, rigid: true}]\n",
        }
        for message, text in cases.items():
            with self.subTest(message):
                self.write("in.yaml", text + "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
                for ranks in swept((1, 2), (1,)):
                    self.assertIn(message, self.pliant("check", "in.yaml", ranks=ranks, status=2).stderr)


if __name__ == "__main__":
    unittest.main()
