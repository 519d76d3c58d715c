#!/usr/bin/python3
"""Convergence studies: the shipped ones keep the orders of theory, a shortfall is an exit code, mistakes are told."""
import csv
import json
import re
import unittest
import xml.etree.ElementTree

import numpy as np

from program import ALL_OR_SOME, LONG, ROOT, ProgramTest, long_test, swept

INPUTS = ROOT / "input/convergence"
COLUMNS = ["method", "level", "step", "size", "error_displacement", "error_velocity", "order_displacement", "order_velocity"]
ORDERS = {"backward-euler": 1, "bdf2": 2, "bdf3": 3, "dirk22": 2, "dirk23": 3, "dirk33": 3, "implicit-midpoint": 2,
          "symplectic-dirk22": 2, "petsc:alpha2": 2, "petsc:bdf": 2, "petsc:arkimex": 3}
SHORTFALL = 0.3  # what the program allows
PARALLEL = 1e-6  # relative; Newton's method stops far below the errors that are measured


class Convergence(ProgramTest):
    def converge(self, case, kind, levels, *more, ranks=1):
        return self.call("converge", INPUTS / f"{case}.yaml", "--in", kind, "--levels", str(levels), "--output", "study", *more,
                         ranks=ranks)

    def study(self, case, kind, levels, *more, ranks=1, code=0):
        """Names of the methods and the columns of numbers of a study that ends with `code`."""
        done = self.converge(case, kind, levels, *more, ranks=ranks)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        with open(self.directory / "study/convergence.csv", encoding="ascii", newline="") as file:
            header, *rows = csv.reader(file)
        self.assertEqual(header[:8], COLUMNS)
        self.assertTrue(all(len(row) == len(header) for row in rows))
        table = {name: np.array([float(row[k + 1]) for row in rows]) for k, name in enumerate(header[1:])}
        return [row[0] for row in rows], table, done

    def check_orders(self, methods, table, expected):
        """Orders are those of the errors in the table, and the last ones those of theory."""
        for name in dict.fromkeys(methods):
            of = np.array(methods) == name
            np.testing.assert_array_equal(table["level"][of], np.arange(of.sum()))
            np.testing.assert_allclose(table["step"][of][1:], table["step"][of][:-1] / 2, rtol=1e-12)
            for kind in ("displacement", "velocity"):
                errors, orders = table["error_" + kind][of], table["order_" + kind][of]
                self.assertTrue(np.isnan(orders[0]))
                np.testing.assert_allclose(orders[1:], np.log2(errors[:-1] / errors[1:]), atol=1e-9)
                self.assertAlmostEqual(orders[-1], expected[name], delta=SHORTFALL, msg=f"{name}, {kind}")

    def check_pictures(self, *names):
        for name in names:
            root = xml.etree.ElementTree.parse(self.directory / "study" / name).getroot()
            self.assertEqual(root.tag, "{http://www.w3.org/2000/svg}svg")
            self.assertGreater(len(list(root.iter())), 10)

    def check_study_in_time(self, case, names="all"):
        methods, table, _ = self.study(case, "time", 4, "--methods", names)
        own = [name for name in ORDERS if not name.startswith("petsc") and (names == "all" or name in names.split(","))]
        self.assertEqual(list(dict.fromkeys(methods)), own)
        self.assertEqual(len(methods), 4 * len(own))
        self.check_orders(methods, table, ORDERS)
        self.check_pictures("convergence.svg", "work.svg")

    def test_spinning_block(self):
        self.check_study_in_time("spinning_block")

    def test_relaxing_block(self):
        self.check_study_in_time("relaxing_block", ALL_OR_SOME)

    def test_moving_clamp(self):
        self.check_study_in_time("moving_clamp", ALL_OR_SOME)

    def test_integrators_of_petsc(self):
        names = ["petsc:alpha2", "petsc:bdf", "petsc:arkimex"]
        methods, table, _ = self.study("spinning_block", "time", 4, "--methods", ",".join(names))
        self.assertEqual(list(dict.fromkeys(methods)), names)
        self.check_orders(methods, table, ORDERS)

    def test_ranks_agree(self):
        one, two = (self.study("spinning_block", "time", 2, "--methods", "bdf3,dirk22" if LONG else "bdf3", "--no-check", ranks=n)
                    for n in (1, 2))
        self.assertEqual(one[0], two[0])
        for name in COLUMNS[1:]:
            np.testing.assert_allclose(two[1][name], one[1][name], rtol=PARALLEL, err_msg=name)

    def test_a_shortfall_is_an_exit_code(self):
        # The difference of strains over a step is the strain rate to first order only, where a body turns.
        secant = ("--set", "bodies.0.viscosity.rate=secant", "--methods", "backward-euler,bdf2")
        _, table, done = self.study("spinning_block", "time", 3, *secant, code=1)
        self.assertLess(table["order_displacement"][-1], 2 - SHORTFALL)
        self.assertRegex(done.stderr, r"bdf2.*order.*2 expected")
        self.assertNotIn("backward-euler", done.stderr)
        self.study("spinning_block", "time", 2, *secant, "--no-check")

    def test_the_reference_keeps_its_order(self):
        # All potential forms of the strain rate are one for backward Euler, so its errors tell whether the reference is.
        rates = [self.study("spinning_block", "time", 2, "--methods", "backward-euler", "--no-check", "--set",
                            f"bodies.0.viscosity.rate={rate}")[1] for rate in ("secant", "reconstructed")]
        np.testing.assert_allclose(rates[0]["error_displacement"], rates[1]["error_displacement"], rtol=1e-5)

    def test_quasistatic(self):
        # Without inertia, and so the reference: a bar with a density, under a load that grows.
        bar = self.write("bar.yaml", f"""mesh: {{file: {ROOT}/meshes/unit_cube.msh}}
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e4, poissons_ratio: 0.3}}VISCOSITY}}]
constraints: [{{surface: clamp, displacement: [0, 0, 0]}}]
loads: [{{where: "z > 0.999", traction: [0, 0, "1e3*sin(2*t)"]}}]
time: {{method: quasistatic, step: 0.1, end: 0.4}}
""")
        text = bar.read_text(encoding="utf-8")
        for viscosity, says in (("", "displacements have rounding errors only"), (", viscosity: [{model: kelvin-voigt, shear: 3e3}]", None)):
            bar.write_text(text.replace("VISCOSITY", viscosity), encoding="utf-8")
            done = self.call("converge", bar, "--in", "time", "--levels", "3", "--output", "study")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("solving the reference: quasistatic, steps of 0.00156 s", done.stdout)
            if says:
                self.assertIn(says, done.stdout)
        with open(self.directory / "study/convergence.csv", encoding="ascii", newline="") as file:
            self.assertAlmostEqual(float(list(csv.DictReader(file))[-1]["order_displacement"]), 1, delta=0.1)

    def test_linear_elements(self):
        methods, table, _ = self.study("stretched_cube", "space", 3)
        self.assertEqual(methods, ["static"] * 3)
        np.testing.assert_allclose(table["size"][1:], table["size"][:-1] / 2, rtol=1e-12)
        self.assertAlmostEqual(table["order_displacement"][-1], 2, delta=SHORTFALL)
        self.check_pictures("convergence.svg")

    def test_warnings_of_the_input_are_told_once(self):
        _, _, done = self.study("stretched_cube", "space", 2, "--no-check", "--set", "bodies.0.elasticity.poissons_ratio=0.499")
        self.assertEqual(done.stderr.count("linear elements lock"), 1, done.stderr)

    def test_results_of_levels(self):
        """Numbers of histories and their errors; in space the distance from the next level, in time that from the reference."""
        _, table, done = self.study("stretched_cube", "space", 2, "--no-check", "--result", "energy=last(elastic_energy)")
        rows = self.results()
        self.assertEqual([row["level"] for row in rows], ["0", "1", "2"])
        values, errors = ([float(row[name]) for row in rows] for name in ("value", "error"))
        np.testing.assert_allclose(errors[:2], np.abs(np.diff(values)), rtol=1e-12)
        self.assertTrue(np.isnan(errors[2]))
        self.assertAlmostEqual(float(rows[1]["order"]), np.log2(errors[0] / errors[1]), places=12)
        np.testing.assert_allclose([float(row["size"]) for row in rows[:2]], table["size"], rtol=1e-12)
        # A line for each level as it is solved, the last of which is the one more than asked for.
        self.assertEqual(re.findall(r"(?m)^level (\d) is solved: (\d+) tetrahedra,", done.stdout), [("0", "48"), ("1", "384"), ("2", "3072")])
        self.assertLess(done.stdout.index("level 2: 3072 tetrahedra, 8 times those of level 1\n"), done.stdout.index("level 2 is solved"))
        self.assertRegex(done.stdout, r"(?m)^energy \[J\]:$")
        for row in rows:
            self.assertRegex(done.stdout, rf"(?m)^static +{row['level']} +{float(row['value']):.8g} ")
        refined = [self.run_input(INPUTS / "stretched_cube.yaml", f"mesh.refine={level}")["elastic_energy"][-1] for level in (0, 1)]
        np.testing.assert_allclose(values[:2], refined, rtol=1e-6)  # Newton's tolerances differ
        _, _, done = self.study("spinning_block", "time", 3, "--methods", "bdf2", "--result", "last(elastic_energy)")
        rows = self.results()
        (reference,) = re.findall(r"(?m)^the reference: (\S+)$", done.stdout)
        for row in rows:
            self.assertAlmostEqual(float(row["error"]), abs(float(row["value"]) - float(reference)), delta=1e-7 * float(reference))
        self.check_pictures("error_last_elastic_energy.svg")
        done = self.call("converge", INPUTS / "stretched_cube.yaml", "--in", "space", "--result", "last(elastic_enrgy)")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("the history has no column 'elastic_enrgy' (did you mean 'elastic_energy'?)", done.stderr)

    def results(self):
        with open(self.directory / "study/results.csv", encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    # A linear body, E = 1 MPa and nu = 0.3, whose whole surface is given. Surfaces of the same kind and smoothness, on the same
    # meshes; but a gradient of a harmonic function is a solution as it stands, smooth up to the edges. The other surface is that
    # of no such function, and leaves at the cube's edges what a clamped wedge of 90 degrees has there: r^a, where
    # (3 - 4 nu) sin(a pi/2) = a (Williams 1952), a = 1.42. The error of its energy is then of the order a, that of the
    # displacement of one order more (Aubin and Nitsche), whatever the degree of the elements.
    GIVEN_SURFACES = {
        "smooth": (3.0, ["0.1*cos(x)*sin(0.75*y+0.4)*exp(1.25*z)", "0.075*sin(x)*cos(0.75*y+0.4)*exp(1.25*z)",
                         "0.125*sin(x)*sin(0.75*y+0.4)*exp(1.25*z)"]),
        "singular": (1.4208 + 1.0, ["0.1*y^2", 0, 0]),
    }

    def test_quadratic_elements_lose_their_order_at_edges_alone(self):
        cases = list(self.GIVEN_SURFACES.items())
        for name, (order, displacement) in swept(cases, cases[:1]):
            with self.subTest(name):
                file = self.write("given.yaml", f"""mesh: {{file: {ROOT}/meshes/unit_cube.msh}}
element: P2
bodies: [{{elasticity: {{model: linear, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}}}]
constraints:
  - {{where: "min(min(x, 1-x), min(min(y, 1-y), min(z, 1-z))) < 1e-9", displacement: {json.dumps(displacement)}}}
time: {{method: static}}
""")
                done = self.call("converge", file, "--in", "space", "--levels", "3", "--no-check", "--output", "study")
                self.assertEqual(done.returncode, 0, done.stderr)
                with open(self.directory / "study/convergence.csv", encoding="ascii", newline="") as csv_file:
                    orders = [float(row["order_displacement"]) for row in list(csv.DictReader(csv_file))[1:]]
                self.assertAlmostEqual(orders[-1], order, delta=0.1)  # 2.98 and 2.48, in which there is some of the smooth part
                self.assertLess(orders[-2], orders[-1])

    def test_steps_chosen_by_tolerance(self):
        # 40 ms of the blow and what follows: errors of the whole run stay near what was allowed.
        methods, table, done = self.study("kicked_beam", "tolerance", 2, "--methods", "bdf2,dirk33", "--set", "time.end=40 ms")
        self.assertEqual(methods, ["bdf2", "bdf2", "dirk33", "dirk33"])
        np.testing.assert_allclose(table["size"][1::2], table["size"][::2] / 10, rtol=1e-12)  # the tolerances
        told = [float(line.split()[-1]) for line in done.stdout.splitlines() if line.startswith(("bdf2", "dirk33"))]
        self.assertEqual(len(told), 4)
        self.assertLessEqual(max(told), 3)
        self.assertTrue((table["error_displacement"][1::2] < table["error_displacement"][::2] / 3).all())
        self.check_pictures("convergence.svg", "work.svg")

    @long_test
    def test_four_decades_of_tolerance(self):
        # From 1e-2 to 1e-5: ten times tighter, about ten times better; the error stays a like part of what was allowed, and
        # the steps of a method of order p shrink by 10^(1/p) in the end.
        methods, table, done = self.study("kicked_beam", "tolerance", 4, "--methods", "bdf2,dirk33", "--set", "time.end=40 ms")
        self.assertEqual(methods, ["bdf2"] * 4 + ["dirk33"] * 4)
        for method, order, rows in (("bdf2", 2, slice(0, 4)), ("dirk33", 3, slice(4, 8))):
            with self.subTest(method):
                np.testing.assert_allclose(table["size"][rows], [1e-2, 1e-3, 1e-4, 1e-5], rtol=1e-12)
                parts = [float(line.split()[-1]) for line in done.stdout.splitlines() if line.startswith(method)]
                self.assertEqual(len(parts), 4)
                self.assertLessEqual(max(parts), 1)
                self.assertLess(max(parts) / min(parts), 4)
                for error in ("error_displacement", "error_velocity"):
                    fell = table[error][rows][:-1] / table[error][rows][1:]
                    self.assertGreater(fell.min(), 5, error)
                    self.assertLess(fell.max(), 15, error)
                step = table["step"][rows]
                self.assertAlmostEqual(step[2] / step[3] / 10**(1 / order), 1, delta=0.15 if order == 3 else 0.05)
        # So the third-order method is the cheaper one where much is asked for: steps eight times as long, two thirds of the
        # iterations.
        self.assertGreater(table["step"][7], 8 * table["step"][3])
        self.assertLess(table["newton_iterations"][7], table["newton_iterations"][3] / 1.5)

    def test_rigid_bodies_alone_have_no_mesh_to_refine(self):
        self.write("in.yaml", "rigid_bodies: [{name: brick, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0], velocity: [1, 0, 0]}]\n"
                   "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
        self.assertIn("the input has only rigid bodies", self.pliant("converge", "in.yaml", "--in", "space", status=2).stderr)

    def test_mistakes(self):
        cases = {
            "static in time": ("stretched_cube", "time", 3, "no convergence in time"),
            "tolerance of equal steps": ("spinning_block", "tolerance", 2, "adaptive"),
            "unknown method": ("spinning_block", "time", 3, "'foo'", "--methods", "bdf2,foo"),
            "one level": ("spinning_block", "time", 1, "--levels"),
            "no number of levels": ("spinning_block", "time", "many", "--levels"),
            "unknown kind": ("spinning_block", "size", 3, "--in"),
        }
        for name, (case, kind, levels, words, *more) in cases.items():
            for ranks in (1, 2) if name == "unknown method" else (1,):
                with self.subTest(name, ranks=ranks):
                    done = self.converge(case, kind, levels, *more, ranks=ranks)
                    self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                    messages = [line for line in done.stderr.splitlines() if words in line]
                    self.assertEqual(len(messages), 1, done.stderr)
                    self.assertNotIn("PETSC ERROR", done.stderr)
                    self.assertFalse((self.directory / "study/convergence.csv").exists())


if __name__ == "__main__":
    unittest.main()
