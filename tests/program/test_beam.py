#!/usr/bin/python3
"""The reference beam: 1 x 0.2 x 0.2 m, neo-Hookean, let go from rest under gravity, backward Euler with steps of 10 ms.

Its deflection u_z(1, 0, 0) is known from independent finite-element codes on the very same meshes, to ten digits.
"""
import json
import subprocess
import sys
import unittest

import numpy as np

from program import LONG, ROOT, ProgramTest, long_test, swept

BEAM = ROOT / "input/beam_small.yaml"
AFTER_TEN_STEPS = {(30, 6, 6): -6.920071856e-02, (55, 11, 11): -6.856066406e-02}
QUADRATIC_AFTER_TWO_STEPS = -2.961637428e-03  # 30 x 6 x 6, from dolfinx 0.5.2 on the same mesh, four quadrature points
SAME = 1e-6  # relative; Newton's method stops at 1e-8 of the forces


class Beam(ProgramTest):
    def mesh(self, n, size=(1, 0.2, 0.2)):
        file = self.directory / f"beam{n[0]}.msh"
        numbers = [*map(str, n), "--box", *map(str, size)]
        subprocess.run([sys.executable, ROOT / "tools/beam_mesh.py", "--n", *numbers, "--binary", "-o", file], check=True)
        return f"mesh.file={file}"

    def check(self, n, ranks, expected, *settings):
        history = self.run_input(BEAM, self.mesh(n), *settings, ranks=ranks, timeout=300)
        self.assertAlmostEqual(history["tip_z"][-1] / expected, 1, delta=SAME)

    def test_small(self):
        for ranks in swept((1, 2, 3), (1,)):
            with self.subTest(ranks=ranks):
                self.check((30, 6, 6), ranks, AFTER_TEN_STEPS[30, 6, 6])

    def test_the_mesh_that_comes_with_the_program(self):
        history = self.run_input(BEAM)
        self.assertAlmostEqual(history["tip_z"][-1] / AFTER_TEN_STEPS[30, 6, 6], 1, delta=SAME)

    @long_test
    def test_medium(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.check((55, 11, 11), ranks, AFTER_TEN_STEPS[55, 11, 11])

    def test_multigrid(self):
        self.check((30, 6, 6), 2 if LONG else 1, AFTER_TEN_STEPS[30, 6, 6], "solver.linear=amg")
        for ranks in swept((1, 3), (1,)):
            with self.subTest(ranks=ranks):
                self.check((30, 6, 6), ranks, QUADRATIC_AFTER_TWO_STEPS, "solver.linear=p-multigrid", "element=P2", "time.end=20 ms")

    def test_quadratic(self):
        for ranks in swept((1, 2, 3), (1,)):
            with self.subTest(ranks=ranks):
                self.check((30, 6, 6), ranks, QUADRATIC_AFTER_TWO_STEPS, "element=P2", "time.end=20 ms")

    def test_a_stiff_bulky_body_is_solved_in_few_iterations(self):
        # Nearly static: the residual's rounding floor lies close to the tolerance.
        n = 19 if LONG else 11
        stiff = (self.mesh((n, n, n), (0.3, 0.3, 0.3)), "bodies.0.elasticity.youngs_modulus=1e9",
                 "bodies.0.elasticity.poissons_ratio=0.45", "time.step=25 ms", "time.end=250 ms", "probes.0.point=[0.3, 0, 0]")
        history = self.run_input(BEAM, *stiff, timeout=300)
        self.assertEqual(len(history["step"]), 11)
        self.assertLessEqual(history["newton_iterations"].max(), 4)
        # The residuals of all nodes together are what the momentum's rate, the support's force and the weight do not balance.
        weight = 1000 * 0.3**3 * 9.81
        for axis, load in (("x", 0), ("y", 0), ("z", -weight)):
            rate = np.diff(history[f"p{axis}"]) / np.diff(history["time"])
            self.assertLess(np.abs(rate - history[f"clamp_f{axis}"][1:] - load).max(), 1e-6 * weight)
        solver = json.loads((self.directory / "out/summary.json").read_text())["solver"]
        self.assertLess(solver["worst_rounding"], 1e-6)
        # What is left of the residual moves the body by less than four digits show.
        exact = self.run_input(BEAM, *stiff, "solver.newton.relative=1e-13", output="exact", timeout=300)
        np.testing.assert_allclose(history["tip_z"][1:], exact["tip_z"][1:], rtol=1e-4)


if __name__ == "__main__":
    unittest.main()
