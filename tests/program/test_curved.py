#!/usr/bin/python3
"""Quadratic elements on a second-order mesh follow curved surfaces: half a ring."""
import math
import re
import unittest

import h5py
import numpy as np

from program import ProgramTest, swept, write_box

INNER, THICKNESS, WIDTH = 1.0, 0.2, 0.2
VOLUME = math.pi / 2 * ((INNER + THICKNESS) ** 2 - INNER**2) * WIDTH
INPUT = """
mesh: {file: ring.msh}
element: P2
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 0.02, end: 0.1}
solver: {newton: {relative: 1e-11}}
probes: [{name: top, point: [0, 0.1, 1.1]}]
"""


def half_ring(points):
    angle, radius = np.pi * points[:, 0], INNER + points[:, 2]
    return np.stack([-radius * np.cos(angle), points[:, 1], radius * np.sin(angle)], axis=1)


class Curved(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "ring.msh", (8, 2, 2), (1, WIDTH, THICKNESS), order=2, shape=half_ring)
        self.input = self.write("ring.yaml", INPUT)

    def mass(self, *settings, ranks=1):
        options = [word for setting in settings for word in ("--set", setting)]
        done = self.call("check", self.input, *options, ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stderr)
        return float(re.search(r"mass (\S+) kg", done.stdout)[1]), done.stdout

    def test_mass(self):
        for ranks in swept((1, 2, 3), (1, 3)):
            with self.subTest(ranks=ranks):
                quadratic, _ = self.mass(ranks=ranks)
                linear, text = self.mass("element=P1", ranks=ranks)
                error = [abs(m / (1000 * VOLUME) - 1) for m in (quadratic, linear)]
                self.assertLess(error[0], 1e-4)
                self.assertGreater(error[1], 0.02)
                self.assertIn("P1 elements straighten", text)

    def test_straight_sides_of_round_geometry_get_a_note(self):
        rod = """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.05, 0.01};
Physical Volume("rod") = {1};
Mesh.MeshSizeMax = 0.01;
"""
        self.write("rod.geo", rod)
        self.write("curved.geo", rod + "Mesh.ElementOrder = 2;\n")
        self.write("box.geo", rod.replace("Cylinder(1) = {0, 0, 0, 0, 0, 0.05, 0.01}", "Box(1) = {0, 0, 0, 1, 1, 1}").replace("0.01;", "0.5;"))
        # gmsh's own kernel: the sides of an extrusion are no planes to it
        self.write("extruded.geo", """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};
v[] = Extrude {0, 0, 1} { Surface{1}; };
Physical Volume("rod") = {v[1]};
Mesh.MeshSizeMax = 0.5;
""")
        text = "mesh: {file: FILE}\nelement: P2\nbodies: [{volume: rod, density: 1, rigid: true}]\ntime: {method: bdf2, step: 1, end: 1}\n"
        note = "note: the geometry has curved faces, and the sides of its P2 elements are straight: for curved ones, write 'Mesh.ElementOrder = 2;' in rod.geo"
        for file, is_noted in (("rod.geo", True), ("curved.geo", False), ("box.geo", False), ("extruded.geo", False)):
            self.write("rod.yaml", text.replace("FILE", file))
            for ranks in (1, 2):  # the second time with the mesh of the first
                self.assertEqual(self.pliant("check", "rod.yaml", ranks=ranks).stdout.count(note), int(is_noted), file)
        self.write("rod.yaml", text.replace("FILE", "rod.geo"))
        self.assertEqual(self.pliant("run", "rod.yaml").stdout.count(note), 1)
        self.assertNotIn("curved faces", self.pliant("check", "rod.yaml", "--set", "element=P1").stdout)

    def test_supports_carry_the_whole_weight(self):
        history = self.run_input(self.input, "time.method=static")
        self.assertAlmostEqual(history["left_fz"][-1] / (9.81 * 1000 * VOLUME), 1, delta=1e-4)

    def test_any_number_of_ranks(self):
        alone = self.run_input(self.input)
        self.assertLess(alone["top_z"][-1], 1.1 - 0.01)
        for ranks in swept((2, 3), (2,)):
            with self.subTest(ranks=ranks):
                self.assert_same_history(alone, self.run_input(self.input, ranks=ranks, output=str(ranks)), 1e-9)

    def test_the_result_holds_the_curved_edges(self):
        self.run_input(self.input, "time.end=0.02")
        with h5py.File(self.directory / "out/result.h5") as file:
            points = file["mesh/coordinates"][()]
            self.assertEqual(file["mesh/cells"].shape[1], 10)
        radius = np.hypot(points[:, 0], points[:, 2])
        self.assertAlmostEqual(radius.max(), INNER + THICKNESS, delta=1e-12)
        self.assertAlmostEqual(radius.min(), INNER, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
