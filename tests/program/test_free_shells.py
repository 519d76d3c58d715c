#!/usr/bin/python3
"""Free shells, as users type them: published benchmarks, closed forms, orders, ranks, restart, results, refusals."""
import csv
import sys
import unittest

import numpy as np
import yaml

from program import ROOT, ProgramTest, read_history, swept
from report_file import ReportFile
from shell_meshes import write_ball, write_patch

sys.path.insert(0, str(ROOT / "src/python"))

from pliant import Surface  # noqa: E402
from pliant.result import Result  # noqa: E402

LAW = "elasticity: {model: saint-venant-kirchhoff, youngs_modulus: %g, poissons_ratio: %g}"


def cylinder(s, t):
    return 300 * np.cos(np.pi / 2 * s), 300 * np.sin(np.pi / 2 * s), 300 * t


def hemisphere(s, t):
    latitude, longitude = np.radians(72) * t, np.pi / 2 * s
    return 10 * np.cos(latitude) * np.cos(longitude), 10 * np.cos(latitude) * np.sin(longitude), 10 * np.sin(latitude)


def roof(s, t):
    return 25 * np.sin(np.radians(40) * s), 25 * np.cos(np.radians(40) * s), 25 * t


def flat(s, t):
    return s, t, 0.0


# An octant of the cylinder, a quarter of the others: its shape, its layer, what holds it and loads it, where it is looked at.
CYLINDER = f"""mesh: {{file: sheet.msh}}
shells:
  - {{name: cylinder, surface: sheet, free: true, thickness: 3, bending: true, {LAW % (3e6, 0.3)},
     clamped: [{{curve: s0, normal: [0, 1, 0]}}, {{curve: s1, normal: [1, 0, 0]}}, {{curve: t0, normal: [0, 0, 1]}}]}}
constraints:
  - {{curve: s0, displacement: [free, 0, free]}}
  - {{curve: s1, displacement: [0, free, free]}}
  - {{curve: t0, displacement: [free, free, 0]}}
  - {{curve: t1, displacement: [0, 0, free]}}
loads: [{{point: p10, force: [0, -0.25, 0]}}]
probes: [{{name: p, point: [0, 300, 0]}}]
"""
HEMISPHERE = f"""mesh: {{file: sheet.msh}}
shells:
  - {{name: hemisphere, surface: sheet, free: true, thickness: 0.04, bending: true, {LAW % (6.825e7, 0.3)},
     clamped: [{{curve: s0, normal: [0, 1, 0]}}, {{curve: s1, normal: [1, 0, 0]}}]}}
constraints:
  - {{curve: s0, displacement: [free, 0, free]}}
  - {{curve: s1, displacement: [0, free, free]}}
  - {{point: p00, displacement: [free, free, 0]}}
loads: [{{point: p00, force: [2, 0, 0]}}, {{point: p10, force: [0, -2, 0]}}]
probes: [{{name: p, point: [10, 0, 0]}}, {{name: q, point: [0, 10, 0]}}]
"""
ROOF = f"""mesh: {{file: sheet.msh}}
shells:
  - {{name: roof, surface: sheet, free: true, thickness: 0.25, bending: true, {LAW % (4.32e8, 0)},
     clamped: [{{curve: s0, normal: [1, 0, 0]}}, {{curve: t0, normal: [0, 0, 1]}}]}}
constraints:
  - {{curve: s0, displacement: [0, free, free]}}
  - {{curve: t0, displacement: [free, free, 0]}}
  - {{curve: t1, displacement: [0, 0, free]}}
loads: [{{surface: sheet, traction: [0, -0.09, 0]}}]
probes: [{{name: p, point: [{25 * np.sin(np.radians(40))!r}, {25 * np.cos(np.radians(40))!r}, 0]}}]
"""
# A sheet clamped on one side, shaken in space.
SHAKEN = f"""mesh: {{file: sheet.msh}}
shells:
  - {{name: flag, surface: sheet, free: true, thickness: 20 mm, density: 1000, bending: true, damping: 1 ms, {LAW % (1e7, 0.3)},
     clamped: [{{curve: s0}}]}}
constraints: [{{curve: s0, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, "2*(1-cos(8*t))", "-5*(1-cos(6*t))"]}}, {{surface: sheet, pressure: "20*(1-cos(9*t))"}}]
probes: [{{name: tip, point: [1, 0.4, 0]}}]
"""


class FreeShells(ProgramTest):
    def patch(self, n, place, **more):
        write_patch(self.directory / "sheet.msh", n, place, **more)

    def end_of(self, text, ranks=1):
        return {name: column[-1] for name, column in self.solve(text, "method: static", ranks).items()}

    def test_apexes_are_not_unknowns(self):
        """A square of 4 x 4 nodes, and of 7 x 7 with those in the middle of the edges, held on one side."""
        self.patch(3, flat)
        file = self.write("sheet.yaml", SHAKEN + "time: {method: bdf2, step: 10 ms, end: 10 ms}\n")
        for element, number, prescribed in (("P1", 48, 12), ("P2", 147, 21)):
            for ranks in (1, 2):
                done = self.call("check", file, "--set", f"element={element}", ranks=ranks)
                self.assertIn(f"unknowns\n  {number} ({prescribed} prescribed), {element} elements", done.stdout, done.stderr)
            for command in (("run",), ("modes", "--number", "1")):
                done = self.call(*command, file, "--set", f"element={element}")
                self.assertIn(f" {number} unknowns, 1 rank", done.stdout, done.stderr)

    def test_a_sheet_is_stretched(self):
        # Plane stress, homogeneous on any mesh.
        E, nu, h, stretch = 1e6, 0.3, 1e-3, 1.2
        self.patch(4, flat, jitter=0.3)
        text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: sheet, surface: sheet, free: true, thickness: {h}, {LAW % (E, nu)}}}]
constraints:
  - {{curve: s0, displacement: [0, free, free]}}
  - {{curve: t0, displacement: [free, 0, free]}}
  - {{curve: s1, displacement: [{stretch - 1}, free, free], name: right}}
  - {{where: "x > -1", displacement: [free, free, 0]}}
probes: [{{name: p, point: [0.4, 1, 0]}}]
"""
        for element in ("P1", "P2"):
            found = self.end_of(f"element: {element}\n{text}")
            strain = (stretch**2 - 1) / 2
            across = np.sqrt(1 - 2 * nu * strain)
            np.testing.assert_allclose(found["right_fx"], E * strain * stretch * h, rtol=1e-9, err_msg=element)
            np.testing.assert_allclose(found["p_y"], across, rtol=1e-9, err_msg=element)

    def test_benchmarks(self):
        # Published displacements, on coarse meshes; the ratios to them are those of docs/shells.md, as printed.
        self.patch(16, roof)
        found = self.end_of(ROOF)
        np.testing.assert_allclose(25 * np.cos(np.radians(40)) - found["p_y"], 0.953 * 0.3024e-3, rtol=1e-3)
        self.patch(16, cylinder)
        np.testing.assert_allclose(300 - self.end_of(CYLINDER)["p_y"], 1.121 * 1.82488e-5, rtol=1e-3)
        self.patch(16, hemisphere)
        found = self.end_of(HEMISPHERE)
        np.testing.assert_allclose([found["p_x"] - 10, found["q_y"] - 10], [1.000 * 0.1849363, -0.998 * 0.1890221], rtol=1e-3)

    def test_a_plate_on_any_mesh(self):
        # Uniform load (Timoshenko & Woinowsky-Krieger): 0.00406235 q a^4/D on supports, 0.00126532 q a^4/D clamped. The ratios to
        # these are those of docs/shells.md, as printed.
        E, nu, h, q = 1e9, 0.3, 0.01, 1e-2
        D = E * h**3 / (12 * (1 - nu**2))
        clamped = ", clamped: [{curve: s0}, {curve: s1}, {curve: t0}, {curve: t1}]"
        for held, expected, ratios in (("", 0.00406235, (1.0054, 1.0073, 1.0027)), (clamped, 0.00126532, (1.0470, 1.0483, 1.0419))):
            cases = tuple(zip((False, True, True), (0.0, 0.0, 0.25), ratios))
            for alternate, jitter, ratio in swept(cases, cases[-1:]):
                self.patch(16, flat, alternate=alternate, jitter=jitter)
                text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: plate, surface: sheet, free: true, thickness: {h}, bending: true, {LAW % (E, nu)}{held}}}]
constraints: [{', '.join(f'{{curve: {c}, displacement: [0, 0, 0]}}' for c in ('s0', 's1', 't0', 't1'))}]
loads: [{{surface: sheet, traction: [0, 0, {q}]}}]
probes: [{{name: p, point: [0.5, 0.5, 0]}}]
"""
                np.testing.assert_allclose(self.end_of(text)["p_z"], ratio * expected * q / D, rtol=1e-4, err_msg=f"{held} {alternate} {jitter}")

    def test_a_plate_vibrates(self):
        # On four supports: (pi/2) (1 + 1) sqrt(D / (rho h)) / a^2.
        E, nu, h, density = 1e9, 0.3, 0.01, 1000
        self.patch(12, flat, alternate=True)
        self.write("in.yaml", f"""mesh: {{file: sheet.msh}}
shells: [{{name: plate, surface: sheet, free: true, thickness: {h}, density: {density}, bending: true, {LAW % (E, nu)}}}]
constraints: [{', '.join(f'{{curve: {c}, displacement: [0, 0, 0]}}' for c in ('s0', 's1', 't0', 't1'))}]
time: {{method: bdf2, step: 1 ms, end: 1}}
""")
        self.pliant("modes", "in.yaml", "--output", "modes", "--number", "4")
        with open(self.directory / "modes/modes.csv", encoding="ascii", newline="") as stream:
            found = [float(row["frequency"]) for row in csv.DictReader(stream)]
        unit = np.pi / 2 * np.sqrt(E * h**3 / (12 * (1 - nu**2)) / (density * h))
        np.testing.assert_allclose(found, unit * np.array([2, 5, 5, 8]), rtol=0.008)  # of the mesh

    def test_a_balloon(self):
        # A spherical membrane: p = 2 h mu/R (1/l - 1/l^7).
        mu, h, R, stretch = 300e3, 1e-3, 0.1, 1.2
        write_ball(self.directory / "sheet.msh", 8, R)
        pressure = 2 * h * mu / R * (1 / stretch - stretch**-7)
        text = f"""mesh: {{file: sheet.msh}}
shells: [{{name: balloon, surface: sheet, free: true, thickness: {h},
  elasticity: {{model: neo-hookean-isochoric, shear_modulus: {mu}, bulk_modulus: 1e9}}}}]
constraints:
  - {{where: "abs(x) < 1e-9", displacement: [0, free, free]}}
  - {{where: "abs(y) < 1e-9", displacement: [free, 0, free]}}
  - {{where: "abs(z) < 1e-9", displacement: [free, free, 0]}}
loads: [{{surface: sheet, pressure: {pressure}}}]
probes: [{{name: pole, point: [{R}, 0, 0]}}]
"""
        for ranks in swept((1, 2, 3), (1, 3)):
            np.testing.assert_allclose(self.end_of(text, ranks)["pole_x"] / R, stretch, rtol=0.012)  # of the mesh

    def test_orders(self):
        # All methods, whether or not the long tests run: the mesh is small.
        self.patch((2, 1), lambda s, t: (s, 0.4 * t, 0.0))
        viscous = "viscosity: {model: kelvin-voigt, shear: 3 kPa*s, bulk: 1 kPa*s}"
        for law in swept(("damping: 1 ms", viscous), (viscous,)):
            self.write("in.yaml", SHAKEN.replace("damping: 1 ms", law) + "time: {method: bdf2, step: 2 ms, end: 0.1, startup: dirk33}\n")
            self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", "all")

    def test_viscosity(self):
        # A sheet that is pulled at constant speed, and does not contract: elastic and viscous stress in plane stress.
        E, nu, h, shear, bulk, speed = 1e5, 0.3, 1e-3, 2e3, 1.5e3, 0.5
        self.patch(2, flat, jitter=0.2)
        h_of = lambda viscosity, time: self.solve(f"""mesh: {{file: sheet.msh}}
shells: [{{name: sheet, surface: sheet, free: true, thickness: {h}, {LAW % (E, nu)}, viscosity: {viscosity}}}]
constraints:
  - {{curve: s0, displacement: [0, free, free]}}
  - {{curve: s1, displacement: ["{speed}*t", free, free], name: right}}
  - {{where: "x > -1", displacement: [free, 0, 0]}}
""", time)
        row = h_of(f"{{model: kelvin-voigt, shear: {shear}, bulk: {bulk}}}", "method: quasistatic, step: 50 ms, end: 0.4")
        F = 1 + speed * row["time"]
        of_trace = 2 * shear * (bulk - 2 / 3 * shear) / (bulk + 4 / 3 * shear)
        elastic, viscous = E / (1 - nu**2) * (F**2 - 1) / 2, (of_trace + 2 * shear) * F * speed
        np.testing.assert_allclose(row["right_fx"][1:], (h * F * (elastic + viscous))[1:], rtol=1e-6)
        # Kelvin-Voigt in the ratio of the elastic moduli is stiffness-proportional, in bending too, and damping is that.
        self.patch((3, 2), lambda s, t: (s, 0.4 * t, 0.0))
        time = "method: dirk22, step: 10 ms, end: 0.1"
        beta, E = 2e-3, 1e7
        laws = [f"damping: {beta}", f"viscosity: {{model: stiffness-proportional, time: {beta}}}",
                f"viscosity: {{model: kelvin-voigt, shear: {beta * E / (2 * (1 + nu))}, bulk: {beta * E / (3 * (1 - 2 * nu))}}}"]
        one, *others = [self.solve(SHAKEN.replace("damping: 1 ms", law) + "solver: {newton: {relative: 1e-12}}\n", time) for law in laws]
        self.assertGreater(one["dissipated_shell_viscosity"][-1], 0.003 * one["load_work"][-1])
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-6 * np.abs(one["load_work"]).max())
        for other in others:
            self.assert_same_history(one, other, 1e-7)
        # A vibration of the circular frequency w has the damping ratio beta w/2, here of bending.
        self.write("in.yaml", SHAKEN.split("loads:")[0].replace("damping: 1 ms", laws[2]) + "time: {method: bdf2, step: 1 ms, end: 1}\n")
        self.pliant("modes", "in.yaml", "--output", "modes", "--number", "3")
        with open(self.directory / "modes/modes.csv", encoding="ascii", newline="") as stream:
            for mode in csv.DictReader(stream):
                np.testing.assert_allclose(float(mode["damping_ratio"]), beta * np.pi * float(mode["frequency"]), rtol=1e-5)

    def test_ranks_restart_and_ledger(self):
        self.patch((6, 3), lambda s, t: (s, 0.4 * t, 0.0), alternate=True)
        text = SHAKEN + "solver: {newton: {relative: 1e-12}}\n"
        time = "method: dirk22, step: 10 ms, end: 0.1"
        one = self.solve(text, time)
        self.assertGreater(np.abs(one["tip_z"]).max(), 1e-3)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-6 * np.abs(one["load_work"]).max())
        for ranks in swept((2, 3), (3,)):
            self.assert_same_history(one, self.solve(text, time, ranks), 1e-7)
        self.write("part.yaml", text + "checkpoint: {}\ntime: {method: dirk22, step: 10 ms, end: 0.05}\n")
        self.run_input("part.yaml", output="part")
        self.pliant("resume", "part", "--quiet", "--set", "time.end=0.1", ranks=2)
        resumed = read_history(self.directory / "part")
        for name in ("kinetic_energy", "elastic_energy", "tip_z"):
            np.testing.assert_allclose(resumed[name][-1], one[name][-1], rtol=1e-6, atol=1e-9, err_msg=name)
        mesh = Result(self.directory / "out").mesh()
        surface = Surface(mesh)
        self.assertEqual(len(surface.triangles), 6 * 3 * 2)  # those of the shell, without the sides of its cells
        a, b, c = (surface.of_nodes(mesh.coordinates)[surface.triangles[:, k]] for k in range(3))
        self.assertAlmostEqual(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum(), 0.4, places=9)

    def test_a_shell_on_a_block(self):
        # A sheet in the extension of a block's side, joined by shared nodes: both carry the same force.
        self.write("joined.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Rectangle(100) = {1, 0, 0.5, 1, 1};
BooleanFragments{ Volume{1}; Delete; }{ Surface{100}; Delete; }
e = 1e-6;
Physical Volume("block") = {1};
Physical Surface("sheet") = Surface In BoundingBox {1-e, -e, 0.5-e, 2+e, 1+e, 0.5+e};
Physical Surface("bottom") = Surface In BoundingBox {-e, -e, -e, 1+e, 1+e, e};
Physical Curve("end") = Curve In BoundingBox {2-e, -e, -e, 2+e, 1+e, 1};
Mesh.MeshSizeMax = 0.5;
""")
        found = self.end_of(f"""mesh: {{file: joined.geo}}
bodies: [{{volume: block, elasticity: {{model: linear, youngs_modulus: 1e6, poissons_ratio: 0.3}}}}]
shells: [{{name: sail, surface: sheet, free: true, thickness: 1 mm, {LAW % (1e6, 0)}}}]
constraints:
  - {{surface: bottom, displacement: [0, 0, 0]}}
  - {{curve: end, displacement: [1 mm, 0, 0], name: pull}}
""")
        self.assertGreater(found["pull_fx"], 0.5)
        self.assertLess(found["pull_fx"], 1.0)
        np.testing.assert_allclose(found["bottom_fx"], -found["pull_fx"], rtol=1e-6)

    def test_a_chamber_of_a_block_under_a_lid(self):
        # The lid gets the orientation of the walls, whatever its own is in the mesh: pressure bulges it outwards.
        geometry = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 4, 4, 2}; Box(2) = {1, 1, 1, 2, 2, 1};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Rectangle(100) = {1, 1, 2, 2, 2};
BooleanFragments{ Volume{3}; Delete; }{ Surface{100}; Delete; }
lid() = Surface In BoundingBox {0.9, 0.9, 1.9, 3.1, 3.1, 2.1};
walls() = Surface In BoundingBox {0.9, 0.9, 0.9, 3.1, 3.1, 2.1};
walls() -= lid();
Physical Volume("block") = {3};
Physical Surface("chamber") = {walls(), lid()};
Physical Surface("lid") = {SIGNlid()};
Physical Surface("bottom") = Surface In BoundingBox {-0.1, -0.1, -0.1, 4.1, 4.1, 0.1};
Mesh.MeshSizeMax = 0.7;
"""
        text = f"""mesh: {{file: block.geo}}
bodies: [{{volume: block, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e7, poissons_ratio: 0.3}}}}]
shells: [{{name: lid, surface: lid, free: true, thickness: 0.02, {LAW % (1e6, 0.3)}}}]
constraints: [{{surface: bottom, displacement: [0, 0, 0]}}]
cavities: [{{name: chamber, surface: chamber, pressure: 2 kPa}}]
probes: [{{name: top, point: [2, 2, 2]}}]
"""
        heights = []
        for sign, ranks in (("", 1), ("-", 2)):
            self.write("block.geo", geometry.replace("SIGN", sign))
            h = self.solve(text, "method: static, load_steps: 4", ranks)
            np.testing.assert_allclose(h["chamber_volume"][0], 4, rtol=1e-12)
            self.assertGreater(h["chamber_volume"][-1], 4.2)
            heights.append(h["top_z"][-1] - 2)
        self.assertGreater(heights[0], 0.1)
        np.testing.assert_allclose(heights[1], heights[0], rtol=1e-6)

    def test_a_membrane_between_two_chambers(self):
        # Each chamber sees it from its own side: it bulges as under the difference of both pressures.
        self.write("block.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 2, 1.5, 1.5}; Box(2) = {0.5, 0.25, 0.25, 1, 1, 1};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Rectangle(100) = {-0.5, -0.5, 0, 1, 1};
Rotate {{0, 1, 0}, {0, 0, 0}, Pi/2} { Surface{100}; }
Translate {1, 0.75, 0.75} { Surface{100}; }
BooleanFragments{ Volume{3}; Delete; }{ Surface{100}; Delete; }
part() = Surface In BoundingBox {0.9, 0.2, 0.2, 1.1, 1.3, 1.3};
left() = Surface In BoundingBox {0.4, 0.2, 0.2, 1.1, 1.3, 1.3};
right() = Surface In BoundingBox {0.9, 0.2, 0.2, 1.6, 1.3, 1.3};
Physical Volume("block") = {3};
Physical Surface("left") = {left()};
Physical Surface("right") = {right()};
Physical Surface("part") = {part()};
Physical Surface("bottom") = Surface In BoundingBox {-0.1, -0.1, -0.1, 2.1, 1.6, 0.1};
Mesh.MeshSizeMax = 0.5;
""")
        text = f"""mesh: {{file: block.geo}}
bodies: [{{volume: block, elasticity: {{model: neo-hookean, youngs_modulus: 1e10, poissons_ratio: 0.3}}}}]
shells: [{{name: part, surface: part, free: true, thickness: 0.02, {LAW % (1e6, 0.3)}}}]
constraints: [{{surface: bottom, displacement: [0, 0, 0]}}]
output: {{history: [{{name: bulge, of: displacement_x, in: part, take: mean}}]}}
time: {{method: static, load_steps: 2}}
"""

        def history(more, ranks=1):
            self.write("in.yaml", text + more)
            return self.run_input("in.yaml", ranks=ranks)

        def chambers(p, q):
            return f"cavities: [{{name: a, surface: left, pressure: {p}}}, {{name: b, surface: right, pressure: {q}}}]\n"

        one = history("cavities: [{name: a, surface: left, pressure: 1 kPa}]\n")
        self.assertGreater(one["bulge"][-1], 0.01)
        for p, q, ranks in ((3000, 2000, 2), (2000, 3000, 1), (3000, 3000, 1)):
            h = history(chambers(p, q), ranks)
            np.testing.assert_allclose(h["bulge"][-1], one["bulge"][-1] * (p - q) / 1000, rtol=1e-3, atol=1e-6)
            np.testing.assert_allclose([h["a_volume"][0], h["b_volume"][0]], 0.5, rtol=1e-12)
            np.testing.assert_allclose(h["a_volume"][-1] - 0.5, h["bulge"][-1], rtol=2e-2, atol=1e-5)
            np.testing.assert_allclose(h["a_volume"][-1] + h["b_volume"][-1], 1, rtol=1e-5)
        pushed = history("loads: [{surface: left, pressure: 3 kPa}, {surface: right, pressure: 2 kPa}]\n")
        np.testing.assert_allclose(pushed["bulge"][-1], one["bulge"][-1], rtol=1e-3)

    def test_a_chamber_between_two_balloons(self):
        self.write("balloons.geo", """SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 0.1}; Sphere(2) = {0, 0, 0, 0.2};
Delete { Volume{1, 2}; }
Physical Surface("inner") = {1}; Physical Surface("outer") = {2}; Physical Surface("both") = {1, 2};
Mesh.MeshSizeMax = 0.05;
""")
        law = LAW % (1e6, 0.3)
        h = self.end_of(f"""mesh: {{file: balloons.geo}}
shells:
  - {{name: inner, surface: inner, free: true, thickness: 1 mm, {law}}}
  - {{name: outer, surface: outer, free: true, thickness: 1 mm, {law}}}
constraints: [{{where: "x > -1", displacement: [0, 0, 0]}}]
cavities:
  - {{name: core, surface: inner, pressure: 1}}
  - {{name: whole, surface: outer, pressure: 1}}
  - {{name: gap, surface: both, pressure: 1}}
""")
        self.assertAlmostEqual(h["core_volume"] / (4 / 3 * np.pi * 1e-3), 1, delta=0.15)  # of the mesh
        self.assertAlmostEqual(h["gap_volume"], h["whole_volume"] - h["core_volume"], places=12)

    def test_results(self):
        self.patch((6, 3), lambda s, t: (s, 0.4 * t, 0.0))
        self.write("in.yaml", SHAKEN + "time: {method: dirk22, step: 20 ms, end: 0.2}\noutput: {every: 0.2}\n")
        self.run_input("in.yaml", output="out", ranks=2)
        frame = Result(self.directory / "out")[-1]
        corners = frame.positions()[frame.mesh.cells]
        sizes = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max()
        self.assertLess(sizes, 0.3)  # the cells stay together
        volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
        self.assertGreater(volumes.min(), 0)
        self.assertLess(volumes.sum(), 0.4 * 20e-3)
        # What stands for the triangles is nowhere counted or measured.
        text = self.pliant("check", "in.yaml").stdout
        self.assertRegex(text, r"(?m)^  size       36 triangles of shells$")
        self.assertRegex(text, r"(?m)^  flag: 36 facets, 0\.4 m\^2, .*\n    extent \[0, 1\] x \[0, 0\.4\] x \[0, 0\] m$")
        for words in ("tetrahedra", "volume", "quality", "bodies"):
            self.assertNotIn(words, text)
        self.pliant("report", "out")
        report = ReportFile(self.directory / "out/report.html")
        self.assertEqual(report.result["elements"], {"tetrahedra": 0, "triangles": 36, "segments": 0})

    def test_gravity_by_name(self):
        self.patch((2, 2), lambda s, t: (s, 0.4 * t, 0.0))
        text = SHAKEN.split("loads:")[0].replace("0]}]\n", "0], name: hold}]\n") + "loads: [{gravity: [0, 0, -10], volume: flag}]\n"
        np.testing.assert_allclose(self.end_of(text)["hold_fz"], 0.4 * 0.02 * 1000 * 10, rtol=1e-6)

    def test_a_post_mortem_says_nothing_of_what_stands_for_the_triangles(self):
        self.patch((4, 2), lambda s, t: (s, 0.4 * t, 0.0))
        self.write("in.yaml", SHAKEN.split("loads:")[0] + """loads: [{gravity: [0, 0, -1000]}]
time: {method: static, load_steps: 1}
solver: {newton: {max_iterations: 1}}
""")
        self.pliant("run", "in.yaml", "-o", "out", status=3)
        report = yaml.safe_load((self.directory / "out/post-mortem/report.yaml").read_text())
        self.assertEqual([body["volume_ratio"] for body in report["bodies"]], [1.0])

    def test_what_is_refused(self):
        self.patch((4, 2), lambda s, t: (s, 0.4 * t, 0.0))
        text = SHAKEN + "time: {method: bdf2, step: 4 ms, end: 0.2}\n"
        cases = {
            "no surface 'shet' in the mesh (did you mean 'sheet'?)": text.replace("surface: sheet, free", "surface: shet, free"),
            "it contains no tetrahedra": text.replace("free: true, ", "").replace("loads:", "bodies: [{density: 1, elasticity: "
            "{model: linear, youngs_modulus: 1, poissons_ratio: 0}}]\nloads:"),
            "needs 'surface', a physical surface": text.replace("surface: sheet, free", 'where: "x > -1", free'),
            "missing key 'density' of free shell 'flag'": text.replace("density: 1000, ", ""),
            "cannot be refined with the mesh": text.replace("sheet.msh}", "sheet.msh, refine: 1}"),
            "has no direction that 'clamped' could hold": text.replace("bending: true, ", ""),
            "curve 's0' does not lie in a plane with the `normal` (0, 1, 0)": text.replace("{curve: s0}]", "{curve: s0, normal: [0, 1, 0]}]"),
            "'force_density' acts on the volume of tetrahedra, and there are none": text.replace("loads: [", "loads: [{force_density: [0, 0, 1]}, "),
            "missing key 'density' of free shell 'flag', which gravity needs": text.replace("density: 1000, ", "").replace(
                "time: {method: bdf2, step: 4 ms, end: 0.2}", "time: {method: static}"),
            "has the name of a body or a rod": text + "rods: [{name: flag, points: [[0, 0, 1], [1, 0, 1]], radius: 1 mm, youngs_modulus: 1, "
            "poissons_ratio: 0, density: 1, start: ground}]\n",
            "the viscosity of shell 'flag' has no effect without 'shear'": text.replace(
                "damping: 1 ms", "viscosity: {model: kelvin-voigt, shear: 0, bulk: 1}"),
            "missing key 'mesh'": text.replace("mesh: {file: sheet.msh}\n", ""),
        }
        self.assert_refused(cases)


if __name__ == "__main__":
    unittest.main()
