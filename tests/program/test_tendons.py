#!/usr/bin/python3
"""Tendons, as users type them: known motions, the capstan equation, slack, ledgers, orders, ranks, restart, mistakes."""
import unittest

import numpy as np

from program import LONG, ProgramTest, read_history, swept, write_box

FINGER = """mesh: {file: finger.msh}
element: P2
bodies: [{density: 1000, elasticity: {model: fixed-corotated, youngs_modulus: 1 MPa, poissons_ratio: 0}}]
constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: right, rigid: {rotation: free}}]
tendons: [{name: flexor, points: [POINTS], PULLED}]
probes: [{name: tip, point: [0.1, 0.005, 0.005]}]
"""
# Two links on hinges, and a tendon from the ground over places on them to the tip, whose points are outside the bodies.
LINKS = """rigid_bodies:
  - {name: one, mass: 1, inertia: [0.01, 0.08, 0.08], center: [0.5, 0, 0]}
  - {name: two, mass: 0.5, inertia: [0.01, 0.04, 0.04], center: [1.5, 0, 0]}
joints:
  - {name: a, type: hinge, between: [ground, one], point: [0, 0, 0], axis: [0, -1, 0], damping: 0.2}
  - {name: b, type: hinge, between: [one, two], point: [1, 0, 0], axis: [0, -1, 0.1], spring: {stiffness: 2}}
tendons:
  - name: cord
    points:
      - {body: ground, point: [-0.2, 0, 0.2]}
      - {body: one, point: [0.3, 0, 0.3]}
      - {body: one, point: [0.8, 0, 0.2]}
      - {body: two, point: [1.2, 0, 0.3]}
      - {body: two, point: [1.9, 0, 0.1]}
    PULLED
loads: [{gravity: [0, 0, -9.81]}]
"""
# A cord over half a circle of 7 chords that lifts a body against a spring.
CAPSTAN = """rigid_bodies: [{name: weight, mass: 1, inertia: [1, 1, 1], center: [1, 0, -2]}]
joints: [{name: rail, type: slider, between: [ground, weight], point: [1, 0, -2], axis: [0, 0, 1], spring: {stiffness: 10}}]
tendons:
  - name: cord
    points: [POINTS, {body: weight, point: [1, 0, -2]}]
    friction: 0.3
    stick_velocity: 0.1 mm/s
    PULLED
"""
HALF_CIRCLE = [(-1, -2)] + [(-np.cos(a), np.sin(a)) for a in np.linspace(0, np.pi, 8)]


class Tendons(ProgramTest):
    def finger(self, pulled, count=41):
        points = ", ".join(f"[{x:.4f}, 0.005, 0.001]" for x in np.linspace(0, 0.1, count))
        return FINGER.replace("POINTS", points).replace("PULLED", pulled)

    def capstan(self, pulled):
        points = ", ".join(f"{{body: ground, point: [{x:.9f}, 0, {z:.9f}]}}" for x, z in HALF_CIRCLE)
        return CAPSTAN.replace("POINTS", points).replace("PULLED", pulled)

    def test_a_given_tension_bends_a_finger(self):
        # On an offset d from the middle: curvature T d / EI, length 1 - T / EA.
        text = self.finger('tension: "1*min(t, 1)"')
        write_box(self.directory / "finger.msh", (20, 2, 2), (0.1, 0.01, 0.01))
        one, *others = [self.solve(text, "method: static, end: 1, load_steps: 4", ranks) for ranks in swept((1, 2), (1,))]
        for other in others:
            for column in ("tip_x", "tip_z", "flexor_length", "elastic_energy"):  # the others are zero but for rounding
                np.testing.assert_allclose(other[column], one[column], rtol=1e-7, err_msg=column)
        np.testing.assert_allclose(one["tip_x"][-1], 95.24195e-3, rtol=0.001)
        np.testing.assert_allclose(0.005 - one["tip_z"][-1], 23.30730e-3, rtol=0.003)
        pull = one["flexor_length"][0] - one["flexor_length"][-1]
        np.testing.assert_allclose(pull, 2.92e-3, rtol=0.003)
        np.testing.assert_allclose(one["flexor_tension"], [0, 0.25, 0.5, 0.75, 1])
        for load in ('tension: "1*min(t, 1)"', "tension: 1"):  # the work of one that turns with the finger, in few steps
            for steps in (2, 4):
                h = self.solve(self.finger(load), f"method: static, end: 1, load_steps: {steps}")
                T, length = h["flexor_tension"], h["flexor_length"]
                np.testing.assert_allclose(h["load_work"][-1], -0.5 * (T[1:] + T[:-1]) @ np.diff(length), rtol=1e-9)
                np.testing.assert_allclose(h["load_work"][-1], h["elastic_energy"][-1], rtol=0.02)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * h["elastic_energy"].max())
        # The same place is reached by the pull that belongs to it.
        k = 1e4
        pulled = self.finger(f"pull: {pull + 1 / k}, stiffness: {k}")
        h = self.solve(pulled, "method: static, load_steps: 4")
        np.testing.assert_allclose(h["flexor_tension"][-1], 1, rtol=1e-6)
        np.testing.assert_allclose(h["tip_z"][-1], one["tip_z"][-1], rtol=1e-6)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * h["elastic_energy"].max())

    def test_every_method_keeps_its_order(self):
        write_box(self.directory / "finger.msh", (20, 2, 2), (0.1, 0.01, 0.01))
        kinds = ('tension: "(20*t)^4"', 'pull: "0.5*(20*t)^4", stiffness: 20')
        for pulled in swept(kinds, kinds[1:]):
            with self.subTest(pulled):
                self.write("in.yaml", self.finger(pulled).replace("P2", "P1") + "time: {method: bdf2, step: 0.5 ms, end: 8 ms}\n")
                self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", "bdf2,dirk22")
        for pulled in ('pull: "0.1*t^2", stiffness: 500', 'tension: 40 + t, friction: 0.3, stick_velocity: 10'):
            with self.subTest(pulled):
                text = LINKS.replace("PULLED", "\n    ".join(pulled.split(", ")))
                self.write("in.yaml", text + "time: {method: bdf2, step: 10 ms, end: 0.16}\n")
                self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", "bdf2,dirk22,dirk33")

    def test_ledger_closes(self):
        # What the method loses of the energies of states, the works of drive and friction included, is of its order.
        for pulled in ('pull: "0.05*sin(5*t)", stiffness: 500', 'pull: "0.1*sin(5*t)", stiffness: 500, friction: 0.3'):
            text = LINKS.replace("PULLED", "\n    ".join(pulled.split(", ")))
            with self.subTest(pulled):
                lost = []
                for step in (10, 5):
                    h = self.solve(text, f"method: dirk22, step: {step} ms, end: 0.6")
                    scale = h["kinetic_energy"].max()
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * scale)
                    lost.append(np.abs(h["numerical_dissipation"]).max() / scale)
                self.assertLess(lost[0], 1e-3)
                self.assertLess(lost[1], 0.4 * lost[0])
                if "friction" in pulled:
                    self.assertGreater(h["dissipated_tendon_friction"][-1], 0.1)
                    self.assertGreaterEqual(np.diff(h["dissipated_tendon_friction"]).min(), 0)

    def test_a_tendon_alone_holds_a_body_at_rest(self):
        write_box(self.directory / "bar.msh", (2, 1, 1), (0.4, 0.1, 0.1))
        text = '''
mesh: {file: bar.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
constraints: [{volume: body, displacement: [0, 0, free]}]
tendons: [{name: rope, points: [{body: ground, point: [0.2, 0.05, 0.3]}, [0.2, 0.05, 0.1]], pull: 0, stiffness: 1e4}]
loads: [{gravity: [0, 0, -9.81]}]
'''
        h = self.solve(text, "method: static")
        self.assertAlmostEqual(h["rope_tension"][-1], 1000 * 4e-3 * 9.81, delta=1e-5)

    def test_a_tendon_becomes_slack(self):
        # The drive lets go of 0.1 m at once: the links fall until the tendon is taut again.
        h = self.solve(LINKS.replace("PULLED", 'pull: "-0.1*min(t/0.05, 1)"\n    stiffness: 500'), "method: bdf2, step: 10 ms, end: 0.6")
        tension = 500 * np.maximum(0, h["cord_length"] - h["cord_length"][0] - 0.1 * np.minimum(h["time"] / 0.05, 1))
        np.testing.assert_allclose(h["cord_tension"], tension, atol=1e-9)
        self.assertEqual(h["cord_tension"][5], 0)
        self.assertGreater(h["cord_tension"].max(), 10)

    def test_a_string_does_not_push(self):
        self.write("push.yaml", """rigid_bodies: [{name: cart, mass: 1, inertia: [1, 1, 1], center: [1, 0, 0]}]
joints: [{name: rail, type: slider, between: [ground, cart], point: [1, 0, 0], axis: [1, 0, 0]}]
tendons: [{name: cord, points: [{body: ground, point: [0, 0, 0]}, {body: cart, point: [1, 0, 0]}], tension: "-100*t"}]
time: {method: dirk33, step: 10 ms, end: 0.1}
""")
        told = self.pliant("run", "push.yaml", "--quiet").stderr
        self.assertEqual(told.count("a string does not push: it is slack"), 1, told)
        h = read_history(self.directory / "out/push")
        self.assertEqual(np.abs(h["rail_travel"]).max(), 0)
        self.assertEqual(np.abs(h["cord_tension"]).max(), 0)

    def test_friction_is_that_of_a_capstan(self):
        ratio = np.exp(0.3 * np.pi)
        # Pulled at 10 mm/s, then let go: the tension at the far end is smaller by the ratio, and then larger.
        h = self.solve(self.capstan('tension: "10*min(t, 2 - t)"'), "method: quasistatic, step: 10 ms, end: 1.9")
        beyond = 10 * h["rail_travel"]
        early, late = h["time"] < 1.005, h["time"] > 1.855
        np.testing.assert_allclose(h["cord_tension"][early][1:] / beyond[early][1:], ratio, rtol=1e-6)
        np.testing.assert_allclose(beyond[late] / h["cord_tension"][late], ratio, rtol=1e-6)
        np.testing.assert_allclose(h["cord_anchor_tension"][1:], beyond[1:], rtol=1e-6)
        stuck = (h["time"] > 1.05) & (h["time"] < 1.8)  # until the tension has fallen by the ratio squared
        np.testing.assert_allclose(beyond[stuck], 10 / ratio, rtol=1e-3)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-8)
        self.assertGreaterEqual(np.diff(h["dissipated_tendon_friction"]).min(), 0)
        # By a pull.
        h = self.solve(self.capstan('pull: "0.5*t"\n    stiffness: 1000'), "method: quasistatic, step: 50 ms, end: 1")
        np.testing.assert_allclose(h["cord_tension"][1:] / (10 * h["rail_travel"][1:]), ratio, rtol=1e-6)

    def test_ranks_and_restart_do_not_matter(self):
        write_box(self.directory / "finger.msh", (8, 1, 1), (0.1, 0.01, 0.01))
        kinds = ('pull: "5*t", stiffness: 200', 'pull: "5*t", stiffness: 200, friction: 0.3')
        for pulled in swept(kinds, kinds[1:]):
            with self.subTest(pulled):
                text = self.finger(pulled, 11).replace("P2", "P1")
                text = text.replace("[0.0500, 0.005, 0.001]", "[0.0500, 0.005, 0.009]")  # a zigzag, for friction
                one, two = [self.solve(text, "method: bdf2, step: 1 ms, end: 6 ms", ranks) for ranks in (1, 2)]
                self.write("in.yaml", text + "time: {method: bdf2, step: 1 ms, end: 3 ms}\n")
                self.pliant("run", "in.yaml", "--quiet", "--output", "half", "--set", "checkpoint={}", ranks=2)
                self.pliant("resume", "half", "--quiet", "--set", "time.end=6ms", ranks=1)
                for other in (two, read_history(self.directory / "half")):
                    for column in ("tip_x", "tip_z", "flexor_length", "flexor_tension", "elastic_energy", "kinetic_energy"):
                        scale = np.abs(one[column]).max()
                        np.testing.assert_allclose(other[column], one[column], atol=1e-6 * scale, err_msg=column)

    def test_points_follow_a_curve(self):
        # A curve in the mesh, and one that is none of its edges; from either end.
        self.write("beam.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 0.2, 0.2};
Point(101) = {0.1, 0.03, 0.15}; Point(102) = {0.5, 0.03, 0.15}; Point(103) = {0.9, 0.07, 0.15};
Line(101) = {101, 102}; Line(102) = {102, 103};
MeshSize{ PointsOf{ Volume{1}; } } = 0.2;
MeshSize{ 101, 102, 103 } = 0.1;
Physical Volume("beam") = {1};
Physical Surface("left") = {1};
Physical Curve("edge") = {9};
Physical Curve("cord") = {101, 102};
Physical Curve("split") = {9, 102};
Physical Curve("ring") = {1, 2, 3, 4};
Physical Curve("fork") = {1, 4, 9};
""")
        text = """mesh: {file: beam.geo}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 10 kPa, poissons_ratio: 0.3}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
tendons: [{name: cord, curve: cord, tension: 2 N, MORE}]
probes: [{name: tip, point: [1, 0, 0]}]
"""
        static = "method: static"
        h = self.solve(text.replace(", MORE", ""), static)
        np.testing.assert_allclose(h["cord_length"][0], 0.4 + np.hypot(0.4, 0.04), rtol=1e-9)
        self.assertLess(h["cord_length"][-1], 0.998 * h["cord_length"][0])
        edge = text.replace(", MORE", "").replace("curve: cord", "curve: edge")
        here = self.solve(edge, static)
        np.testing.assert_allclose(here["cord_length"][0], 1, rtol=1e-9)
        shown = self.pliant("check", "in.yaml").stdout
        self.assertRegex(shown, r"cord: \d+ points, 1 m long, turns by \S+ rad")
        # Pliant's own format has the edges, though not their direction.
        self.pliant("mesh", "convert", "beam.geo", "beam.h5")
        own = edge.replace("beam.geo", "beam.h5")
        np.testing.assert_allclose(self.solve(own, static, 2)["cord_length"], here["cord_length"], rtol=1e-6)
        cases = {
            "no curve 'cords' in the mesh": text.replace("curve: cord", "curve: cords"),
            "physical curve 'ring', which tendon 'cord' follows, is closed": text.replace("curve: cord", "curve: ring"),
            "branches at": text.replace("curve: cord", "curve: fork"),
            "consists of 2 pieces": text.replace("curve: cord", "curve: split"),
            "have no directions in Pliant's own mesh format": own.replace("tension:", "friction: 0.1, tension:"),
        }
        for message, wrong in cases.items():
            with self.subTest(message):
                self.write("in.yaml", wrong.replace(", MORE", "") + "time: {method: static}\n")
                ranks = 2 if LONG or "directions" in message else 1
                self.assertIn(message, self.pliant("check", "in.yaml", ranks=ranks, status=2).stderr)
        self.solve(own.replace("tension:", "pulled_at: [0, 0, 0], friction: 0.1, tension:"), "method: quasistatic, step: 0.1, end: 0.1")

    def test_mistakes_are_told(self):
        links = LINKS.replace("PULLED", "tension: 1")
        chain = links[:links.index("tendons:")]
        cases = {
            "the same point twice": chain + "tendons: [{name: cord, points: [[0.5, 0, 0], [0.5, 0, 0]], tension: 1}]\n",
            "and there is no mesh: name its body": chain + "tendons: [{name: cord, points: [[0.5, 0, 0], [9, 9, 9]], tension: 1}]\n",
            "which is not a rigid body": links.replace("body: two, point: [1.9", "body: tow, point: [1.9"),
            "all points of tendon 'cord' are fixed in 'one': it moves nothing": links.replace("body: ground", "body: one").replace("body: two", "body: one"),
            "'points' must be a list of at least 2 entries, not of 1": chain + "tendons: [{name: cord, points: [[0.5, 0, 0]], tension: 1}]\n",
            "it moves nothing": links.replace("body: one", "body: ground").replace("body: two", "body: ground"),
            "one of tension, pull is needed": LINKS.replace("PULLED", "friction: 0"),
            "only one of tension, pull can be given": links.replace("tension: 1", "tension: 1\n    pull: 1"),
            "missing key 'stiffness'": links.replace("tension: 1", "pull: t"),
            "'pulled_at' can only be given with 'curve'": links.replace("tension: 1", "tension: 1\n    pulled_at: [0, 0, 0]"),
            "the pull of tendon 'cord' is not finite": links.replace("tension: 1", 'pull: "1/t"\n    stiffness: 1'),
        }
        for message, text in cases.items():
            with self.subTest(message):
                self.write("in.yaml", text + "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
                for ranks in swept((1, 2), (1,)):
                    self.assertIn(message, self.pliant("check", "in.yaml", ranks=ranks, status=2).stderr)


if __name__ == "__main__":
    unittest.main()
