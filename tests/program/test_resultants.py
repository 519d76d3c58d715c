#!/usr/bin/python3
"""Stress resultants and curvatures of shells, and of rods, against closed forms; what columns of the history may be taken from."""
import sys
import unittest

import numpy as np

from program import ROOT, ProgramTest, swept, write_box
from shell_meshes import write_ball, write_patch

sys.path.insert(0, str(ROOT / "src/python"))

from pliant.result import Result  # noqa: E402

LAW = "elasticity: {model: saint-venant-kirchhoff, youngs_modulus: %g, poissons_ratio: %g}"
SHELL_FIELDS = "membrane_force, principal_membrane_force, bending_moment, principal_bending_moment, principal_curvature"


def flat(s, t):
    return s, t, 0.0


class Resultants(ProgramTest):
    def frame(self, text, ranks=1, fields=SHELL_FIELDS, history=""):
        """The last frame and the last row of the history of a static input."""
        self.write("in.yaml", f"{text}time: {{method: static}}\noutput: {{fields: [displacement, {fields}], history: [{history}]}}\n")
        rows = self.run_input("in.yaml", ranks=ranks)
        return Result(self.directory / "out")[-1], {name: column[-1] for name, column in rows.items()}

    def test_a_stretched_sheet(self):
        # Plane stress, homogeneous on any mesh: Cauchy's force per length is the force on the width that is left.
        E, nu, h, stretch = 1e6, 0.3, 1e-3, 1.2
        write_patch(self.directory / "sheet.msh", 3, flat, jitter=0.3)
        text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: sheet, surface: sheet, free: true, thickness: {h}, bending: true, {LAW % (E, nu)}}}]
constraints:
  - {{curve: s0, displacement: [0, free, free]}}
  - {{curve: t0, displacement: [free, 0, free]}}
  - {{curve: s1, displacement: [{stretch - 1}, free, free], name: right}}
  - {{where: "x > -1", displacement: [free, free, 0]}}
solver: {{newton: {{relative: 1e-12}}}}
"""
        columns = ", ".join(f"{{name: {take}, of: membrane_force_xx, in: sheet, take: {take}}}" for take in ("min", "max", "mean", "integral"))
        columns += ", {name: first, of: principal_membrane_force_1, take: max}, {name: second, of: principal_membrane_force_2, take: max}"
        columns += ", {name: way, of: displacement_x, take: mean}, {name: there, of: displacement_x, in: sheet, take: max}"
        strain = (stretch**2 - 1) / 2
        across = np.sqrt(1 - 2 * nu * strain)
        for element, ranks in swept((("P1", 1), ("P1", 2), ("P1", 3), ("P2", 1), ("P2", 2)), (("P1", 2), ("P2", 1))):
            frame, row = self.frame(f"element: {element}\n{text}", ranks, history=columns)
            N = E * strain * stretch * h / across
            np.testing.assert_allclose(row["right_fx"], N * across, rtol=1e-9)
            for name in ("min", "max", "mean", "integral", "first"):
                np.testing.assert_allclose(row[name], N, rtol=1e-9, err_msg=name)
            self.assertLess(abs(row["second"]), 1e-7 * N)
            np.testing.assert_allclose([row["way"], row["there"]], [(stretch - 1) / 2, stretch - 1], rtol=1e-9)
            self.assertTrue(frame.field("membrane_force").on_nodes)
            np.testing.assert_allclose(frame["membrane_force"], np.tile([N, 0, 0, 0, 0, 0], (len(frame["displacement"]), 1)), atol=1e-8 * N)
            self.assertLess(np.abs(frame["principal_curvature"]).max(), 1e-9)

    def test_a_bent_plate(self):
        # A quadratic deflection: its curvature, and the moments of a plate, inside; on the free rim no moment across it.
        E, nu, h, k = 1e9, 0.3, 0.01, 1e-3
        write_patch(self.directory / "sheet.msh", 8, flat, jitter=0.2)
        D = E * h**3 / (12 * (1 - nu**2))
        text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: plate, surface: sheet, free: true, thickness: {h}, bending: true, {LAW % (E, nu)}}}]
constraints: [{{where: "x > -1", displacement: [0, 0, "{k / 2}*x^2"]}}]
"""
        for element, ranks in swept((("P1", 1), ("P1", 2), ("P1", 3), ("P2", 1), ("P2", 2)), (("P1", 2), ("P2", 2))):
            frame, _ = self.frame(f"element: {element}\n{text}", ranks)
            X = frame.mesh.coordinates
            inside = np.all((X[:, :2] > 0.33) & (X[:, :2] < 0.67), axis=1)
            self.assertGreater(inside.sum(), 8)
            # The upper side, to which the normals point, is hollow and compressed.
            expected = {"bending_moment": [-D * k, -nu * D * k, 0, 0, 0, 0], "principal_bending_moment": [-nu * D * k, -D * k, 0],
                        "principal_curvature": [0, -k, 0]}
            for name, want in expected.items():
                size = k if "curvature" in name else D * k
                np.testing.assert_allclose(frame[name][inside] / size, np.tile(want, (inside.sum(), 1)) / size, atol=2e-3, err_msg=name)

    def test_the_moment_at_a_clamped_edge(self):
        # Timoshenko: -0.0513 q a^2 at the middle of the side of a clamped square. A facet of six nodes is four triangles, each
        # with its moment: as many squares of quadratic elements are as good as twice as many of linear ones.
        q, found = 1.0, {}
        for element, n in (("P1", 8), ("P1", 16), ("P2", 8)):
            write_patch(self.directory / "sheet.msh", n, flat)
            sides = ("s0", "s1", "t0", "t1")
            text = f"""mesh: {{file: sheet.msh}}
element: {element}
shells: [{{name: plate, surface: sheet, free: true, thickness: 0.01, bending: true, {LAW % (1e9, 0.3)},
  clamped: [{", ".join(f"{{curve: {side}}}" for side in sides)}]}}]
constraints: [{", ".join(f"{{curve: {side}, displacement: [0, 0, 0]}}" for side in sides)}]
loads: [{{surface: sheet, traction: [0, 0, {q}]}}]
"""
            _, row = self.frame(text, history="{name: M, of: bending_moment_xx, in: plate, take: min}, "
                                              "{name: N, of: bending_moment_xx, in: plate, take: max}")
            found[element, n] = max(abs(row["M"]), abs(row["N"]))
        self.assertAlmostEqual(found["P1", 16] / 0.0513, 1, delta=0.05)
        self.assertAlmostEqual(found["P2", 8] / found["P1", 16], 1, delta=0.02)

    def test_a_balloon(self):
        # N = p r/2 and curvatures of 1/r, negative where normals point inwards.
        mu, h, R, stretch = 300e3, 1e-3, 0.1, 1.2
        write_ball(self.directory / "sheet.msh", 6, R)
        pressure = 2 * h * mu / R * (1 / stretch - stretch**-7)
        text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: balloon, surface: sheet, free: true, thickness: {h}, bending: true,
  elasticity: {{model: neo-hookean-isochoric, shear_modulus: {mu}, bulk_modulus: 1e9}}}}]
constraints:
  - {{where: "abs(x) < 1e-9", displacement: [0, free, free]}}
  - {{where: "abs(y) < 1e-9", displacement: [free, 0, free]}}
  - {{where: "abs(z) < 1e-9", displacement: [free, free, 0]}}
loads: [{{surface: sheet, pressure: {pressure}}}]
"""
        columns = ", ".join(f"{{name: {name}{n}, of: principal_{field}_{n}, in: balloon, take: mean}}"
                            for name, field in (("N", "membrane_force"), ("k", "curvature")) for n in (1, 2))
        _, row = self.frame(text, history=columns)
        r = stretch * R
        np.testing.assert_allclose([row["N1"], row["N2"]], pressure * r / 2, rtol=0.035)  # of the mesh: 2.3 and 3.1 %
        np.testing.assert_allclose([row["k1"], row["k2"]], -1 / r, rtol=0.05)  # of the mesh: 0.2 and 4.6 %

    def test_a_skin_on_a_body(self):
        # Stretched with the body; two layers on one another are added.
        write_box(self.directory / "box.msh", (2, 2, 2))
        strain, E, h = 1e-3, 1e8, 1e-3
        layer = f"surface: right, thickness: {h}, {LAW % (E, 0)}"
        text = f"""mesh: {{file: box.msh}}
bodies: [{{elasticity: {{model: linear, youngs_modulus: 1e6, poissons_ratio: 0}}}}]
shells: [{{name: skin, {layer}}}, {{name: second, {layer}}}]
constraints: [{{where: "x > -1", displacement: [0, "{strain}*y", 0]}}]
"""
        N = E * h * (strain + strain**2 / 2) * (1 + strain)
        for ranks in swept((1, 2, 3), (2,)):
            frame, row = self.frame(text, ranks, history="{name: n, of: membrane_force_yy, in: skin, take: max}, "
                                    "{name: s, of: von_mises_stress, take: max}")
            np.testing.assert_allclose(row["n"], N, rtol=1e-9)
            self.assertGreater(row["s"], 0)
            x = frame.mesh.coordinates[:, 0]
            np.testing.assert_allclose(frame["membrane_force"][:, 1], np.where(x > x.max() - 1e-9, 2 * N, 0), atol=1e-9 * N)

    def test_a_rod(self):
        # A cantilever that a block pulls, bends and twists: the moment at the wall, and its mean.
        P, T, M, L = 1e-3, 2.0, 3e-4, 0.5
        text = f"""rods: [{{name: beam, points: [[0, 0, 0], [{L}, 0, 0]], segments: 10, radius: 5 mm, density: 1000, youngs_modulus: 1 GPa,
         poissons_ratio: 0.3, start: ground, end: tip}}]
rigid_bodies: [{{name: tip, center: [{L}, 0, 0]}}]
loads: [{{force: [{T}, 0, {P}], volume: tip}}, {{torque: [{M}, 0, 0], volume: tip}}]
"""
        columns = ", ".join(f"{{name: {name}, of: {of}, in: beam, take: {take}}}" for name, of, take in (
            ("pull", "rod_force", "mean"), ("most", "rod_bending_moment", "max"), ("least", "rod_bending_moment", "min"),
            ("average", "rod_bending_moment", "mean"), ("twist", "rod_torque", "max")))
        for ranks in swept((1, 2, 3), (2,)):
            frame, row = self.frame(text, ranks, "rod_force, rod_bending_moment, rod_torque", columns)
            np.testing.assert_allclose(row["pull"], T, rtol=1e-5)
            np.testing.assert_allclose(row["twist"], M, rtol=1e-4)
            # The pull takes a part of the moment: P L tanh(w)/w, w = L sqrt(T/(E I)).
            w = L * np.sqrt(T / (1e9 * np.pi / 4 * 5e-3**4))
            np.testing.assert_allclose(row["most"], P * L * np.tanh(w) / w, rtol=0.01)
            np.testing.assert_allclose(row["average"], P * L * (1 - 1 / np.cosh(w)) / w**2, rtol=2e-3)
            self.assertLess(row["least"], 1e-3 * P * L)
            segments = np.array([name == "beam" for name in np.array(frame.mesh.body_names)[frame.mesh.body]])
            self.assertEqual(segments.sum(), 10)
            np.testing.assert_allclose(frame["rod_force"][segments], T, rtol=1e-5)
            np.testing.assert_allclose(frame["rod_torque"][segments], M, rtol=1e-4)
            np.testing.assert_allclose(frame["rod_bending_moment"][segments].mean(), row["average"], rtol=1e-9)

    def test_what_is_refused(self):
        write_patch(self.directory / "sheet.msh", 2, flat)
        sheet = f"""mesh: {{file: sheet.msh}}
shells: [{{name: sail, surface: sheet, free: true, thickness: 1 mm, {LAW % (1e6, 0.3)}}}]
constraints: [{{curve: s0, displacement: [0, 0, 0]}}]
time: {{method: static}}
"""
        rod = """rods: [{name: beam, points: [[0, 0, 0], [1, 0, 0]], radius: 1 mm, youngs_modulus: 1e9, poissons_ratio: 0.3, start: ground}]
time: {method: static}
"""
        column = lambda of, place="": f"output: {{history: [{{name: c, of: {of}{place}, take: max}}]}}\n"
        cases = {
            "'von_mises_stress' is of bodies of tetrahedra, and this input has none": sheet + column("von_mises_stress"),
            "'discretization_error' is of bodies": sheet + "output: {fields: [displacement, discretization_error]}\n",
            "'membrane_force' needs 'shells'": rod + column("membrane_force_xx"),
            "'rod_torque' needs 'rods'": sheet + column("rod_torque"),
            "'membrane_force' is a field of shells: 'in' is the name of one, not 'sil' (did you mean 'sail'?)":
                sheet + column("membrane_force_xx", ", in: sil"),
            "contains no tetrahedron of a body with a mesh": rod + column("displacement"),
        }
        self.assert_refused(cases)


if __name__ == "__main__":
    unittest.main()
