#!/usr/bin/python3
"""The Python package: what it reads is what the program wrote, and what the page docs/python.md shows works."""
import base64
import contextlib
import html.parser
import io
import os
import re
import shutil
import subprocess
import sys
import types
import unittest
from unittest import mock

import h5py
import numpy as np
import yaml

from program import ENVIRONMENT, PROGRAM, ROOT, ProgramTest, box, read_history, write_box, write_mesh

sys.path.insert(0, str(ROOT / "src/python"))
os.environ.update(ENVIRONMENT, PLIANT=str(PROGRAM))

import pliant  # noqa: E402

INPUT = """
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 10 ms, end: 30 ms}
output: {fields: [displacement, cauchy_stress]}
checkpoint: {every: 2}
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""


class Reader(html.parser.HTMLParser):
    """The texts of a piece of HTML in their order, and its pictures; every element is closed in its turn."""

    def __init__(self, text):
        super().__init__()
        self.texts, self.pictures, self.frames, self._open = [], [], [], []
        self.feed(text)
        self.close()
        assert self._open == [], f"not closed: {self._open}"

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.pictures.append(base64.b64decode(dict(attrs)["src"].removeprefix("data:image/png;base64,"), validate=True))
        else:
            self._open.append(tag)
            self.frames += [dict(attrs)["srcdoc"]] if tag == "iframe" else []

    def handle_endtag(self, tag):
        assert tag == "img" or self._open.pop() == tag, tag

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_data(self, data):
        self.texts.append(data)

    def after(self, name):
        """The text behind a name in a table."""
        return self.texts[self.texts.index(name) + 1]


class Package(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2))
        self.enterContext(contextlib.chdir(self.directory))

    def test_what_a_run_wrote(self):
        run = pliant.run(INPUT, {"time.end": 0.04, "loads.0.gravity": [0, 0, -5.0]})
        self.assertEqual(run.directory, str(self.directory / "out"))
        self.assertEqual(sorted(os.listdir(self.directory)), ["bar.msh", "out"])
        given = yaml.safe_load((self.directory / "out/run.yaml").read_text())
        self.assertEqual((given["time"]["end"], given["loads"][0]["gravity"]), (0.04, [0, 0, -5]))
        self.assertEqual(run.summary["outcome"], "done")
        self.assertEqual((run.warnings, run.notes), ([], re.findall("(?m)^note: (.*)", run.log)))
        odd = pliant.run(INPUT, {"bodies.0.density": 1.1, "loads.0.gravity": [0, 0, 0], "time.end": 0.01}, output="odd")
        self.assertIn("the density is 1.1 kg/m^3", "".join(odd.warnings))
        self.assertIn("the density is 1.1 kg/m^3", Reader(odd._repr_html_()).after("warning"))
        self.assertIn("the density is 1.1 kg/m^3", Reader(odd.result._repr_html_()).after("warning"))
        self.assertIn("is not used by the input", odd.notes[-1])
        self.assertIn(odd.notes[-1], Reader(odd._repr_html_()).texts)
        shutil.rmtree("odd")
        written = read_history("out")
        self.assertEqual(list(run.history), list(written))
        for name in written:
            np.testing.assert_array_equal(run.history[name], written[name])
        result = run.result
        np.testing.assert_allclose(result.times, run.history.time)
        again = pliant.run(INPUT, {"time.end": 0.04, "loads.0.gravity": [0, 0, -5.0]}, go_on=True)
        self.assertEqual((again.directory, again.summary), (run.directory, run.summary))
        self.assertIn("done already", again.log)
        self.assertEqual([frame.step for frame in result], [0, 1, 2, 3, 4])
        self.assertEqual((result.at(0.021).step, result[1:3][1].step), (2, 2))
        last, mesh = result[-1], result.mesh()
        with h5py.File("out/result.h5") as h5:
            for name in ("displacement", "cauchy_stress"):
                np.testing.assert_array_equal(last[name], h5["frames/000004"][name][()])
        self.assertEqual((last.field("displacement").unit, last.field("cauchy_stress").on_nodes), ("m", False))
        self.assertEqual(last["von_mises_stress"].shape, (len(mesh.cells),))
        # The probe is a node.
        tip = np.flatnonzero(np.abs(mesh.coordinates - [1, 0.2, 0.2]).max(axis=1) < 1e-9)
        self.assertEqual(result.series("displacement", tip).shape, (5, 1, 3))
        self.assertEqual(run.history.vector("tip_").shape, (5, 3))
        self.assertIsNone(last.obstacles)
        with self.assertRaisesRegex(pliant.PliantError, "no field 'speed'; it has cauchy_stress, displacement, von_mises"):
            last.field("speed")
        # Frames that are added meanwhile.
        more = pliant.resume("out", {"time.end": 0.05})
        self.assertEqual(len(result), 5)
        result.refresh()
        self.assertEqual(len(result), 6)
        self.assertEqual(more.history.time[-1], 0.05)
        with self.assertRaisesRegex(pliant.PliantError, "was resumed"):
            result.series("displacement")
        with more.checkpoint as checkpoint:
            self.assertEqual((checkpoint.step, checkpoint.time, checkpoint.ranks), (5, 0.05, 1))
            self.assertEqual(yaml.safe_load(checkpoint.input)["time"]["end"], 0.05)
            q = checkpoint.state["advance.history.0.q"]
            u = result[-1].displacement()
            # Another order of nodes, the same nodes.
            np.testing.assert_array_equal(q[np.lexsort(q.T)], u[np.lexsort(u.T)])

    def test_earlier_run(self):
        """The directory of a run is enough to read it."""
        pliant.run(INPUT, output="out")
        run = pliant.Run("out")
        self.assertEqual((len(run.result), run.history.time[-1], run.summary["outcome"]), (4, 0.03, "done"))
        self.assertRegex(repr(run), "^Run\\('out': done, 3 steps")
        self.assertNotIn("what the program printed", run._repr_html_())
        with self.assertRaisesRegex(pliant.PliantError, "missing/history.csv does not exist"):
            pliant.Run("missing")

    def test_mistakes(self):
        with self.assertRaises(pliant.PliantError) as caught:
            pliant.run(yaml.safe_load(INPUT), {"time.step": "10 m"}, output="out")
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("time.step", str(caught.exception))
        with self.assertRaisesRegex(pliant.PliantError, "^input:1:1: missing key 'mesh'"):
            pliant.run({"time": {"step": 0.1, "end": 1}})
        for ranks in (0, 2.0, "2"):
            with self.assertRaisesRegex(pliant.PliantError, f"ranks={ranks!r}"):
                pliant.run(yaml.safe_load(INPUT), ranks=ranks)
        with self.assertRaisesRegex(pliant.PliantError, "a function; a formula is a text"):
            pliant.run(INPUT, {"loads.0.gravity": [0, 0, lambda t: t]})
        for source, overrides, words in ((None, {}, "not None"), (INPUT, ["time.step=1"], "a dictionary is expected")):
            with self.assertRaisesRegex(pliant.PliantError, words):
                pliant.run(source, overrides)
        with self.assertRaisesRegex(pliant.PliantError, "output: the name is empty"):
            pliant.run(INPUT, output="")
        with self.assertRaises(pliant.PliantError) as caught:
            pliant.run("missing.yaml", ranks=2)
        self.assertEqual(caught.exception.code, 2)
        for reader in (pliant.Result, pliant.History, pliant.Run):
            with self.assertRaisesRegex(pliant.PliantError, "does not exist") as caught:
                reader("missing")
            self.assertEqual(caught.exception.code, 4)
            self.write("in.yaml", INPUT)
            with self.assertRaisesRegex(pliant.InputError, "in.yaml is an input, not a result") as caught:
                reader("in.yaml")
            self.assertEqual(caught.exception.code, 2)
        with self.assertRaises(pliant.PliantError) as caught:
            pliant.Checkpoint(".")
        self.assertEqual(caught.exception.code, 4)
        with self.assertRaisesRegex(pliant.PliantError, "no checkpoint"):
            pliant.Checkpoint(".")
        self.write("text.h5", "no HDF5")
        with self.assertRaisesRegex(pliant.PliantError, "is not an HDF5 file"):
            pliant.Result("text.h5")

    def test_values_that_are_not_what_is_expected(self):
        """Each ends with one exception of the package, a ValueError, and leaves no file."""
        run = pliant.run(INPUT, output="out")
        result, history = run.result, run.history
        last, surface = result[-1], pliant.Surface(result.mesh())
        before = sorted(os.listdir("."))
        for words, call in {
                "the time of a frame .s.: a finite number is expected, not inf": lambda: result.at(np.inf),
                "a finite number is expected, not nan": lambda: result.at(np.nan),
                "not '20 ms'": lambda: result.at("20 ms"),
                "has the frames 0 to 3, not 4": lambda: result[4],
                r"fields belong to one of them: result\[-1\]\['displacement'\]": lambda: result["displacement"],
                "has no mesh '/mesh_1'; it has /mesh$": lambda: result.mesh("/mesh_1"),
                "rows: numbers of nodes or cells are expected": lambda: result.series("displacement", 1000),
                "no field '3'; it has cauchy_stress, displacement": lambda: last[3],
                "no field '../000001'": lambda: last["../000001"],
                "Result: the name is empty": lambda: pliant.Result(""),
                "History: the name of a file or a directory is expected, not None": lambda: pliant.History(None),
                "Checkpoint: the name of a file or a directory is expected, not 3": lambda: pliant.Checkpoint(3),
                "size: a number above 0 is expected, not -1": lambda: result.show(size=-1),
                "no columns tipx, tipy and tipz .*; there are those of p, L, tip_, tip_v": lambda: history.vector("tip"),
                "no column 'tip_zz'": lambda: history["tip_zz"],
                r"no column \['time'\]": lambda: history[["time"]],
                "a key of the input is a text, .* not 3": lambda: pliant.run(INPUT, {3: 4}),
                "timeout, a time .s.: a finite number is expected": lambda: pliant.run(INPUT, timeout=np.nan),
                "petsc_options: a list of words": lambda: pliant.run(INPUT, petsc_options="-log_view"),
                "output: the name of a file or a directory": lambda: pliant.run(INPUT, output=3),
                "modes takes the name of an input file, not": lambda: pliant.modes(INPUT),
                "near, a frequency .Hz.: a finite number": lambda: pliant.modes("in.yaml", near="x"),
                "of: a list of names is expected": lambda: pliant.sensitivity("in.yaml", of=3, to=["bodies.0.density"]),
                "output: the name is empty": lambda: pliant.gradient("in.yaml", {"time": [0], "tip_z": [1]}, to=["bodies.0.density"], output=""),
                "'tip_z' has 2 values, and 'time' has 4": lambda: run.gradient({"tip_z": [1, 2]}, to=["bodies.0.density"]),
                "4 of 4 numbers are not finite": lambda: run.gradient({"tip_z": history.time * np.nan}, to=["bodies.0.density"]),
                "weights: a dictionary of arrays": lambda: run.gradient(3, to=["bodies.0.density"]),
                r"von_mises: an array of shape \(n, 6\) is needed, not \(2, 5\)": lambda: pliant.von_mises(np.zeros((2, 5))),
                "a mesh is expected, such as result.mesh": lambda: pliant.Surface(result),
                "divisions: a whole number from 1": lambda: pliant.Surface(result.mesh(), 0),
                "cells: numbers from 0 to 23 are expected": lambda: pliant.Surface(result.mesh(), cells=[24]),
                r"nodal values: an array of shape \(20, n\) is needed, not \(3, 3\)": lambda: surface.of_nodes(np.zeros((3, 3)))}.items():
            with self.subTest(words), self.assertRaisesRegex(pliant.InputError, words) as caught:
                call()
            self.assertEqual(caught.exception.code, 2)
        self.assertEqual(sorted(os.listdir(".")), before)
        for kind, call in ((KeyError, lambda: history["x"]), (IndexError, lambda: result[9]), (KeyError, lambda: last["x"])):
            with self.assertRaises(kind):
                call()
        self.assertEqual((len(list(result)), history.get("x")), (4, None))
        for text, words in (("a\n", "must be a map of keys"), ("a: [\n", "not valid YAML"), ("output: 3\n", "output")):
            with self.assertRaisesRegex(pliant.PliantError, words):
                pliant.run(text)
        result.close()
        with self.assertRaisesRegex(pliant.PliantError, "is closed; refresh"):
            last["displacement"]
        shutil.rmtree("out")
        with self.assertRaisesRegex(pliant.PliantError, "summary.json: No such file"):
            pliant.Run("out", "").summary
        with mock.patch.dict(os.environ, {"PLIANT": "/missing/pliant"}), self.assertRaisesRegex(pliant.PliantError, "/missing/pliant could not be started"):
            pliant.run(INPUT)

    def test_runs_that_ranks_of_mpirun_start(self):
        """Each rank starts a job of its own, before and after it has started MPI itself."""
        self.write("script.py", f"""
import os, sys
sys.path.insert(0, {str(ROOT / 'src/python')!r})
import pliant
rank = os.environ["OMPI_COMM_WORLD_RANK"]
text = {INPUT!r}
print(pliant.run(text, {{"time.end": "20 ms"}}, output="out" + rank).summary["ranks"])
with pliant.Simulation(text) as sim:
    sim.advance()
    print(pliant.run(text, {{"time.end": "20 ms"}}, output="both" + rank, ranks=2).summary["ranks"])
""")
        call = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "2", "/usr/bin/python3", "script.py"]
        done = subprocess.run(call, env=os.environ, text=True, capture_output=True, timeout=100, check=False)
        self.assertEqual((done.returncode, sorted(done.stdout.split())), (0, ["1", "1", "2", "2"]), done.stderr)
        for name in ("out0", "out1", "both0", "both1"):
            self.assertEqual(len(pliant.Result(name)), 3)

    def test_groups_of_the_mesh(self):
        """Nodes, facets and cells of what has a name in the mesh, with linear and quadratic elements, on any number of ranks."""
        points, triangles, cells = box((4, 2, 1), (1, 0.2, 0.2))
        is_tip = (points[cells].mean(axis=1)[:, 0] > 0.5).astype(int)
        write_mesh("parts.msh", points, triangles, cells, (["root", "tip"], is_tip))
        text = INPUT.replace("bar.msh", "parts.msh").replace("volume: body, ", "")
        for element, ranks in (("P1", 1), ("P2", 2)):
            with self.subTest(element):
                mesh = pliant.run(text, {"element": element}, output=element, ranks=ranks).result.mesh()
                x = mesh.coordinates
                self.assertEqual([group.name for group in mesh.groups if group.kind == "volume"], ["body", "root", "tip"])
                np.testing.assert_array_equal(mesh.surface("right").nodes, np.flatnonzero(np.abs(x[:, 0] - 1) < 1e-9))
                top = x[mesh.surface("top").facets]
                self.assertEqual(top.shape, (16, 3 if element == "P1" else 6, 3))
                area = np.cross(top[:, 1] - top[:, 0], top[:, 2] - top[:, 0]).sum(axis=0) / 2
                np.testing.assert_allclose(area, [0, 0, 0.2], atol=1e-12)
                if element == "P2":
                    np.testing.assert_allclose(top[:, 3:], (top[:, :3] + top[:, [1, 2, 0]]) / 2, atol=1e-12)
                tip = mesh.volume("tip")
                np.testing.assert_array_equal(tip.cells, np.flatnonzero(x[mesh.cells[:, :4]].mean(axis=1)[:, 0] > 0.5))
                np.testing.assert_array_equal(tip.nodes, np.flatnonzero(x[:, 0] > 0.5 - 1e-9))
                self.assertEqual(len(mesh.volume("body").cells), len(mesh.cells))
                with self.assertRaisesRegex(pliant.InputError, "the mesh has no surface 'topp'; did you mean 'top'. It has left, right"):
                    mesh.surface("topp")
        frame = pliant.resume("P1", {"time.end": 0.04}, ranks=2).result[-1]
        held = frame.mesh.surface("left")
        self.assertEqual(repr(held), "MeshGroup(surface 'left': 6 nodes, 4 facets)")
        self.assertEqual(np.abs(frame["displacement"][held.nodes]).max(), 0)
        shutil.copy("P1/result.h5", "old.h5")
        with h5py.File("old.h5", "r+") as file:  # as earlier versions wrote it
            del file["groups"], file["groups_1"]
        self.assertEqual([group.name for group in pliant.Result("old.h5").mesh().groups], ["body"])

    def test_curves_of_the_mesh(self):
        self.write("bar.geo", 'SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 1, 0.2, 0.2}; MeshSize {:} = 0.2;\n'
                   'Physical Volume("body") = {1}; Physical Surface("left") = {1}; Physical Curve("edge") = {1}; Physical Point("corner") = {7};\n')
        for element in ("P1", "P2"):
            mesh = pliant.run(INPUT.replace("bar.msh", "bar.geo"), {"element": element}, ranks=2).result.mesh()
            edge, corner = mesh.curve("edge"), mesh.point("corner")
            is_there = (np.abs(mesh.coordinates[:, :2]) < 1e-9).all(axis=1)
            np.testing.assert_array_equal(edge.nodes, np.flatnonzero(is_there))
            np.testing.assert_allclose(mesh.coordinates[corner.nodes], [[1, 0.2, 0.2]], atol=1e-12)

    def test_notebooks(self):
        """What a cell shows of a run, its result and its history, without a notebook."""
        run = pliant.run("title: a <bar> & its end\n" + INPUT)
        history, result = run.history, run.result
        self.assertRegex(repr(run), r"^Run\('.*/out': done, 3 steps to t = 0\.03 in \S+ s\)$")
        self.assertRegex(repr(result), r"^Result\('.*/out/result\.h5': 4 frames, t = 0 to 0\.03, 24 tetrahedra\)$")
        self.assertRegex(repr(history), rf"^History\('.*/history\.csv': 4 rows, t = 0 to 0\.03, {len(history)} columns\)$")
        shown = Reader(run._repr_html_())
        self.assertEqual(shown.texts[0], "a <bar> & its end")
        self.assertEqual(shown.after("elastic energy"), f"{history['elastic_energy'][-1]:.6g} J")
        self.assertEqual(shown.after("tip"), "({:.6g}, {:.6g}, {:.6g}) m at the end".format(*history.vector("tip_")[-1]))
        self.assertRegex(shown.after("files"), r"checkpoint-\d+\.h5 .*history\.csv \(.* kB\)")
        self.assertEqual(shown.texts[-1], run.log)
        self.assertEqual([picture[:4] for picture in shown.pictures], [b"\x89PNG"] * 2)
        shown = Reader(result._repr_html_())
        self.assertEqual(shown.after("mesh"), "24 linear tetrahedra, 20 nodes")
        largest = np.linalg.norm(result[-1]["displacement"], axis=1).max()
        self.assertEqual(shown.after("displacement"), f"up to {largest:.4g} m at the end")
        self.assertEqual(len(shown.pictures), 1)
        shown = Reader(history._repr_html_())
        at = shown.texts.index("tip_z")
        tip = history["tip_z"]
        self.assertEqual(shown.texts[at + 1: at + 6], ["m", *(f"{x:.6g}" for x in (tip[0], tip[-1], tip.min(), tip.max()))])
        with mock.patch.dict(sys.modules, {"matplotlib.figure": None}):
            self.assertEqual(Reader(run._repr_html_()).pictures, [])
        result.close()
        self.assertRegex(repr(result), r"4 frames, t = 0 to 0\.03\)$")
        self.assertEqual(Reader(result._repr_html_()).after("state"), "closed")
        shutil.rmtree("out")
        for gone in (run, pliant.Run(run.directory, run.log)):
            self.assertIn(run.directory, repr(gone))
            Reader(gone._repr_html_())

    def test_notebooks_of_static_runs(self):
        """Load factors are no times, and segments of rods and triangles of shells no tetrahedra."""
        run = pliant.run(INPUT.replace("time: {method: bdf2, step: 10 ms, end: 30 ms}", "time: {method: static, load_steps: 2}"))
        self.assertRegex(repr(run), r"done, 2 steps to load factor 1 in \S+ s\)$")
        self.assertRegex(repr(run.history), r"3 rows, load factor 0 to 1, ")
        self.assertRegex(repr(run.result), r"load factor 0 to 1, 24 tetrahedra\)$")
        shown = Reader(run.history._repr_html_())
        self.assertEqual(shown.texts[shown.texts.index("time") + 1], "0")  # there is no unit
        cells = np.arange(16).reshape(4, 4)
        mesh = pliant.Mesh(np.zeros((16, 3)), cells, np.array([0, 1, 1, 2]), ["block", "wire", "sail"], rods=["wire"], shells=["sail"])
        self.assertEqual(pliant.notebook.elements_of(mesh, "linear"), "1 linear tetrahedron, 1 triangle of shells, 2 segments of rods")
        mesh = pliant.Mesh(np.zeros((16, 3)), cells, np.zeros(4, int), ["bob"], masses=["bob"])
        self.assertEqual(pliant.notebook.elements_of(mesh), "rigid bodies alone")

    def test_page_of_a_result(self):
        result = pliant.run(INPUT).result
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            result.show(output="page.html")
        self.assertRegex(printed.getvalue(), rf"^{self.directory}/page\.html: .* open it in a browser\n$")
        with self.assertRaisesRegex(pliant.PliantError, "cannot write"):
            result.show(output="missing/page.html")
        displayed = []
        shell = types.SimpleNamespace(kernel=object())
        notebook = {"IPython": types.SimpleNamespace(get_ipython=lambda: shell),
                    "IPython.display": types.SimpleNamespace(HTML=str, display=displayed.append)}
        with mock.patch.dict(sys.modules, notebook), contextlib.redirect_stdout(printed):
            result.show(output="page.html", size=5)
        with open("page.html", encoding="utf-8") as page:
            self.assertEqual(Reader(displayed[0]).frames, [page.read()])
        self.assertEqual(printed.getvalue().count("\n"), 1)

    def test_history_as_dataframe(self):
        history = pliant.run(INPUT).history
        with mock.patch.dict(sys.modules, {"pandas": None}), self.assertRaisesRegex(pliant.PliantError, "install the package python3-pandas"):
            history.to_dataframe()
        try:
            import pandas
        except ImportError:
            self.skipTest("needs the package python3-pandas")
        frame = history.to_dataframe()
        self.assertIsInstance(frame, pandas.DataFrame)
        self.assertEqual(list(frame.columns), list(history))
        np.testing.assert_array_equal(frame["tip_z"].to_numpy(), history["tip_z"])

    def test_frames_for_meshio(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("needs the package python3-meshio")
        last = pliant.run(INPUT, {"element": "P2"}).result[-1]
        last.to_meshio().write("last.vtu")
        read = meshio.read("last.vtu")
        np.testing.assert_array_equal(read.points, last.positions())
        np.testing.assert_array_equal(read.cells_dict["tetra10"], last.mesh.cells)
        np.testing.assert_array_equal(read.point_data["displacement"], last["displacement"])
        np.testing.assert_array_equal(read.cell_data["von_mises_stress"][0], last["von_mises_stress"])

    def test_page(self):
        """The blocks of the page one after another, as a reader types them; their beam with a coarser mesh."""
        for name in ("input/verification", "meshes"):
            (self.directory / name).mkdir(parents=True)
        for name in ("input/verification/pendulum.yaml", "input/released_beam.yaml", "meshes/cantilever.geo"):
            shutil.copy(ROOT / name, self.directory / name)
        text = (ROOT / "input/beam_small.yaml").read_text()
        self.write("input/beam_small.yaml", text.replace("volume: beam", "volume: body").replace("surface: clamp", "surface: left"))
        write_box("meshes/beam_small.msh", (4, 1, 1), (1, 0.2, 0.2))
        pliant.run("input/beam_small.yaml", output="out/beam")
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.S)
        self.assertGreater(len(blocks), 4)
        printed = io.StringIO()
        names = {}
        with contextlib.redirect_stdout(printed):
            for block in blocks:
                exec(compile(block.replace('"clamp"', '"left"'), "docs/python.md", "exec"), names)
        self.assertGreater(len(printed.getvalue().splitlines()), 8)


if __name__ == "__main__":
    unittest.main()
