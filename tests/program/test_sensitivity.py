#!/usr/bin/python3
"""Derivatives of runs by numbers of their inputs against differences of runs, and numbers fitted to motions."""
import csv
import os
import sys
import unittest

import numpy as np
import scipy.optimize

from program import ENVIRONMENT, LONG, PROGRAM, ROOT, ProgramTest, swept, write_box

sys.path.insert(0, str(ROOT / "src/python"))
os.environ.update(ENVIRONMENT, PLIANT=str(PROGRAM))

import pliant  # noqa: E402

METHODS = {"backward-euler": "kelvin-voigt", "bdf2": "maxwell", "bdf3": "prony", "dirk22": "stiffness-proportional",
           "dirk23": "kelvin-voigt", "dirk33": "maxwell", "implicit-midpoint": "prony",
           "symplectic-dirk22": "stiffness-proportional"}
# Of each viscosity: its entry, and a number of it.
VISCOSITIES = {"kelvin-voigt": ("{model: kelvin-voigt, shear: 0.3}", "shear", 0.3),
               "maxwell": ("{model: maxwell, shear_ratio: 0.5, relaxation_time: 0.1}", "relaxation_time", 0.1),
               "prony": ("{model: prony, ratio: 0.5, relaxation_time: 0.1}", "ratio", 0.5),
               "stiffness-proportional": ("{model: stiffness-proportional, time: 0.02}", "time", 0.02)}
BLOCK = """mesh: {{file: block.msh}}
element: {element}
volumetric: {volumetric}
bodies:
  - volume: body
    density: 1
    elasticity: {{model: {law}}}
    viscosity: [{viscosity}]
{more}
initial: {{velocity: ["-(y - 0.5) + z + 0.4*x", "(x - 0.5) - 0.3*y*z", "-x + 0.5*z"]}}
time: {{method: {method}, step: 0.02, end: 0.16}}
probes: [{{name: corner, point: [2, 1, 1]}}]
solver: {{newton: {{relative: 1.0e-13}}}}
"""
SOFT = "neo-hookean, youngs_modulus: 10, poissons_ratio: 0.3"
# The relative change of a number in differences of whole runs, which are of fourth order.
PART = 1e-3


class Derivatives(ProgramTest):
    def sensitivities(self, file, columns, keys, *settings, ranks=1):
        """The derivatives at the end, by column and key."""
        done = self.call("sensitivity", file, "--of", ",".join(columns), "--to", ",".join(keys), "--output", "tangent",
                         *[word for s in settings for word in ("--set", s)], ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(self.directory / "tangent" / "sensitivity.csv", encoding="utf-8") as stream:
            last = list(csv.DictReader(stream))[-1]
        return {(c, k): float(last[f"d({c})/d({k})"]) for c in columns for k in keys}

    def difference(self, file, columns, key, value, *settings, part=PART):
        """The same by differences of fourth order of whole runs."""
        ends = []
        for factor in (-2, -1, 1, 2):
            h = self.run_input(file, f"{key}={value * (1 + factor * part)!r}", *settings)
            ends.append({c: h[c][-1] for c in columns})
        a, b, c, d = ends
        return {name: (a[name] - 8 * b[name] + 8 * c[name] - d[name]) / (12 * part * value) for name in columns}

    def compare(self, file, columns, numbers, *settings, within=1e-7, part=PART, rounding=0.0):
        """`rounding`: the error of p dy/dp that the rounding errors of whole runs cause."""
        found = self.sensitivities(file, columns, list(numbers), *settings)
        for key, value in numbers.items():
            expected = self.difference(file, columns, key, value, *settings, part=part)
            for column in columns:
                with self.subTest(column=column, key=key):
                    self.assertNotEqual(expected[column], 0)
                    np.testing.assert_allclose(found[column, key], expected[column], rtol=within, atol=rounding / value)

    def block(self, element="P1", volumetric="standard", law=SOFT, viscosity="", more="", method="bdf2"):
        write_box(self.directory / "block.msh", (2, 1, 1), (2, 1, 1))
        text = BLOCK.format(element=element, volumetric=volumetric, law=law, viscosity=viscosity, more=more, method=method)
        return self.write("block.yaml", text if viscosity else text.replace("    viscosity: []\n", ""))

    def test_every_method_and_viscosity(self):
        cases = list(enumerate(METHODS.items()))
        for n, (method, name) in swept(cases, [cases[k] for k in (1, 4, 5, 7)]):
            with self.subTest(method, viscosity=name):
                entry, key, value = VISCOSITIES[name]
                by_number = {f"bodies.0.viscosity.0.{key}": value} if n % 2 else {"bodies.0.elasticity.youngs_modulus": 10}
                # Maxwell was measured at 2e-7, the others below 1e-7.
                self.compare(self.block(viscosity=entry, method=method),
                             ("corner_x", "corner_vz", "elastic_energy", "dissipated_energy"), by_number,
                             within=5e-7 if name == "maxwell" else 1e-7)

    def test_treatments_of_the_volume(self):
        law = "neo-hookean-isochoric, shear_modulus: 10, poissons_ratio: {}"
        for element, volumetric, nu in (("P1", "mixed", 0.5), ("P2", "mean-dilatation", 0.499)):
            with self.subTest(volumetric):
                file = self.block(element, volumetric, law.format(nu), VISCOSITIES["prony"][0])
                self.compare(file, ("corner_x", "corner_vz"), {"bodies.0.elasticity.shear_modulus": 10})

    def test_supports_loads_and_works(self):
        """Follower pressure, moving support, steps that follow their error, statics."""
        more = """loads: [{surface: right, pressure: 1}]
constraints: [{surface: left, displacement: [0, 0, "0.1*sin(3*t)"]}]"""
        columns = ("corner_x", "left_fx", "support_work", "load_work")
        self.compare(self.block(more=more), columns, {"loads.0.pressure": 1})
        file = self.block(more=more)
        self.compare(file, columns[:2], {"bodies.0.density": 1}, "time.method=dirk22", "time.adaptive.relative=1e-4",
                     "time.adaptive.absolute=1e-5", within=1e-6, part=1e-4)
        self.write("static.yaml", """mesh: {file: block.msh}
bodies: [{volume: body, elasticity: {model: neo-hookean, youngs_modulus: 10, poissons_ratio: 0.3}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, 0.1]}]
time: {method: static, load_steps: 2}
solver: {newton: {relative: 1.0e-13}}
probes: [{name: corner, point: [2, 1, 1]}]
""")
        self.compare("static.yaml", ("corner_z", "elastic_energy"),
                     {"bodies.0.elasticity.youngs_modulus": 10, "bodies.0.elasticity.poissons_ratio": 0.3})

    def test_contact_with_friction_that_follows_it(self):
        """A block slides to rest on a plane, with the pressure of the present."""
        write_box(self.directory / "block.msh", (2, 1, 1), (2, 1, 1))
        file = self.write("slide.yaml", """mesh: {file: block.msh}
bodies:
  - {volume: body, density: 100, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3},
     viscosity: {model: stiffness-proportional, time: 0.01}}
loads: [{gravity: [0, 0, -9.81]}]
initial: {displacement: [0, 0, 0.02], velocity: [1, 0.2, 0]}
contact: {law: barrier, friction: 0.3, obstacles: [{name: floor, shape: plane, normal: [0, 0, 1]}]}
time: {method: bdf2, step: 0.005, end: 0.15}
probes: [{name: corner, point: [2, 1, 1]}]
solver: {newton: {relative: 1.0e-12}}
""")
        for update in ("iterated", "frozen"):
            with self.subTest(update):
                self.compare(file, ("corner_x", "px"), {"contact.friction": 0.3}, f"contact.friction_update={update}",
                             within=1e-4, part=1e-5)

    def test_friction_between_sliding_and_sticking(self):
        """A thrown block lands, slides and sticks: there a difference over the whole change reaches beyond the kink of the law."""
        write_box(self.directory / "block.msh", (2, 2, 2), (1, 1, 1))
        file = self.write("stick.yaml", """mesh: {file: block.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3},
     viscosity: {model: kelvin-voigt, shear: 200}}
loads: [{gravity: [0, 0, -9.81]}]
initial: {velocity: [0.5, 0, -0.5]}
contact: {obstacles: [{name: floor, shape: plane, point: [0, 0, -0.05], normal: [0.1, 0, 1], friction: 0.2}]}
time: {method: bdf2, step: 0.005, end: 0.275}
probes: [{name: corner, point: [1, 1, 1]}]
solver: {newton: {relative: 1.0e-12}}
""")
        self.compare(file, ("corner_x", "corner_z"), {"contact.obstacles.0.friction": 0.2},
                     within=1e-5, part=1e-5)

    def test_frozen_friction_beyond_its_bound(self):
        """A rod falls onto a block. From the first impact on the friction frozen at a step's start exceeds what the pressure allows."""
        write_box(self.directory / "block.msh", (4, 1, 1), (0.4, 0.1, 0.1))
        file = self.write("rod.yaml", """mesh: {file: block.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}]
rods:
  - {name: wire, points: [[-0.1, 0.05, 0.115], [0.5, 0.06, 0.115]], segments: 12, radius: 0.005, density: 3000, youngs_modulus: 1e6,
     poissons_ratio: 0.3, damping: 0.002}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
contact: {law: barrier, width: 0.004, friction: 0.4, friction_update: frozen, pairs: [{name: pr, surface: wire, with: body}]}
time: {method: backward-euler, step: 0.004, end: 0.056}
solver: {newton: {relative: 1.0e-12}}
""")
        self.compare(file, ("pr_fx",), {"contact.friction": 0.4, "bodies.0.density": 1000}, within=1e-3, part=1e-4)

    def test_components_of_a_direction(self):
        write_box(self.directory / "block.msh", (2, 1, 1), (2, 1, 1))
        file = self.write("slope.yaml", """mesh: {file: block.msh}
bodies: [{volume: body, density: 100, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}]
loads: [{gravity: [0, 0, -9.81]}]
initial: {displacement: [0, 0, 0.02]}
contact: {law: barrier, obstacles: [{name: floor, shape: plane, normal: [0.1, 0, 1]}]}
time: {method: bdf2, step: 0.005, end: 0.1}
solver: {newton: {relative: 1.0e-12}}
""")
        self.compare(file, ("px",), {"contact.obstacles.0.normal.0": 0.1}, within=1e-4, part=1e-4)
        with open(self.directory / "tangent/numbers.csv", encoding="utf-8") as stream:
            self.assertEqual({len(row) for row in csv.reader(stream)}, {3})

    def test_mechanism_with_tendon_on_any_number_of_ranks(self):
        """Rigid parts, joints, a motor, a tendon with friction and a spring; the same on all ranks."""
        write_box(self.directory / "block.msh", (4, 1, 1), (2, 1, 1))
        file = self.write("arm.yaml", """mesh: {file: block.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: hand, mass: 50, inertia: [5, 5, 5], center: [0, 0.5, 0.5], attached: [left]}
  - {name: bob, mass: 100, inertia: [1, 1, 1], center: [0, 0.5, -1]}
joints:
  - {name: knuckle, type: hinge, between: [ground, hand], point: [0, 0.5, 0.5], axis: [0, 1, 0],
     motor: {target: "0.2*t", stiffness: 20000, damping: 200}}
  - {name: eye, type: ball, between: [hand, bob], point: [0, 0.5, 0]}
tendons:
  - {name: flexor, points: [{body: ground, point: [-1, 0.5, 2]}, [0.5, 0.5, 0.9], [1, 0.5, 0.9], [1.8, 0.5, 0.9]],
     tension: "500*t", friction: 0.2}
loads: [{gravity: [0, 0, -9.81]}]
time: {method: dirk22, step: 0.02, end: 0.04}
probes: [{name: corner, point: [2, 1, 1]}]
solver: {newton: {relative: 1.0e-13}}
""")
        columns = ("corner_z", "knuckle_angle")
        numbers = {"tendons.0.friction": 0.2, "rigid_bodies.1.mass": 100}
        self.compare(file, columns, numbers, within=2e-6, rounding=5e-11)
        alone = self.sensitivities(file, columns, numbers)
        together = self.sensitivities(file, columns, numbers, ranks=3)
        for key, value in alone.items():
            np.testing.assert_allclose(together[key], value, rtol=1e-6, atol=5e-11 / numbers[key[1]])

    def test_numbers_without_influence(self):
        # Far below its limit a motor does not depend on it: the differences are rounding, and no reason to give up.
        self.write("bar.geo", 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 0.2, 0.05, 0.05};\nMeshSize{ PointsOf{ Volume{1}; } } = 0.05;\n'
                   'Physical Volume("bar") = {1};\nPhysical Surface("right") = {2};\n')
        self.write("in.yaml", """mesh: {file: bar.geo}
bodies: [{volume: bar, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 3e5, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: hub, mass: 0.2, inertia: [1e-4, 2e-4, 3e-4], center: [0.23, 0.025, 0.025], coupled: [right]}
  - {name: wheel, mass: 0.3, inertia: [1e-4, 2e-4, 3e-4], center: [0.3, 0.025, 0.025]}
joints: [{name: axle, type: hinge, between: [hub, wheel], point: [0.25, 0.025, 0.025], axis: [0, 1, 0], motor: {target: t, stiffness: 0.1, limit: 0.2}}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: dirk22, step: 2 ms, end: 0.01}
""")
        limit, stiffness = "joints.axle.motor.limit", "joints.axle.motor.stiffness"
        found = self.sensitivities("in.yaml", ["axle_angle"], [limit, stiffness])
        self.assertLess(abs(found["axle_angle", limit]), 1e-3 * abs(found["axle_angle", stiffness]))

    def test_files_and_table(self):
        file = self.block()
        done = self.call("sensitivity", file, "--of", "corner_x,px", "--to", "bodies.0.density", "--output", "tangent")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"derivatives at t = 0\.16 s")
        self.assertRegex(done.stdout, r"bodies\.0\.density +1 +kg/m\^3 ")
        with open(self.directory / "tangent" / "sensitivity.csv", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        self.assertEqual(len(rows), 9)
        # Momentum is density times velocity.
        self.assertAlmostEqual(float(rows[0]["d(px)/d(bodies.0.density)"]), float(rows[0]["px"]), delta=1e-9)
        self.assertEqual(float(rows[5]["bodies.0.density*d(px)/d(bodies.0.density)"]),
                         float(rows[5]["d(px)/d(bodies.0.density)"]))
        for column in ("corner_x", "px"):
            self.assertIn("bodies.0.density", (self.directory / "tangent" / f"sensitivity_{column}.svg").read_text())
        # The run is that of `pliant run`.
        h = self.run_input(file)
        np.testing.assert_allclose([float(row["corner_x"]) for row in rows], h["corner_x"], rtol=1e-11)

    def test_mistakes(self):
        file = self.block(viscosity=VISCOSITIES["prony"][0])
        density = "bodies.0.density"
        for words, columns, keys, settings in (
                ("has no column 'corner_q' (did you mean 'corner_", "corner_q", density, ()),
                ("the input has no 'bodies.1.density' (did you mean 'bodies.0.density'?)", "px", "bodies.1.density", ()),
                ("(did you mean 'bodies.0.elasticity.poissons_ratio'?)", "px", "bodies.0.elasticity.poisson_ratio", ()),
                ("(did you mean 'bodies.0.density'?)", "px", "density", ()),
                ("the input has no 'gamma'; name", "px", "gamma", ()),
                ("'time.step' cannot be varied", "px", "time.step", ()),
                ("'title' is", "px", "title", ("title=block",)),
                ("'bodies.0.elasticity.model' is", "px", "bodies.0.elasticity.model", ()),
                ("is named twice", "px", f"{density},{density}", ()),
                ("'bodies.0.elasticity.youngs_modulus' is '10*x", "px", "bodies.0.elasticity.youngs_modulus",
                 ("bodies.0.elasticity.youngs_modulus=10*x+1",)),
                ("one of Pliant's own methods", "px", density, ("time.method=petsc:bdf",)),
                ("'contact.friction' is 0", "px", "contact.friction",
                 ("contact={obstacles: [{name: floor, shape: plane, normal: [0, 0, 1], point: [0, 0, -9]}], friction: 0}",))):
            with self.subTest(words):
                for ranks in swept((1, 2), (1,)):
                    done = self.call("sensitivity", file, "--of", columns, "--to", keys,
                                     *[word for s in settings for word in ("--set", s)], ranks=ranks)
                    self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                    self.assertIn(words, done.stderr)


FINGER = """mesh: {file: finger.msh}
bodies:
  - volume: body
    density: 1100
    elasticity: {model: neo-hookean, youngs_modulus: 0.3 MPa, poissons_ratio: 0.4}
    viscosity: {model: kelvin-voigt, shear: 300, bulk: 100}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: dirk22, step: 10 ms, end: 0.3 s}
probes: [{name: tip, point: [0.1, 0.02, 0.02]}]
solver: {newton: {relative: 1.0e-10}}
"""
TRUTH = {"bodies.0.elasticity.youngs_modulus": 0.3e6, "bodies.0.viscosity.shear": 300.0}
FIT = """input: guess.yaml
parameters: {bodies.0.elasticity.youngs_modulus: [0.1 MPa, 2 MPa], bodies.0.viscosity.shear: [0, 2000]}
targets: [{column: tip_z, data: tip.csv, scale: 1 mm}]
"""


class Motion(ProgramTest):
    def measure(self, noise=0.0):
        """A trajectory of the tip, and an input that guesses at its numbers."""
        write_box(self.directory / "finger.msh", (4, 1, 1), (0.1, 0.02, 0.02))
        h = self.run_input(self.write("finger.yaml", FINGER))
        scatter = noise * np.random.default_rng(7).standard_normal(len(h["time"]))
        rows = zip(h["time"][1:].tolist(), ((h["tip_z"] + scatter)[1:] * 1e3).tolist())
        self.write("tip.csv", "time,tip_z [mm]\n" + "".join(f"{t!r},{z!r}\n" for t, z in rows))
        self.write("guess.yaml", FINGER.replace("0.3 MPa", "0.8 MPa").replace("shear: 300", "shear: 900"))


class Fits(Motion):
    def fitted(self):
        with open(self.directory / "out" / "fit.csv", encoding="utf-8") as stream:
            return {row["parameter"]: row for row in csv.DictReader(stream)}

    def fit(self, text=FIT, ranks=1, status=0):
        self.write("fit.yaml", text)
        done = self.call("fit", "fit.yaml", "--output", "out", ranks=ranks, timeout=300)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done

    def test_a_static_run_is_measured_over_its_load_factor(self):
        write_box(self.directory / "finger.msh", (4, 1, 1), (0.1, 0.02, 0.02))
        text = FINGER.replace("method: dirk22, step: 10 ms, end: 0.3 s", "method: static, load_steps: 4")
        h = self.run_input(self.write("bent.yaml", text))
        self.write("tip.csv", "time,tip_z [mm]\n" + "".join(f"{t!r},{1e3 * z!r}\n" for t, z in zip(h["time"].tolist(), h["tip_z"].tolist())))
        self.write("guess.yaml", text.replace("0.3 MPa", "0.8 MPa"))
        self.fit(FIT.replace(", bodies.0.viscosity.shear: [0, 2000]", ""))
        self.assertAlmostEqual(float(self.fitted()["bodies.0.elasticity.youngs_modulus"]["value"]) / 0.3e6, 1, delta=1e-6)
        self.write("tip.csv", "time,tip_z [mm]\n0.5,19\n1.5,18\n")
        self.assertIn("`time` is the load factor, from 0 to 1", self.fit(status=2).stderr)

    def test_values_that_the_input_does_not_take_count_as_far_away(self):
        # The first step of Newton's method goes to the upper bound, where displacements alone represent nothing.
        write_box(self.directory / "finger.msh", (4, 1, 1), (0.1, 0.02, 0.02))
        text = FINGER.replace("method: dirk22, step: 10 ms, end: 0.3 s", "method: static, load_steps: 4")
        text = text.replace("poissons_ratio: 0.4", "poissons_ratio: 0.49")
        h = self.run_input(self.write("bent.yaml", text))
        self.write("tip.csv", "time,tip_z [mm]\n" + "".join(f"{t!r},{1e3 * z!r}\n" for t, z in zip(h["time"].tolist(), h["tip_z"].tolist())))
        self.write("guess.yaml", text.replace("poissons_ratio: 0.49", "poissons_ratio: 0.45"))
        done = self.fit(FIT.replace("youngs_modulus: [0.1 MPa, 2 MPa], bodies.0.viscosity.shear: [0, 2000]", "poissons_ratio: [0.4, 0.5]"))
        self.assertIn("the input does not take these values: guess.yaml:5", done.stdout)
        self.assertAlmostEqual(float(self.fitted()["bodies.0.elasticity.poissons_ratio"]["value"]), 0.49, delta=1e-7)

    def test_numbers_that_made_the_motion(self):
        self.measure()
        done = self.fit(ranks=2 if LONG else 1)
        self.assertNotIn("warning", done.stderr)
        for key, row in self.fitted().items():
            self.assertAlmostEqual(float(row["value"]) / TRUTH[key], 1, delta=1e-6)
        self.assertEqual(self.fitted()["bodies.0.viscosity.shear"]["unit"], "Pa*s")
        # What was written runs, and moves so.
        h = self.run_input("out/fitted.yaml")
        measured = np.loadtxt(self.directory / "tip.csv", delimiter=",", skiprows=1)
        np.testing.assert_allclose(1e3 * h["tip_z"][1:], measured[:, 1], rtol=1e-7)
        page = (self.directory / "out" / "report.html").read_text(encoding="utf-8")
        for words in ("Correlation", "What the data determine", "tip_z (tip.csv)", "the fit has converged", "--set bodies"):
            self.assertIn(words, page)

    def test_covariance(self):
        """Standard errors of a noisy trajectory: those of the linearised problem, by differences of runs."""
        noise = 2e-4
        self.measure(noise)
        self.fit()
        rows = self.fitted()
        values = {key: float(row["value"]) for key, row in rows.items()}
        measured = np.loadtxt(self.directory / "tip.csv", delimiter=",", skiprows=1)[:, 1] * 1e-3
        columns, residual = [], None
        for key, value in values.items():
            ends = []
            for factor in (-1, 1):
                settings = [f"{k}={v * (1 + 1e-4 * factor * (k == key))!r}" for k, v in values.items()]
                ends.append(self.run_input("finger.yaml", *settings)["tip_z"][1:])
            columns.append((ends[1] - ends[0]) / (2e-4 * value))
            residual = 0.5 * (ends[0] + ends[1]) - measured
        J = np.stack(columns, axis=1)
        variance = residual @ residual / (len(residual) - 2)
        self.assertLess(abs(np.sqrt(variance) / noise - 1), 0.3)
        covariance = variance * np.linalg.inv(J.T @ J)
        for n, (key, row) in enumerate(rows.items()):
            self.assertAlmostEqual(float(row["standard_error"]) / np.sqrt(covariance[n, n]), 1, delta=1e-3)
            self.assertLess(abs(values[key] - TRUTH[key]), 4 * float(row["standard_error"]))

    def test_mistakes(self):
        self.measure()
        self.write("other.csv", (self.directory / "tip.csv").read_text().replace("tip_z [mm]", "tip_w"))
        for words, text in (
                ("fit.yaml:3:11: history.csv of the input has no column 'tip_w' (did you mean 'tip_",
                 FIT.replace("column: tip_z", "column: tip_w").replace("tip.csv, scale: 1 mm", "other.csv")),
                ("tip.csv:1:1: the table has no column 'tip_x'", FIT.replace("column: tip_z", "column: tip_x")),
                ("fit.yaml:2:50: 'bodies.0.elasticity.youngs_modulus' must be [lowest, highest]",
                 FIT.replace("[0.1 MPa, 2 MPa]", "[2 MPa, 0.1 MPa]")),
                ("the input has no 'bodies.0.elastic'", FIT.replace("bodies.0.viscosity.shear", "bodies.0.elastic")),
                ("'scale': ", FIT.replace("1 mm", "1 kg")),
                ("but the run goes from 0 to 0.1 s", FIT.replace("guess.yaml", "short.yaml")),
                ("missing key 'targets'", FIT[:FIT.index("targets")]),
                ("material", "material: {model: neo-hookean}\n" + FIT)):
            with self.subTest(words):
                self.write("short.yaml", FINGER.replace("0.3 s", "0.1 s"))
                for ranks in swept((1, 2), (1,)):
                    done = self.fit(text, ranks=ranks, status=2)
                    self.assertIn(words, done.stderr)


class FromPython(Motion):
    def test_scipy_finds_the_numbers(self):
        """A function with its Jacobian, and the fit itself."""
        self.measure()
        measured = np.loadtxt(self.directory / "tip.csv", delimiter=",", skiprows=1)[:, 1] * 1e-3
        keys = list(TRUTH)
        known = {}

        def run(x):
            if tuple(x) not in known:
                known[tuple(x)] = pliant.sensitivity(self.directory / "guess.yaml", of=["tip_z"], to=keys,
                                                     overrides=dict(zip(keys, x * np.array([1e6, 1e3]))),
                                                     output=self.directory / "tangent")
            return known[tuple(x)]

        found = scipy.optimize.least_squares(lambda x: run(x).values["tip_z"][1:] - measured, [0.5, 0.5], x_scale="jac",
                                             jac=lambda x: run(x).jacobians["tip_z"][1:] * np.array([1e6, 1e3]), ftol=1e-12)
        np.testing.assert_allclose(found.x, [0.3, 0.3], rtol=1e-5)
        self.write("fit.yaml", FIT)
        fit = pliant.fit(self.directory / "fit.yaml", output=self.directory / "out")
        self.assertTrue(fit.converged)
        for key, value in TRUTH.items():
            self.assertAlmostEqual(fit.values[key] / value, 1, delta=1e-6)
        self.assertEqual(fit.units["bodies.0.elasticity.youngs_modulus"], "Pa")
        with self.assertRaisesRegex(pliant.PliantError, "has no column 'tip_q'"):
            pliant.sensitivity(self.directory / "guess.yaml", of=["tip_q"], to=keys, output=self.directory / "tangent")


if __name__ == "__main__":
    unittest.main()
