#!/usr/bin/python3
"""What a run writes: the history, the frames of the result, the input as understood, and what it says meanwhile."""
import fcntl
import os
import re
import time
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np
import yaml

from program import ROOT, ProgramTest, finish, read_history, start, swept, write_box

INPUT = """
title: bar
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1200 kg/m^3, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints:
  - {surface: left, displacement: [0, 0, 0]}
  - {box: [[0.9, -1, -1], [1.1, 1, 1]], displacement: [free, 0, free]}
loads:
  - {gravity: [0, 0, -9.81]}
initial: {velocity: ["0.1*x", 0, 0]}
time: {method: bdf2, step: 10 ms, end: 0.1}
output: {directory: somewhere, every: 25 ms, fields: [displacement, velocity, acceleration, cauchy_stress,
                                                      von_mises_stress, volume_ratio, energy_density]}
probes: [{name: tip, point: [1, 0.1, 0.1]}, {name: root, point: [0, 0.1, 0.1]}]
"""
COLUMNS = ("step,time,dt,newton_iterations,linear_iterations,kinetic_energy,elastic_energy,load_potential,dissipated_energy,"
           "load_work,energy_balance_error,px,py,pz,Lx,Ly,Lz,tip_x,tip_y,tip_z,tip_vx,tip_vy,tip_vz,"
           "root_x,root_y,root_z,root_vx,root_vy,root_vz,left_fx,left_fy,left_fz,"
           "constraint2_fx,constraint2_fy,constraint2_fz,numerical_dissipation,support_work,"
           "left_tx,left_ty,left_tz,constraint2_tx,constraint2_ty,constraint2_tz,"
           "tip_ux,tip_uy,tip_uz,root_ux,root_uy,root_uz")


class Outputs(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2))
        self.input = self.write("bar.yaml", INPUT)
        self.out = self.directory / "out"

    def test_one_run_per_directory(self):
        """A directory in which a run goes on is refused; one whose run is just ending is waited for."""
        self.out.mkdir()
        other = os.open(self.out, os.O_RDONLY)
        fcntl.flock(other, fcntl.LOCK_EX)
        for ranks in swept((1, 2), (2,)):
            done = finish(start(["run", "bar.yaml", "--output", "out"], self.directory, ranks), 60)
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertEqual(done.stderr.count("another run is writing into 'out'"), 1, done.stderr)
            self.assertEqual(os.listdir(self.out), [])
        waiting = start(["run", "bar.yaml", "--output", "out", "--quiet"], self.directory, 1)
        time.sleep(0.5)
        os.close(other)
        self.assertEqual(finish(waiting, 60).returncode, 0)

    def test_history(self):
        history = self.run_input(self.input)
        lines = (self.out / "history.csv").read_text().splitlines()
        self.assertEqual(lines[0], COLUMNS)
        self.assertEqual(len(lines), 12)
        np.testing.assert_array_equal(history["step"], np.arange(11))
        np.testing.assert_array_equal(history["time"], np.arange(11) * 10 / 1000)
        np.testing.assert_allclose(history["dt"], [0] + [0.01] * 10, rtol=1e-14)
        # Row 0 is the initial state: velocity 0.1 x along x.
        self.assertEqual(history["newton_iterations"][0], 0)
        self.assertAlmostEqual(history["kinetic_energy"][0], 0.5 * 1200 * 0.04 * 0.1**2 / 3, delta=1e-12)
        self.assertAlmostEqual(history["px"][0], 1200 * 0.04 * 0.1 / 2, delta=1e-12)
        self.assertEqual(history["elastic_energy"][0], 0)
        self.assertEqual(history["energy_balance_error"][0], 0)
        np.testing.assert_allclose([history[f"tip_{c}"][0] for c in ("x", "y", "z", "vx", "vy", "vz")],
                                   [1, 0.1, 0.1, 0.1, 0, 0], atol=1e-15)
        # The books close by definition.
        h = history
        balance = h["kinetic_energy"] + h["elastic_energy"] + h["load_potential"] + h["dissipated_energy"] - h["load_work"]
        np.testing.assert_allclose(balance - balance[0] + h["numerical_dissipation"], h["energy_balance_error"], atol=1e-12)

    def test_numbers_have_full_precision(self):
        self.run_input(self.input)
        text = (self.out / "history.csv").read_text().splitlines()[-1].split(",")
        digits = [len(re.sub(r"e.*|[-.]", "", number).lstrip("0")) for number in text]
        self.assertGreaterEqual(max(digits), 16)
        for number in text:
            self.assertEqual(float(number), float(repr(float(number))))

    def test_supports_carry_the_weight(self):
        history = self.run_input(self.input, "time.method=static", "constraints.1.displacement=[free, 0, 0]")
        held = sum(history[name][-1] for name in ("left_fz", "constraint2_fz"))
        self.assertAlmostEqual(held, 1200 * 0.04 * 9.81, delta=1e-6)
        for axis in "xy":
            self.assertAlmostEqual(sum(history[f"{name}_f{axis}"][-1] for name in ("left", "constraint2")), 0, delta=1e-6)

    def test_supports_carry_what_inertia_leaves(self):
        # Newton's second law of the whole body, at the end of a backward-Euler step: sum of forces = change of p / dt.
        history = self.run_input(self.input, "time.method=backward-euler")
        for axis, weight in (("x", 0), ("y", 0), ("z", -1200 * 0.04 * 9.81)):
            forces = history[f"left_f{axis}"] + history[f"constraint2_f{axis}"] + weight
            np.testing.assert_allclose(forces[1:], np.diff(history[f"p{axis}"]) / 0.01, atol=1e-4)

    def test_frames(self):
        for ranks in swept((1, 2), (2,)):
            with self.subTest(ranks=ranks):
                history = self.run_input(self.input, ranks=ranks)
                tree = xml.etree.ElementTree.parse(self.out / "result.xdmf")
                grids = tree.findall(".//Grid[@GridType='Uniform']")
                times = [float(grid.find("Time").get("Value")) for grid in grids]
                # Due at 0, 25, 50, 75 and 100 ms; written at the first step at or after that.
                np.testing.assert_allclose(times, [0, 0.03, 0.05, 0.08, 0.1], rtol=1e-12)
                fields = {a.get("Name") for a in grids[-1].findall("Attribute")}
                self.assertLessEqual({"displacement", "velocity", "acceleration", "cauchy_stress", "von_mises_stress",
                                      "volume_ratio", "energy_density", "rank", "body"}, fields)
                with h5py.File(self.out / "result.h5") as file:
                    for item in tree.findall(".//DataItem"):
                        name, path = item.text.split(":")
                        self.assertEqual(name, "result.h5")
                        shape = tuple(map(int, item.get("Dimensions").split()))
                        self.assertEqual(int(np.prod(shape)), int(np.prod(file[path].shape)))
                    points = file["mesh/coordinates"][()]
                    last = file["frames"][sorted(file["frames"])[-1]]
                    tip = np.argmin(np.abs(points - [1, 0.1, 0.1]).sum(axis=1))
                    np.testing.assert_allclose(points[tip] + last["displacement"][tip],
                                               [history[f"tip_{c}"][-1] for c in "xyz"], atol=1e-14)
                    np.testing.assert_allclose(last["velocity"][tip],
                                               [history[f"tip_v{c}"][-1] for c in "xyz"], atol=1e-14)
                    x, y, z = (points + last["displacement"])[file["mesh/cells"][()]].transpose(2, 0, 1)
                    volumes = np.linalg.det(np.stack([v[:, 1:] - v[:, :1] for v in (x, y, z)], axis=2)) / 6
                    x, y, z = points[file["mesh/cells"][()]].transpose(2, 0, 1)
                    reference = np.linalg.det(np.stack([v[:, 1:] - v[:, :1] for v in (x, y, z)], axis=2)) / 6
                    np.testing.assert_allclose(np.ravel(last["volume_ratio"]), volumes / reference, rtol=1e-12)
                    energy = (np.ravel(last["energy_density"]) * reference).sum()
                    self.assertAlmostEqual(energy / history["elastic_energy"][-1], 1, delta=1e-12)

    def test_what_was_understood_runs_again(self):
        first = self.run_input(self.input, "time.step=5 ms", "bodies.0.density=1 g/cm^3", output="first")
        file = self.directory / "first/run.yaml"
        understood = yaml.safe_load(file.read_text())
        self.assertEqual(understood["time"]["step"], 0.005)
        self.assertEqual(understood["bodies"][0]["density"], 1000)
        self.assertIn("PETSc", file.read_text())
        # Without --output it writes where the first run did.
        (self.directory / "elsewhere").mkdir()
        moved = self.directory / "elsewhere/again.yaml"
        file.rename(moved)
        (self.directory / "first/history.csv").rename(self.directory / "elsewhere/history.csv")
        done = self.call("run", moved, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_history(first, read_history(self.directory / "first"), 0)

    def test_where_results_go(self):
        cases = {
            "somewhere": [],
            "by option": ["--output", "by option"],
            "by key": ["--set", "output.directory=by key"],
            "option wins": ["--output", "option wins", "--set", "output.directory=lost"],
            "a/b/c": ["--output", "a/b/c"],
        }
        for directory, arguments in cases.items():
            with self.subTest(directory):
                done = self.call("run", self.input, "--set", "time.end=0.01", *arguments)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(len(read_history(self.directory / directory)["step"]), 2)
                self.assertIn(f"{directory}/result.xdmf", done.stdout)
        self.assertFalse((self.directory / "lost").exists())
        # By default out/<name of the input>, in the working directory.
        done = self.call("run", self.write("bare.yaml", re.sub("output:.*?}", "", INPUT, flags=re.DOTALL)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.directory / "out/bare/history.csv").exists())

    def test_a_second_run_replaces_the_first(self):
        self.run_input(self.input)
        history = self.run_input(self.input, "time.end=0.02")
        self.assertEqual(len(history["step"]), 3)
        frames = xml.etree.ElementTree.parse(self.out / "result.xdmf").findall(".//Grid[@GridType='Uniform']")
        self.assertEqual(len(frames), 2)

    def test_a_pipe_gets_a_line_per_frame(self):
        for ranks in swept((1, 2), (2,)):
            with self.subTest(ranks=ranks):
                done = self.call("run", self.input, ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertFalse(re.search(r"[^\x20-\x7e\n]", done.stdout), done.stdout)
                progress = re.findall(r"^t (\S+) s .*", done.stdout, flags=re.MULTILINE)
                self.assertEqual([float(t) for t in progress], [0.03, 0.05, 0.08, 0.1], done.stdout)
                for word in ("assembly", "factorization", "solve", "output", "worst step", "result.xdmf", "history.csv"):
                    self.assertIn(word, done.stdout)
                self.assertEqual(done.stderr, "")

    def test_quiet(self):
        done = self.call("run", self.input, "--quiet", ranks=2)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_petsc_options(self):
        done = self.call("run", self.input, "--", "-snes_monitor", "-snes_view")
        for words in ("SNES Function norm", "an earlier factorization, rotated with the nodes", "MUMPS factorization in single precision",
                      "entries of the factors"):
            self.assertIn(words, done.stdout)
        self.assertEqual(done.stderr, "")
        direct = self.run_input(self.input, "solver.newton.relative=1e-11", output="direct")
        iterated = self.run_input(self.input, "solver.newton.relative=1e-11", output="iterated",
                                  options=["-ksp_type", "cg", "-pc_type", "jacobi", "-ksp_rtol", "1e-10"])
        self.assertGreater(iterated["linear_iterations"].sum(), 3 * direct["linear_iterations"].sum())
        self.assertAlmostEqual(iterated["tip_z"][-1], direct["tip_z"][-1], delta=1e-9)

    def test_an_unknown_petsc_option_is_named(self):
        done = self.call("run", self.input, "--quiet", "--", "-snes_monitr", "-ksp_typ", "cg")
        self.assertEqual(done.returncode, 0)
        for option in ("-snes_monitr", "-ksp_typ"):
            self.assertEqual(done.stderr.count(option + ";"), 1, done.stderr)

    def test_any_working_directory(self):
        done = self.call("run", ROOT / "input/beam_small.yaml", "--set", "time.end=0.01", "--output", "here")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.directory / "here/history.csv").exists())


if __name__ == "__main__":
    unittest.main()
