#!/usr/bin/python3
"""The quick cases of input/verification keep to their published numbers; docs/verification.md says where those come from.

A row of the table in that document is a call of `row`; its numbers are those of the last `--write`, and a run that gives
others fails.
"""
import csv
import json
import sys
import unittest

import h5py
import numpy as np

from program import LONG, ROOT, ProgramTest, long_test, swept, write_box
from thick_shell import ThickShell
from verification_table import Row, agree, lines_of, number_in, with_lines

INPUTS = ROOT / "input/verification"
DOCUMENT = ROOT / "docs/verification.md"
# Joint, its angle at the start and at 30 ms [rad], and whole turns between them.
ANDREWS = (
    ("beta", -0.0617138900142764, 15.81077119629904),
    ("theta", 0.0, -15.75637105984298),
    ("gamma", 0.4552798191630704, 0.04082224013073),
    ("phi", 0.2226683901658859, -0.5347301163226948),
    ("delta", 0.4873649795438426, 0.5244099658805304),
    ("omega", -0.2226683901658859, 0.5347301163226948),
    ("epsilon", 1.230547444549821, 1.048080741042263),
)


class Verification(ProgramTest):
    is_writing = False
    rows = {}  # by the test's name

    def setUp(self):
        super().setUp()
        self.rows[self._testMethodName] = []

    def about(self, case, mesh, source):
        """What the next rows are about; source: its number in the document."""
        self.subject = (case, mesh, source)

    def row(self, quantity, expected, value, within, size=None):
        """`value` is as `expected` ("-1.5e-3 m", as published; its unit is the value's), to a part `within` of `size`,
        by default of `expected`."""
        row = Row(*self.subject, quantity, expected, value, within, number_in(expected) if size is None else size)
        self.rows[self._testMethodName].append(row)
        self.assertLessEqual(abs(row.difference()), within, row.line())

    def tearDown(self):
        lines = [row.line() for row in self.rows[self._testMethodName]]
        if self.is_writing:
            return
        written = lines_of(DOCUMENT.read_text(encoding="utf-8"))
        for line in lines:
            self.assertTrue(any(agree(other, line) for other in written),
                            f"docs/verification.md does not hold the row\n{line}\n`{sys.argv[0]} --write` writes its table")

    @classmethod
    def all_lines(cls):
        """In the order of the tests in this file."""
        return [row.line() for name in vars(cls) if name in cls.rows for row in cls.rows[name]]

    @classmethod
    def tearDownClass(cls):
        if cls.is_writing or not LONG or any(name.startswith("test_") and name not in cls.rows for name in vars(cls)):
            return
        lines = cls.all_lines()
        extra = [old for old in lines_of(DOCUMENT.read_text(encoding="utf-8")) if not any(agree(old, new) for new in lines)]
        if extra:
            raise AssertionError("docs/verification.md holds rows that no test computes:\n" + "\n".join(extra))

    def history(self, case, *settings, ranks=1):
        return self.run_input(INPUTS / f"{case}.yaml", *settings, ranks=ranks)

    def assert_close(self, value, expected, relative):
        self.assertAlmostEqual(value / expected, 1, delta=relative)

    def frames(self):
        with h5py.File(self.directory / "out/result.h5") as file:
            names = sorted(file["frames"])
            mesh = {name: file["mesh"][name][()] for name in ("coordinates", "cells")}
            return mesh, [{name: data[()] for name, data in file["frames"][frame].items()} for frame in names]

    def test_turek_hron_statics(self):
        # 70 x 4 elements along and across: the error halves twice with the next mesh.
        cases = (("turek_hron_csm1", "-7.187e-3 m", "-66.10e-3 m"), ("turek_hron_csm2", "-0.4690e-3 m", "-16.97e-3 m"))
        for case, ux, uy in swept(cases, cases[1:]):
            with self.subTest(case):
                h = self.history(case)
                self.about(case, "70 x 4", 2)
                self.row("u_x(A)", ux, h["A_x"][-1] - 0.6, 3e-3)
                self.row("u_y(A)", uy, h["A_y"][-1] - 0.2, 2e-3)

    def test_free_shells(self):
        h = self.history("scordelis_lo")
        self.about("scordelis_lo", "`size` 1", 28)
        self.row("the edge sags by", "0.3006 mm", -1e3 * h["edge_uy"][-1], 0.02)
        h = self.history("pinched_cylinder")
        self.about("pinched_cylinder", "32 x 32", 28)
        self.row("the loaded point moves by", "1.82488e-5 m", -h["loaded_uy"][-1], 0.06)
        h = self.history("hemisphere")
        self.about("hemisphere", "16 x 16", 28)
        self.row("u_x, outwards", "0.1849363 m", h["outwards_ux"][-1], 2e-3)
        self.row("u_y, inwards", "-0.1890221 m", h["inwards_uy"][-1], 2e-3)

    def test_plates(self):
        D = 1e9 * 1e-6 / (12 * 0.91)
        for case, size, coefficient, within in (("supported_plate", "1/16", "0.00406235", 0.01), ("clamped_plate", "0.03", "0.00126532", 0.015)):
            h = self.history(case, *([] if "/" in size else [f"mesh.size={size}"]))
            self.about(case, f"`size` {size}", 29)
            self.row("deflection, in q a^4/D", coefficient, -h["center_uz"][-1] * D / 0.01, within)
        self.pliant("modes", INPUTS / "supported_plate.yaml", "--output", "modes", "--number", "4")
        with open(self.directory / "modes/modes.csv", encoding="ascii", newline="") as stream:
            found = [float(row["frequency"]) for row in csv.DictReader(stream)]
        self.about("supported_plate", "`size` 1/16", 29)
        unit = np.pi / 2 * np.sqrt(D / 10)
        for number, expected in ((0, "2"), (1, "5"), (3, "8")):
            self.row(f"frequency of mode {number + 1}, in pi/2 sqrt(D/(rho h))/a^2", expected, found[number] / unit, 5e-3)

    def test_a_plate_that_buckles(self):
        # The critical load by Southwell's plot of the deflection over the deflection per load, below it; then the stiffness.
        h = self.history("buckled_plate", "time.path.max_load=1.4")
        critical = 4 * np.pi**2 * 70e9 * 1e-6 / (12 * 0.91)
        load, w = -h["push_fx"] / critical, -h["center_uz"]
        before = (load > 0.3) & (load < 0.85)
        self.about("buckled_plate", "`size` 1/16", 29)
        self.row("critical load b^2/(pi^2 D)", "4", 4 * np.polyfit(w[before] / load[before], w[before], 1)[0], 0.015)
        after = h["load_factor"] > 1.05
        self.row("stiffness after buckling, in that before", "0.408", np.polyfit(h["load_factor"][after], load[after], 1)[0], 0.02)
        self.assertEqual(h["unstable_modes"].max(), 0)

    def test_turek_hron_dynamics(self):
        # A fifth of the period; within the difference of two time integrators at this step.
        h = self.history("turek_hron_csm3", "time.end=0.2")
        self.assertEqual(len(h["time"]), 81)
        self.about("turek_hron_csm3", "70 x 4", 3)
        self.row("u_x(A) at 0.2 s", "-4.3498e-3 m", h["A_x"][-1] - 0.6, 3e-3)
        self.row("u_y(A) at 0.2 s", "-52.011e-3 m", h["A_y"][-1] - 0.2, 1e-3)

    def test_cooks_membrane(self):
        h = self.history("cooks_membrane")
        self.about("cooks_membrane", "16 x 16", 3)
        self.row("u_y(48, 52)", "14.505 mm", (h["end_y"][-1] - 0.052) * 1e3, 2e-3)
        self.assertAlmostEqual(h["clamp_fy"][-1], -1, delta=1e-7)

    def test_cooks_membrane_with_the_volume_split_off(self):
        # Quadrilaterals of second order, 32 x 32; here triangles cut from 16 x 16.
        h = self.history("cooks_membrane_isochoric")
        self.about("cooks_membrane_isochoric", "16 x 16", 8)
        self.row("u_y(48, 52)", "14.74 mm", (h["end_y"][-1] - 0.052) * 1e3, 2e-3)

    def test_long_wall(self):
        # The closed form, to the digits it is published with.
        h = self.history("long_wall")
        self.about("long_wall", "as given", 9)
        self.row("u_x(1, 2)", "-0.1675 m", h["corner_x"][-1] - 1, 6e-4)
        self.row("u_y(1, 2)", "0.4025 m", h["corner_y"][-1] - 2, 2.5e-4)

    def test_twisting_column(self):
        # The start of the motion, within what the independent code's two meshes differ by.
        h = self.history("twisting_column", "time.end=0.02")
        self.assert_close(h["kinetic_energy"][0], 3.0319e6, 1e-4)
        self.about("twisting_column", "3 x 18 x 3", 3)
        for time, degrees in ((0.01, "55.87 deg"), (0.02, "110.84 deg")):
            at = np.argmin(np.abs(h["time"] - time))
            turned = np.degrees(np.arctan2(h["corner_x"][at], h["corner_z"][at])) - 45
            self.row(f"turned by at {time} s", degrees, turned, 1e-2)

    def test_vibrating_cantilever(self):
        # Against another code and element, half a percent of the largest displacement.
        h = self.history("cantilever_vibration", "time.end=0.3")
        self.about("cantilever_vibration", "2 x 14 x 2", 3)
        for time, expected in ((0.1, "0.81436 m"), (0.2, "2.00586 m"), (0.3, "2.76568 m")):
            at = np.argmin(np.abs(h["time"] - time))
            u = np.linalg.norm([h["end_x"][at], h["end_y"][at], h["end_z"][at] - 2])
            self.row(f"displacement at {time} s; difference of the largest, 2.8 m", expected, u, 0.005, size=2.8)

    def test_nearly_incompressible(self):
        # Cook's membrane at nu = 0.4999; quadrilaterals of second order find 11.954 mm on 4 x 4, 11.974 mm on 8 x 8.
        geometry = (ROOT / "meshes/cooks_membrane.geo").read_text(encoding="utf-8")
        treatments = (("mixed", 8, "11.974 mm", 2e-2), ("mean-dilatation", 4, "11.954 mm", 1e-2))
        for treatment, n, expected, within in swept(treatments, treatments[1:]):
            with self.subTest(treatment):
                mesh = self.write("cook.geo", geometry.replace("n = {16", f"n = {{{n}"))
                h = self.history("cooks_membrane_incompressible", f"volumetric={treatment}", f"mesh.file={mesh}")
                self.about("cooks_membrane_incompressible", f"{n} x {n}, `{treatment}`", 3)
                self.row("u_y(48, 52)", expected, (h["end_y"][-1] - 0.052) * 1e3, within)
                self.assertAlmostEqual(h["clamp_fy"][-1], -1, delta=1e-7)
                # What the loads did is stored, but for the error of the trapezoidal rule over four steps.
                self.assert_close(h["elastic_energy"][-1], h["load_work"][-1], 1e-2)

    def test_indented_block(self):
        # An independent code, quadrilaterals of second order with pressures of their own, 8 bricks a side; its own
        # coarser meshes scatter by 1.4 %.
        h = self.history("indented_block")
        self.about("indented_block", "4 x 4 x 4", 3)
        for step, expected in ((2, "-0.21968 mm"), (5, "-0.51199 mm"), (10, "-0.76115 mm")):
            self.row(f"u_y(0, 1, 0) at {40 * step} MPa", expected, h["middle_y"][step] * 1e3 - 1, 1.4e-2)

    def test_pressure_vessel(self):
        h = self.history("pressure_vessel")
        self.about("pressure_vessel", "8 x 12", 9)
        self.row("u_r of the inner wall", "3.211502 m", h["inner_x"][-1] - 7, 1e-3)
        self.row("u_r of the outer wall", "1.429062 m", h["outer_x"][-1] - 18.625, 1e-3)
        # The hoop stress of the closed form, in every cell to half a percent of the largest one.
        mesh, frames = self.frames()
        cells = mesh["cells"]
        centres = mesh["coordinates"][cells[:, 4:]].sum(axis=1) / 4 - mesh["coordinates"][cells[:, :4]].sum(axis=1) / 8
        R = np.hypot(centres[:, 0], centres[:, 1])
        across = np.stack([-centres[:, 1], centres[:, 0]]) / R
        xx, yy, _, xy, _, _ = frames[-1]["cauchy_stress"].T
        hoop = xx * across[0] ** 2 + yy * across[1] ** 2 + 2 * xy * across[0] * across[1]
        c = 55.274768

        def pressure_to(R):
            return 200e6 * (0.5 * np.log(R**2 / (R**2 + c)) - c / (2 * (R**2 + c)))

        self.assert_close(pressure_to(18.625) - pressure_to(7), 100e6, 1e-7)
        stretch = 1 + c / R**2
        expected = pressure_to(R) - pressure_to(7) - 100e6 + 200e6 * (stretch - 1 / stretch)
        np.testing.assert_allclose(hoop, expected, atol=5e-3 * 231.6e6)
        # The nearest cell is off by the same part as the closed form at its centre.
        for radius, published in ((8.043, "183.74 MPa"), (10.693, "118.37 MPa"), (14.534, "78.36 MPa")):
            near = np.argmin(np.abs(R - radius))
            at_radius = hoop[near] * number_in(published) * 1e6 / expected[near]
            self.row(f"hoop stress at R = {radius} m", published, at_radius / 1e6, 5e-3)

    def test_bent_cube(self):
        # dolfinx, the same mesh and quadrature.
        h = self.history("bent_cube", "solver.newton.relative=1e-11")
        self.about("bent_cube", "2 x 2 x 2", 4)
        self.row("strain energy", "2.190388296086e-1 J", h["elastic_energy"][-1], 1e-10)
        for axis, X, expected in (("x", 1, "0.09436176 m"), ("y", 1, "-0.04945564 m"), ("z", 1, "-1.14346301 m")):
            self.row(f"u_{axis}(1, 1, 1)", expected, h[f"corner_{axis}"][-1] - X, 5e-7)
        # Finer: the independent code integrates by another rule.
        finer = ((4, "2.192716468225e-1 J"), (8, "2.207060693174e-1 J"))
        for n, energy in swept(finer, finer[:1]):
            points_per_side = write_box(self.directory / "cube.msh", (n, n, n))
            h = self.history("bent_cube", f"mesh.file={points_per_side}", "constraints.0.surface=left")
            self.about("bent_cube", f"{n} x {n} x {n}", 3)
            self.row("strain energy", energy, h["elastic_energy"][-1], 2e-3)

    def test_rotation_and_stretch(self):
        h = self.history("rotation_and_stretch", ranks=2)
        turned, stretched, end = (np.argmin(np.abs(h["time"] - t)) for t in (1, 2, 3))
        self.assertLess(h["elastic_energy"][: turned + 1].max(), 1e-10)
        np.testing.assert_allclose([h[f"end_{c}"][turned] for c in "xyz"], [-0.5, 1, 0.5], atol=1e-12)
        np.testing.assert_allclose([h[f"end_{c}"][end] for c in "xyz"], [-0.5, 1, 0.5], atol=1e-12)
        _, frames = self.frames()
        stress = frames[stretched]["cauchy_stress"]  # xx yy zz xy yz xz; the axis lies along y now
        self.about("rotation_and_stretch", "as given", 5)
        self.row("u of the end at 31096.154 MPa", "100 mm", (h["end_y"][stretched] - 1) * 1e3, 1e-7)
        self.row("Cauchy stress along", "31096.154 MPa", stress[:, 1].mean() * 1e-6, 1e-7)
        self.row("Cauchy stress across", "11013.986 MPa", stress[:, 0].mean() * 1e-6, 1e-7)
        np.testing.assert_allclose(stress[:, 1], 31096.154e6, rtol=1e-7)
        np.testing.assert_allclose(stress[:, [0, 2]], 11013.986e6, rtol=1e-7)
        np.testing.assert_allclose(stress[:, 3:], 0, atol=1e3)

    def test_pulled_cube(self):
        h = self.history("pulled_cube")
        self.about("pulled_cube", "384 cells, P1", 6)
        mesh, frames = self.frames()
        u, cells = frames[-1]["displacement"], mesh["cells"]
        corners = mesh["coordinates"][cells]
        edges = corners[:, 1:] - corners[:, :1]
        volumes = np.abs(np.linalg.det(edges)) / 6
        middle = u[cells].mean(axis=1)
        gradient = np.linalg.solve(edges, u[cells][:, 1:] - u[cells][:, :1])
        self.row("L2 norm of u", "0.06019896863581861", np.sqrt((volumes * (middle**2).sum(axis=1)).sum()), 1e-9)
        self.row("L2 norm of grad u", "0.21798642314867062", np.sqrt((volumes * (gradient**2).sum(axis=(1, 2))).sum()), 1e-9)
        self.row("largest displacement of a centroid", "0.08992836526", np.linalg.norm(middle, axis=1).max(), 1e-9)
        self.about("pulled_cube", "384 cells, P1", 3)
        self.row("strain energy", "406.5814263543 J", h["elastic_energy"][-1], 1e-11)
        self.about("pulled_cube", "384 cells, P2", 3)
        self.row("strain energy", "390.4527566047 J", self.history("pulled_cube", "element=P2")["elastic_energy"][-1], 1e-11)

    def test_single_tetrahedron(self):
        h = self.history("single_tetrahedron")
        u = np.array([h["right_x"][-1] - 1, h["back_y"][-1] - 1, h["apex_z"][-1] - 1])
        self.about("single_tetrahedron", "1 cell", 13)
        self.row("u_x(1, 0, 0)", "0.2144631867 m", u[0], 1e-9)
        self.row("u_z(0, 0, 1)", "-0.3224567281 m", u[2], 1e-9)
        # The published components make this a norm of 0.4426818930 m, too.
        self.row("norm of all displacements", "0.44268188785 m", np.linalg.norm(u), 2e-8)

    def test_tied_cube(self):
        # The law is nonlinear, by a part of the strain: 1e-7.
        for settings, element in (((), "P1"), (("element=P2",), "P2")):
            h = self.history("tied_cube", *settings)
            self.about("tied_cube", f"as given, {element}", 14)
            u = 1e6 * np.array([h[f"corner_{axis}"][-1] - 1 for axis in "xyz"])
            self.row("u_x(1, 1, 1) for p = 100", "0.0277778 m", u[0], 2e-6)
            self.row("u_y(1, 1, 1) for p = 100", "0.0277778 m", u[1], 2e-6)
            self.row("u_z(1, 1, 1) for p = 100", "-0.1111111 m", u[2], 2e-6)

    def contact_pressures(self):
        """Of the last frame, in Pa, at the nodes that feel one: their reference positions, and the pressures."""
        mesh, frames = self.frames()
        pressure = frames[-1]["contact_pressure"]
        touching = pressure > 0
        return mesh["coordinates"][touching] + frames[-1]["displacement"][touching], pressure[touching]

    def test_contact_patch(self):
        for element in swept(("P1", "P2"), ("P1",)):
            for ranks in swept((1, 3), (1,)):
                self.history("contact_patch", f"element={element}", ranks=ranks)
                pressure = self.contact_pressures()[1]
                self.about("contact_patch", element, 15)
                if ranks == 1:
                    self.row("contact pressure, least of all nodes", "0.625 Pa", pressure.min(), 0.02)
                    self.row("contact pressure, largest of all nodes", "0.625 Pa", pressure.max(), 0.02)
                    alone = np.sort(pressure)
            np.testing.assert_allclose(np.sort(pressure), alone, rtol=1e-6)

    @long_test
    def test_contact_balls(self):
        h = self.history("contact_balls", "time.load_steps=4")
        place, pressure = self.contact_pressures()
        square = (place[:, :2] ** 2).sum(axis=1)
        inside = pressure > 0.3 * pressure.max()
        slope, largest = np.polyfit(square[inside], pressure[inside] ** 2, 1)  # p^2 = p0^2 (1 - r^2/a^2)
        # Held at their equators, the balls are stiffer than half-spaces, by 0.36 a/R = 7.2 % of the approach (Tatara 1991).
        self.about("contact_balls", "as given, `load_steps=4`", 16)
        # The iteration ends at its tolerance, differently on other processors.
        self.row("largest pressure", "2798.33 MPa", round(1e-6 * np.sqrt(largest), 1), 0.05)
        self.row("radius of the circle of contact", "10 mm", 1e3 * np.sqrt(-largest / slope), 0.04)
        self.row("force", "586.08 kN", -4e-3 * h["balls_fz"][-1], 0.15)

    def cylinders(self, mesh, within, *settings):
        """Runs contact_cylinders and checks it; `within`: the differences that are allowed in the contact and in what sticks of it."""
        load, shear, friction, radius = 10.0, 0.93616, 0.2, 4.0  # [N/m], [N/m], 1, that of the gap [m]
        a = np.sqrt(4 * load * radius * 2 * (1 - 0.3**2) / (np.pi * 200))
        self.assert_close(a, 0.68078, 1e-5)
        h = self.history("contact_cylinders", *settings)
        mesh_data, frames = self.frames()
        self.assertEqual(len(frames), len(h["time"]))
        X, pressed, sheared = mesh_data["coordinates"], frames[np.abs(h["time"] - 1).argmin()], frames[-1]
        pressure = sheared["contact_pressure"]
        np.testing.assert_allclose(h["cylinders_fy"][-1] / X[:, 2].max(), -load, rtol=1e-6)
        np.testing.assert_allclose(h["cylinders_fx"][-1] / X[:, 2].max(), shear, rtol=1e-5)
        # Hertz: p^2 = p0^2 (1 - x^2/a^2)
        inside = pressure > 0.3 * pressure.max()
        slope, largest = np.polyfit(X[inside, 0] ** 2, pressure[inside] ** 2, 1)
        half_width = np.sqrt(-largest / slope)
        self.about("contact_cylinders", mesh, 18)
        self.row("largest pressure", "9.35135 Pa", np.sqrt(largest), within[0])
        self.row("half width of the contact", "0.68078 m", half_width, within[0])
        # Both surfaces moved together at the start of the shear; the means over the thickness.
        sheared_by = (sheared["displacement"] - pressed["displacement"])[:, 0]
        moved = []
        for body in (X[:, 1] < 0, X[:, 1] > 0):
            nodes = body & (pressure > 1)
            x, place = np.unique(X[nodes, 0].round(9), return_inverse=True)
            moved.append((x, np.bincount(place, sheared_by[nodes]) / np.bincount(place)))
        (x, of_lower), of_upper = moved
        slip = np.interp(x, *of_upper) - of_lower

        def exact_slip(c):
            # Its derivative is friction/radius sqrt(x^2 - c^2), as that of Hertz's gap is sqrt(x^2 - a^2)/radius.
            y = np.maximum(np.abs(x) / c, 1)
            return friction * c**2 / (2 * radius) * (y * np.sqrt(y**2 - 1) - np.arccosh(y))

        stuck = min(np.arange(0.4, 0.6, 1e-5), key=lambda c: np.square(slip - exact_slip(c)).sum())
        largest_traction = friction * np.sqrt(largest * (1 - (stuck / half_width) ** 2))
        self.row("half width that sticks", "0.49651 m", stuck, within[1])
        self.row("traction where the slip begins", "1.27957 Pa", largest_traction, within[1])
        # The upper cylinder rolls on the lower one as it moves, so their tangent tilts towards the load.
        part = (shear + load * h["top_x"][-1] / 16) / (friction * load)
        rolled = np.array([a * np.sqrt(1 - part), friction * 2 * load / (np.pi * a) * np.sqrt(part)])
        return np.abs(slip - exact_slip(stuck)).max() / slip.max(), np.array([stuck, largest_traction]) / rolled - 1

    def test_contact_cylinders(self):
        slip, rolled = self.cylinders("as given, `step=1`", (4e-3, 0.015), "time.step=1")
        self.assertLess(slip, 0.04)
        np.testing.assert_allclose(rolled, 0, atol=5e-3)

    @long_test
    def test_contact_cylinders_refined(self):
        text = (ROOT / "meshes/contact_cylinders.geo").read_text(encoding="utf-8")
        self.assertIn("fine = {0.05,", text)
        coarse = self.write("cylinders.geo", text.replace("fine = {0.05,", "fine = {0.1,"))
        settings = (f"mesh.file={self.directory / coarse}", "time.step=1")
        self.cylinders("`fine` = 0.1, `step=1`", (6e-3, 0.015), *settings)
        self.cylinders("`fine` = 0.1, P2, `step=1`", (6e-3, 6e-3), *settings, "element=P2")
        penalty = ("contact.law=penalty", "contact.threshold=0.002")
        self.cylinders("`fine` = 0.1, `law=penalty`", (0.01, 0.06), settings[0], *penalty)

    def test_colliding_bars(self):
        h = self.history("colliding_bars")
        steady = (h["time"] > 5) & (h["time"] < 15)
        self.about("colliding_bars", "20 elements, P1", 17)
        self.row("stress in contact", "0.1 Pa", -h["bars_fx"][steady].mean(), 2e-3)
        self.row("time in contact", "20 s", h["time"][h["bars_fx"] != 0].max() - 0.05, 0.02)
        self.row("impulse: velocities are exchanged", "2 N s", -h["bars_jx"][-1], 0.02)

    @long_test
    def test_colliding_balls(self):
        h = self.history("colliding_balls")
        force, approach = -4 * h["balls_fz"], 1e3 * (0.1 - (h["high_z"] - h["low_z"]))
        touching = h["time"][force > 0]
        # Stiffer than half-spaces, as the balls above.
        self.about("colliding_balls", "as given", 17)
        self.row("largest force", "136.29 N", force.max(), 0.07)
        self.row("largest approach", "2.4011 mm", approach.max(), 0.07)
        self.row("time in contact", "7.067 ms", 1e3 * touching.max() - 0.05, 0.07)

    def test_stack_of_blocks(self):
        h = self.history("stack_of_cubes")
        weights = [9810 * (1 - 0.04 * k) * (1 - 0.02 * k) for k in range(4)]
        self.about("stack_of_cubes", "as given", 17)
        for k, pair in enumerate(("ab", "bc", "cd")):
            self.row(f"force of {pair[0]} on {pair[1]}", f"{sum(weights[k + 1:]):.7g} N", -h[f"{pair}_fz"][-1], 1e-6)

    def test_pendulum(self):
        times = ((1, ".98629175", "-.16501085"), (5, "-.94230544", "-.33475434"), (10, "-.27508746", "-.96141921"))
        times = swept(times, times[:1])
        h = self.history("pendulum", f"time.end={times[-1][0]}")
        self.about("pendulum", "rigid", 19)
        for time, x, y in times:
            row = np.flatnonzero(np.isclose(h["time"], time))[0]
            for axis, expected in (("x", x), ("y", y)):
                self.row(f"{axis} at {time} s", f"{float(expected):.8f} m", h[f"bob_{axis}"][row], 3e-5)

    def test_heavy_top(self):
        h = self.history("heavy_top")
        self.about("heavy_top", "rigid", 20)
        sign = -1 if h["top_qw"][-1] > 0 else 1  # a rotation has two quaternions
        for axis, expected in zip("wxyz", ("-0.70824", "0.43878", "0.54578", "0.08937")):
            self.row(f"q_{axis} at 0.2 s", expected, sign * h[f"top_q{axis}"][-1], 2e-4)

    def test_andrews_squeezing_mechanism(self):
        # Angles since the start, with whole turns: beta and Theta have gone round 2.5 times.
        h = self.history("andrews")
        self.about("andrews", "rigid", 21)
        for name, start, expected in ANDREWS:
            self.row(f"{name} at 30 ms", f"{expected:.8g} rad", start + h[f"{name}_angle"][-1], 3e-4)

    def test_elastica(self):
        loads = ((1, ".301721", ".056433"), (5, ".713792", ".387628"))
        for force, down, back in loads:
            h = self.history("elastica", f"loads.0.force=[0, 0, {-force}]")
            self.about("elastica", "40 segments", 22)
            self.row(f"deflection, P = {force} N", f"{float(down)} m", -h["tip_z"][-1], 5e-4)
            self.row(f"shortening, P = {force} N", f"{float(back)} m", 1 - h["tip_x"][-1], 5e-4)

    def test_bathes_bend(self):
        h = self.history("bathe_bend")
        self.about("bathe_bend", "32 segments", 23)
        start = 100 * np.array([np.sin(np.pi / 4), 1 - np.cos(np.pi / 4), 0])
        for axis, X, expected in zip("xyz", start, ("-23.5585", "-13.6040", "53.4718")):
            self.row(f"u_{axis} of the tip", f"{expected} m", h[f"tip_{axis}"][-1] - X, 1e-3)

    def test_free_ball(self):
        """Each eigenvalue has five modes; the numbers are w a / c, c the speed of shear waves."""
        self.about("free_ball", "as given", 27)
        self.pliant("modes", INPUTS / "free_ball.yaml", "--number", "16", "--output", "modes")
        f = np.genfromtxt(self.directory / "modes/modes.csv", delimiter=",", names=True)["frequency"]
        self.assertEqual(f[:6].tolist(), [0.0] * 6)
        for name, modes, expected in (("torsional", f[6:11], "2.501133"), ("spheroidal", f[11:16], "2.639869")):
            self.assertLess(np.ptp(modes), 2e-3 * modes.mean())
            self.row(f"frequency of the five {name} modes, mean", expected, 2 * np.pi * modes.mean(), 0.005)

    def test_beam_theory(self):
        h = self.history("slender_beam")
        self.about("slender_beam", "as given", 7)
        self.row("deflection", "-2.56 mm", (h["tip_z"][-1] - 0.1) * 1e3, 1e-3)

    def test_axial_vibration(self):
        h = self.history("axial_vibration")
        u, t = h["end_x"] - 1, h["time"]
        self.assert_close(h["elastic_energy"][0], 2.467401e-2, 1e-5)
        zero = [t[k] - u[k] * (t[k + 1] - t[k]) / (u[k + 1] - u[k]) for k in range(len(t) - 1) if u[k] * u[k + 1] < 0]
        period = 2 * (zero[1] - zero[0])
        self.about("axial_vibration", "as given", 7)
        self.row("period", "0.126491 s", period, 3e-4)
        # BDF2 lengthens a period by (w dt)^2 / 3 of it.
        self.assert_close(period, 0.126491 * (1 + (49.673 * 0.5e-3) ** 2 / 3), 1e-4)

    def test_damped_bar(self):
        h = self.history("damped_bar")
        u, t = h["end_x"] - 1, h["time"]
        ratio, omega = 0.0496729, 49.67294
        damped = omega * np.sqrt(1 - ratio**2)
        # Of a decaying vibration u[k + 1] = 2 r cos(w dt) u[k] - r^2 u[k - 1], r the decay in a step.
        (p, q), *_ = np.linalg.lstsq(np.stack([u[1:-1], -u[:-2]], axis=1), u[2:], rcond=None)
        angle = np.arccos(p / (2 * np.sqrt(q)))
        self.about("damped_bar", "as given", 7)
        self.row("angular frequency", "49.6116 rad/s", angle / (t[1] - t[0]), 2e-4)
        self.row("logarithmic decrement", "0.312490", -np.pi * np.log(q) / angle, 1e-3)
        # The motion by its formula, cos(w t) + z / sqrt(1 - z^2) sin(w t) within the decay.
        decay = np.exp(-ratio * omega * t)
        exact = 1e-5 * decay * (np.cos(damped * t) + ratio / np.sqrt(1 - ratio**2) * np.sin(damped * t))
        np.testing.assert_allclose(u, exact, atol=2e-4 * 1e-5)
        self.assert_close(h["dissipated_stiffness_proportional"][-1], h["dissipated_energy"][-1], 1e-12)

    def test_viscous_column(self):
        exact = 3 * 0.5 / 5 + 1 - (1 - 9 / 4 * 0.25) ** (1 / 3)
        # Backward Euler's recursion for 2 l^2 dl/dt = -3 t, by hand.
        for step, expected in ((100, "0.72458 m"), (50, "0.59605 m")):
            h = self.history("viscous_column", "time.method=backward-euler", f"time.step={step} ms")
            self.about("viscous_column", f"`backward-euler`, {step} ms", 10)
            self.row("rise of the foot", expected, h["foot_z"][-1], 2e-5)
        rises = [self.history("viscous_column", f"time.step={step}")["foot_z"][-1] for step in (0.025, 0.0125)]
        errors = [abs(rise - exact) for rise in rises]
        self.about("viscous_column", "`bdf2`, 12.5 ms", 10)
        self.row("rise of the foot", f"{exact:.6f} m", rises[1], 4e-3)
        self.assertAlmostEqual(np.log2(errors[0] / errors[1]), 2, delta=0.3)

    def test_viscous_tube(self):
        h = self.history("viscous_tube", "time.end=1000")
        branches = ((2.93, 30), (5.86, 300), (6.60, 3000), (18.32, 12000))
        # Lame's solution in plane strain; four quadratic elements through the wall are 0.2 % off at this node.
        self.about("viscous_tube", "as given", 11)
        self.row("u of the outer wall at one node", "0.61751 um", (h["outer_x"][-1] - 10e-3) * 1e6, 3e-3)
        n, step = h["step"][1:], 50
        # Backward Euler holds the exponentials by (1 + step / tau)^-n, so exactly as the stresses do.
        modulus = 39.58 + sum(E / (1 + step / tau) ** n for E, tau in branches)
        force = h["inner_fx"][1:]
        np.testing.assert_allclose(force / force[0], modulus / modulus[0], rtol=1e-8)
        self.row("force after 1000 s, of that after the first step", f"{modulus[-1] / modulus[0]:.8f}", force[-1] / force[0], 2e-8)
        continuous = 39.58 + sum(E * np.exp(-h["time"][-1] / tau) for E, tau in branches)
        self.assert_close(modulus[-1], continuous, 3e-3)

    def test_inflated_tube(self):
        h = self.history("inflated_tube")
        tube = ThickShell(5e-3, 10e-3, 1e6, 0.4, curved=1)
        radii = 5e-3 * np.sqrt(h["bore_volume"] / h["bore_volume"][0])
        expected = [tube.pressure(radius, 20) for radius in radii]
        # With elements of half the size 2.5e-5 off.
        self.about("inflated_tube", "4 x 6", 12)
        self.row("pressure that belongs to the bore's volume, wider by 61 %", f"{expected[-1]:.0f} Pa", h["bore_pressure"][-1], 5e-4)
        np.testing.assert_allclose(h["bore_pressure"], expected, rtol=5e-4, atol=1e-3)
        self.assert_close(h["bore_pressure"][-1], 1e5, 1e-12)
        # Nodes lie off the circle by more.
        self.assert_close(h["inside_x"][-1], radii[-1], 1e-3)

    @long_test
    def test_balloon(self):
        # Past the greatest pressure, where one that is given would have no stable answer. Two quadratic elements through
        # the wall are 1e-4 off at most.
        h = self.history("balloon", "time.load_steps=8")
        ball = ThickShell(8e-3, 10e-3, 1e6, 0.45, curved=2)
        expected = np.array([ball.pressure(radius) for radius in h["inside_x"]])
        np.testing.assert_allclose(h["hollow_pressure"], expected, rtol=3e-4, atol=1e-3)
        self.about("balloon", "as given, `load_steps=8`", 12)
        for load in (0.25, 0.5, 1):  # steps between may be repeated in halves
            n = int(np.flatnonzero(np.isclose(h["time"], load))[0])
            stretch = h["inside_x"][n] / 8e-3
            self.row(f"pressure at {stretch:.4f} times its inner radius", f"{expected[n]:.0f} Pa", h["hollow_pressure"][n], 3e-4)
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-8 * h["elastic_energy"][-1])
        self.assertLess(h["hollow_pressure"][-1], 0.9 * h["hollow_pressure"].max())
        np.testing.assert_allclose(h["inside_x"] / 8e-3, (h["hollow_volume"] / h["hollow_volume"][0]) ** (1 / 3), rtol=3e-4)

    def test_skin_balloon(self):
        # Past the greatest pressure too. The mesh of the sphere is a few 1e-4 off.
        h = self.history("skin_balloon", "time.load_steps=3")
        stretch = h["inside_x"] / 8e-3
        expected = 2 * 1e-4 * 3e5 / 8e-3 * (1 / stretch - stretch**-7)
        self.about("skin_balloon", "as given, `load_steps=3`", 24)
        for n in (1, 2, 3):
            self.row(f"pressure at {stretch[n]:.4f} times its radius", f"{expected[n]:.0f} Pa", h["hollow_pressure"][n], 1e-3)

    def limit_loads(self):
        summary = json.loads((self.directory / "out/summary.json").read_text())
        return [point["load_factor"] for point in summary["critical_points"] if point["kind"] != "bifurcation"]

    def test_lees_frame(self):
        self.history("lees_frame")
        first, second = self.limit_loads()
        self.about("lees_frame", "80 segments", 25)
        self.row("first limit load", "1.8555 N", first, 2e-3)
        self.row("second limit load", "-0.9415 N", second, 8e-3)

    def test_balloon_path(self):
        # The volume tells the radius, so that nodes off the sphere do not matter.
        h = self.history("balloon_path")
        stretch = (h["hollow_volume"] / (np.pi / 6 * 8e-3**3)) ** (1 / 3)

        def pressure(a):
            b = np.cbrt(10**3 + (8 * a) ** 3 - 8**3) / 10
            return 3e5 * (2 / b + 1 / (2 * b**4) - 2 / a - 1 / (2 * a**4))

        np.testing.assert_allclose(h["hollow_pressure"][2:], pressure(stretch[2:]), rtol=1e-3)
        self.about("balloon_path", "as given", 26)
        self.row("greatest pressure", f"{pressure(np.linspace(1, 3, 100001)).max():.0f} Pa", 1e5 * self.limit_loads()[0], 1e-3)
        self.row(f"pressure at {stretch[-1]:.4f} times its inner radius", f"{pressure(stretch[-1]):.0f} Pa", h["hollow_pressure"][-1], 1e-3)


if __name__ == "__main__":
    if "--write" in sys.argv:
        sys.argv.remove("--write")
        Verification.is_writing = True
        if unittest.main(exit=False).result.wasSuccessful():
            document = DOCUMENT.read_text(encoding="utf-8")
            DOCUMENT.write_text(with_lines(document, Verification.all_lines()), encoding="utf-8")
    else:
        unittest.main()
