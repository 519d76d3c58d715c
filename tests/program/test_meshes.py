#!/usr/bin/python3
"""A mesh that is damaged or of another kind ends the program, on any number of ranks alike, with one message that names the file, what
is wrong and what helps: a few of those that tests/mesh reads. One that is odd but whole is simulated."""
import os
import pathlib
import re
import sys
import unittest

from mistakes import MistakesTest
from program import LONG, ProgramTest, finish, start, write_box

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "mesh"))

import bad_meshes  # noqa: E402
from bricks import Brick, write_parts  # noqa: E402

INPUT = """mesh: {file: @FILE}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
time: {step: 0.01, end: 0.01}
output: {directory: out-FILE}
"""
EVERY_CASE = {1: 1, 2: 1}
SAMPLE = 1 if LONG else 15  # each how many-th bad mesh the program is run on


class BadMeshes(MistakesTest):
    def case(self, file, words):
        source = INPUT.replace("FILE", file)
        at = source.index("@")
        path = self.write(file + ".yaml", source.replace("@", ""))
        return (self.directory, ["run", path.name], 2, f"{path.name}:1:{at + 1}:", rf"mesh file '{re.escape(file)}': (?s:.*)(?:{words})")

    def test_a_sample(self):
        cases = bad_meshes.write_all(self.directory)
        self.assertGreaterEqual(len(cases), 100)
        self.judge_all({name: self.case(file, words) for name, file, words in cases[::SAMPLE]}, EVERY_CASE)

    def test_a_variable_that_a_script_does_not_define(self):
        """What follows from it is not reported: the box without a height."""
        self.write("box.geo", 'SetFactory("OpenCASCADE");\nheight = 1;\nBox(1) = {0, 0, 0, 1, 1, heigth};\nPhysical Volume("box") = {1};\n')
        words = r"gmsh could not read it:\n  'box.geo', line 3: Unknown variable 'heigth': correct its name, or define it above that line \('heigth = ...;'\)\n$"
        self.judge_all({"variable": self.case("box.geo", words)}, EVERY_CASE)

    def test_what_is_no_file(self):
        (self.directory / "folder.msh").mkdir()
        os.mkfifo(self.directory / "pipe.msh")
        os.symlink("self.msh", self.directory / "self.msh")
        cases = {name: self.case(name, words) for name, words in
                 {"folder.msh": "directory", "pipe.msh": "a pipe or a device", "self.msh": "does not exist",
                  "nowhere.h5": "does not exist"}.items()}
        self.judge_all(cases, EVERY_CASE)


def twice(b):
    """A second brick beside the first, joined to nothing."""
    shift, last = len(b.tags), len(b.blocks) - 1
    b.tags += [tag + shift for tag in b.tags]
    b.points += [(x + 2.0, y, z) for x, y, z in b.points]
    dimension, entity, kind, physical, cells = b.blocks[last]
    b.blocks[last] = (dimension, entity, kind, physical, cells + [[n + shift for n in cell] for cell in cells])


def huge_tags(b):
    b.tags = [tag + 2_000_000_000 for tag in b.tags]
    b.blocks = [(*block[:4], [[n + 2_000_000_000 for n in member] for member in block[4]]) for block in b.blocks]


def turned_round(b):
    cell = b.cells()[0]
    cell[0], cell[1] = cell[1], cell[0]


def ungrouped_cells(b):
    dimension, entity, kind, _, cells = b.blocks.pop()
    b.blocks += [(dimension, entity + 1, kind, 0, cells[:1]), (dimension, entity, kind, 7, cells[1:])]


def group_of_nothing(b):
    b.names += [(2, 17, "hole"), (3, 18, "void")]


def orphans(b):
    b.tags.append(28)
    b.points.append((9.0, 9.0, 9.0))


# Name: change of the brick, what the run says of it.
ODD = {
    "as it is": (lambda b: None, ""),
    "two parts": (twice, "2 disconnected parts"),
    "huge tags": (huge_tags, ""),
    "a cell turned round": (turned_round, "1 inverted tetrahedron was reoriented: element 49"),
    "a cell in no group": (ungrouped_cells, "1 tetrahedra are in no physical volume and were left out"),
    "groups of nothing": (group_of_nothing, "'hole' has no elements"),
    "a node of no cell": (orphans, "1 nodes that no tetrahedron uses were dropped: node 28"),
}


class OddMeshes(MistakesTest):
    def simulate(self, file, ranks):
        source = self.write(file + ".yaml", INPUT.replace("FILE", file).replace("@", "")).name
        return self.pool.submit(finish, start(["run", source], self.directory, ranks), 60)

    def test_are_simulated(self):
        waiting = []
        for name, (change, words) in ODD.items():
            b = Brick()
            change(b)
            forms = {"2.2": b.msh2(), "2.2 in bytes": b.msh2(binary=True, order=">"), "4.1": b.msh4(), "4.1 in bytes": b.msh4(binary=True)}
            form = list(forms)[len(waiting) % 4]
            file = bad_meshes.as_file(f"{name} {form}") + ".msh"
            (self.directory / file).write_bytes(forms[form])
            waiting.append((f"{name} {form}", words, self.simulate(file, 1 + len(waiting) % 2)))
        write_parts(self.directory / "good.h5")
        waiting.append(("in parts", "", self.simulate("good.h5", 2)))
        for name, words, result in waiting:
            with self.subTest(name):
                done = result.result()
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertIn(words, done.stdout + done.stderr)


class NamesOfGroups(ProgramTest):
    def test_a_name_goes_before_a_tag(self):
        # `right` has the tag 2; now `left` is called 2.
        text = write_box(self.directory / "named.msh", (2, 1, 1)).read_text()
        (self.directory / "numbered.msh").write_text(text.replace('"left"', '"2"').replace('"right"', '"end"'))
        body = "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0.3}}]\nprobes: [{name: p, point: [1, 1, 1]}]\n"
        rows = []
        for mesh, clamp in (("named", "left"), ("numbered", '"2"')):
            self.write(f"{mesh}.yaml", f"mesh: {{file: {mesh}.msh}}\n{body}constraints: [{{surface: {clamp}, displacement: [0, 0, 0]}}]\n"
                                       "loads: [{gravity: [0.01, 0, 0]}]\ntime: {method: static}\n")
            rows.append(self.run_input(f"{mesh}.yaml")["p_ux"][-1])
        self.assertEqual(*rows)


class EmptyGroups(ProgramTest):
    def test_are_not_taken_for_slips_of_names(self):
        """A box that is exactly as large as a face catches nothing."""
        self.write("cube.geo", 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Volume("cube") = {1};\nPhysical Volume("core") = {};\n'
                               'Physical Surface("lid") = Surface In BoundingBox{0, 0, 1, 1, 1, 1};\nPhysical Surface("left") = {1};\n')
        law = "density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0.3}"
        good = (f"mesh: {{file: cube.geo}}\nbodies: [{{volume: cube, {law}}}]\nconstraints: [{{surface: left, displacement: [0, 0, 0]}}]\n"
                "time: {method: static}\n")
        for text, place, words in ((good + "loads: [{surface: lid, pressure: 1}]\n", "5:19", "surface 'lid' is defined in the mesh, but holds nothing of it"),
                                   (good.replace("volume: cube", "volume: core"), "2:19", "volume 'core' is defined in the mesh, but holds nothing of it")):
            self.write("cube.yaml", text)
            for ranks in (1, 2):
                said = self.pliant("check", "cube.yaml", ranks=ranks, status=2).stderr
                self.assertIn(f"cube.yaml:{place}: {words}", said)
                self.assertIn("widen it by 1e-6", said)
        self.write("cube.yaml", good)
        self.assertIn("physical surface 'lid' has no elements", self.pliant("check", "cube.yaml").stdout)


class KeptMeshes(MistakesTest):
    def test_the_second_run_takes_the_mesh_of_the_first(self):
        (self.directory / "cube.geo").write_text('SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\n'
                                                 'Physical Surface("left") = {1};\nPhysical Volume("cube") = {1};\n', encoding="utf-8")
        source = self.write("cube.yaml", INPUT.replace("@FILE", "cube.geo").replace("FILE", "cube") + "probes: [{name: tip, point: [1, 1, 1]}]\n").name
        keeping = {"XDG_CACHE_HOME": str(self.directory / "cache")}
        ends = []
        for number, ranks in enumerate((1, 1, 2)):
            done = finish(start(["run", source], self.directory, ranks, keeping), 120)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            told = "note: its mesh is that of an earlier run, kept as " + str(self.directory / "cache/pliant/meshes")
            self.assertEqual(told in done.stdout, number > 0, done.stdout)
            ends.append((self.directory / "out-cube/history.csv").read_text(encoding="utf-8"))
        self.assertEqual(ends[0], ends[1])


if __name__ == "__main__":
    unittest.main()
