#!/usr/bin/python3
"""The number of ranks does not change what is computed."""
import unittest

import numpy as np

from program import ProgramTest, write_box

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
            for ranks in (2, 3):
                with self.subTest(order, ranks=ranks):
                    self.assert_same_history(alone, self.run_input(file, ranks=ranks, output=f"{order}_{ranks}"), 1e-9)

    def test_the_mesh_in_parts_on_every_rank(self):
        write_box(self.directory / "bar.msh", (12, 3, 4), (1, 0.2, 0.2))
        done = self.call("mesh", "convert", "bar.msh", "bar.h5", ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("bar.h5: 864 tetrahedra, 260 vertices", done.stdout)
        file = self.write("in.yaml", INPUT.replace("ORDER", "P1"))
        whole = self.run_input(file)
        for ranks in (1, 2, 3):
            with self.subTest(ranks=ranks):
                parts = self.run_input(file, "mesh.file=bar.h5", ranks=ranks, output=f"parts_{ranks}")
                self.assert_same_history(whole, parts, 1e-9)


if __name__ == "__main__":
    unittest.main()
