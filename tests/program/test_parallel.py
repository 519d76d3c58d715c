#!/usr/bin/python3
"""The number of ranks does not change what is computed, and the same run gives the same numbers."""
import unittest

import h5py
import numpy as np

from program import ProgramTest, swept, write_box

INPUT = """
mesh: {file: bar.msh}
element: ORDER
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
constraints:
  - {surface: left, displacement: [0, "0.02*(1 - cos(20*t))", 0]}
  - {box: [[0.45, -1, -1], [0.55, 1, 0.01]], displacement: [free, free, 0]}
loads:
  - {gravity: [0, 0, -9.81]}
  - {surface: right, traction: ["500*t", 0, "-3000*sin(30*t)"]}
  - {where: "z > 0.199", traction: [0, "1000*x", 0]}
initial: {velocity: [0, "x", 0]}
time: {method: bdf2, step: 5 ms, end: 60 ms}
solver: {newton: {relative: 1e-12}}
probes:
  - {name: tip, point: [1, 0.25, 0.2]}
  - {name: inside, point: [0.512, 0.113, 0.071]}
"""

SMALL = """
mesh: {file: box.msh}
bodies:
  - density: 1000
    elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}
    viscosity: [{model: prony, ratio: 0.5, relaxation_time: 50 ms}]
constraints: [{surface: left, displacement: [0, 0, "0.002*sin(20*t)"]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 1 ms, end: 0.02}
"""


class Parallel(ProgramTest):
    def test_equal_histories(self):
        # Bent prisms, so that no symmetry hides a mistake; Newton converges to rounding, which the tolerance allows for.
        write_box(self.directory / "bar.msh", (12, 3, 4), (1, 0.2, 0.2),
                  shape=lambda X: X + 0.05 * np.stack([0 * X[:, 0], X[:, 0] ** 2, 0 * X[:, 0]], axis=1) * (X[:, :1] > 0.7))
        for order in ("P1", "P2"):
            file = self.write(order + ".yaml", INPUT.replace("ORDER", order))
            alone = self.run_input(file, output=order)
            self.assertEqual(len(alone["step"]), 13)
            self.assertGreater(np.abs(alone["tip_z"] - alone["tip_z"][0]).max(), 1e-3)
            for ranks in swept((2, 3), (2, 3) if order == "P1" else (2,)):
                with self.subTest(order, ranks=ranks):
                    self.assert_same_history(alone, self.run_input(file, ranks=ranks, output=f"{order}_{ranks}"), 1e-9)

    def test_the_mesh_in_parts_on_every_rank(self):
        write_box(self.directory / "bar.msh", (12, 3, 4), (1, 0.2, 0.2))
        done = self.call("mesh", "convert", "bar.msh", "bar.h5", ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("bar.h5: 864 tetrahedra, 260 vertices", done.stdout)
        file = self.write("in.yaml", INPUT.replace("ORDER", "P1"))
        whole = self.run_input(file)
        for ranks, options in ((1, ()), (3, ()), (2, ("-mesh_cells_on_root", "0")), (3, ("-mesh_cells_on_root", "0"))):
            with self.subTest(ranks=ranks, options=options):
                parts = self.run_input(file, "mesh.file=bar.h5", ranks=ranks, output=f"parts_{ranks}", options=options)
                self.assert_same_history(whole, parts, 1e-9)


class Determinism(ProgramTest):
    """The same ranks, the same bits; another number of them, the same to 1e-9."""

    # On several ranks MUMPS adds up in the order in which messages arrive; multigrid does not.
    CASES = {
        "factorization": ("time.method=bdf2",),
        "stages, adaptive": ("time.method=dirk23", "time.adaptive={relative: 1e-3, absolute: 1e-5}"),
        "multigrid": ("solver.linear=amg",),
        "cavity": ("constraints=[{surface: left, displacement: [0, free, free]}, {surface: right, displacement: [0, free, free]}, "
                   "{surface: front, displacement: [free, 0, free]}, {surface: back, displacement: [free, 0, free]}, "
                   "{surface: top, displacement: [free, free, '0.002*sin(20*t)']}]",
                   "cavities=[{name: below, surface: bottom, volume: 1e-3, "
                   "liquid: {bulk_modulus: 1e5, added_volume: '1e-5*sin(20*t)'}}]",),
    }
    EXACT = {(name, 1) for name in CASES} | {("multigrid", 2)}

    def bits(self, output):
        """All that a run has computed, as bytes."""
        with h5py.File(self.directory / output / "result.h5") as file:
            frames = [frame["displacement"][()].tobytes() for frame in file["frames"].values()]
        return (self.directory / output / "history.csv").read_bytes(), frames

    def test_the_same_again(self):
        write_box(self.directory / "box.msh", (6, 2, 2), (0.3, 0.1, 0.1))
        file = self.write("in.yaml", SMALL)
        cases = list(self.CASES.items())
        for name, settings in swept(cases, cases[2:]):
            settings = [*settings, "solver.newton.relative=1e-12"]
            alone = self.run_input(file, *settings, output="alone")
            for ranks in (1, 2):
                with self.subTest(name, ranks=ranks):
                    first = self.run_input(file, *settings, ranks=ranks, output="first")
                    self.assert_same_history(alone, first, 1e-9)
                    second = self.run_input(file, *settings, ranks=ranks, output="second")
                    self.assert_same_history(first, second, 1e-9)
                    if (name, ranks) in self.EXACT:
                        self.assertEqual(self.bits("first"), self.bits("second"))


if __name__ == "__main__":
    unittest.main()
