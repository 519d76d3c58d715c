#!/usr/bin/python3
"""Meshes of other programs are the same mesh as gmsh's, with their sets as groups. Damaged ones: tests/mesh/bad_formats.py."""
import pathlib
import sys
import unittest

import h5py
import numpy as np

from mistakes import MistakesTest
from program import LONG, finish, read_history, start

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "mesh"))

import other_formats  # noqa: E402
from other_formats import Body  # noqa: E402

NUMBERED = (".mesh", ".bdf", ".nas", ".vtk", ".vtu")
INPUT = """mesh: {{file: {file}}}
element: P2
bodies:
  - {{volume: {near}, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}}}
  - {{volume: {far}, density: 2000, elasticity: {{model: neo-hookean, youngs_modulus: 2e6, poissons_ratio: 0.3}}}}
constraints: [{{surface: {left}, displacement: [0, 0, 0], name: left}}]
loads: [{{gravity: [0, 0, -9.81]}}, {{surface: {top}, traction: [100, 0, 0]}}, {{surface: {right}, pressure: 200}}]
time: {{method: static, load_steps: 1}}
output: {{directory: out-{file}, fields: [displacement]}}
"""


def input_for(file):
    names = {name: str(tag) if file.endswith(NUMBERED) else name for tag, name in Body().names.items()}
    return INPUT.format(file=file, **names)


def contents(path):
    """Nodes, cells and members of groups by dimension and name, or by number."""
    with h5py.File(path) as file:
        groups = {}
        for group in file["groups"].values():
            members = group[()].reshape(len(group), -1)
            name = group.attrs["name"].decode() or int(group.attrs["tag"])
            groups[int(group.attrs["dimension"]), name] = members[np.lexsort(members.T[::-1])].tolist()
        return file["nodes"][()], file["cells"][()], groups


class OtherFormats(MistakesTest):
    def test_first_order_meshes_are_those_of_gmsh(self):
        names = ["body.msh", *other_formats.write_all(self.directory, 1)]
        done = dict(zip(names, self.pool.map(
            lambda name: finish(start(["mesh", "convert", name, name + ".h5"], self.directory), 60), names)))
        nodes, cells, groups = contents(self.directory / "body.msh.h5")
        self.assertEqual({len(groups[3, "near"]), len(groups[3, "far"])}, {24})
        self.assertEqual(len(groups[2, "left"]), 8)
        number = {name: tag for tag, name in Body().names.items()}
        for name, result in done.items():
            with self.subTest(name):
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                its_nodes, its_cells, its_groups = contents(self.directory / (name + ".h5"))
                np.testing.assert_array_equal(its_nodes, nodes)
                np.testing.assert_array_equal(its_cells, cells)
                wanted = {(d, number[title] if name.endswith(NUMBERED) else title): members for (d, title), members in groups.items()}
                found = {key: its_groups.get(key) for key in wanted}
                if name.endswith(".inp"):  # has not the spelling of all, and more sets
                    found = {key: members for (d, title), members in its_groups.items() for key in [(d, title.lower())] if key in wanted}
                    self.assertEqual(len(its_groups[3, "all"]), 48)
                    self.assertEqual(len(its_groups[0, "right"]), 9)
                    self.assertNotIn((3, "_top_S1"), its_groups)
                else:
                    self.assertEqual(its_groups.keys(), wanted.keys())
                if name.endswith(".unv"):  # which has numbers besides names
                    with h5py.File(self.directory / (name + ".h5")) as file:
                        found_numbers = {group.attrs["name"].decode(): int(group.attrs["tag"]) for group in file["groups"].values()}
                    self.assertEqual(found_numbers, number)
                self.assertEqual(found, wanted)

    def test_what_is_not_taken_over_is_noted(self):
        body = Body()
        files = {
            "mm.unv": (other_formats.unv(body).replace(b"         1  SI: Metre", b"         5  mm (milli)"), "lengths are millimetres"),
            "shells.inp": (other_formats.abaqus(body).replace(b"*Elset, elset=all", b"*Element, type=S4R\n999, 1, 2, 3, 4\n*Elset, elset=all"),
                           "left out: 1 of type S4R"),
            "two.vtk": (other_formats.vtk(body).replace(b"SCALARS region int", b"SCALARS part int")
                        + other_formats.lines("SCALARS colour int", "LOOKUP_TABLE default", *[1] * 96), "('part', 'colour'), and no groups were made"),
        }
        for name, (content, _) in files.items():
            (self.directory / name).write_bytes(content)
        done = self.pool.map(lambda name: finish(start(["mesh", "convert", name, name + ".h5"], self.directory), 60), files)
        for (name, (_, words)), result in zip(files.items(), done):
            with self.subTest(name):
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                self.assertIn(words, result.stdout + result.stderr)

    def test_second_order_meshes_run_as_those_of_gmsh(self):
        names = ["body.msh", *other_formats.write_all(self.directory, 2)]
        if not LONG:
            names = ["body.msh", "plain.inp", "text.mesh", "large.nas", "groups.unv", "binary.vtk", "zlib.vtu", "salome.med"]

        def run(number, name):
            text = input_for(name)
            if name.endswith(".inp"):
                text = text.replace("near", "NEAR").replace("far", "Far")
            self.write(name + ".yaml", text)
            return finish(start(["run", name + ".yaml"], self.directory, 1 + number % 2), 120)
        done = list(self.pool.map(run, range(len(names)), names))
        for name, result in zip(names, done):
            with self.subTest(name):
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                wanted, found = (read_history(self.directory / f"out-{file}") for file in ("body.msh", name))
                for key in ("elastic_energy", "left_fx", "left_fz"):
                    self.assertNotEqual(wanted[key][-1], 0.0)
                    np.testing.assert_allclose(found[key][-1], wanted[key][-1], rtol=1e-8, err_msg=key)


if __name__ == "__main__":
    unittest.main()
