#!/usr/bin/python3
"""Every analysis runs: in time, quasistatic, static; a step that fails is repeated, a run that is lost says so."""
import subprocess
import unittest

import numpy as np

from program import PROGRAM, ProgramTest, read_history, swept, write_box

INPUT = """
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, "-4000*t"]}]
time: {method: backward-euler, step: 0.1, end: 1}
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""


class Methods(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2))
        self.input = self.write("bar.yaml", INPUT)

    def test_every_method_of_the_list_runs(self):
        table = subprocess.run([PROGRAM, "methods"], capture_output=True, text=True, check=True).stdout.splitlines()
        names = [line.split()[0] for line in table if not line.startswith(" ") and "-stable" in line]
        self.assertEqual(len(names), 8)
        ends = {}
        for name in names:
            with self.subTest(name):
                # 0.3 s, by when the load has grown slowly; all methods agree on that.
                history = self.run_input(self.input, "time.method=" + name, "time.step=0.01", "time.end=0.3")
                self.assertEqual(len(history["step"]), 31)
                ends[name] = history["tip_z"][-1]
        for name, end in ends.items():
            self.assertAlmostEqual(end, ends["bdf2"], delta=0.02 * abs(ends["bdf2"] - 0.1), msg=name)

    def test_a_method_that_lets_vibrations_grow_is_told(self):
        damped = "bodies.0.viscosity={model: kelvin-voigt, shear: 1, bulk: 0}"
        for settings, told in ((["time.method=bdf3"], True), (["time.method=bdf3", damped], False), (["time.method=bdf2"], False)):
            done = self.call("check", self.input, *(word for setting in settings for word in ("--set", setting)))
            text = done.stdout + done.stderr  # a note, or a warning where that is certain
            self.assertEqual("not A-stable" in text, told, settings)

    def test_units_do_not_matter(self):
        """A bar of nanometres and terapascals, whose steps are femtoseconds, moves as one of metres does."""
        def motion(method, length, modulus):
            write_box(self.directory / "bar.msh", (4, 1, 1), (length, 0.2 * length, 0.2 * length))
            time = length * (1000 / modulus) ** 0.5  # a wave's through the bar
            text = (INPUT.replace("1e6", repr(modulus)).replace("-4000*t", f"{-1e-3 * modulus / time}*t")
                    .replace("[1, 0.1, 0.1]", f"[{length}, {0.1 * length}, {0.1 * length}]"))
            h = self.run_input(self.write("units.yaml", text), f"time.method={method}", f"time.step={0.5 * time!r}",
                               f"time.end={5 * time!r}")
            return h["tip_z"] / length
        for method in ("petsc:alpha2", "petsc:bdf", "petsc:arkimex", "dirk33"):
            with self.subTest(method):
                expected = motion(method, 1.0, 1e6)
                np.testing.assert_allclose(motion(method, 1e-8, 1e12), expected, atol=1e-6 * np.abs(expected - 0.1).max())

    def test_load_steps_and_quasistatic_steps_agree(self):
        slow = self.run_input(self.input, "time.method=quasistatic", "solver.newton.relative=1e-10", output="slow")
        at_once = self.run_input(self.input, "time.method=static", "solver.newton.relative=1e-10", output="at once")
        stepped = self.run_input(self.input, "time.method=static", "time.load_steps=10", "solver.newton.relative=1e-10",
                                 output="stepped")
        self.assertEqual((len(slow["step"]), len(at_once["step"]), len(stepped["step"])), (11, 2, 11))
        for name in ("tip_x", "tip_y", "tip_z", "elastic_energy", "left_fx", "left_fy", "left_fz"):
            scale = max(1, abs(slow[name][-1]))
            self.assertAlmostEqual(stepped[name][-1], slow[name][-1], delta=1e-7 * scale, msg=name)
            self.assertAlmostEqual(at_once[name][-1], slow[name][-1], delta=1e-7 * scale, msg=name)
        np.testing.assert_allclose(stepped["time"], np.arange(11) / 10, atol=1e-15)
        np.testing.assert_allclose(stepped["tip_z"], slow["tip_z"], atol=1e-7)
        self.assertLess(stepped["tip_z"][-1], 0.1 - 0.1)  # well into the nonlinear range
        # Without inertia, what the load works is what the body stores, and no step depends on the length of another.
        for history in (slow, stepped):
            self.assertEqual(np.abs(history["kinetic_energy"]).max(), 0)
            self.assertAlmostEqual(history["load_work"][-1] / history["elastic_energy"][-1], 1, delta=2e-3)

    def test_static_motion_of_a_surface(self):
        # Stretched by a tenth between two sliding ends: homogeneous uniaxial stress.
        text = """
mesh: {file: bar.msh}
bodies: [{elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
constraints:
  - {surface: left, displacement: [0, free, free]}
  - {surface: right, displacement: ["0.1*t", free, free]}
  - {surface: front, displacement: [free, 0, free]}
  - {surface: bottom, displacement: [free, free, 0]}
time: {method: static, end: 1, load_steps: 4}
"""
        history = self.run_input(self.write("pull.yaml", text), "solver.newton.relative=1e-12")
        # mu (b - 1/b) + lambda ln(l b^2) / b = 0 across, l = 1.1; the force per reference area is dW/dl.
        mu, lam, l = 1e6 / 2.6, 0.3e6 / (1.3 * 0.4), 1 + 0.1 * history["time"]
        b = np.ones_like(l)
        for _ in range(50):
            b -= (mu * (b**2 - 1) + lam * np.log(l * b**2)) / (2 * mu * b + 2 * lam / b)
        force = 0.04 * (mu * (l - 1 / l) + lam * np.log(l * b**2) / l)
        np.testing.assert_allclose(history["right_fx"], force, atol=1e-6)
        np.testing.assert_allclose(history["left_fx"], -force, atol=1e-6)
        energy = 0.04 * (mu / 2 * (l**2 + 2 * b**2 - 3) - mu * np.log(l * b**2) + lam / 2 * np.log(l * b**2) ** 2)
        np.testing.assert_allclose(history["elastic_energy"], energy, atol=1e-8)
        # Work of the support: the trapezoidal rule over four steps.
        work = (0.5 * (force[1:] + force[:-1]) * np.diff(l)).sum()
        self.assertAlmostEqual(history["load_work"][-1], work, delta=1e-6)

    def test_a_failed_step_is_halved(self):
        for ranks in swept((1, 2), (2,)):
            done = self.call("run", self.input, "--output", "out", "--quiet", "--set", "time.method=quasistatic", "--set",
                             "time.step=1", "--set", "solver.newton.max_iterations=4", ranks=ranks)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("; trying ", done.stderr)
            history = read_history(self.directory / "out")
            self.assertGreater(len(history["step"]), 3)
            self.assertEqual(history["time"][-1], 1)
            self.assertLess(history["dt"][1], 1)
            np.testing.assert_allclose(np.diff(history["time"]), history["dt"][1:], rtol=1e-12)
            whole = self.run_input(self.input, "time.method=quasistatic", output="whole")
            self.assertAlmostEqual(history["tip_z"][-1], whole["tip_z"][-1], delta=1e-5)

    def test_a_lost_run_says_so_and_keeps_what_it_has(self):
        # Pushed inside out from 0.3 s on: no step, however small, can follow.
        text = INPUT.replace("constraints: [", 'constraints: [{surface: right, displacement: ["t > 0.25 ? -1.5 : 0", 0, 0]}, ')
        text = text.replace('loads: [{surface: right, traction: [0, 0, "-4000*t"]}]', "loads: [{gravity: [0, 0, -9.81]}]")
        file = self.write("lost.yaml", text)
        for ranks in swept((1, 2), (2,)):
            with self.subTest(ranks=ranks):
                done = self.call("run", file, "--output", "out", "--quiet", "--set", "time.min_step=0.02", ranks=ranks)
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertEqual(done.stderr.count("the solve failed at"), 1, done.stderr)
                self.assertIn("is in out", done.stderr)
                self.assertNotIn("PETSC ERROR", done.stderr)
                history = read_history(self.directory / "out")
                self.assertAlmostEqual(history["time"][-1], 0.25, delta=0.06)
                self.assertRegex(done.stderr, rf"last good state \(t = {history['time'][-1]:.6g}\)")
                self.assertTrue(np.isfinite(list(history.values())).all())

    def test_a_lost_load_step(self):
        done = self.call("run", self.input, "--output", "out", "--quiet", "--set", "time.method=static", "--set",
                         "time.end=1", "--set", "solver.newton.max_iterations=1")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("load factor", done.stderr)
        self.assertIn("a larger solver.newton.max_iterations", done.stderr)  # of which it had one
        self.assertIn("more load_steps", (self.directory / "out/post-mortem/report.yaml").read_text())


if __name__ == "__main__":
    unittest.main()
