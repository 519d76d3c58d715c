#!/usr/bin/python3
"""Runs that make energy say so, before they start where it is certain, and at their end, and those that lose much; sound ones say nothing."""
import json
import re
import unittest

from program import ProgramTest, write_box

SPIN = """mesh: {file: cube.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: %s, poissons_ratio: 0.3}}]
initial: {velocity: ["-6.3*(y - 0.05)", "6.3*(x - 0.05)", 0]}
time: {method: %s, step: %s, end: 0.5}
output: {every: 1}
"""
BOUNCE = """mesh: {file: cube.msh, scale: 10}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}%s}]
loads: [{gravity: [0, 0, -9.81]}]
contact: {obstacles: [{name: floor, shape: plane, point: [0, 0, -0.03], normal: [0, 0, 1]}]}
time: {method: %s, step: 4 ms, end: %s}
output: {every: 100}
"""
FALL = """mesh: {file: cube.msh, scale: 10}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 10 kPa, poissons_ratio: 0.3}}]
constraints: [{where: "z > 0.99", displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: %s, step: %s, end: %s}
output: {every: 100}
"""
AHEAD, BEHIND = "times the energy of the rotation", "the energy grew without work"


class EnergyGrowth(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "cube.msh", (2, 2, 2), (0.1, 0.1, 0.1))

    def log(self, text, ranks=1):
        done = self.call("run", self.write("in.yaml", text), "--output", "out", "--quiet", ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr, json.loads((self.directory / "out/summary.json").read_text())

    def test_stiff_bodies_that_turn(self):
        for method, step, ranks in (("implicit-midpoint", "10 ms", 1), ("symplectic-dirk22", "25 ms", 2), ("dirk23", "10 ms", 1)):
            with self.subTest(method):
                told, summary = self.log(SPIN % ("1 GPa", method, step), ranks)
                self.assertEqual(told.count(AHEAD), 1, told)
                self.assertEqual(told.count(BEHIND), 1, told)
                self.assertGreater(summary["energy_growth"]["factor"], 10)

    def test_sound_runs_say_nothing(self):
        for young, method, step in (("10 MPa", "symplectic-dirk22", "10 ms"), ("100 kPa", "implicit-midpoint", "10 ms"),
                                    ("1 GPa", "dirk33", "10 ms"), ("1 GPa", "bdf2", "10 ms")):
            with self.subTest(method):
                told, summary = self.log(SPIN % (young, method, step))
                self.assertNotIn(AHEAD, told)
                self.assertNotIn(BEHIND, told)
                self.assertNotIn("energy_growth", summary)

    def test_steps_that_are_too_long_for_the_motion(self):
        lost = r"warning: \S*in.yaml:5:16: 'bdf2' with steps of 1 s dissipated \S+ J, (\d+) % of the energy supplied .*: the steps are too long"
        told, summary = self.log(FALL % ("bdf2", 1, 10))
        self.assertTrue(25 < float(re.search(lost, told)[1]) < 50, told)
        self.assertEqual(["warning: " + line for line in summary["warnings"]], told.splitlines())
        for method, step, end in (("bdf2", "10 ms", 1), ("implicit-midpoint", "50 ms", 1)):
            self.assertEqual(self.log(FALL % (method, step, end))[0], "")
        # Backward Euler damps, and finds a state of rest so; impacts are shorter than steps.
        self.assertEqual(self.notes(FALL % ("backward-euler", 0.5, 0.5)), ["methods of the first order damp"])
        self.assertEqual(self.notes(FALL % ("backward-euler", 1, 40)), ["the state of rest at the end"])
        self.assertEqual(self.notes(BOUNCE.replace("4 ms", "20 ms") % ("", "bdf2", 0.8)), ["impacts shorter than a step"])
        thrown = (FALL % ("backward-euler", 0.1, 0.2)).replace("loads: [{gravity: [0, 0, -9.81]}]", "initial: {velocity: [0, 0, 1]}")
        self.assertRegex(self.log(thrown)[0], r"warning: \S*in.yaml:5:16: 'backward-euler' with steps of 0.1 s dissipated")

    def notes(self, text):
        """Beginnings of what is noted of the energy that the method took, where nothing is warned of."""
        done = self.call("run", self.write("in.yaml", text), "--output", "out")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [words for words in ("methods of the first order damp", "the state of rest at the end", "impacts shorter than a step")
                if re.search(rf"note: \S*in.yaml:\d+:16: .* % of the energy supplied .*: {words}", done.stdout)]

    def test_bounces_with_bdf3(self):
        # The warning ahead counts on the lowest vibrations alone: 25 s. Others have grown within one.
        ahead = self.call("check", self.write("in.yaml", BOUNCE % ("", "bdf3", 25)))
        self.assertRegex(ahead.stderr, r"warning: .*'bdf3' is not A-stable.* by a factor of \de\+1\d or more")
        told, summary = self.log(BOUNCE % ("", "bdf3", 0.8))
        self.assertEqual(told.count(BEHIND), 1, told)
        self.assertGreater(summary["energy_growth"]["factor"], 2)
        for damping, method in ((", viscosity: {model: stiffness-proportional, time: 1 ms}", "bdf3"), ("", "dirk22")):
            with self.subTest(method):
                told, _ = self.log(BOUNCE % (damping, method, 2))
                self.assertNotIn("A-stable", told)
                self.assertNotIn(BEHIND, told)


if __name__ == "__main__":
    unittest.main()
