#!/usr/bin/python3
"""Shells, as users type them: closed forms of membranes, sandwiches, bimetals, balloons and plates, orders, ranks, restart."""
import unittest

import numpy as np

from program import ALL_OR_SOME, ROOT, ProgramTest, read_history, swept, write_box

# A body that hardly resists, below a layer.
FAINT = "{model: neo-hookean, youngs_modulus: 1 mPa, poissons_ratio: 0}"
HELD = """  - {surface: left, displacement: [0, free, free]}
  - {surface: front, displacement: [free, 0, free]}
  - {surface: bottom, displacement: [free, free, 0]}
"""
# A bar with a skin all around, shaken in space.
SKIN = """shells:
  - name: skin
    where: "x > -1"
    thickness: 5 mm
    density: 2000
    prestretch: 1.05
    damping: 1 ms
    elasticity: {model: neo-hookean, youngs_modulus: 2 MPa, poissons_ratio: 0.45}
"""
SHAKEN = f"""mesh: {{file: box.msh}}
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}}}]
{SKIN}constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, "20*(1-cos(8*t))", "-50*(1-cos(6*t))"]}}]
probes: [{{name: tip, point: [0.6, 0, 0]}}]
"""


class Shells(ProgramTest):
    def box(self, n, size, **more):
        write_box(self.directory / "box.msh", n, size, **more)

    def end_of(self, text, ranks=1):
        return {name: column[-1] for name, column in self.solve(text, "method: static", ranks).items()}

    def test_stretched_membranes(self):
        # Mooney-Rivlin, almost incompressible: P_1 = 2 (l_1 - 1/(l_1^3 l_2^2)) (c10 + c01 l_2^2) (Treloar).
        c10, c01, h = 300e3, 80e3, 1e-3
        self.box((2, 2, 1), (1.0, 0.5, 0.2))
        for element, l1, l2 in (("P1", 1.5, 1 / np.sqrt(1.5)), ("P2", 1.5, 1 / np.sqrt(1.5)), ("P1", 2.0, 2.0), ("P2", 2.0, 1.0)):
            text = f"""mesh: {{file: box.msh}}
element: {element}
bodies: [{{elasticity: {FAINT}}}]
shells: [{{name: skin, surface: top, thickness: {h}, elasticity: {{model: mooney-rivlin, c10: {c10}, c01: {c01}, bulk_modulus: 1e11}}}}]
constraints:
{HELD}  - {{surface: right, displacement: [{l1 - 1}, free, free]}}
  - {{surface: back, displacement: [free, {0.5 * (l2 - 1)!r}, free]}}
"""
            found = self.end_of(text)
            for side, a, b, width in (("right_fx", l1, l2, 0.5), ("back_fy", l2, l1, 1.0)):
                stress = 2 * (a - 1 / (a**3 * b**2)) * (c10 + c01 * b**2)
                np.testing.assert_allclose(found[side], stress * h * width, rtol=2e-4, atol=1e-4 * c10 * h, err_msg=f"{element} {side}")

    def test_a_skin_between_two_bodies_counts_once(self):
        halves = """mesh: {file: halves.geo}
bodies:
  - {volume: low, elasticity: {model: linear, youngs_modulus: 1 kPa, poissons_ratio: 0}}
  - {volume: high, elasticity: {model: linear, youngs_modulus: 1 kPa, poissons_ratio: 0}}
shells: [{name: sheet, surface: between, thickness: 1 mm, elasticity: {model: linear, youngs_modulus: 1 MPa, poissons_ratio: 0}}]
constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: right, displacement: [1 mm, 0, 0]}]
"""
        self.write("halves.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 0.2, 0.1}; Box(2) = {0, 0, 0.1, 1, 0.2, 0.1};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("low") = {1}; Physical Volume("high") = {2};
e = 1e-6;
Physical Surface("between") = Surface In BoundingBox {-e, -e, 0.1-e, 1+e, 0.2+e, 0.1+e};
Physical Surface("left") = Surface In BoundingBox {-e, -e, -e, e, 1, 1};
Physical Surface("right") = Surface In BoundingBox {1-e, -e, -e, 1+e, 1, 1};
Mesh.MeshSizeMax = 0.1;
""")
        expected = 1e-3 * (1e3 * 0.04 + 1e6 * 1e-3 * 0.2)
        for ranks in swept((1, 2, 3), (1, 3)):
            np.testing.assert_allclose(self.end_of(halves, ranks)["right_fx"], expected, rtol=1e-9)

    def test_a_stretched_skin_curls_a_strip(self):
        # Linear beam: forces and moments of strip and skin balance (Timoshenko's bimetal; Stoney for a thin skin).
        L, h, hf, E, Ef, stretch = 1.0, 0.05, 1e-3, 1e6, 20e6, 1.001
        self.box((10, 1, 2), (L, 0.1, h))
        skin = Ef * hf * (1 - 1 / stretch)  # of a linear law: strain from the stretched state, per length at rest
        text = f"""mesh: {{file: box.msh}}
element: P2
bodies: [{{elasticity: {{model: saint-venant-kirchhoff, youngs_modulus: {E}, poissons_ratio: 0}}}}]
shells:
  - {{name: skin, surface: top, thickness: {hf}, prestretch: [{stretch}, 1], direction: [1, 0, 0],
     elasticity: {{model: saint-venant-kirchhoff, youngs_modulus: {Ef}, poissons_ratio: 0}}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
probes: [{{name: tip, point: [{L}, 0.05, {h / 2}]}}]
"""
        found = self.end_of(text)
        # E h e + Ef hf (e + k h/2 + 0.001) = 0, E h^3/12 k + Ef hf (e + k h/2 + 0.001) h/2 = 0
        a, b, c = E * h + Ef * hf, Ef * hf * h / 2, E * h**3 / 12 + Ef * hf * h**2 / 4
        mean, curvature = np.linalg.solve([[a, b], [b, c]], -skin * np.array([1, h / 2]))
        self.assertLess(curvature, -0.01)
        np.testing.assert_allclose(found["tip_z"] - h / 2, -curvature * L**2 / 2, rtol=0.01)
        np.testing.assert_allclose(found["tip_x"] - L, mean * L - curvature**2 * L**3 / 6, rtol=0.02)

    def test_a_sandwich_bends_as_theory_says(self):
        # Thin stiff skins on a soft core (Allen 1969): P L^3/(3 D) + P L/(G b h).
        L, b, h, hf, E, nu, Ef, P = 1.0, 0.1, 0.1, 0.5e-3, 1e6, 0.3, 1e9, 0.5
        self.box((20, 1, 2), (L, b, h))
        law = f"{{model: linear, youngs_modulus: {Ef}, poissons_ratio: 0.3}}"
        text = f"""mesh: {{file: box.msh}}
element: P2
bodies: [{{elasticity: {{model: linear, youngs_modulus: {E}, poissons_ratio: {nu}}}}}]
shells:
  - {{name: upper, surface: top, thickness: {hf}, elasticity: {law}}}
  - {{name: lower, surface: bottom, thickness: {hf}, elasticity: {law}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{surface: right, force: [0, 0, {-P}]}}]
probes: [{{name: tip, point: [{L}, {b / 2}, {h / 2}]}}]
"""
        bending = 2 * Ef * hf * b * (h / 2) ** 2 + E * b * h**3 / 12
        expected = P * L**3 / (3 * bending) + P * L / (E / (2 * (1 + nu)) * b * h)
        np.testing.assert_allclose(h / 2 - self.end_of(text)["tip_z"], expected, rtol=0.02)

    def test_a_balloon(self):
        # A skin on a hollow sphere of next to nothing: p = 2 h mu / R (1/l - 1/l^7).
        mu, h, R, stretch = 300e3, 0.1e-3, 8e-3, 1.3
        pressure = 2 * h * mu / R * (1 / stretch - stretch**-7)
        text = f"""mesh: {{file: {ROOT}/meshes/hollow_sphere.geo, scale: 1e-3, size: 1.5 mm}}
element: P2
bodies: [{{volume: shell, elasticity: {{model: neo-hookean, youngs_modulus: 100, poissons_ratio: 0}}}}]
shells: [{{name: skin, surface: inner, thickness: {h}, elasticity: {{model: neo-hookean-isochoric, shear_modulus: {mu}, bulk_modulus: 1e9}}}}]
constraints:
  - {{surface: yz, displacement: [0, free, free]}}
  - {{surface: xz, displacement: [free, 0, free]}}
  - {{surface: xy, displacement: [free, free, 0]}}
loads: [{{surface: inner, pressure: {pressure}}}]
probes: [{{name: pole, point: [{R}, 0, 0]}}]
"""
        np.testing.assert_allclose(self.end_of(text)["pole_x"] / R, stretch, rtol=5e-3)

    def test_weight_and_free_fall(self):
        self.box((2, 1, 1), (0.2, 0.1, 0.1))
        mass = 1000 * 2e-3 + 2000 * 0.005 / 1.05**2 * 0.1
        held = SHAKEN.split("loads:")[0] + "loads: [{gravity: [0, 0, -10]}]\n"
        np.testing.assert_allclose(self.end_of(held)["left_fz"], 10 * mass, rtol=1e-6)
        for element in ("P1", "P2"):
            for kind in ("consistent", "lumped"):
                falling = f"element: {element}\nmass: {kind}\n" + held.replace("constraints: [{surface: left, displacement: [0, 0, 0]}]\n", "").replace(
                    "    prestretch: 1.05\n", "")
                h = self.solve(falling, "method: bdf2, step: 10 ms, end: 0.05")
                self.assertLess(np.abs(h["elastic_energy"]).max(), 1e-12 * h["kinetic_energy"].max())

    def test_a_layer_on_a_rigid_body(self):
        # Its mass moves the centre of mass: a force there turns nothing.
        self.box((2, 1, 1), (0.2, 0.1, 0.1))
        text = """mesh: {file: box.msh}
bodies: [{volume: body, density: 1000, rigid: true}]
shells: [{name: skin, surface: right, thickness: 10 mm, density: 2000, elasticity: {model: linear, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
loads: [{force: [0, 0, 10], volume: body}]
"""
        center = (2 * 0.1 + 0.2 * 0.2) / 2.2
        for element in ("P1", "P2"):
            h = self.solve(f"element: {element}\n" + text, "method: dirk33, step: 10 ms, end: 0.05")
            np.testing.assert_allclose(h["body_x"], center, rtol=1e-9)
            np.testing.assert_allclose(h["body_wy"], 0, atol=1e-6)
            np.testing.assert_allclose(h["body_vz"], 10 / 2.2 * h["time"], rtol=1e-9)

    def test_orders(self):
        # Without a prestretch, which would start fast vibrations.
        self.box((2, 1, 1), (0.6, 0.2, 0.2))
        for key, methods in swept((("damping: 1 ms", ALL_OR_SOME), ("bending: true", ALL_OR_SOME)), (("damping: 1 ms", ALL_OR_SOME),)):
            text = SHAKEN.replace("    prestretch: 1.05\n", "").replace("damping: 1 ms", key)
            self.write("in.yaml", text + "time: {method: bdf2, step: 2 ms, end: 0.1, startup: dirk33}\n")
            self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", methods)

    def test_ranks_restart_and_ledger(self):
        self.box((3, 1, 1), (0.6, 0.2, 0.2))
        for element in swept(("P1", "P2"), ("P2",)):
            text = f"element: {element}\n" + SHAKEN.replace("damping: 1 ms", "damping: 1 ms\n    bending: true") + "solver: {newton: {relative: 1e-12}}\n"
            time = "method: dirk22, step: 5 ms, end: 0.05"
            one = self.solve(text, time)
            self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-7 * np.abs(one["elastic_energy"]).max())
            self.assertGreater(one["dissipated_shell_viscosity"][-1], 0)
            for ranks in swept((2, 3), (3,)):
                self.assert_same_history(one, self.solve(text, time, ranks), 1e-7)
            self.write("part.yaml", text + "checkpoint: {}\ntime: {method: dirk22, step: 5 ms, end: 0.025}\n")
            self.run_input("part.yaml", output="part")
            self.pliant("resume", "part", "--quiet", "--set", "time.end=0.05")
            resumed = read_history(self.directory / "part")
            for name in ("kinetic_energy", "elastic_energy", "Lx", "pz"):
                np.testing.assert_allclose(resumed[name][-1], one[name][-1], rtol=1e-6, atol=1e-9, err_msg=name)

    def plate(self, n, ranks=1):
        """Deflection of the middle of a square plate on four supports, divided by that of theory."""
        a, h, E, nu, q = 1.0, 0.01, 1e9, 0.3, 1e-2
        self.write("plate.geo", f"""SetFactory("OpenCASCADE");
Box(1) = {{0, 0, 0, {a}, {a}, {-a / 10}}};
e = 1e-6;
Physical Volume("bed") = {{1}};
Physical Surface("plate") = Surface In BoundingBox {{-e, -e, -e, {a}+e, {a}+e, e}};
Physical Curve("rim") = Curve In BoundingBox {{-e, -e, -e, {a}+e, {a}+e, e}};
Point(100) = {{{a / 2}, {a / 2}, 0}};
Point{{100}} In Surface{{6}};
Mesh.MeshSizeMax = {a / n}; Mesh.MeshSizeMin = {a / n};
""")
        text = f"""mesh: {{file: plate.geo}}
bodies: [{{volume: bed, elasticity: {{model: linear, youngs_modulus: 1 mPa, poissons_ratio: 0}}}}]
shells: [{{name: plate, surface: plate, thickness: {h}, bending: true, elasticity: {{model: linear, youngs_modulus: {E}, poissons_ratio: {nu}}}}}]
constraints: [{{curve: rim, displacement: [0, 0, 0]}}]
loads: [{{surface: plate, traction: [0, 0, {q}]}}]
probes: [{{name: middle, point: [{a / 2}, {a / 2}, 0]}}]
"""
        D = E * h**3 / (12 * (1 - nu**2))
        return self.end_of(text, ranks)["middle_z"] / (0.00406235 * q * a**4 / D)

    def test_a_plate(self):
        # Simply supported, uniform load (Timoshenko & Woinowsky-Krieger): w = 0.00406235 q a^4 / D.
        errors = [self.plate(n) - 1 for n in swept((6, 12, 24), (6, 12))]
        self.assertLess(abs(errors[-1]), 0.05, errors)
        for coarse, fine in zip(errors, errors[1:]):
            self.assertLess(abs(fine), 0.6 * abs(coarse), errors)

    def test_what_is_refused(self):
        self.box((2, 1, 1), (0.6, 0.2, 0.2))
        text = SHAKEN + "time: {method: static}\n"
        model = "{model: neo-hookean, youngs_modulus: 2 MPa, poissons_ratio: 0.45}"
        fibres = "{model: guccione, fibre: [1, 0, 0]}"
        cases = {
            "no surface 'skn' in the mesh": text.replace('where: "x > -1"', "surface: skn"),
            "'thickness' must be": text.replace("thickness: 5 mm", "thickness: 0"),
            "missing key 'elasticity'": text.replace(f"    elasticity: {model}\n", "", 1),
            "the prestretch of shell 'skin' is one number, or two": text.replace("prestretch: 1.05", "prestretch: [1, 1, 1]"),
            "missing key 'direction' of shell 'skin'": text.replace("prestretch: 1.05", "prestretch: [1.1, 1]"),
            "'direction' must have a length": text.replace("prestretch: 1.05", "prestretch: [1.1, 1]\n    direction: [0, 0, 0]"),
            "is at right angles to a facet": text.replace("prestretch: 1.05", "prestretch: [1.1, 1]\n    direction: [1, 0, 0]"),
            "use a Poisson's ratio such as 0.4999": text.replace("poissons_ratio: 0.45", "poissons_ratio: 0.5"),
            "instead of 'incompressible' give": text.replace("poissons_ratio: 0.45", "incompressible: true"),
            "the shell name 'skin' is given twice": text.replace(SKIN, SKIN + SKIN.replace("shells:\n", "")),
            "bends, which needs the two moduli of an isotropic law": text.replace(model, fibres).replace("damping: 1 ms", "bending: true"),
            "is data of cells, and facets have none": text.replace("youngs_modulus: 2 MPa", "youngs_modulus: {cell_data: E}"),
            "lies on a surface of the mesh, which this input lacks": "rods: [{name: r, points: [[0,0,0],[1,0,0]], radius: 1 mm, youngs_modulus: 1, "
            f"poissons_ratio: 0, start: ground}}]\n{SKIN}time: {{method: static}}\n",
        }
        for message, wrong in cases.items():
            with self.subTest(message):
                self.write("in.yaml", wrong)
                done = self.call("run", "in.yaml", ranks=2 if "facet" in message else 1)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)
                if "'direction' must" in message:  # a key that is wrong is not missing
                    self.assertNotIn("missing key", done.stderr)
                self.assertRegex(done.stderr, r"in\.yaml:\d+:\d+: ")
        self.write("in.yaml", text.replace("damping: 1 ms", "bending: true"))
        self.assertRegex(self.pliant("check", "in.yaml").stdout, r"skin: 20 facets, 0\.56 m\^2, thickness 0\.005 m, neo-hookean .*mass .* stretched by 1\.05, bends")


if __name__ == "__main__":
    unittest.main()
