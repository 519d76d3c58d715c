"""The meshes that come with Pliant: gmsh makes good ones of the geometries, tools/beam_mesh.py writes right ones."""
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRIANGLE, TETRAHEDRON = 2, 4
EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]


def read_msh(file):
    """Vertices, and {group name: its triangles or tetrahedra}, of a gmsh 2.2 text file."""
    sections = {}
    lines = iter(file.read_text().splitlines())
    for line in lines:
        body = sections[line] = []
        for text in lines:
            if text.startswith("$End"):
                break
            body.append(text)
    names = {tuple(map(int, row.split()[:2])): row.split()[2].strip('"') for row in sections["$PhysicalNames"][1:]}
    nodes = np.array([row.split() for row in sections["$Nodes"][1:]], dtype=float)
    row_of = {int(number): row for row, number in enumerate(nodes[:, 0])}
    groups = {name: [] for name in names.values()}
    for row in sections["$Elements"][1:]:
        _, kind, num_tags, tag, *rest = map(int, row.split())
        if kind in (TRIANGLE, TETRAHEDRON):
            name = names[2 if kind == TRIANGLE else 3, tag]
            groups[name].append([row_of[number] for number in rest[num_tags - 1:]])
    return nodes[:, 1:], {name: np.array(elements) for name, elements in groups.items()}


def volumes(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.linalg.det(edges) / 6


def mean_ratio(points, cells):
    squares = sum(((points[cells[:, a]] - points[cells[:, b]]) ** 2).sum(axis=1) for a, b in EDGES)
    return 12 * (3 * np.abs(volumes(points, cells))) ** (2 / 3) / squares


def boundary(cells):
    """Facets of one tetrahedron only, as sorted rows."""
    facets = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    rows, counts = np.unique(facets, axis=0, return_counts=True)
    return {tuple(row) for row in rows[counts == 1]}


def run(*command):
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True).stdout


class Meshes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def of_geometry(self, name):
        file = self.folder / "mesh.msh"
        log = run("gmsh", "-3", "-nt", "1", ROOT / "meshes" / name, "-o", file, "-format", "msh22")
        self.assertNotIn("Warning", log)
        return read_msh(file)

    def of_generator(self, *options):
        file = self.folder / "beam.msh"
        run(ROOT / "tools/beam_mesh.py", *options, "-o", file)
        return file

    def test_gripper_finger(self):
        points, groups = self.of_geometry("gripper_finger.geo")
        cells = groups["finger"]
        self.assertGreaterEqual(len(cells), 20000)
        self.assertGreater(mean_ratio(points, cells).min(), 0.1)
        outside = boundary(cells)
        for name in ("mount", "pad", "tip", "inside"):
            facets = {tuple(row) for row in np.sort(groups[name], axis=1)}
            self.assertTrue(facets and facets <= outside, name)
        self.assertEqual(np.abs(points[groups["mount"]][..., 0]).max().round(9), 0)
        self.assertEqual(np.abs(points[groups["pad"]][..., 2]).max().round(9), 0)
        # Every chamber's wall is inside: its area is far larger than the channel's alone.
        corners = points[groups["inside"]]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
        self.assertGreater(area, 6000)

    def test_cantilever(self):
        points, groups = self.of_geometry("cantilever.geo")
        self.assertAlmostEqual(np.abs(volumes(points, groups["beam"])).sum(), 0.04, delta=1e-12)
        self.assertAlmostEqual(points[groups["tip"]][..., 0].min(), 1.0, delta=1e-12)

    def test_generated_beam(self):
        points, groups = read_msh(self.of_generator("--n", "5", "4", "3", "--box", "1", "0.8", "0.6"))
        cells = groups["beam"]
        self.assertEqual((len(points), len(cells), len(groups["clamp"])), (6 * 5 * 4, 5 * 4 * 3 * 6, 4 * 3 * 2))
        np.testing.assert_allclose(volumes(points, cells), 0.2**3 / 6, rtol=1e-12)  # positive, too
        # Conforming: the boundary has two triangles per brick face. Diagonal: each tetrahedron spans its brick.
        self.assertEqual(len(boundary(cells)), 2 * 2 * (5 * 4 + 4 * 3 + 5 * 3))
        np.testing.assert_allclose(np.ptp(points[cells], axis=1), 0.2, rtol=1e-12)
        np.testing.assert_allclose(points[cells].max(axis=1) - points[cells[:, 3]], 0, atol=1e-15)
        self.assertLessEqual({tuple(row) for row in np.sort(groups["clamp"], axis=1)}, boundary(cells))

    def test_binary_is_the_same_as_text(self):
        points, groups = read_msh(self.of_generator("--n", "3", "2", "2"))
        binary = self.of_generator("--n", "3", "2", "2", "--binary")
        run("gmsh", "-0", binary, "-o", self.folder / "again.msh", "-format", "msh22")
        points_again, groups_again = read_msh(self.folder / "again.msh")  # gmsh numbers the vertices anew
        for name, elements in groups.items():
            # Positions are sums of tenths and thirds: twelve digits tell them apart.
            wanted = sorted(map(tuple, points[elements].round(12).reshape(len(elements), -1).tolist()))
            found = points_again[groups_again[name]].round(12).reshape(len(elements), -1).tolist()
            self.assertEqual(sorted(map(tuple, found)), wanted)

    def test_small_beam_is_what_the_generator_writes(self):
        file = self.of_generator("--n", "30", "6", "6", "--binary")
        self.assertEqual(file.read_bytes(), (ROOT / "meshes/beam_small.msh").read_bytes())


if __name__ == "__main__":
    unittest.main()
