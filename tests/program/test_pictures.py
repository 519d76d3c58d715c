#!/usr/bin/python3
"""`pliant render` and `pliant plot`: they draw, take the options of their Python code, and say what is wrong or missing.

What pictures show is tested in tests/tools.
"""
import importlib
import re
import sys
import types
import unittest

import numpy as np
from PIL import Image

from program import ROOT, ProgramTest, box, finish, start, write_mesh

sys.path[:0] = [str(ROOT / "tests/tools"), str(ROOT / "src/python")]

import synthetic  # noqa: E402


class Pictures(ProgramTest):
    def setUp(self):
        super().setUp()
        self.out = self.directory / "out"

    def call(self, *arguments, ranks=1, timeout=60, environment=None):
        """With a folder for the caches of matplotlib and of the graphics library, which say so where they have none."""
        return finish(start(arguments, self.directory, ranks, {"XDG_CACHE_HOME": str(self.directory / "cache"), **(environment or {})}), timeout)

    def test_forces_are_drawn_once_and_few_at_a_time(self):
        sys.path.insert(0, str(ROOT / "src/python"))
        from pliant.pictures import plot  # which needs matplotlib
        time = np.linspace(0, 1, 5)
        history = {"time": time, "elastic_energy": time**2, "load_work": time**2}
        for k, name in enumerate(("root", "table", "table_ball", "wall", "wall_left", "grip", "still")):
            history |= {f"{name}_f{axis}": (name != "still") * time ** (1 + (k if name != "table_ball" else 1)) for axis in "xyz"}
        figure = plot.draw(history, "", {})
        drawn = {axes.get_title(): [line.get_label() for line in axes.lines] for axes in figure.axes}
        of = {title: sorted({label.split()[0] for label in labels}) for title, labels in drawn.items() if title.startswith("Forces")}
        self.assertEqual(of, {"Forces of root, table, wall": ["root", "table", "wall"], "Forces of wall_left, grip": ["grip", "wall_left"]})
        styles = {line.get_label(): line.get_linestyle() for line in figure.axes[0].lines}
        self.assertEqual(styles, {"elastic energy": "-", "load work": "--"})
        plot.plt.close(figure)

    def test_forces_that_balance_are_not_drawn(self):
        sys.path.insert(0, str(ROOT / "src/python"))
        from pliant.pictures import plot  # which needs matplotlib
        time = np.linspace(0, 1, 5)
        for force, is_drawn in ((1e-10, False), (1e-6, True)):  # what a tolerance of 1e-8 leaves of 8 N on the walls of a chamber
            history = {"time": time, "elastic_energy": 9e-3 * time**2, "load_work": 9e-3 * time**2} | {f"mount_f{axis}": force * time for axis in "xyz"}
            figure = plot.draw(history, "", {})
            self.assertEqual(any(axes.get_title().startswith("Forces") for axes in figure.axes), is_drawn)
            plot.plt.close(figure)

    def test_a_result_and_a_history_are_drawn(self):
        synthetic.write_result(self.out, num_frames=2, cubes=(3, 1, 1))
        synthetic.write_history(self.out, num_steps=5)
        done = self.pliant("render", "out", "--view", "-1,0.5,0.3", "--hide", "root", "--size=320x240", "-o", "tip.png")
        self.assertEqual((done.stdout, done.stderr), ("tip.png\n", ""))
        with Image.open(self.directory / "tip.png") as picture:
            self.assertEqual(picture.size, (320, 240))
        done = self.pliant("plot", "out")
        self.assertEqual(done.stdout, f"{self.out}/history.png\n")
        with Image.open(self.out / "history.png") as picture:
            self.assertGreater(len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)), 100)
        self.pliant("plot", "out", "--of", "kinetic_energy,elastic_energy", "--x", "dt", "--output", "chosen.svg")
        self.pliant("plot", "out", "--of", "kinetic_energy", "--of", "elastic_energy", "--x", "dt", "--output", "repeated.svg")
        undated = [re.sub(r"<dc:date>.*</dc:date>|(?<=[#\"])[mpC][0-9a-z_]{6,}", "", (self.directory / file).read_text()) for file in ("chosen.svg", "repeated.svg")]
        self.assertEqual(*undated)
        drawn = (self.directory / "chosen.svg").read_text()
        for words in ("<!-- kinetic energy -->", "<!-- elastic energy -->", "<!-- dt [s] -->", "<!-- [J] -->"):
            self.assertIn(words, drawn)

    def fails(self, status, words, *arguments, ranks=1, environment=None):
        done = self.call(*arguments, ranks=ranks, environment=environment)
        self.assertEqual((done.returncode, done.stdout), (status, ""), done.stderr)
        self.assertRegex(done.stderr, words)
        if ranks == 1:
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_rigid_bodies_have_no_stress(self):
        """The nodes that they share with soft ones have the stress of these."""
        points, triangles, cells = box((4, 1, 1), (1, 0.2, 0.2))
        write_mesh(self.directory / "bar.msh", points, triangles, cells, (["body", "end"], (points[cells, 0].mean(axis=1) > 0.75).astype(int)))
        self.write("bar.yaml", """mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
  - {volume: end, density: 1000, rigid: true}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: static}
output: {fields: [displacement, von_mises_stress, volume_ratio]}
""")
        from pliant import Result
        from pliant.pictures.shown import Shown
        options = dict(range=None, colour_map="viridis", scale=1, hide=(), transparent=(), outline=False, cut=None, mirror=(), view=(1, 1, 1))
        for is_nodal in ("false", "true"):
            self.run_input("bar.yaml", f"output.nodal={is_nodal}")
            with Result(self.out) as result:
                frame = result.frames[-1]
                self.assertEqual(frame.mesh.rigid, ["end"])
                for field, at_rest in (("von_mises_stress", 0), ("volume_ratio", 1)):
                    shown = Shown(result, [frame], types.SimpleNamespace(field=field, **options))
                    found = {shell.names[0]: values for shell, values in zip(shown.shells(frame), shown._values(frame))}
                    np.testing.assert_array_equal(found["end"], at_rest)
                    self.assertGreater(np.abs(found["body"] - at_rest).max(), 1e-4)

    def test_errors_in_one_line(self):
        synthetic.write_result(self.out, num_frames=1, order=1, cubes=(2, 1, 1))
        synthetic.write_history(self.out, num_steps=2)
        self.fails(4, "^pliant render: no result: missing does not exist$", "render", "missing")
        self.fails(4, "^pliant plot: no history: .*history.csv does not exist", "plot", self.directory)
        self.fails(2, "^pliant render: in/finger.yaml is an input, not a result: give the directory of its results, such as out/finger$", "render", "in/finger.yaml")
        self.fails(2, "^pliant plot: finger.yaml is an input", "plot", "finger.yaml")
        self.fails(2, "--sise.*see pliant render --help", "render", "out", "--sise", "3")
        self.fails(2, "^pliant render: argument --size: invalid WIDTHxHEIGHT value: '3'", "render", "out", "--size", "3")
        self.fails(2, "--hide arm: nothing that is drawn has this name; names are root, tip", "render", "out", "--hide", "root", "--hide", "arm")
        self.fails(2, "plot.xyz: the name must end in one of", "plot", "out", "--output", "plot.xyz")
        self.fails(4, "^pliant plot: .*missing/a.png: No such file", "plot", "out", "--output", "missing/a.png")
        self.fails(2, "start it without mpirun", "plot", "out", ranks=2)
        self.fails(2, "--of kinetic_energi: the history has no such column; did you mean 'kinetic_energy'", "plot", "out", "--of", "kinetic_energi")
        for of in ("", "kinetic_energy,"):
            self.fails(2, "^pliant plot: --of '.*': a name is missing", "plot", "out", "--of", of)
        self.fails(2, "--x needs the columns", "plot", "out", "--x", "time")

    def test_what_is_missing(self):
        synthetic.write_result(self.out, num_frames=1, order=1, cubes=(2, 1, 1))
        modules = self.directory / "modules"
        modules.mkdir()
        empty = {"PYTHONPATH": str(modules), "PYTHONDONTWRITEBYTECODE": "1"}
        nowhere = {"PATH": str(modules), "PLIANT_PYTHON": "/usr/bin/python3"}  # without Xvfb and ffmpeg
        other = "; or name another Python in the environment variable PLIANT_PYTHON$"
        for lacking, line, arguments, environment in (
                (["vtkmodules"], "lacks 'vtkmodules': apt-get install python3-vtk9" + other, ["render", "out"], empty),
                (["matplotlib"], "lacks 'matplotlib': apt-get install python3-matplotlib" + other, ["plot", "out"], empty),
                (["h5py"], "lacks 'h5py': apt-get install python3-h5py" + other, ["plot", "out"], empty),
                (["matplotlib", "vtkmodules"], "lacks 'matplotlib', 'vtkmodules', and there is no program 'Xvfb', 'ffmpeg': "
                 "apt-get install python3-matplotlib python3-vtk9 xvfb ffmpeg" + other, ["render", "out", "--movie=mp4"], empty | nowhere),
                (["matplotlib", "vtkmodules"], "lacks 'matplotlib': apt-get install python3-matplotlib" + other, ["render", "out", "-o", "a.glb"], empty | nowhere),
                ([], "there is no program 'Xvfb', 'ffmpeg': apt-get install xvfb ffmpeg$", ["render", "out", "--movie", "mp4"], empty | nowhere),
                ([], "there is no program 'Xvfb': apt-get install xvfb$", ["render", "out"], empty | nowhere)):
            for module in lacking:
                (modules / f"{module}.py").write_text("raise ModuleNotFoundError(name=__name__)\n")
            with self.subTest(line):
                self.fails(2, f"^pliant {arguments[0]}: (/usr/bin/python3 )?{line}", *arguments, environment=environment)
            for module in lacking:
                (modules / f"{module}.py").unlink()
        self.fails(2, "'/missing/python' could not be started: install the package python3", "plot", "out", environment={"PLIANT_PYTHON": "/missing/python"})
        self.fails(70, "its Python code failed \\(exit code 1\\)", "plot", "out", environment={"PLIANT_PYTHON": "/usr/bin/false"})

    def test_options_are_those_of_the_code(self):
        """Names and descriptions, which stand in C++ for help and completion, and in Python."""
        for command, module in (("render", "pictures.render"), ("plot", "pictures.plot"), ("convert", "convert.convert")):
            section = re.search(rf'(?ms)^\.SS "pliant {command} .*?(?=^\.S)', self.pliant("man").stdout)[0].replace("\\-", "-")
            documented = dict(re.findall(r"^\.TP\n\.B ((?:-\w, )?--[\w-]+)[^\n]*\n([^\n]*)", section, re.M))
            parser = importlib.import_module(f"pliant.{module}").parser_of("pliant")
            taken = {", ".join(action.option_strings): action.help for action in parser._actions if action.option_strings}
            del taken["-h, --help"]
            self.assertEqual(documented, taken)


if __name__ == "__main__":
    unittest.main()
