#!/usr/bin/python3
"""Adjoints of runs: against the derivatives that follow the run, against differences of runs, and from Python."""
import csv
import os
import pathlib
import sys
import unittest

import h5py
import numpy as np

from program import ENVIRONMENT, PROGRAM, ROOT, ProgramTest, box, swept, write_box, write_mesh

sys.path.insert(0, str(ROOT / "src/python"))
os.environ.update(ENVIRONMENT, PLIANT=str(PROGRAM))

import pliant  # noqa: E402

# Each method with a viscosity, and a number of that.
CASES = {"backward-euler": ("{model: kelvin-voigt, shear: 0.3, bulk: 0.1}", "shear"),
         "bdf2": ("{model: maxwell, shear_ratio: 0.5, relaxation_time: 0.1}", "relaxation_time"),
         "bdf3": ("{model: kelvin-voigt, shear: 0.3}", "shear"),
         "dirk22": ("{model: prony, ratio: 0.5, relaxation_time: 0.1}", "ratio"),
         "dirk23": ("{model: kelvin-voigt, shear: 0.3, bulk: 0.1}", "bulk"),
         "dirk33": ("{model: kelvin-voigt, shear: 0.3}", "shear"),
         "implicit-midpoint": ("{model: maxwell, shear_ratio: 0.5, relaxation_time: 0.1}", "shear_ratio"),
         "symplectic-dirk22": ("{model: stiffness-proportional, time: 0.02}, {model: mass-proportional, decay_rate: 0.5}", "0.time")}
COLUMNS = ("corner_x", "corner_z", "corner_vy", "middle_y")
YOUNG = "bodies.0.elasticity.youngs_modulus"
BLOCK = """mesh: {{file: block.msh}}
element: {element}
volumetric: {volumetric}
bodies:
  - volume: body
    density: 1
    elasticity: {{model: {law}, youngs_modulus: 10, poissons_ratio: 0.3}}
    viscosity: [{viscosity}]
{more}
initial: {{velocity: ["-(y - 0.5) + z + 0.4*x", "(x - 0.5) - 0.3*y*z", "-x + 0.5*z"]}}
time: {{method: {method}, step: 0.02, end: 0.16}}
probes: [{{name: corner, point: [2, 1, 1]}}, {{name: middle, point: [0.9, 0.45, 0.4]}}]
solver: {{newton: {{relative: 1.0e-13}}}}
"""
SHAPE = """mesh: {{file: shape.msh}}
element: {element}
volumetric: {volumetric}
mass: {mass}
bodies:
  - {{volume: most, density: 1, elasticity: &law {{model: neo-hookean, youngs_modulus: 10, poissons_ratio: 0.3}}, viscosity: &more [{viscosity}]}}
  - {{volume: one, density: 2, elasticity: *law, viscosity: *more}}
constraints: [{{surface: left, displacement: [0, 0, "0.1*(1 - cos(3*t))"]}}]
loads: [{{gravity: [1, 0.5, "-3*cos(t)"]}}, {{force_density: [0, 0.4, 0]}}]
time: {{method: {method}, step: 0.02, end: 0.16}}
probes: [{{name: corner, point: [2, 1, 1]}}]
solver: {{newton: {{relative: 1.0e-13}}}}
"""
HELD = """constraints: [{surface: left, displacement: [0, 0, "0.1*sin(3*t)"]}]
loads: [{surface: right, traction: [0.2, 0, "0.3*t"]}, {gravity: [0, 0, -1]}]"""


class Adjoint(ProgramTest):
    def block(self, method="bdf2", viscosity="", element="P1", volumetric="standard", law="neo-hookean", more="", n=(2, 1, 1)):
        write_box(self.directory / "block.msh", n, (2, 1, 1))
        text = BLOCK.format(element=element, volumetric=volumetric, law=law, viscosity=viscosity, more=more, method=method)
        return self.write("block.yaml", text if viscosity else text.replace("    viscosity: []\n", ""))

    def weigh(self, times, columns=COLUMNS):
        """Writes weights of all columns at these times; returns them."""
        weights = np.random.default_rng(3).standard_normal((len(times), len(columns)))
        rows = "".join(",".join(map(repr, row)) + "\n" for row in np.column_stack([times, weights]).tolist())
        self.write("weights.csv", f"time,{','.join(columns)}\n" + rows)
        return weights

    def table(self, name):
        with open(self.directory / "adjoint" / name, encoding="utf-8") as stream:
            return list(csv.DictReader(stream))

    def adjoint(self, file, numbers=(), fields=(), *settings, ranks=1, more=()):
        """The derivatives by numbers, by key."""
        arguments = (["--to", ",".join(numbers)] if numbers else []) + (["--fields", ",".join(fields)] if fields else [])
        self.pliant("sensitivity", file, "--adjoint", "weights.csv", *arguments, "--output", "adjoint", *more,
                    *[word for s in settings for word in ("--set", s)], ranks=ranks)
        return {row["number"]: float(row["derivative"]) for row in self.table("gradient.csv")} if numbers else {}

    def compare(self, file, numbers, *settings, within=1e-7, columns=COLUMNS):
        """Against the derivatives of every column, with weights at every step."""
        self.pliant("sensitivity", file, "--of", ",".join(columns), "--to", ",".join(numbers), "--output", "tangent",
                    *[word for s in settings for word in ("--set", s)])
        with open(self.directory / "tangent" / "sensitivity.csv", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        weights = self.weigh([float(row["time"]) for row in rows], columns)
        found = self.adjoint(file, numbers, (), *settings)
        for key in numbers:
            slopes = np.array([[float(row[f"d({c})/d({key})"]) for c in columns] for row in rows])
            with self.subTest(key=key):
                self.assertNotEqual(found[key], 0)
                # Relative to the sum of what the steps add.
                self.assertLessEqual(abs(found[key] - (weights * slopes).sum()), within * np.abs(weights * slopes).sum())

    def test_every_method_and_viscosity(self):
        for method, (viscosity, number) in CASES.items():
            with self.subTest(method):
                key = "bodies.0.viscosity." + (number if "." in number else f"0.{number}")
                self.compare(self.block(method, viscosity), (YOUNG, key, "bodies.0.density"))

    def test_supports_loads_contact_and_steps(self):
        """Numbers of what moves and pulls; steps that follow their error, events, quadratic cells, statics."""
        held = ("loads.1.gravity.2", YOUNG)
        self.compare(self.block("dirk22", CASES["dirk22"][0], "P2", "mean-dilatation", more=HELD, n=(1, 1, 1)), held)
        self.compare(self.block("dirk23", CASES["dirk23"][0], more=HELD), held, "time.adaptive.relative=1e-4",
                     "time.adaptive.absolute=1e-5", within=1e-6)
        jump = "constraints: [{surface: left, displacement: [0, 0, \"t < 0.07 ? 0 : 0.3*(t - 0.07)\"]}]"
        self.compare(self.block("bdf3", CASES["bdf3"][0], more=jump), (YOUNG, "bodies.0.density"))
        floor = """contact: {law: penalty, stiffness: 100, obstacles: [{name: floor, shape: plane, normal: [0, 0, 1], point: [0, 0, -0.01]}]}
loads: [{gravity: [0, 0, -3]}]"""
        self.compare(self.block("bdf2", CASES["backward-euler"][0], more=floor), (YOUNG, "contact.stiffness"), within=1e-6)
        static = self.block(more=HELD).read_text().replace("method: bdf2, step: 0.02, end: 0.16", "method: static, load_steps: 2")
        static = static[:static.index("initial:")] + static[static.index("time:"):]
        self.write("static.yaml", static.replace("0.1*sin(3*t)", "0.1").replace("0.3*t", "0.3"))
        self.compare("static.yaml", held, columns=("corner_x", "middle_z"))

    def test_fields(self):
        """A value in each cell, against differences of runs; the same on all ranks, and from steps that are repeated."""
        file = self.block("dirk22", CASES["dirk22"][0], n=(2, 2, 1))
        text = pathlib.Path(file).read_text().replace("youngs_modulus: 10", "youngs_modulus: {cell_data: E}")
        self.write("field.yaml", text)
        mesh = (self.directory / "block.msh").read_text()
        elements = mesh[mesh.index("$Elements"):].splitlines()[2:-1]
        cells = [line.split()[0] for line in elements if line.split()[1] == "4"]
        values = 10 + np.random.default_rng(5).random(len(cells))

        def run_with(values):
            rows = "".join(f"{cell} {value!r}\n" for cell, value in zip(cells, values.tolist()))
            (self.directory / "block.msh").write_text(
                f'{mesh}$ElementData\n1\n"E"\n1\n0.0\n3\n0\n1\n{len(cells)}\n{rows}$EndElementData\n')

        run_with(values)
        h = self.run_input("field.yaml")
        weights = self.weigh(h["time"])
        fields = (YOUNG, "bodies.0.viscosity.0.relaxation_time", "initial.velocity")
        self.adjoint("field.yaml", ("bodies.0.density",), fields)
        table, nodes = self.table("gradient_cells.csv"), self.table("gradient_nodes.csv")
        slopes = np.array([float(row[f"derivative({YOUNG})"]) for row in table])
        self.assertEqual([int(row["cell"]) for row in table], list(range(len(cells))))
        np.testing.assert_allclose([float(row[YOUNG]) for row in table], values, rtol=1e-12)
        with h5py.File(self.directory / "adjoint" / "gradient.h5") as stream:
            stored = stream[f"frames/000000/derivative({YOUNG})"][:]
            self.assertEqual(sorted(stored.ravel().tolist()), sorted(slopes.tolist()))
        # A different number of steps in memory, and other numbers of ranks.
        for ranks, more in ((1, ("--kept-steps", "3")), (2, ()), (3, ())):
            self.adjoint("field.yaml", (), fields, ranks=ranks, more=more)
            for name, expected in (("gradient_cells.csv", table), ("gradient_nodes.csv", nodes)):
                for column in expected[0]:
                    a, b = (np.array([float(row[column]) for row in t]) for t in (self.table(name), expected))
                    np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max(), err_msg=f"{column} on {ranks} ranks")
        # Differences of fourth order of whole runs, in a cell and along a direction.
        direction = np.random.default_rng(6).standard_normal(len(cells))
        for change in (np.eye(len(cells))[3], direction):
            ends = []
            for factor in (-2, -1, 1, 2):
                run_with(values + 0.01 * factor * change)
                h = self.run_input("field.yaml")
                ends.append((weights * np.stack([h[c] for c in COLUMNS], axis=1)).sum())
            expected = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / 0.12
            self.assertLessEqual(abs(slopes @ change - expected), 1e-7 * np.abs(slopes * change).sum())
        run_with(values)
        # Velocities at the start.
        ends = []
        for h in (-1e-3, 1e-3):
            self.write("faster.yaml", (self.directory / "field.yaml").read_text().replace("-x + 0.5*z", f"-x + 0.5*z + {h}*x*y"))
            h = self.run_input("faster.yaml")
            ends.append((weights * np.stack([h[c] for c in COLUMNS], axis=1)).sum())
        by_velocity = sum(float(row["derivative(initial.velocity)_z"]) * float(row["x"]) * float(row["y"]) for row in nodes)
        self.assertLessEqual(abs(by_velocity - (ends[1] - ends[0]) / 2e-3), 1e-6 * abs(by_velocity))

    def write_shape(self, points, triangles, cells):
        """A mesh whose fifth cell is a body of its own."""
        write_mesh(self.directory / "shape.msh", points, triangles, cells, (["most", "one"], (np.arange(len(cells)) == 4).astype(int)))

    def test_density_and_shape(self):
        """The density of each cell and the place of each node, with the methods and viscosities, on any number of ranks."""
        columns = ("corner_x", "corner_z", "corner_vy")
        points, triangles, cells = box((2, 1, 1), (2, 1, 1))
        random = np.random.default_rng(8)
        points = points + 0.05 * random.standard_normal(points.shape) * (points[:, :1] > 0) * (points != [2, 1, 1]).any(axis=1)[:, None]
        move = random.standard_normal(points.shape)
        kinds = {"P1": ("P1", "standard", "consistent"), "P2": ("P2", "standard", "lumped"), "mean": ("P2", "mean-dilatation", "consistent")}
        cases = [(method, "P1") for method in CASES] + [("bdf2", "P2"), ("dirk22", "mean")]
        for method, kind in swept(cases, [("backward-euler", "P1"), ("dirk22", "mean"), ("symplectic-dirk22", "P1"), ("bdf2", "P2")]):
            with self.subTest(method=method, kind=kind):
                element, volumetric, mass = kinds[kind]
                self.write("shape.yaml", SHAPE.format(method=method, viscosity=CASES[method][0], element=element, volumetric=volumetric, mass=mass))
                self.write_shape(points, triangles, cells)
                h = self.run_input("shape.yaml")
                weights = self.weigh(h["time"], columns)
                fields = ("bodies.0.density", "bodies.1.density", "mesh.nodes")
                numbers = self.adjoint("shape.yaml", fields[:2], fields)
                table, nodes = self.table("gradient_cells.csv"), self.table("gradient_nodes.csv")
                for key in fields[:2]:
                    slopes = np.array([float(row[f"derivative({key})"]) for row in table])
                    self.assertAlmostEqual(slopes.sum() / numbers[key], 1, delta=1e-6)
                self.assertEqual(np.flatnonzero(slopes).size, 1)
                ends = []
                for factor in (-2, -1, 1, 2):
                    self.write_shape(points + 1e-3 * factor * move, triangles, cells)
                    # The probe stays at the corner, which moves.
                    place = ", ".join(map(repr, ([2, 1, 1] + 1e-3 * factor * move[-1]).tolist()))
                    h = self.run_input("shape.yaml", f"probes.0.point=[{place}]")
                    ends.append((weights * np.stack([h[c] for c in columns], axis=1)).sum())
                expected = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / 12e-3
                by_vertex = {int(row["vertex"]): [float(row[f"derivative(mesh.nodes)_{a}"]) for a in "xyz"] for row in nodes if int(row["vertex"]) >= 0}
                parts = np.array([by_vertex[n] for n in range(len(points))]) * move
                self.assertLessEqual(abs(parts.sum() - expected), 1e-7 * np.abs(parts).sum())
        self.write_shape(points, triangles, cells)
        self.adjoint("shape.yaml", (), fields)
        expected = [self.table(name) for name in ("gradient_cells.csv", "gradient_nodes.csv")]
        for ranks in (2, 3):
            self.adjoint("shape.yaml", (), fields, ranks=ranks)
            for name, rows in zip(("gradient_cells.csv", "gradient_nodes.csv"), expected):
                for column in rows[0]:
                    a, b = (np.array([float(row[column]) for row in t]) for t in (self.table(name), rows))
                    np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * np.nanmax(np.abs(b)), err_msg=f"{column} on {ranks} ranks")

    def test_from_python(self):
        file = self.block("bdf2", CASES["bdf2"][0], more=HELD)
        run = pliant.run(file, output=self.directory / "out")
        aim = run.history["corner_z"] + 0.01
        weights = {"corner_z": 2 * (run.history["corner_z"] - aim)}
        gradient = run.gradient(weights, to=["bodies.0.density", YOUNG], fields=[YOUNG, "initial.displacement"])
        s = pliant.sensitivity(file, of=["corner_z"], to=["bodies.0.density", YOUNG], output=self.directory / "tangent")
        for n, key in enumerate(("bodies.0.density", YOUNG)):
            self.assertAlmostEqual(gradient.numbers[key] / (weights["corner_z"] @ s.jacobians["corner_z"][:, n]), 1, delta=1e-7)
        # Steps of a run that was resumed with others are not those of its input.
        resumed = pliant.run(file, overrides={"time.end": float(run.history.time[-1]) / 2, "checkpoint": {}}, output=self.directory / "resumed")
        resumed = pliant.resume(resumed.directory, {"time.end": float(run.history.time[-1]), "time.step": float(run.history["dt"][-1]) / 2})
        with self.assertRaisesRegex(pliant.PliantError, "resumed with other steps"):
            resumed.gradient({"corner_z": np.ones(len(resumed.history.time))}, to=["bodies.0.density"])
        rigid = {"loads": [{"gravity": [0, 0, -1]}], "constraints": [{"surface": "left", "displacement": [0, 0, 0]}], "initial.velocity": [0, 0.3, 0]}
        shape = pliant.gradient(file, {"time": run.history.time, **weights}, fields=["mesh.nodes", "bodies.0.density"],
                                overrides=rigid, output=self.directory / "shape")
        # A body that is moved with its support moves as before; its probe is elsewhere by as much.
        self.assertEqual(shape.fields["mesh.nodes"].shape, shape.points.shape)
        np.testing.assert_allclose(shape.fields["mesh.nodes"].sum(axis=0), [0, 0, weights["corner_z"].sum()], rtol=0,
                                   atol=1e-8 * np.abs(shape.fields["mesh.nodes"]).max())
        self.assertEqual(gradient.values, {"bodies.0.density": 1, YOUNG: 10})
        # All cells together are the number; what is held at the start does not move.
        self.assertAlmostEqual(gradient.fields[YOUNG].sum() / gradient.numbers[YOUNG], 1, delta=1e-7)
        np.testing.assert_array_equal(gradient.field_values[YOUNG], np.full(len(gradient.cells), 10.0))
        self.assertEqual(gradient.centroids.shape, (len(gradient.cells), 3))
        at_support = gradient.points[:, 0] == 0
        self.assertEqual(np.abs(gradient.fields["initial.displacement"][at_support]).max(), 0)
        self.assertGreater(np.abs(gradient.fields["initial.displacement"][~at_support]).min(), 0)
        with self.assertRaisesRegex(pliant.PliantError, "equally many are needed"):
            pliant.gradient(file, {"time": [0, 1], "corner_z": [1]}, to=[YOUNG])
        with self.assertRaisesRegex(pliant.PliantError, "one of them is needed"):
            run.gradient(weights)

    def test_weights_as_other_programs_write_them(self):
        file = self.block(viscosity=CASES["bdf2"][0])
        self.weigh([0.04, 0.16])
        text = (self.directory / "weights.csv").read_text(encoding="utf-8")
        expected = self.adjoint(file, (YOUNG,))
        names, *rows = text.splitlines()
        quoted = ",".join(f'"{name}"' for name in names.split(","))
        for other in ("\r\n".join([quoted, *rows]), "\ufeff# weights\n" + text.rstrip("\n")):  # the last row without its end
            (self.directory / "weights.csv").write_text(other, encoding="utf-8", newline="")
            self.assertEqual(self.adjoint(file, (YOUNG,)), expected)

    def test_mistakes(self):
        file = self.block(viscosity=CASES["bdf2"][0], more="contact: {obstacles: [{name: floor, shape: plane, normal: [0, 0, 1], "
                                                           "point: [0, 0, -9]}]}")
        self.weigh([0.04, 0.16])
        to = ("--adjoint", "weights.csv", "--to", YOUNG)
        for words, table, arguments, settings in (
                ("has no column 'corner_q' (did you mean 'corner_", "time,corner_q\n0.04,1\n", to, ()),
                ("'px' has no adjoint", "time,px\n0.04,1\n", to, ()),
                ("bad.csv:1:1: the table has no column 'time'", "t,corner_x\n0.04,1\n", to, ()),
                ("bad.csv:2:1: no step ends at 0.05; the nearest is at 0.0", "time,corner_x\n0.05,1\n", to, ()),
                ("bad.csv:3:6: '' is not a number", "time,corner_x\n0.04,1\n0.08,\n", to, ()),
                ("bad.csv:3:1: this row has 1 values", "time,corner_x\n0.04,1\n0.08", to, ()),
                ("bad.csv:2:6: 'nan' is not a number", "time,corner_x\n0.04,nan\n", to, ()),
                ("--adjoint none.csv: cannot read it; give the path of a CSV file", "", ("--adjoint", "none.csv", "--to", YOUNG), ()),
                ("either --of COLUMN,... or --adjoint", "", ("--to", YOUNG), ()),
                ("--to KEY,... or --fields KEY,... is needed", "", ("--adjoint", "weights.csv"), ()),
                ("'loads.0.gravity' has no value in each cell", "", ("--adjoint", "weights.csv", "--fields", "loads.0.gravity"), ()),
                ("'mesh.nodes' cannot have a derivative at each node: not only cells", "time,corner_x\n0.04,1\n",
                 ("--adjoint", "weights.csv", "--fields", "mesh.nodes"), ()),
                ("has no constant 'c10'", "", ("--adjoint", "weights.csv", "--fields", "bodies.0.elasticity.c10"), ()),
                ("is named twice", "", ("--adjoint", "weights.csv", "--fields", f"{YOUNG},{YOUNG}"), ()),
                ("what has no adjoint: friction", "", to, ("contact.friction=0.3",)),
                ("'volumetric: mixed' have no adjoint", "", to, ("volumetric=mixed", "bodies.0.elasticity.model=neo-hookean-isochoric")),
                ("one of Pliant's own methods", "", to, ("time.method=petsc:bdf",))):
            self.write("bad.csv", table)
            with self.subTest(words):
                # Those that ranks find together.
                for ranks in (1, 2) if "adjoint" in words or "no step" in words or "file" in words else (2,):
                    done = self.call("sensitivity", file, *(a if a != "weights.csv" or not table else "bad.csv" for a in arguments),
                                     *[word for s in settings for word in ("--set", s)], ranks=ranks)
                    self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                    self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
