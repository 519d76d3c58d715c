#!/usr/bin/python3
"""`mesh.sizes`: elements have the size asked for at physical surfaces, curves and points, and grow from there."""
import unittest

import h5py
import numpy as np

from mistakes import MistakesTest
from program import finish, start

GEOMETRY = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1000, 1000, 1000};
Physical Volume("cube") = {1};
Physical Surface("left", 21) = {1};
Physical Surface("right") = {2};
Physical Curve("edge") = {10};
Physical Point("corner") = {1};
Physical Surface("nowhere") = {Surface In BoundingBox{9e3, 9e3, 9e3, 9.1e3, 9.1e3, 9.1e3}};
"""
INPUT = """mesh: {{file: {file}, scale: 0.001, size: 0.3{sizes}}}
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}}}]
constraints: [{{where: "x < 1e-9", displacement: [0, 0, 0]}}]
time: {{method: static, load_steps: 1}}
output: {{directory: out-{name}, fields: [displacement]}}
"""
# Name: what is asked for, and where: distance of points from it.
SIZES = {
    "surface": ("[{surface: left, size: 0.06, distance: 0.3}]", lambda x: x[:, 0]),
    "number": ("[{surface: 21, size: 6 cm, distance: 0.3}]", lambda x: x[:, 0]),
    "curve": ("[{curve: edge, size: 0.04, distance: 0.4}]", None),
    "point": ("[{point: corner, size: 0.02, distance: 0.5}, {surface: right, size: 0.15, distance: 0.1}]", None),
}
REFUSED = {
    "unknown": ("cube.geo", "[{surface: fillet, size: 1 mm, distance: 5 mm}]",
                "names the physical surface 'fillet', but the geometry has only: (left|right), (left|right)"),
    "empty": ("cube.geo", "[{surface: nowhere, size: 1 mm, distance: 5 mm}]", "names the physical surface 'nowhere', which is empty: .*a box a little larger"),
    "another kind": ("cube.geo", "[{curve: left, size: 10 mm, distance: 5 mm}]", "names the physical curve 'left', but .* only: edge"),
    "unit": ("cube.geo", "[{surface: left, size: 1e-6, distance: 5 mm}]", "check the unit of this size in 'mesh.sizes'"),
    "a mesh": ("cube.msh", "[{surface: left, size: 10 mm, distance: 5 mm}]", "a mesh already, to which 'mesh.sizes' does not apply"),
    "another mesh": ("cube.vtu", "[{surface: left, size: 10 mm, distance: 5 mm}]", "a mesh already, to which 'mesh.sizes' does not apply"),
    "own mesh": ("cube.h5", "[{surface: left, size: 10 mm, distance: 5 mm}]", "a mesh already, to which 'mesh.sizes' does not apply"),
    "size of a mesh": ("cube.msh", "", "a mesh already, to which 'size' does not apply"),
    "size of own mesh": ("cube.h5", "", "a mesh already, to which 'size' does not apply"),
    "two groups": ("cube.geo", "[{surface: left, curve: edge, size: 10 mm, distance: 5 mm}]", "only one of surface, curve can be given"),
    "no distance": ("cube.geo", "[{surface: left, size: 10 mm}]", "distance"),
}


def edges(path):
    """Midpoints and lengths of all edges of the mesh of a result."""
    with h5py.File(path) as file:
        points, cells = file["mesh/coordinates"][()], file["mesh/cells"][()][:, :4]
    pairs = np.unique(np.sort(cells[:, [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]].reshape(-1, 2), axis=1), axis=0)
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    return (a + b) / 2, np.linalg.norm(b - a, axis=1)


class LocalSizes(MistakesTest):
    def setUp(self):
        super().setUp()
        self.write("cube.geo", GEOMETRY)

    def input_for(self, name, file, sizes):
        return self.write(name + ".yaml", INPUT.format(file=file, name=name, sizes=f", sizes: {sizes}" if sizes else "")).name

    def test_are_those_asked_for(self):
        cases = {"uniform": "", **{name: sizes for name, (sizes, _) in SIZES.items()}}
        keeping = {"XDG_CACHE_HOME": str(self.directory / "cache")}

        def run(name):
            file = self.input_for(name, "cube.geo", cases[name])
            return [finish(start(["run", file], self.directory, 1, keeping), 120) for _ in range(2 if name == "surface" else 1)]
        done = dict(zip(cases, self.pool.map(run, cases)))
        for name, results in done.items():
            for result in results:
                self.assertEqual(result.returncode, 0, f"{name}: {result.stdout}{result.stderr}")
            self.assertNotIn("that of an earlier run", results[0].stdout, name)
        self.assertIn("that of an earlier run", done["surface"][1].stdout)
        found = {name: edges(self.directory / f"out-{name}/result.h5") for name in cases}

        def mean(name, there):
            middle, length = found[name]
            self.assertGreater(there(middle).sum(), 3, name)
            return length[there(middle)].mean()
        x, y, z = 0, 1, 2
        self.assertGreater(mean("uniform", lambda p: p[:, x] < 1e-9), 0.2)
        for name in ("surface", "number"):
            self.assertAlmostEqual(mean(name, lambda p: p[:, x] < 1e-9) / 0.06, 1.0, delta=0.15)
            self.assertAlmostEqual(mean(name, lambda p: abs(p[:, x] - 0.15) < 0.05) / 0.18, 1.0, delta=0.25)  # half of the way
            self.assertGreater(mean(name, lambda p: p[:, x] > 0.6), 0.2)
        np.testing.assert_array_equal(found["surface"][1], found["number"][1])
        # Curve 10 of the box: the one at which the fine edges lie, along one axis.
        middle, length = found["curve"]
        fine = middle[np.argsort(length)[:10]]
        self.assertEqual((np.ptp(fine, axis=0) < 0.1).sum(), 2)
        self.assertLess(np.sort(length)[:10].mean(), 0.045)
        self.assertGreater(np.median(length), 0.08)
        self.assertLess(mean("point", lambda p: np.linalg.norm(p - np.array([0, 0, 1]), axis=1) < 0.05), 0.045)
        self.assertAlmostEqual(mean("point", lambda p: p[:, x] > 1 - 1e-9) / 0.15, 1.0, delta=0.15)
        self.assertGreater(mean("point", lambda p: abs(p[:, x] - 0.75) < 0.1), 0.2)

    def test_are_refused_where_they_make_no_sense(self):
        self.write("cube.msh", "$MeshFormat\n")
        self.write("cube.vtu", "<VTKFile>\n")
        self.write("cube.h5", "nothing\n")
        cases = {}
        for name, (file, sizes, words) in REFUSED.items():
            source = self.input_for(name.replace(" ", "_"), file, sizes)
            cases[name] = (self.directory, ["check", source], 2, None, words)
        self.judge_all(cases, {1: 1, 2: 4})


if __name__ == "__main__":
    unittest.main()
