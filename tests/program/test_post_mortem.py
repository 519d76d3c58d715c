#!/usr/bin/python3
"""A run that cannot go on leaves a post-mortem that names the place, and agrees with itself and with the state beside it."""
import shutil
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np
import yaml

from program import ProgramTest, box, read_history, swept, write_mesh

SIZE, PARTS = (0.6, 0.2, 0.2), (6, 2, 2)
FIELDS = {"displacement", "residual", "newton_step", "volume_ratio", "quality"}

# Two bodies, one after the other along x; no shorter step is allowed, so that the first failure is the last.
BODY = """
title: "a body that 'fails'"
mesh: {file: bar.msh}
bodies:
  - {volume: held, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}
  - {volume: free, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, "t < 0.02 ? -100 : -50000"]}]
time: {method: bdf2, step: 10 ms, end: 0.1, min_step: 10 ms}
solver: {newton: {max_iterations: 3}}
"""

# name: settings, words of the advice, whether Newton's method got as far as a direction
CASES = {
    "out of iterations": ((), "max_iterations", True),
    "pushed inside out": (("constraints=[{surface: left, displacement: [0, 0, 0]}, "
                           "{surface: right, displacement: ['t < 0.015 ? 0 : -0.75', 0, 0]}]",
                           "solver.newton.max_iterations=50", "loads=[]"), "inverts tetrahedra", False),
    "static": (("time={method: static, load_steps: 1, end: 0.1}", "solver.newton.max_iterations=1"), "", True),
    "not in SI": (("bodies.0.elasticity.youngs_modulus=0.5", "bodies.1.elasticity.youngs_modulus=0.5"), "units of the material: ", True),
    "quadratic": (("element=P2",), "", True),
    "quasistatic": (("time={method: quasistatic, step: 50 ms, end: 0.1, min_step: 50 ms}", "solver.newton.max_iterations=1",
                     "loads=[{surface: right, traction: [0, 0, -5 kPa]}]"), 'let it grow, as [0, 0, "-5000*min(t/0.1, 1)"]', True),
    "quasistatic, a formula": (("time={method: quasistatic, step: 50 ms, end: 0.1, min_step: 50 ms}", "solver.newton.max_iterations=1",
                                "loads=[{surface: right, traction: [0, 0, '-5000 - y']}]"), 'as [0, 0, "(-5000 - y)*min(t/0.1, 1)"]', True),
    "with pressures": (("element=P2", "volumetric=mixed", "solver.newton.max_iterations=1"), "", True),
    "with a rigid part": (("constraints=[{surface: left, displacement: [0, 0, 0]}, {surface: right, rigid: {}}]",), "",
                          True),
    "of PETSc": (("time={method: {petsc: bdf}, step: 10 ms, end: 0.1, min_step: 10 ms}", "solver.newton.max_iterations=2",
                  "bodies=[{volume: held, density: 1000, elasticity: {model: linear, youngs_modulus: 100 kPa, "
                  "poissons_ratio: 0.3}}, {volume: free, density: 1000, elasticity: {model: neo-hookean, "
                  "youngs_modulus: 50 kPa, poissons_ratio: 0.3}}]"), "", None),
}


class PostMortem(ProgramTest):
    def setUp(self):
        super().setUp()
        points, triangles, cells = box(PARTS, SIZE)
        volume = (points[cells].mean(axis=1)[:, 0] > SIZE[0] / 2).astype(int)
        write_mesh(self.directory / "bar.msh", points, triangles, cells, (["held", "free"], volume))
        self.input = self.write("bar.yaml", BODY)
        self.bundle = self.directory / "out/post-mortem"

    def failed(self, settings, ranks):
        shutil.rmtree(self.directory / "out", ignore_errors=True)
        arguments = [a for setting in settings for a in ("--set", setting)]
        done = self.call("run", self.input, "--quiet", "--output", "out", *arguments, ranks=ranks)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(done.stderr.count("the solve failed at"), 1, done.stderr)
        self.assertIn("out/post-mortem/report.yaml", done.stderr)
        self.assertEqual({file.name for file in self.bundle.iterdir()}, {"report.yaml", "state.h5", "state.xdmf"})
        return yaml.safe_load((self.bundle / "report.yaml").read_text())

    def test_of_each_kind(self):
        for number, (name, case) in enumerate(CASES.items()):
            for ranks in swept((1, 2), (1, 2) if number == 0 else (1,)):
                with self.subTest(name, ranks=ranks):
                    self.judge(case, self.failed(case[0], ranks))

    def judge(self, case, report):
        _, words, has_direction = case
        self.assertTrue(any(words in line for line in report["advice"]), report["advice"])
        self.assertEqual(report["title"], "a body that 'fails'")
        self.assertEqual(report["last_good"]["step"], read_history(self.directory / "out")["step"][-1])
        self.assertAlmostEqual(report["tried"]["time"] - report["last_good"]["time"], report["tried"]["length"], delta=1e-9)
        self.assertEqual([body["name"] for body in report["bodies"]], ["held", "free"])
        for frame in xml.etree.ElementTree.parse(self.bundle / "state.xdmf").findall(".//Grid[@GridType='Uniform']"):
            self.assertLessEqual(FIELDS, {field.get("Name") for field in frame.findall("Attribute")})
        with h5py.File(self.bundle / "state.h5") as file:
            points, cells, body = (file["mesh"][name][()] for name in ("coordinates", "cells", "body"))
            frames = [{name: frame[name][()] for name in FIELDS} for frame in file["frames"].values()]
        self.assertEqual(len(frames), 1 if has_direction is None else 2)
        self.judge_cells(report, points, cells, body, frames[-1])
        if has_direction is None:
            self.assertNotIn("newton", report)
            return
        self.judge_nodes(report, points, cells, body, frames[-1])
        self.judge_newton(report, frames[-1], has_direction)

    def judge_cells(self, report, points, cells, body, state):
        """The cells of the report are the worst of the state, and its volume ratios those of its displacement."""
        ratio = np.ravel(state["volume_ratio"])
        corners = cells[:, :4]
        if cells.shape[1] == 4:
            x, X = (points + state["displacement"])[corners], points[corners]
            now, before = (np.linalg.det(y[:, 1:] - y[:, :1]) for y in (x, X))
            np.testing.assert_allclose(ratio, now / before, rtol=1e-9, atol=1e-12)
        worst = report["worst_cells"]
        self.assertEqual(len(worst), 10)
        np.testing.assert_allclose([cell["volume_ratio"] for cell in worst], np.sort(ratio)[:10], rtol=1e-5)
        for cell in worst:
            self.assertAlmostEqual(ratio[cell["row"]], cell["volume_ratio"], delta=1e-5 * abs(cell["volume_ratio"]))
            np.testing.assert_allclose(cell["position"], points[corners[cell["row"]]].mean(axis=0), rtol=1e-5, atol=1e-12)
            self.assertEqual(cell["body"], ("held", "free")[body[cell["row"]]])
            self.assertEqual(len(set(cell["vertices"])), 4)
        for k, part in enumerate(report["bodies"]):
            self.assertAlmostEqual(part["volume_ratio"], ratio[body == k].min(), delta=1e-5 * abs(part["volume_ratio"]))

    def judge_nodes(self, report, points, cells, body, state):
        size = np.linalg.norm(state["residual"], axis=1)
        worst = report["worst_nodes"]
        np.testing.assert_allclose([node["residual"] for node in worst], np.sort(size)[::-1][:10], rtol=1e-5)
        for node in worst:
            np.testing.assert_allclose(node["position"], points[node["row"]], rtol=1e-5, atol=1e-12)
        for k, part in enumerate(report["bodies"]):
            norm = np.linalg.norm(size[np.unique(cells[body == k])])
            np.testing.assert_allclose(part["residual"], norm, rtol=1e-5)

    def judge_newton(self, report, state, has_direction):
        newton = report["newton"]
        if not has_direction:
            self.assertEqual((newton["force_scale"], newton["iterations"]), (0, None))
            self.assertNotIn("line", report)
            # The motion of the right end alone inverts what touches it, nothing else.
            self.assertTrue(all(cell["volume_ratio"] < 0 and cell["position"][0] > 0.5 for cell in report["worst_cells"]))
            self.assertTrue(np.isnan(report["worst_nodes"][0]["residual"]))
            return
        self.assertGreater(newton["iterations"][-1]["residual"], newton["tolerance"])
        for iteration in newton["iterations"]:
            np.testing.assert_allclose(iteration["relative"], iteration["residual"] / newton["force_scale"], rtol=1e-4)
        self.assertGreater(np.abs(state["newton_step"]).max(), 0)
        profile = report["line"]["profile"]
        self.assertEqual(len(profile), 21)
        self.assertEqual([sample["length"] for sample in profile], sorted(sample["length"] for sample in profile))
        self.assertEqual("slope" in report["line"], newton["lowers"] == "potential")
        if "slope" in report["line"]:
            ahead, behind = profile[12], profile[8]
            slope = (ahead["change"] - behind["change"]) / (ahead["length"] - behind["length"])
            self.assertAlmostEqual(slope / report["line"]["slope"], 1, delta=1e-2)

    def test_the_place_is_that_of_the_load(self):
        """A traction on the right end: what is worst lies there, in the body that has that end."""
        report = self.failed((), 2)
        held, free = report["bodies"]
        self.assertGreater(free["residual"], 10 * held["residual"])
        self.assertGreater(held["volume_ratio"], free["volume_ratio"])
        for place in (report["worst_cells"][0], report["worst_nodes"][0]):
            self.assertEqual(place["body"], "free")
            self.assertGreater(place["position"][0], 0.4)

    def test_is_shown(self):
        """By the commands that show results, given its directory."""
        self.failed((), 1)
        self.assertIn("`pliant report out/post-mortem`", self.call("run", self.input, "--quiet", "--output", "out").stderr)
        self.assertIn("newton_step [m], 3 per node", self.pliant("info", "out/post-mortem").stdout)
        self.assertIn("2 of 2 frames", self.pliant("report", "out/post-mortem").stdout)
        done = self.pliant("render", "out/post-mortem", "--field", "volume_ratio", "-o", "state.glb")
        self.assertEqual(done.stdout, "state.glb\n")
        done = self.call("render", "out/post-mortem/report.yaml")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("its pictures are those of the directory out/post-mortem", done.stderr)

    def test_goes_on_from_there_and_a_new_run_forgets(self):
        self.failed((), 2)
        done = self.call("resume", "out", "--quiet", "--set", "solver.newton.max_iterations=50", "--set", "time.end=0.04")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(self.bundle.exists())
        done = self.call("run", self.input, "--quiet", "--output", "out", "--set", "time.end=0.01")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse(self.bundle.exists())

    def test_where_it_cannot_be_written(self):
        """The failure of the solve remains what the run is told to have died of."""
        (self.directory / "out").mkdir()
        (self.directory / "out/post-mortem").write_text("in the way")
        done = self.call("run", self.input, "--quiet", "--output", "out", ranks=2)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("the solve failed", done.stderr)
        self.assertIn("post-mortem", done.stderr)


if __name__ == "__main__":
    unittest.main()
