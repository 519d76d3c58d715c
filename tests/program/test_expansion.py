#!/usr/bin/python3
"""Bodies that expand by heat or swelling: closed forms, a strip of two metals, the books of energy."""
import unittest

import h5py
import numpy as np

from program import LONG, ProgramTest, box, swept, write_box, write_mesh

MU, LAMBDA = 1e4, 4e4
BRICK = """mesh: {file: brick.msh}
element: %s
volumetric: %s
bodies:
  - density: 1000
    elasticity: %s
    expansion: {stretch: "%s"}
%sconstraints:
%s
time: {%s}
solver: {newton: {relative: 1e-12}}
output: {fields: [cauchy_stress, volume_ratio]}
probes: [{name: tip, point: [1, 1, 1]}]
"""
SYMMETRY = """  - {surface: left, displacement: [0, free, free]}
  - {surface: front, displacement: [free, 0, free]}
  - {surface: bottom, displacement: [free, free, 0]}"""
CONFINED = SYMMETRY + """
  - {surface: right, displacement: [0, free, free]}
  - {surface: back, displacement: [free, 0, free]}
  - {surface: top, displacement: [free, free, 0]}"""
HELD = """  - {surface: left, displacement: [0, 0, 0]}
  - {surface: right, displacement: [0, 0, 0]}"""
NEO_HOOKEAN = f"{{model: neo-hookean, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}"
LINEAR = f"{{model: linear, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}"
INCOMPRESSIBLE = f"{{model: neo-hookean, shear_modulus: {MU}, poissons_ratio: 0.5}}"
EVERY_TREATMENT = (("P1", "standard"), ("P2", "standard"), ("P2", "mean-dilatation"), ("P1", "mixed"), ("P2", "mixed"))
VISCOSITY = """    viscosity:
      - {model: prony, ratio: 0.6, relaxation_time: 0.05}
      - {model: maxwell, shear_ratio: 0.3, relaxation_time: 0.1}
      - {model: kelvin-voigt, shear: 30, bulk: 50}
"""


class Expansion(ProgramTest):
    def brick(self, law, stretch, constraints, time, kind=("P1", "standard"), viscosity="", n=(2, 2, 2), more=(), ranks=1):
        write_box(self.directory / "brick.msh", n)
        text = BRICK % (*kind, law, stretch, viscosity, constraints, time)
        return self.run_input(self.write("brick.yaml", text), *more, ranks=ranks)

    def last_frame(self, *fields):
        with h5py.File(self.directory / "out/result.h5") as file:
            frame = file["frames"][max(file["frames"])]
            return [frame[field][()] for field in fields]

    def test_free_brick_grows_without_stress(self):
        ranks = 0
        for kind in EVERY_TREATMENT:
            for law in (NEO_HOOKEAN, INCOMPRESSIBLE) if kind[1] == "mixed" else (NEO_HOOKEAN,):
                with self.subTest(kind, law=law):
                    ranks = ranks % 3 + 1 if LONG else 1 + (kind == EVERY_TREATMENT[-1])
                    h = self.brick(law, "1.2", SYMMETRY, "method: static, load_steps: 2", kind, ranks=ranks)
                    np.testing.assert_allclose([h["tip_" + x] for x in "xyz"], [[1, 1.1, 1.2]] * 3, rtol=1e-9)
                    self.assertLess(abs(h["elastic_energy"][-1]), 1e-10 * MU)
                    stress, ratio = self.last_frame("cauchy_stress", "volume_ratio")
                    np.testing.assert_allclose(stress, 0, atol=1e-7 * MU)
                    np.testing.assert_allclose(ratio, 1.2**3, rtol=1e-8)

    def test_free_viscous_brick_grows_without_stress(self):
        h = self.brick(NEO_HOOKEAN, "1 + 0.2*t", SYMMETRY, "method: quasistatic, step: 0.25, end: 1", viscosity=VISCOSITY)
        np.testing.assert_allclose([h["tip_" + x][-1] for x in "xyz"], 1.2, rtol=2e-3)  # the rate of a strain is a difference
        self.assertLess(h["elastic_energy"][-1], 1e-4 * MU)

    def test_confined_brick(self):
        s = 1.1
        forms = {NEO_HOOKEAN: MU * (s - s**3) - 3 * LAMBDA * s**3 * np.log(s), LINEAR: -(3 * LAMBDA + 2 * MU) * (s - 1)}
        for kind in EVERY_TREATMENT:
            for law, expected in forms.items():
                if law == LINEAR and kind[1] != "standard":
                    continue
                with self.subTest(kind, law=law):
                    h = self.brick(law, str(s), CONFINED, "method: static", kind, n=(1, 1, 1))
                    np.testing.assert_allclose(h["right_fx"][-1], expected, rtol=1e-9)
                    stress, = self.last_frame("cauchy_stress")
                    np.testing.assert_allclose(stress, np.broadcast_to([expected] * 3 + [0] * 3, stress.shape),
                                               atol=1e-9 * abs(expected))

    def test_expanded_body_is_a_larger_body(self):
        """Of the same material: pulled and sheared, with a stretch, or on a mesh of that scale."""
        s, kept = 1.25, {}
        for name, stretch, scale, size in (("expanded", s, 1, s), ("large", 1, s, 1)):
            for kind in (("P1", "mixed"), ("P2", "mean-dilatation")):
                held = f'  - {{surface: left, displacement: ["{size - 1}*x", "{size - 1}*y", "{size - 1}*z"]}}\nloads:\n' \
                       f"  - {{surface: right, traction: [{5e3 * size**2}, {2e3 * size**2}, 0]}}"
                h = self.brick(NEO_HOOKEAN, stretch, held, "method: static, load_steps: 2", kind, n=(2, 1, 1),
                               more=[f"mesh.scale={scale}", f"probes=[{{name: tip, point: [{scale}, {scale}, {scale}]}}]"])
                kept[name, kind] = [h["tip_" + x][-1] for x in "xyz"] + [h["elastic_energy"][-1]]
                self.assertGreater(np.abs(kept[name, kind][:3] - np.array(s)).max(), 0.2)
                np.testing.assert_allclose(kept[name, kind], kept["expanded", kind], rtol=1e-8)

    def test_strip_of_two_metals(self):
        """Timoshenko, J. Opt. Soc. Am. 11 (1925) 233-255, with n the ratio of the moduli and m that of the thicknesses."""
        length, width, height, layers = 12.0, 0.5, 1.0, 3
        points, triangles, cells = box((12, 1, layers), (length, width, height))
        is_upper = points[cells].mean(axis=1)[:, 2] > 1 / 3
        write_mesh(self.directory / "strip.msh", points, triangles, cells, (["lower", "upper"], is_upper.astype(int)))
        s1, s2, m, n = 1.0, 1 + 1e-4, 0.5, 3.0
        self.write("strip.yaml", f"""mesh: {{file: strip.msh}}
element: P2
bodies:
  - volume: lower
    elasticity: {{model: neo-hookean, youngs_modulus: {n} GPa, poissons_ratio: 0.3}}
    expansion: {{stretch: {s1}}}
  - volume: upper
    elasticity: {{model: neo-hookean, youngs_modulus: 1 GPa, poissons_ratio: 0.3}}
    expansion: {{stretch: {s2!r}}}
constraints:
  - {{surface: left, displacement: [0, free, free]}}
  - {{surface: front, displacement: [free, 0, free]}}
  - {{where: "x < 1e-9 && z < 1e-9", displacement: [0, free, 0]}}
time: {{method: static}}
probes: [{{name: near, point: [2, 0, 0]}}, {{name: far, point: [10, 0, 0]}}, {{name: middle, point: [6, 0, 0]}}]
""")
        h = self.run_input("strip.yaml")
        curvature = 6 * (s2 - s1) * (1 + m)**2 / (height * (3 * (1 + m)**2 + (1 + m * n) * (m**2 + 1 / (m * n))))
        measured = (2 * h["middle_z"][-1] - h["near_z"][-1] - h["far_z"][-1]) / 4.0**2  # the longer layer is outside
        self.assertLess(abs(measured / curvature - 1), 0.02)

    def test_books_balance(self):
        """The brick is held at both ends: what expansion supplies is stored, moves the sides, or is lost to viscosity."""
        stretch = "1 + 0.1*sin(2*pi*t)^2*(1 + x*y)"
        for ranks, (kind, viscosity) in enumerate(((("P1", "standard"), VISCOSITY), (("P1", "mixed"), VISCOSITY),
                                                   (("P2", "mean-dilatation"), "")), 1):
            losses = []
            for step in (0.02, 0.01):
                with self.subTest(kind, step=step):
                    h = self.brick(NEO_HOOKEAN, stretch, HELD, f"method: dirk33, step: {step}, end: 0.2", kind, viscosity,
                                   n=(2, 1, 1), ranks=ranks if LONG else 1)
                    scale = max(np.abs(h["load_work"]).max(), h["elastic_energy"].max())
                    self.assertGreater(scale, 10)
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * scale)
                    losses.append(np.abs(h["numerical_dissipation"][-1]) / scale)
            self.assertLess(losses[1], 0.3 * losses[0])  # third order
            self.assertLess(losses[1], 1e-2)

    def test_books_of_slow_heating_balance(self):
        for viscosity in ("", VISCOSITY):
            losses = []
            for step in (0.1, 0.05):
                h = self.brick(NEO_HOOKEAN, "1 + 0.1*t*(1 + y)", HELD, f"method: quasistatic, step: {step}, end: 1",
                               viscosity=viscosity, n=(2, 1, 1))
                self.assertGreater(h["elastic_energy"][-1], 1.0)
                losses.append(abs(h["numerical_dissipation"][-1]))
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * h["load_work"][-1])
                self.assertEqual(h["dissipated_energy"][-1] > 0, bool(viscosity))
            self.assertLess(losses[1], (0.6 if viscosity else 0.3) * losses[0])

    def test_books_of_slow_heating_with_pressures(self):
        losses = []
        for step in (0.1, 0.05):
            h = self.brick(NEO_HOOKEAN, "1 + 0.1*t", HELD, f"method: quasistatic, step: {step}, end: 1", ("P2", "mixed"), n=(1, 1, 1))
            losses.append(abs(h["numerical_dissipation"][-1]) / h["elastic_energy"][-1])
        self.assertLess(losses[0], 0.02)
        self.assertLess(losses[1], 0.3 * losses[0])

    def test_stretch_that_is_not_positive(self):
        write_box(self.directory / "brick.msh", (1, 1, 1))
        for stretch, method, code, message in (
                ("x - 0.5", "static", 2, "brick.yaml:7:16: the stretch must be > 0 in the whole body; at t = 0 it is -"),
                ("1 - 2*t", "quasistatic, step: 0.2, end: 1", 3, "the stretch must be > 0 in the whole body; at t = 0.6 it is -0.2")):
            for ranks in swept((1, 2), (1,)):
                done = self.call("run", self.write("brick.yaml", BRICK % ("P1", "standard", LINEAR, stretch, "", SYMMETRY,
                                                                          "method: " + method)), ranks=ranks)
                self.assertEqual(done.returncode, code, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main()
