#!/usr/bin/python3
"""Loads: their resultants and work, springs and dashpots to the ground; what the ledger makes of them."""
import unittest

import numpy as np

from program import ProgramTest, read_history, swept, write_box

# A bar of 1 m x 0.2 m x 0.2 m with the groups that a table of sides does not have: a curve and a point.
BAR = """
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 0.2, 0.2};
e = 1e-6;
left() = Surface In BoundingBox{-e, -e, -e, e, 1, 1};
right() = Surface In BoundingBox{1 - e, -e, -e, 1 + e, 1, 1};
edge() = Curve In BoundingBox{1 - e, -e, 0.2 - e, 1 + e, 1, 1};
corner() = Point In BoundingBox{1 - e, -e, -e, 1 + e, e, e};
Physical Volume("body") = {1};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Curve("edge") = {edge()};
Physical Point("corner") = {corner()};
"""
HELD = """
mesh: {file: bar.geo, size: 0.2}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
solver: {newton: {relative: 1e-11}}
"""
FREE = """
mesh: {file: block.msh}
bodies: [{density: 1000, elasticity: {model: linear, youngs_modulus: MODULUS, poissons_ratio: 0}}]
probes: [{name: tip, point: [1, 0, 0]}]
solver: {newton: {relative: 1e-11}}
"""
METHODS = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk33", "implicit-midpoint", "dirk23", "symplectic-dirk22")
PETSC_METHODS = ("petsc:alpha2", "petsc:bdf", "petsc:arkimex")


class Loads(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "block.msh", (5, 1, 1), (1, 0.2, 0.2))
        self.write("bar.geo", BAR)

    def history(self, text, *settings, **more):
        return self.run_input(self.write("in.yaml", text), *settings, **more)

    def test_the_support_holds_what_the_loads_exert(self):
        loads = (("{force_density: [0, 0, -500]}", -500 * 0.04), ("{curve: edge, line_force: [0, 0, 30]}", 6),
                 ("{point: corner, force: [0, 0, 3]}", 3), ("{surface: right, force: [0, 0, 7]}", 7),
                 ("{curve: edge, force: [0, 0, 2 N]}", 2), ('{force_density: [0, 0, "1e3*x*t"]}', 0))
        for element, usually in (("P1", loads[::2]), ("P2", loads[1::2])):
            for load, force in swept(loads, usually):
                with self.subTest(load, element=element):
                    h = self.history(HELD + f"element: {element}\nloads: [{load}]\ntime: {{method: static}}\n")
                    self.assertAlmostEqual(h["left_fz"][-1], -force, delta=1e-8 * max(abs(force), 1))

    def test_bodies_rest_when_loads_are_gone(self):
        """Each step comes nearer to 0, to numbers that single precision has not; a resumed run goes on from such a state."""
        for element, law, load in (("P1", "neo-hookean", '{surface: right, traction: [0, 0, "t < 0.15 ? 100 : 0"]}'), ("P2", "linear", '{surface: right, traction: [0, 0, "t < 0.15 ? 1e-3 : 0"]}'),
                                   ("P1", "neo-hookean", '{surface: right, pressure: "t < 0.15 ? 100 : 0"}')):
            with self.subTest(element, law=law, load=load):
                text = HELD.replace("neo-hookean", law).replace("solver: {newton: {relative: 1e-11}}", f"element: {element}\nloads: [{load}]\ncheckpoint: {{}}\n")
                h = self.history(text + "time: {method: quasistatic, step: 0.1, end: 1}\n")
                self.assertGreater(h["elastic_energy"][1], 0)
                self.assertLess(h["elastic_energy"][-1], 1e-12 * h["elastic_energy"][1])
                self.assertEqual(h["newton_iterations"][-3:].sum(), 0)
                self.pliant("resume", "out", "--quiet", "--set", "time.end=1.5", ranks=2)
                self.assertAlmostEqual(read_history(self.directory / "out")["time"][-1], 1.5)

    def test_the_books_balance_on_any_number_of_ranks(self):
        loads = ('loads: [{force_density: ["200*x", 0, "-300*sin(9*t)"]}, {curve: edge, line_force: [0, 40, 0]}, '
                 '{point: corner, force: ["2*cos(5*t)", 0, 0]}, {surface: right, force: [0, "3*t", 4]}, '
                 "{surface: right, spring: 1e4, dashpot: 500}, {point: corner, point_spring: 100, point_dashpot: 4}]\n")
        text = HELD + loads + "time: {method: dirk22, step: 5 ms, end: 0.2}\n"
        alone = self.history(text)
        scale = max(np.abs(alone[n]).max() for n in ("elastic_energy", "load_work", "load_potential"))
        np.testing.assert_allclose(alone["energy_balance_error"], 0, atol=1e-7 * scale)
        self.assertGreater(alone["dissipated_foundation"][-1], 0.01 * scale)
        # The method's own loss is of its order.
        self.assertLess(np.abs(alone["numerical_dissipation"]).max(), 0.05 * scale)
        short = ("time.end=0.04",)
        self.assert_same_history(self.history(text, *short), self.history(text, *short, ranks=2), 1e-7)

    # A bar of stiffness E A / l between a spring k A and the force T A: it stretches by T l / E and moves by T / k.
    def test_a_pulse_gives_its_impulse(self):
        """A load that jumps at an event acts from there on, not in the step that ends there: with every method."""
        for begins, ends, methods in ((">=", "<", (*METHODS, *PETSC_METHODS)), (">", "<=", PETSC_METHODS)):
            text = FREE.replace("MODULUS", "1e8") + f"""loads: [{{where: "x > 0.999", traction: ["1e5*(t {begins} 0.5)*(t {ends} 0.507)", 0, 0]}}]
time: {{method: bdf2, step: 0.1, end: 1}}
"""
            for method in swept(methods, methods[::2]):
                with self.subTest(method, begins=begins):
                    h = self.history(text, f"time.method={method}")
                    np.testing.assert_allclose(h["px"][-1], 1e5 * 0.04 * 0.007, rtol=1e-6)

    def test_a_bar_on_springs(self):
        text = FREE.replace("MODULUS", "1e6") + "time: {method: static}\n"
        text += "constraints: [{surface: front, displacement: [free, 0, 0]}]\n"
        text += "loads: [{surface: left, spring: 5e4 Pa/m, direction: DIRECTION}, {surface: right, traction: [1 kPa, 0, 0]}]\n"
        for direction in ("all", "normal"):
            h = self.history(text.replace("DIRECTION", direction))
            self.assertAlmostEqual(h["tip_x"][-1] - 1, 1e3 / 1e6 + 1e3 / 5e4, delta=1e-9)
            # What the springs and the bar have stored is half of what the final force would have done along the way.
            stored = 0.5 * 40 * (1e3 / 1e6 + 1e3 / 5e4)
            self.assertAlmostEqual(h["elastic_energy"][-1], stored, delta=1e-9 * stored)

    # So stiff a bar moves as a whole: m v' = -c A v.
    def test_dashpots_brake_a_body(self):
        text = FREE.replace("MODULUS", "1e9") + "initial: {velocity: [0.5, 0, 0]}\n"
        text += "loads: [{surface: left, dashpot: 2 kPa*s/m}]\ntime: {method: bdf2, step: 5 ms, end: 1}\n"
        h = self.history(text)
        rate = 2e3 * 0.04 / (1000 * 0.04)
        np.testing.assert_allclose(h["px"] / 40, 0.5 * np.exp(-rate * h["time"]), atol=5e-5)  # bdf2: (rate dt)^2 / 3
        lost = h["kinetic_energy"][0] - h["kinetic_energy"][-1]
        self.assertAlmostEqual(h["dissipated_energy"][-1], lost, delta=2e-3 * lost)

    def test_dashpots_do_nothing_to_an_equilibrium(self):
        text = HELD + "time: {method: static}\nloads: [{surface: right, dashpot: 1e3}, {surface: right, traction: [0, 0, 10]}]\n"
        done = self.call("run", self.write("in.yaml", text), "--output", "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("dashpots have no effect", done.stdout)


if __name__ == "__main__":
    unittest.main()
