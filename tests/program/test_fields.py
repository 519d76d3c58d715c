#!/usr/bin/python3
"""Strains, stresses and their principal values, smoothed fields, columns of the history from fields, and the error of the mesh."""
import json
import unittest

import h5py
import numpy as np

from program import ProgramTest, box, read_history, swept, write_box, write_mesh
from report_file import ReportFile

YOUNG, NU = 2e5, 0.3
MU, LAMBDA = YOUNG / (2 * (1 + NU)), YOUNG * NU / ((1 + NU) * (1 - 2 * NU))
VOIGT = ((0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2))
FIELDS = ("cauchy_stress", "principal_stress", "first_piola_kirchhoff_stress", "displacement_gradient", "green_lagrange_strain",
          "log_strain", "principal_stretches", "volume_ratio", "von_mises_stress", "discretization_error")
# Stretched, sheared and turned.
F = np.array([[1.2, 0.3, 0.0], [-0.1, 0.9, 0.05], [0.02, 0.0, 1.1]])
CUBE = """mesh: {file: cube.msh}
element: %s
%s
bodies: [{volume: body, elasticity: {model: %s, youngs_modulus: %g, poissons_ratio: %g}}]
constraints: [{where: "x > -1", displacement: [%s]}]
time: {method: static, end: 1}
output: {nodal: %s, fields: [%s], history: [%s]}
"""


def formulas(gradient):
    return ", ".join('"' + " + ".join(f"({h!r})*{x}" for h, x in zip(row, "xyz")) + '"' for row in gradient.tolist())


def neo_hookean(F):
    """Cauchy stress."""
    J = np.linalg.det(F)
    return (MU * (F @ F.T - np.eye(3)) + LAMBDA * np.log(J) * np.eye(3)) / J


def function_of(A, f):
    values, vectors = np.linalg.eigh(A)
    return vectors @ np.diag(f(values)) @ vectors.T


def von_mises(s):
    d = s - np.trace(s) / 3 * np.eye(3)
    return np.sqrt(1.5 * np.tensordot(d, d))


class Fields(ProgramTest):
    def frame(self, name="out"):
        """Fields of the last frame, with `location`s, and the mesh's nodes and cells."""
        with h5py.File(self.directory / name / "result.h5") as file:
            group = file["frames"][sorted(file["frames"])[-1]]
            values = {field: group[field][()] for field in group}
            return values, {field: group[field].attrs["location"].decode() for field in group}, file["mesh/coordinates"][()], file["mesh/cells"][()]

    def wanted(self):
        sigma = neo_hookean(F)
        J = np.linalg.det(F)
        return {"cauchy_stress": sigma[VOIGT], "principal_stress": np.linalg.eigvalsh(sigma)[::-1],
                "first_piola_kirchhoff_stress": (J * sigma @ np.linalg.inv(F).T).ravel(),
                "displacement_gradient": (F - np.eye(3)).ravel(),
                "green_lagrange_strain": ((F.T @ F - np.eye(3)) / 2)[VOIGT],
                "log_strain": function_of(F @ F.T, lambda b: np.log(b) / 2)[VOIGT],
                "principal_stretches": np.linalg.svd(F)[1], "volume_ratio": J, "von_mises_stress": von_mises(sigma)}

    def test_uniform_deformation(self):
        """All are the same everywhere, in cells or smoothed at nodes, and the error of the mesh is none."""
        write_box(self.directory / "cube.msh", (2, 2, 1))
        cases = [(element, nodal, ranks, volumetric) for element, volumetric in
                 (("P1", "standard"), ("P2", "standard"), ("P2", "mean-dilatation"), ("P1", "mixed"), ("P2", "mixed"))
                 for nodal in ("false", "true") for ranks in (1, 2, 3)]
        usually = [("P1", "true", 2, "standard"), ("P1", "false", 1, "standard"), ("P2", "false", 1, "mean-dilatation"),
                   ("P2", "true", 1, "mixed")]
        for element, nodal, ranks, volumetric in swept(cases, usually):
            with self.subTest(element=element, nodal=nodal, ranks=ranks, volumetric=volumetric):
                self.write("cube.yaml", CUBE % (element, f"volumetric: {volumetric}", "neo-hookean", YOUNG, NU,
                                                formulas(F - np.eye(3)), nodal, ", ".join(FIELDS), ""))
                history = self.run_input("cube.yaml", ranks=ranks)
                values, locations, _, _ = self.frame()
                for name, want in self.wanted().items():
                    self.assertEqual(locations[name], "node" if nodal == "true" else "cell", name)
                    scale = MU if "stress" in name else 1
                    np.testing.assert_allclose(values[name], np.broadcast_to(want, values[name].shape), atol=1e-9 * scale,
                                               err_msg=name)
                self.assertEqual(locations["discretization_error"], "cell")
                self.assertLess(values["discretization_error"].max(), 1e-12 * MU)
                self.assertLess(history["discretization_error"].max(), 1e-12)

    def test_simple_shear_has_the_strains_of_textbooks(self):
        gamma = 0.5
        write_box(self.directory / "cube.msh", (1, 1, 1))
        H = np.zeros((3, 3))
        H[0, 1] = gamma
        self.write("cube.yaml", CUBE % ("P1", "", "neo-hookean", YOUNG, NU, formulas(H), "false", ", ".join(FIELDS), ""))
        self.run_input("cube.yaml")
        values = self.frame()[0]
        largest = gamma / 2 + np.sqrt(1 + gamma**2 / 4)
        np.testing.assert_allclose(values["principal_stretches"][0], [largest, 1, 1 / largest], rtol=1e-12)
        np.testing.assert_allclose(values["green_lagrange_strain"][0], [0, gamma**2 / 2, 0, gamma / 2, 0, 0], atol=1e-12)
        # P = mu (F - F^-T), tau = mu gamma.
        self.assertAlmostEqual(values["first_piola_kirchhoff_stress"][0, 1] / (MU * gamma), 1, delta=1e-12)
        self.assertAlmostEqual(values["first_piola_kirchhoff_stress"][0, 3] / (MU * gamma), 1, delta=1e-12)

    BENDING = np.array([2e-7, 1e-7])  # curvatures [1/m] about y and z: Cauchy stress is linear in them to 1e-7
    STRESS = YOUNG * 1e-7

    def bent(self, element, ranks, nodal="true", history=""):
        """Pure bending, which quadratic elements represent: sigma_xx = E (k z - c y), all else 0."""
        k, c = self.BENDING
        u = (f'"{k}*x*z - {c}*x*y"',
             f'"{c}*x^2/2 - {NU}*({k}*y*z - {c}*(y^2 - z^2)/2)"',
             f'"-{k}*x^2/2 - {NU}*({k}*(z^2 - y^2)/2 - {c}*y*z)"')
        write_box(self.directory / "cube.msh", (3, 2, 2), (1.5, 1, 1), origin=(0, -0.5, -0.5))
        self.write("cube.yaml", CUBE % (element, "", "linear", YOUNG, NU, ", ".join(u), nodal,
                                        "displacement, cauchy_stress, von_mises_stress, principal_stress, discretization_error", history))
        return self.run_input("cube.yaml", ranks=ranks)

    def test_smoothed_stress_of_bending_is_exact_at_the_surface(self):
        k, c = self.BENDING
        for ranks in swept((1, 2, 3), (2,)):
            history = self.bent("P2", ranks)
            values, locations, X, _ = self.frame()
            self.assertEqual(locations["cauchy_stress"], "node")
            stress = YOUNG * (k * X[:, 2] - c * X[:, 1])
            # At the few nodes with a single cell around them the smoothed value is that of its centroid.
            exact = np.abs(values["cauchy_stress"][:, 0] - stress) < 1e-6 * self.STRESS
            self.assertGreater(exact.mean(), 0.9)
            self.assertAlmostEqual(stress[exact].max() / stress.max(), 1, delta=1e-6)  # a corner or an edge, not only the middle
            np.testing.assert_allclose(values["von_mises_stress"][exact], np.abs(stress[exact]), atol=1e-6 * self.STRESS)
            np.testing.assert_allclose(values["principal_stress"][exact, 0], np.maximum(stress[exact], 0), atol=1e-6 * self.STRESS)
            self.assertLess(history["discretization_error"][-1], 1e-12)  # the gradient is linear

    COLUMNS = """
      {name: most, of: cauchy_stress_xx, in: body, take: max}, {name: least, of: cauchy_stress_xx, in: body, take: min},
      {name: middle, of: cauchy_stress_xx, take: mean}, {name: force, of: cauchy_stress_xx, in: right, take: integral},
      {name: on_top, of: cauchy_stress_xx, in: top, take: mean}, {name: tip, of: displacement_z, in: right, take: mean},
      {name: far, of: displacement, in: right, take: max}, {name: near, of: displacement_x, in: 1, take: min},
      {name: size, of: volume_ratio, in: body, take: integral}, {name: u, of: displacement, take: norm},
      {name: grad_u, of: displacement_gradient, take: norm}, {name: sigma, of: cauchy_stress, take: norm}"""

    def test_columns_from_fields(self):
        k, c = self.BENDING
        for element, ranks in swept([(e, r) for e in ("P1", "P2") for r in (1, 2, 3)], [("P2", 1), ("P2", 3), ("P1", 2)]):
            with self.subTest(element=element, ranks=ranks):
                history = {name: values[-1] for name, values in self.bent(element, ranks, "false", self.COLUMNS).items()}
                values, _, X, cells = self.frame()
                corners = X[cells[:, :4]]
                volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
                xx = values["cauchy_stress"][:, 0]
                for name, want in {"most": xx.max(), "least": xx.min(), "middle": volumes @ xx / 1.5,
                                   "sigma": np.sqrt(volumes @ (values["cauchy_stress"]**2 @ [1, 1, 1, 2, 2, 2]))}.items():
                    self.assertAlmostEqual(history[name], want, delta=1e-11 * self.STRESS, msg=name)
                self.assertAlmostEqual(history["near"], 0, delta=1e-15)
                right = values["displacement"][X[:, 0] == 1.5]
                self.assertAlmostEqual(history["far"], np.linalg.norm(right, axis=1).max(), delta=1e-14)
                # The cells behind facets, which are equally large on each side.
                behind = {side: xx[(np.abs(corners[:, :, axis] - end) < 1e-9).sum(axis=1) == 3].mean()
                          for side, axis, end in (("right", 0, 1.5), ("top", 2, 0.5))}
                self.assertAlmostEqual(history["on_top"], behind["top"], delta=1e-11 * self.STRESS)
                self.assertAlmostEqual(history["force"], behind["right"], delta=1e-11 * self.STRESS)
                if element == "P1":
                    continue
                # Closed forms of the quadratic displacement, Gauss points enough for its square.
                x, y, z, w = self.gauss()
                u = np.array([k * x * z - c * x * y, c * x**2 / 2 - NU * (k * y * z - c * (y**2 - z**2) / 2),
                              -k * x**2 / 2 - NU * (k * (z**2 - y**2) / 2 - c * y * z)])
                strain = k * z - c * y
                turned = k * x, c * x, -NU * (k * y + c * z)  # du_x/dz = -du_z/dx, du_y/dx = -du_x/dy, du_y/dz = -du_z/dy
                square = (1 + 2 * NU**2) * strain**2 + 2 * sum(g**2 for g in turned)
                self.assertAlmostEqual(history["u"], np.sqrt(w @ (u**2).sum(axis=0)), delta=1e-9 * k)
                self.assertAlmostEqual(history["grad_u"], np.sqrt(w @ square), delta=1e-9 * k)
                self.assertAlmostEqual(history["tip"], -k * 1.5**2 / 2, delta=1e-9 * k)

    def test_fields_at_probes(self):
        k, c = self.BENDING
        points = {"inside": (0.31, 0.1, -0.17), "corner": (1.5, -0.5, 0.5), "beyond": (1.51, -0.5, 0.5)}
        columns = ", ".join(f"{{name: {name}_{short}, of: {of}, at: {name}}}" for name in points
                            for short, of in (("u", "displacement_z"), ("far", "displacement"), ("xx", "cauchy_stress_xx")))
        for nodal, ranks in swept([(n, r) for n in ("true", "false") for r in (1, 2, 3)], [("true", 2), ("false", 3)]):
            with self.subTest(nodal=nodal, ranks=ranks):
                probes = ", ".join(f"{{name: {name}, point: [{x}, {y}, {z}]}}" for name, (x, y, z) in points.items())
                history = self.bent("P2", ranks, nodal, columns + f"]}}\nprobes: [{probes}]\n#")
                values, _, X, cells = self.frame()
                for name, place in points.items():
                    x, y, z = place = np.minimum(place, 1.5)
                    self.assertAlmostEqual(history[name + "_u"][-1], -k * x**2 / 2 - NU * (k * (z**2 - y**2) / 2 - c * y * z), delta=1e-14)
                    self.assertAlmostEqual(history[name + "_far"][-1], np.linalg.norm([history[f"{name}_u{i}"][-1] for i in "xyz"]), delta=1e-14)
                    corners = X[cells[:, :4]]
                    weights = np.linalg.solve(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2), (place - corners[:, 0])[:, :, None])[:, :, 0]
                    around = (weights > -1e-9).all(axis=1) & (weights.sum(axis=1) < 1 + 1e-9)
                    xx = values["cauchy_stress"][:, 0]
                    if nodal == "false":
                        self.assertLess(np.abs(xx[around] - history[name + "_xx"][-1]).min(), 1e-11 * self.STRESS)
                    elif name == "inside":
                        self.assertAlmostEqual(history["inside_xx"][-1], YOUNG * (k * z - c * y), delta=1e-6 * self.STRESS)

    @staticmethod
    def gauss():
        points, weights = np.polynomial.legendre.leggauss(4)
        x, y, z = (a.ravel() for a in np.meshgrid(0.75 + 0.75 * points, 0.5 * points, 0.5 * points, indexing="ij"))
        w = np.einsum("i,j,k->ijk", 0.75 * weights, 0.5 * weights, 0.5 * weights).ravel()
        return x, y, z, w

    def test_a_surface_inside_has_the_mean_of_both_sides(self):
        points, triangles, cells = box((3, 2, 2))
        faces = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
        triangles[5] = np.unique(faces[(np.abs(points[faces][:, :, 2] - 0.5) < 1e-9).all(axis=1)], axis=0)  # top, halfway up
        above = (points[cells].mean(axis=1)[:, 2] > 0.5).astype(int)
        write_mesh(self.directory / "two.msh", points, triangles, cells, (["soft", "stiff"], above))
        law = "elasticity: {model: saint-venant-kirchhoff, youngs_modulus: %g, poissons_ratio: 0}"
        self.write("two.yaml", f"""mesh: {{file: two.msh}}
bodies:
  - {{volume: soft, {law % 1e4}}}
  - {{volume: stiff, {law % 3e4}}}
constraints: [{{where: "x > -1", displacement: [0, 0, "0.1*z"]}}]
time: {{method: static}}
output:
  history:
    - {{name: between, of: first_piola_kirchhoff_stress_zz, in: top, take: mean}}
    - {{name: most, of: first_piola_kirchhoff_stress_zz, in: top, take: max}}
    - {{name: force, of: first_piola_kirchhoff_stress_zz, in: bottom, take: integral}}
    - {{name: moved, of: displacement_z, in: top, take: integral}}
""")
        stress = 1e4 * 1.1 * (1.1**2 - 1) / 2  # F S
        for ranks in swept((1, 2, 3), (1, 3)):
            history = self.run_input("two.yaml", ranks=ranks)
            for name, want in {"between": 2 * stress, "most": 3 * stress, "force": stress, "moved": 0.05}.items():
                self.assertAlmostEqual(history[name][-1] / want, 1, delta=1e-12, msg=name)

    BEAM = """mesh: {file: beam.msh}
element: %s
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
constraints: [{name: wall, surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, "-10*t"]}]
probes: [{name: tip, point: [10, 0.5, 0.5]}]
time: {method: quasistatic, step: 0.5, end: 1}
output: {fields: [displacement, discretization_error], history: [{name: sag, of: displacement_z, in: right, take: min},
                                                             {name: peak, of: von_mises_stress, take: max}]}
"""

    def beam(self, element, n, *settings, ranks=1, output="out"):
        write_box(self.directory / "beam.msh", n, (10, 1, 1))
        self.write("beam.yaml", self.BEAM % element)
        arguments = ["run", "beam.yaml", "--output", output] + [a for s in settings for a in ("--set", s)]
        done = self.pliant(*arguments, ranks=ranks)
        summary = json.loads((self.directory / output / "summary.json").read_text())
        return read_history(self.directory / output), summary["discretization_error"], done.stdout + done.stderr

    def test_one_layer_of_linear_elements_in_bending_is_found_out(self):
        deflection = 10 * 10**3 / (3 * 1e6 / 12)  # P L^3 / 3 E I at t = 1
        history, error, text = self.beam("P1", (10, 1, 1))
        self.assertLess(-history["sag"][-1], 0.3 * deflection)  # silently wrong
        self.assertGreater(error["share"], 0.5)
        self.assertEqual(history["discretization_error"][-1], error["share"])
        self.assertEqual(error["time"], 1)
        self.assertRegex(text, r"warning: beam.yaml:1:14: the mesh is too coarse: .* about \d+ % .*element: P2.* first around \(0\.\d+, ")
        self.assertRegex(text, r"discretization error: 6[0-9] % of the elastic energy, when that was largest \(t = 1 s\)")
        x, y, z = error["place"]
        self.assertLess(x, 1)  # at the wall
        history, error, text = self.beam("P2", (10, 1, 1))
        self.assertAlmostEqual(-history["sag"][-1] / deflection, 1, delta=0.03)
        self.assertLess(error["share"], 0.03)
        self.assertNotIn("too coarse", text)
        # Who does not ask for the estimate has a note about linear elements all the same, at the end, and about no others.
        unasked = ("output.fields=[displacement]", "output.history=[]")
        for element, n, has_note in (("P1", (10, 1, 1), True), ("P2", (10, 1, 1), False), ("P1", (32, 4, 4), False)):
            write_box(self.directory / "beam.msh", n, (10, 1, 1))
            self.write("beam.yaml", self.BEAM % element)
            text = self.pliant("run", "beam.yaml", *[word for setting in unasked for word in ("--set", setting)]).stdout
            self.assertEqual("note: beam.yaml:1:14: linear elements are too coarse here: about 6" in text, has_note, text)
            self.assertEqual("element: P2" in text, has_note)

    def test_the_estimate_is_as_large_as_the_error(self):
        """The energy of the error is what the energy of the same load lacks."""
        energy = {}
        for element, n in (("P1", (20, 2, 2)), ("P1", (40, 4, 4)), ("P2", (10, 1, 1)), ("P2", (20, 3, 3))):
            history, error, _ = self.beam(element, n, "time.step=1", "loads.0.traction=[0,0,-0.01*t]")
            energy[element, n] = history["elastic_energy"][-1], error["energy"]
        reference = energy["P2", (20, 3, 3)][0] + energy["P2", (20, 3, 3)][1]
        for case, (elastic, estimate) in energy.items():
            effectivity = np.sqrt(estimate / (reference - elastic))
            self.assertTrue(0.7 < effectivity < 1.3, f"{case}: {effectivity}")

    def test_lames_cylinder(self):
        """On unstructured curved meshes: smoothed stresses at the inner surface, and the error as the energy that is lacking."""
        a, b, p = 1, 2, 10
        u = (1 + NU) / YOUNG * p * a**2 / (b**2 - a**2) * ((1 - 2 * NU) * a + b**2 / a)  # plane strain
        energy = p * u / 2 * np.pi / 2 * a
        self.write("cylinder.geo", """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 1, 2, Pi/2};
Cylinder(2) = {0, 0, 0, 0, 0, 1, 1, Pi/2};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Physical Volume("wall") = {3};
Mesh.ElementOrder = 2;
""")
        for element, size, tolerance in (("P1", 0.25, 0.2), ("P2", 0.5, 0.12)):
            with self.subTest(element=element):
                self.write("cylinder.yaml", f"""mesh: {{file: cylinder.geo, size: {size}}}
element: {element}
bodies: [{{elasticity: {{model: linear, youngs_modulus: {YOUNG}, poissons_ratio: {NU}}}}}]
constraints:
  - {{where: "x < 1e-9", displacement: [0, free, free]}}
  - {{where: "y < 1e-9", displacement: [free, 0, free]}}
  - {{where: "z < 1e-9 || z > 1 - 1e-9", displacement: [free, free, 0]}}
loads: [{{where: "x^2 + y^2 < 1.01", traction: ["{p}*x", "{p}*y", 0]}}]
time: {{method: static}}
output: {{nodal: true, fields: [principal_stress, discretization_error]}}
""")
                history = self.run_input("cylinder.yaml")
                values, _, X, _ = self.frame()
                error = json.loads((self.directory / "out/summary.json").read_text())["discretization_error"]
                effectivity = np.sqrt(error["energy"] / (energy - history["elastic_energy"][-1]))
                self.assertTrue(0.8 < effectivity < 1.2, effectivity)
                hoop = values["principal_stress"][np.hypot(X[:, 0], X[:, 1]) < 1.001, 0] / (p * (a**2 + b**2) / (b**2 - a**2))
                self.assertGreater(len(hoop), 10)
                self.assertAlmostEqual(hoop.mean(), 1, delta=0.06)
                self.assertLess(np.abs(hoop - 1).max(), tolerance)

    def test_ranks_and_restarts_agree(self):
        nodal = "output.nodal=true"
        whole, error, _ = self.beam("P2", (6, 1, 1), nodal, "checkpoint={every: 1}")
        for ranks in swept((2, 3), (3,)):
            other, of_ranks, _ = self.beam("P2", (6, 1, 1), nodal, ranks=ranks, output="ranks")
            self.assert_same_history(whole, other, 1e-8)
            self.assertAlmostEqual(error["share"], of_ranks["share"], delta=1e-8)
        self.beam("P2", (6, 1, 1), nodal, "time.end=0.5", "checkpoint={every: 1}", output="parts")
        self.pliant("resume", "parts", "--set", "time.end=1")
        self.assertEqual((self.directory / "parts/history.csv").read_text(), (self.directory / "out/history.csv").read_text())
        summary = json.loads((self.directory / "parts/summary.json").read_text())
        self.assertEqual(summary["discretization_error"], error)

    def test_names_of_constraints_and_displacements_of_probes(self):
        history, _, _ = self.beam("P1", (4, 1, 1))
        self.assertAlmostEqual(history["wall_fz"][-1], 10, delta=1e-6)
        self.assertNotIn("left_fz", history)
        for axis, X in zip("xyz", (10, 0.5, 0.5)):
            np.testing.assert_allclose(history[f"tip_u{axis}"], history[f"tip_{axis}"] - X, atol=1e-14)
        self.assertLess(history["tip_uz"][-1], -0.001)

    def test_the_report_has_them(self):
        self.beam("P1", (4, 1, 1), "output.fields=[displacement, principal_stress, log_strain, discretization_error]", "output.nodal=true")
        self.pliant("report", "out")
        report = ReportFile(self.directory / "out/report.html")
        self.assertEqual([field["name"] for field in report.result["fields"]],
                         ["displacement", "discretization_error", "principal_stress_1", "principal_stress_2", "principal_stress_3"])
        values, _, _, _ = self.frame()
        largest = report.field("principal_stress_1")[-1]  # every node is at the surface
        self.assertAlmostEqual(largest.max() / values["principal_stress"][:, 0].max(), 1, delta=2e-3)
        self.assertEqual(report.json["taken"], [{"column": "sag", "title": "min of displacement_z in right", "unit": "m"},
                                                {"column": "peak", "title": "max of von_mises_stress", "unit": "Pa"}])
        self.assertGreater(report.json["summary"]["discretization_error"]["share"], 0.5)

    def test_softened_expanded_and_rigid(self):
        """Strains are those of the whole deformation; a rigid body has none, and nodes that it shares are the other's."""
        points, triangles, cells = box((1, 1, 2))
        above = (points[cells].mean(axis=1)[:, 2] > 0.5).astype(int)
        write_mesh(self.directory / "two.msh", points, triangles, cells, (["soft", "stiff"], above))
        self.write("two.yaml", """mesh: {file: two.msh}
bodies:
  - {volume: soft, elasticity: {model: neo-hookean-isochoric, shear_modulus: 1e4, bulk_modulus: 1e5}, mullins: {r: 1.5, m: 1 kPa, beta: 0.1}}
  - {volume: stiff, rigid: true}
constraints:
  - {surface: bottom, displacement: [0, 0, 0]}
  - {volume: stiff, rigid: {translation: [0, 0, "0.25*t"], rotation: fixed}}
time: {method: quasistatic, step: 0.5, end: 1}
output: {nodal: true, fields: [displacement, green_lagrange_strain, principal_stretches, softening, discretization_error],
         history: [{name: rigid_strain, of: green_lagrange_strain, in: stiff, take: norm}]}
""")
        done = self.call("run", "two.yaml", "--output", "out", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        values, _, X, _ = self.frame()
        between = np.abs(X[:, 2] - 0.5) < 1e-9
        np.testing.assert_allclose(values["principal_stretches"][X[:, 2] > 0.6], 1, atol=1e-12)
        self.assertGreater(values["principal_stretches"][between, 0].min(), 1.3)
        self.assertTrue(np.all((values["softening"] >= 0) & (values["softening"] < 1)))

        write_box(self.directory / "cube.msh", (2, 2, 2))
        self.write("hot.yaml", """mesh: {file: cube.msh}
bodies: [{elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}, expansion: {stretch: 1.1}}]
constraints: [{surface: left, symmetry: plane}, {surface: front, symmetry: plane}, {surface: bottom, symmetry: plane}]
time: {method: static}
output: {fields: [displacement, log_strain, cauchy_stress, discretization_error]}
""")
        history = self.run_input("hot.yaml", output="hot")
        values = self.frame("hot")[0]
        np.testing.assert_allclose(values["log_strain"][:, :3], np.log(1.1), rtol=1e-7)
        self.assertEqual(history["discretization_error"][-1], 0)  # no energy, only rounding


if __name__ == "__main__":
    unittest.main()
