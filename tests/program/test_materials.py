#!/usr/bin/python3
"""Materials as users give them: constants of any kind, graded bodies, pictures of laws."""
import json
import re
import unittest
import xml.etree.ElementTree

import numpy as np

from program import ProgramTest, read_history, swept, write_box

STRETCHED = """
mesh: {{file: bar.msh}}
bodies: [{{elasticity: {{model: {elasticity}}}}}]
constraints:
  - {{surface: left, displacement: [0, free, free]}}
  - {{where: "y < 1e-9", displacement: [free, 0, free]}}
  - {{where: "z < 1e-9", displacement: [free, free, 0]}}
loads: [{{surface: right, traction: [1, 0, 0]}}]
time: {{method: static}}
probes: [{{name: end, point: [1, 0, 0]}}]
"""

# A cube that keeps its volume, stretched by l along x, and along y too.
CUBE = """
mesh: {{file: cube.msh}}
element: P2
volumetric: mixed
bodies: [{{elasticity: {{model: {elasticity}, incompressible: true}}}}]
constraints:
  - {{surface: left, displacement: [0, free, free]}}
  - {{surface: right, displacement: [{stretch} - 1, free, free]}}
  - {{where: "y < 1e-9", displacement: [free, 0, free]}}
  - {{where: "z < 1e-9", displacement: [free, free, 0]}}
{also}
time: {{method: static, load_steps: 4}}
solver: {{newton: {{relative: 1e-12}}}}
probes: [{{name: corner, point: [1, 1, 1]}}]
"""
ALONG_Y = '  - {{where: "y > 1 - 1e-9", displacement: [free, {stretch} - 1, free]}}'

def invariants(a, b, c):
    return a**2 + b**2 + c**2 - 3, (a * b)**2 + (b * c)**2 + (c * a)**2 - 3


def yeoh_like(slopes):
    return lambda a, b, c: sum(k * invariants(a, b, c)[0]**(n + 1) for n, k in enumerate(slopes))


def arruda_boyce(a, b, c, mu=3.0, lm=2.8):
    s, I1 = lm**-2, invariants(a, b, c)[0] + 3
    weights = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    at_rest = sum(2 * (k + 1) * w * s**k * 3**k for k, w in enumerate(weights))
    return mu / at_rest * sum(w * s**k * (I1**(k + 1) - 3**(k + 1)) for k, w in enumerate(weights))


def guccione(a, b, c):  # fibre along x
    E = [(l * l - 1) / 2 for l in (a, b, c)]
    return 0.5 * (np.exp(4 * E[0]**2 + 1.5 * (E[1]**2 + E[2]**2)) - 1)


def holzapfel_gasser_ogden(a, b, c):  # both families along x
    i1 = invariants(a, b, c)[0]
    return 1.5 * i1 + 2 * 5 / (2 * 0.8) * (np.exp(0.8 * (0.1 * i1 + 0.7 * (a**2 - 1))**2) - 1)


def holzapfel_ogden(a, b, c):  # fibre along x, sheet along z, which gets shorter
    return 3 / (2 * 1.5) * (np.exp(1.5 * invariants(a, b, c)[0]) - 1) + 4 / (2 * 1.2) * (np.exp(1.2 * (a**2 - 1)**2) - 1)


# Energies of bodies that keep their volume, as textbooks write them, of the principal stretches [Pa].
ENERGIES = {
    "neo-hookean, shear_modulus: 3": yeoh_like([1.5]),
    "neo-hookean, youngs_modulus: 9": yeoh_like([1.5]),
    "neo-hookean-isochoric, shear_modulus: 3": yeoh_like([1.5]),
    "mooney-rivlin, c10: 3, c01: 1": lambda a, b, c: 3 * invariants(a, b, c)[0] + invariants(a, b, c)[1],
    "mooney-rivlin-coupled, c1: 3, c2: 1": lambda a, b, c: 3 * invariants(a, b, c)[0] + invariants(a, b, c)[1],
    "mooney-rivlin-5, c10: 3, c01: 1, c20: 0.5": lambda a, b, c: yeoh_like([3, 0.5])(a, b, c) + invariants(a, b, c)[1],
    "yeoh, c10: 3, c30: 0.2": yeoh_like([3, 0, 0.2]),
    "gent, shear_modulus: 3, stretch_limit: 20": lambda a, b, c: -30 * np.log(1 - invariants(a, b, c)[0] / 20),
    "arruda-boyce, shear_modulus: 3, locking_stretch: 2.8": arruda_boyce,
    "ogden, mu1: 2, alpha1: 1.3, mu2: 1, alpha2: -2":
        lambda a, b, c: sum(2 * mu / al**2 * (a**al + b**al + c**al - 3) for mu, al in ((2, 1.3), (1, -2))),
    "guccione, C: 1, bf: 4, bt: 1.5, bfs: 2, fibre: [1, 0, 0]": guccione,
    "holzapfel-gasser-ogden, shear_modulus: 3, k1: 5, k2: 0.8, dispersion: 0.1, fibre: [1, 0, 0], fibre2: [1, 0, 0]":
        holzapfel_gasser_ogden,
    "holzapfel-ogden, a: 3, b: 1.5, a_f: 4, b_f: 1.2, fibre: [1, 0, 0], sheet: [0, 0, 1]": holzapfel_ogden,
}


class Materials(ProgramTest):
    def test_incompressible_cubes(self):
        """Every law with a volumetric part: the force is dW/da of W(a, b, 1/(a b)), by a complex step."""
        self.assertEqual(sorted(set(law.split(",")[0] for law in ENERGIES)),
                         sorted(self.laws_with("incompressible")))
        write_box(self.directory / "cube.msh", (1, 1, 1), (1.0, 1.0, 1.0))
        step = 1e-30j
        for elasticity, W in ENERGIES.items():
            tests = ((1.5, 1.5**-0.5, ""), (1.2, 1.2, ALONG_Y.format(stretch=1.2)))
            for l, b, also in swept(tests, tests if elasticity.startswith("mooney") else tests[:1]):
                with self.subTest(elasticity, stretch=l, across=b):
                    self.write("cube.yaml", CUBE.format(elasticity=elasticity, stretch=l, also=also))
                    history = self.run_input(self.directory / "cube.yaml")
                    force = W(l + step, b, 1 / (l + step) / b).imag / step.imag
                    self.assertGreater(abs(force), 1)
                    self.assertAlmostEqual(history["right_fx"][-1] / force, 1, delta=1e-8)
                    self.assertAlmostEqual(history["corner_z"][-1], 1 / (l * b), delta=1e-10)

    def laws_with(self, key):
        """The laws with which a key of `elasticity` is allowed."""
        lines = self.call("schema", "--markdown").stdout.splitlines()
        line = next(line for line in lines if line.endswith(f"optionally `{key}`."))
        return re.findall(r"`model: ([\w-]+)`", line)

    def stretched(self, elasticity, ranks=1, n=(8, 1, 1)):
        write_box(self.directory / "bar.msh", n, (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity=elasticity))
        history = self.run_input(self.directory / "bar.yaml", ranks=ranks)
        return history["end_x"][-1] - 1

    def test_any_two_constants_are_the_same_body(self):
        for constants in ("youngs_modulus: 1 kPa, poissons_ratio: 0.25", "shear_modulus: 400, lame_lambda: 400",
                          "bulk_modulus: 2000/3, shear_modulus: 0.4 kPa"):
            with self.subTest(constants):
                self.assertAlmostEqual(self.stretched(f"linear, {constants}") / 1e-3, 1, delta=1e-10)

    def test_graded_bar(self):
        # du/dx = P/E(x): the end moves by ln 2/1000, as the mesh gets finer.
        def error(n, ranks):
            u = self.stretched('linear, youngs_modulus: "1000*(1 + x)", poissons_ratio: 0', ranks, (n, 1, 1))
            return u / (1e-3 * np.log(2)) - 1

        coarse, fine = error(8, 1), error(32, 2)
        self.assertLess(abs(fine), 1e-3)
        self.assertLess(abs(fine), abs(coarse) / 4)

    def test_constants_that_are_not_admissible_somewhere(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity='linear, youngs_modulus: "0.5 - x", poissons_ratio: 0'))
        for ranks in (1, 2):
            done = self.call("run", "bar.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"bar.yaml:3:\d+: youngs_modulus is -0\.\d+; it must be finite and above 0, at \(0\.")

    def test_check_tells_the_equivalents(self):
        write_box(self.directory / "bar.msh", (1, 1, 1), (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity="mooney-rivlin, c10: 3, c01: 1, poissons_ratio: 0.25"))
        done = self.call("check", "bar.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("E = 20 Pa, nu = 0.25, mu = 8 Pa, K = 13.33 Pa, lambda = 8 Pa", done.stdout)

    def laws(self):
        schema = json.loads(self.call("schema").stdout)
        return schema["properties"]["bodies"]["items"]["properties"]["elasticity"]["properties"]["model"]["enum"]

    def test_every_law_is_drawn(self):
        laws = self.laws()
        self.assertGreater(len(laws), 5)
        for law in laws:
            with self.subTest(law):
                done = self.call("materials", "plot", law)
                self.assertEqual(done.returncode, 0, done.stderr)
                root = xml.etree.ElementTree.parse(self.directory / f"{law}.svg").getroot()
                curves = [e.get("points").split() for e in root.iter() if e.tag.endswith("polyline")]
                self.assertEqual(len(curves), 3)
                for points in curves:
                    self.assertGreater(len(points), 40)  # of 161: some laws end before a stretch of 2

    def test_measured_materials(self):
        """A body of the library is the body that its row describes; a run beyond the measured stretch is reported."""
        write_box(self.directory / "cube.msh", (1, 1, 1), (1.0, 1.0, 1.0))

        def run(elasticity, stretch, name):
            self.write("cube.yaml", CUBE.format(elasticity="X", stretch=stretch, also="").replace("{model: X, incompressible: true}", elasticity))
            done = self.call("run", "cube.yaml", "--output", name)
            self.assertEqual(done.returncode, 0, done.stderr)
            return read_history(self.directory / name)["right_fx"][-1], done.stdout + done.stderr

        own, _ = run("{model: yeoh, c10: 8002, c20: 80.8, poissons_ratio: 0.499}", 2, "own")
        force, told = run("{library: ecoflex-00-30}", 2, "library")
        self.assertEqual(force, own)
        self.assertNotIn("warning", told)
        self.assertAlmostEqual(force, 29.72e3, delta=0.011 * 114.76e3)  # as measured, and the deviation of the fit
        softer, _ = run("{library: ecoflex-00-30, c10: 4001, c20: 40.4, incompressible: true}", 2, "softer")
        self.assertAlmostEqual(softer / force, 0.5, delta=2e-3)  # 1 - 2 nu
        _, told = run("{library: ninjaflex, poissons_ratio: 0.49}", 2.2, "far")
        self.assertIn("beyond the range of 'ninjaflex': it was measured up to a stretch of 2", told)

    def test_density_of_a_measured_material(self):
        write_box(self.directory / "bar.msh", (1, 1, 1), (1.0, 0.1, 0.1))
        for body, mass in (("{elasticity: {library: dragon-skin-20}}", 10.8), ("{density: 500, elasticity: {library: dragon-skin-20}}", 5)):
            self.write("bar.yaml", f"mesh: {{file: bar.msh}}\nbodies: [{body}]\nloads: [{{gravity: [0, 0, -1]}}]\n"
                       "constraints: [{surface: left, displacement: [0, 0, 0]}]\ntime: {method: static}\n")
            history = self.run_input(self.directory / "bar.yaml")
            self.assertAlmostEqual(history["left_fz"][-1], mass, delta=1e-6)
        self.write("bar.yaml", "mesh: {file: bar.msh}\nbodies: [{elasticity: {library: rtv615}}]\nloads: [{gravity: [0, 0, -1]}]\ntime: {method: static}\n")
        done = self.call("run", "bar.yaml")
        self.assertEqual(done.returncode, 2)
        self.assertIn("missing key 'density' in bodies[0], which gravity needs: the library does not know that of 'rtv615'", done.stderr)

    def test_library_is_listed_and_drawn(self):
        listed = self.call("materials", "--library").stdout
        for name in ("ecoflex-00-30", "dragon-skin-10", "natural-rubber-treloar", "ninjaflex"):
            self.assertIn(name, listed)
            done = self.call("materials", "plot", name, "--stretch", "1", "2")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((self.directory / f"{name}.svg").exists())

    def test_bodies_that_leave_the_stable_range(self):
        """The force of this bar is largest at a stretch of 1.8; the ends are prescribed, so the run goes on."""
        write_box(self.directory / "cube.msh", (1, 1, 1), (1.0, 1.0, 1.0))
        elasticity = "yeoh, c10: 3, c20: -0.3"
        for stretch, leaves in ((1.3, False), (2.4, True)):
            self.write("cube.yaml", CUBE.format(elasticity=elasticity, stretch=stretch, also=""))
            for ranks in swept((1, 2), (1,)):
                done = self.call("run", "cube.yaml", "--output", f"{stretch}-{ranks}", ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stderr)
                told = done.stderr + done.stdout
                self.assertEqual(told.count("'yeoh' is stable only in uniaxial tension up to a stretch of"), 1, told)
                self.assertEqual(told.count("with these constants 'yeoh' is stable up to"), 1 if leaves else 0, told)

    def test_mistakes_in_plots(self):
        for arguments, words in ((("neo-hooken",), "did you mean 'neo-hookean'"), (("yeoh", "--set", "c40=1"), "one of c10, c20, c30"),
                                 (("linear", "--set", "shear_modulus=1 m"), "1 m"), (("linear", "--set", "shear_modulus=-1"), "above 0"),
                                 (("linear", "--stretch", "2", "3"), "at most 1")):
            with self.subTest(arguments):
                done = self.call("materials", "plot", *arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
