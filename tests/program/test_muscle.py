#!/usr/bin/python3
"""Fibres and their contraction: closed forms, directions from the mesh file, the books of energy."""
import unittest

import numpy as np

from program import ROOT, ProgramTest, box, swept, write_box, write_mesh

MU, LAMBDA = 1e4, 4e4
# A free brick: each of three sides slides in its plane.
FREE = """mesh: {file: brick.msh}
bodies:
  - density: 1000
    elasticity: {model: neo-hookean, shear_modulus: 1e4, lame_lambda: 4e4}
    active: {fibre: [1, 0, 0], %s}
constraints:
  - {surface: left, displacement: [0, free, free]}
  - {surface: front, displacement: [free, 0, free]}
  - {surface: bottom, displacement: [free, free, 0]}
time: {%s}
solver: {newton: {relative: 1e-12}}
probes: [{name: tip, point: [1, 1, 1]}]
"""


def with_data(path, name, values, first_element):
    """Appends $ElementData, of the cells from that element on."""
    values = np.atleast_2d(values.T).T
    rows = "\n".join(f"{first_element + k} " + " ".join(map(repr, row)) for k, row in enumerate(values.tolist()))
    with open(path, "a", encoding="ascii") as file:
        file.write(f'$ElementData\n1\n"{name}"\n1\n0.0\n3\n0\n{values.shape[1]}\n{len(values)}\n{rows}\n$EndElementData\n')


class Contraction(ProgramTest):
    def contract(self, active, time, *settings, ranks=1):
        write_box(self.directory / "brick.msh", (2, 2, 2))
        return self.run_input(self.write("brick.yaml", FREE % (active, time)), *settings, ranks=ranks)

    def test_free_brick_under_active_stress(self):
        tension = 5e3
        for ranks in swept((1, 2, 3), (1, 3)):
            h = self.contract(f"stress: {tension}", "method: static, load_steps: 2", ranks=ranks)
            a, b, c = (h["tip_" + x][-1] for x in "xyz")
            self.assertLess(a, 0.9)
            log_j = np.log(a * b * c)
            along = MU * (a - 1 / a) + LAMBDA * log_j / a + tension * a  # P_11 of law and tension
            across = [MU * (s - 1 / s) + LAMBDA * log_j / s for s in (b, c)]
            np.testing.assert_allclose([along, *across], 0, atol=1e-6 * tension)

    def test_free_brick_under_active_strain_takes_its_shape_without_stress(self):
        for time in ("method: static, load_steps: 2", "method: quasistatic, step: 0.5, end: 1"):
            h = self.contract('shortening: "0.2"' if "static," in time else 'shortening: "0.2*t"', time)
            a, b, c = (h["tip_" + x][-1] for x in "xyz")
            np.testing.assert_allclose([a, b, c], [0.8, 0.8**-0.5, 0.8**-0.5], rtol=1e-9)
            self.assertLess(abs(h["elastic_energy"][-1]), 1e-12 * MU)

    def test_books_of_the_contraction_balance(self):
        # The brick is held at both ends: all work of the activation is stored, or moves the sides and is lost to the method.
        time = "method: dirk33, step: 0.02, end: 0.2"
        held = "constraints=[{surface: left, displacement: [0, 0, 0]}, {surface: right, displacement: [0, 0, 0]}]"
        losses = []
        for step in (0.02, 0.01):
            h = self.contract('shortening: "0.2*sin(2*pi*t)^2*(1 + y)"', time, held, f"time.step={step}")
            work = h["load_work"][-1]
            self.assertGreater(work, 1.0)
            self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * work)
            self.assertAlmostEqual((h["elastic_energy"] + h["kinetic_energy"] + h["numerical_dissipation"])[-1], work,
                                   delta=1e-9 * work)
            losses.append(abs(h["numerical_dissipation"][-1]))
        # Third order: what time alone brings in is integrated as exactly as the motion.
        self.assertLess(losses[1], 0.3 * losses[0])
        self.assertLess(losses[1], 1e-2 * work)

    def test_contractions_that_are_not_possible(self):
        write_box(self.directory / "brick.msh", (2, 2, 2))
        soon, later = "method: bdf2, step: 10 ms, end: 0.02", "method: bdf2, step: 10 ms, end: 0.1"
        for active, time, code, message in (
                ('stress: "sqrt(0.5 - x)"', soon, 2, "brick.yaml:5:13: the active stress is not finite at t = 0"),
                ('shortening: "sqrt(0.5 - x)"', "method: static", 2, "brick.yaml:5:13: the shortening is not finite at t = 0"),
                ('shortening: "0.5 + x"', soon, 2, "brick.yaml:5:13: the shortening must be below 1 in the whole body; at t = 0 it is 1."),
                ('stress: "1e3*sqrt(0.025 - t)"', later, 3, "the active stress is not finite at t = 0.0"),
                ('shortening: "40*t"', later, 3, "the shortening must be below 1 in the whole body; at t = 0.0")):
            file = self.write("brick.yaml", FREE % (active, time))
            for ranks in swept((1, 2, 3), (1,) if code == 3 else (3,)):
                done = self.call("run", file, ranks=ranks)
                self.assertEqual(done.returncode, code, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)

    def test_books_of_a_slow_contraction_balance(self):
        losses = []
        for step in (0.1, 0.05):
            h = self.contract('shortening: "0.3*t*(1 + y)/2"', f"method: quasistatic, step: {step}, end: 1")
            losses.append(abs(h["numerical_dissipation"][-1]))
            self.assertGreater(h["elastic_energy"][-1], 1.0)
            self.assertAlmostEqual(h["load_work"][-1], h["elastic_energy"][-1] + h["numerical_dissipation"][-1],
                                   delta=1e-6 * h["load_work"][-1])
        self.assertLess(losses[1], 0.3 * losses[0])  # trapezoids: second order

    def test_example(self):
        h = self.run_input(ROOT / "input/muscle.yaml", "element=P1", "mesh.size=0.1", "time.end=0.5", "time.step=0.05",
                           "output.every=0.5")
        self.assertGreater(h["tip_z"][-1], 0.15)  # it bends upwards
        self.assertLess(h["tip_x"][-1], 1.0)


class DataOfTheMesh(ProgramTest):
    INPUT = """mesh: {{file: brick.msh}}
bodies:
  - elasticity: {{model: {law}, fibre: {fibre}}}
constraints:
  - {{surface: left, displacement: [0, 0, 0]}}
loads: [{{surface: right, traction: [2e3, 1e3, 0]}}]
time: {{method: static}}
probes: [{{name: tip, point: [2, 1, 1]}}]
"""
    LAW = "guccione, C: {C}, bf: 8, bt: 2, bfs: 4, bulk_modulus: 50 kPa"

    def mesh(self):
        points, triangles, cells = box((4, 2, 2), (2.0, 1.0, 1.0))
        path = write_mesh(self.directory / "brick.msh", points, triangles, cells)
        is_left = points[cells].mean(axis=1)[:, :1] < 1
        first = sum(map(len, triangles)) + 1
        with_data(path, "fibres", np.where(is_left, [3.0, 0, 0], [0, 1.0, -1.0]), first)
        with_data(path, "C of the law", np.where(is_left, 2e3, 4e3), first)
        with_data(path, "half", np.ones(len(cells) // 2), first)

    def test_same_as_formulas(self):
        self.mesh()
        formulas = self.write("formulas.yaml", self.INPUT.format(
            law=self.LAW.format(C='"2e3 + 2e3*(x > 1)"'), fibre='["x < 1", "x > 1", "-(x > 1)"]'))
        data = self.write("data.yaml", self.INPUT.format(
            law=self.LAW.format(C="{cell_data: C of the law}"), fibre="{cell_data: fibres}"))
        for refine in (0, 1):
            expected = self.run_input(formulas, f"mesh.refine={refine}")
            self.assertGreater(expected["tip_x"][-1], 2.02)
            for ranks in swept((1, 2, 3), (1,)) if refine == 0 else (3,):
                h = self.run_input(data, f"mesh.refine={refine}", ranks=ranks)
                self.assert_same_history(expected, h, 1e-7)

    def test_mistakes(self):
        self.mesh()
        good = {"law": self.LAW.format(C="1"), "fibre": "[1, 0, 0]"}
        for change, message in (
                ({"fibre": "{cell_data: fibre}"},
                 "the mesh has no cell data 'fibre'; it has 'fibres', 'C of the law', 'half'"),
                ({"fibre": "{cell_data: half}"}, "cell data 'half' of the mesh has 1 components; 3 are needed"),
                ({"law": self.LAW.format(C="{cell_data: fibres}")}, "has 3 components; 1 is needed"),
                ({"law": self.LAW.format(C="{cell_data: half}")}, "cell data 'half' has no value at ("),
                ({"fibre": '["x - x", 0, 0]'}, "'fibre' has no direction at (")):
            file = self.write("bad.yaml", self.INPUT.format(**{**good, **change}))
            for ranks in swept((1, 2), (1,)):
                done = self.call("run", file, ranks=ranks)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)
                self.assertIn("bad.yaml:3:", done.stderr)


if __name__ == "__main__":
    unittest.main()
