#!/usr/bin/python3
"""Runs that make energy say so, before they start where it is certain, and at their end; sound ones say nothing."""
import json
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
