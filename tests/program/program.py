"""What the tests of the built program share: running it on any number of ranks, reading what it writes, meshes to feed it.

The program is the file that the environment variable PLIANT names, or else build/bin/pliant.
"""
import csv
import itertools
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import beam_mesh  # noqa: E402

PROGRAM = pathlib.Path(os.environ.get("PLIANT", ROOT / "build/bin/pliant")).resolve()
LONG = bool(os.environ.get("PLIANT_LONG_TESTS"))  # everything, where otherwise a part is run
ENVIRONMENT = {
    **os.environ,
    "OMP_NUM_THREADS": "1",
    "XDG_CACHE_HOME": os.devnull,  # no mesh is kept
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}
# When a rank ends with an error, mpirun waits so long for the others, which have ended too; after a signal they need it.
UNSIGNALLED = {"OMPI_MCA_odls_base_sigkill_timeout": "0"}
ENVIRONMENT.pop("DISPLAY", None)  # MPI asks an X server for its graphics cards, and fails with it

LINE, TRIANGLE, TETRAHEDRON, TRIANGLE_6, TETRAHEDRON_10 = 1, 2, 4, 9, 11  # gmsh's element types
SIDES = ("left", "right", "front", "back", "bottom", "top")  # surfaces of a box: x, y, z, each at its low and high end


long_test = unittest.skipUnless(LONG, "PLIANT_LONG_TESTS is not set")


def swept(values, usually):
    """All values of a sweep with PLIANT_LONG_TESTS; otherwise those that are `usually` run, some of them."""
    missing = [value for value in usually if value not in values]
    assert not missing, f"{missing} are not among {values}"
    return values if LONG else usually


ALL_OR_SOME = "all" if LONG else "bdf2,dirk23,dirk33"  # methods of a study of order


def command(arguments, ranks=1):
    call = [str(PROGRAM), *map(str, arguments)]
    return call if ranks == 1 else ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *call]


def start(arguments, directory, ranks=1, environment=None):
    """The program, going; in a process group of its own."""
    return subprocess.Popen(command(arguments, ranks), cwd=directory, env=ENVIRONMENT | (environment or {}), text=True,
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def finish(process, timeout):
    """Exit code and both outputs; a program that hangs is ended, with all its ranks."""
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
        raise AssertionError(f"{process.args} hangs; it has written:\n{out}{err}") from None
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def ranks_of(mpirun):
    """Process ids of the ranks that this mpirun started."""
    found = []
    for directory in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parent = int((directory / "stat").read_text().rsplit(")", 1)[1].split()[1])
            if parent == mpirun and (directory / "exe").resolve() == PROGRAM:
                found.append(int(directory.name))
        except (OSError, ValueError):
            continue  # gone, or not ours
    return found


def read_history(directory):
    """Columns of history.csv by name."""
    with open(pathlib.Path(directory) / "history.csv", encoding="ascii", newline="") as file:
        names, *rows = csv.reader(file)
    return dict(zip(names, np.array(rows, dtype=float).T))


def write_cube(file, low, high):
    """A box as an .stl file: a closed surface of twelve triangles."""
    low, high = np.array(low, float), np.array(high, float)
    with open(file, "w") as out:
        out.write("solid cube\n")
        for axis, side in itertools.product(range(3), (0, 1)):
            j, k = (axis + 1) % 3, (axis + 2) % 3
            corners = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                x = np.empty(3)
                x[axis], x[j], x[k] = (low, high)[side][axis], (low, high)[a][j], (low, high)[b][k]
                corners.append(x)
            if side == 0:
                corners.reverse()
            for triangle in ((0, 1, 2), (0, 2, 3)):
                out.write("facet normal 0 0 0\nouter loop\n")
                for c in triangle:
                    out.write("vertex {:.17g} {:.17g} {:.17g}\n".format(*corners[c]))
                out.write("endloop\nendfacet\n")
        out.write("endsolid cube\n")


class ProgramTest(unittest.TestCase):
    """A test with a directory of its own."""

    def setUp(self):
        self.assertTrue(PROGRAM.exists(), f"{PROGRAM} is not built")
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="pliant-program-"))
        self.addCleanup(shutil.rmtree, self.directory)

    def write(self, name, text):
        path = self.directory / name
        path.write_text(text, encoding="utf-8")
        return path

    def call(self, *arguments, ranks=1, timeout=300):
        return finish(start(arguments, self.directory, ranks, UNSIGNALLED), timeout)

    def pliant(self, *arguments, ranks=1, status=0):
        done = self.call(*arguments, ranks=ranks, timeout=300)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done

    def solve(self, text, time, ranks=1, more=()):
        """The history of an input with these keys of `time`, and a frame at every step."""
        self.write("in.yaml", text + f"time: {{{time}}}\noutput: {{every: 1}}\n")
        return self.run_input("in.yaml", *more, ranks=ranks)

    def run_input(self, file, *settings, ranks=1, output="out", options=(), timeout=300):
        """Runs an input that must succeed; returns its history. `settings`: KEY.PATH=VALUE."""
        arguments = ["run", file, "--quiet", "-o", output]
        for setting in settings:
            arguments += ["--set", setting]
        done = self.call(*arguments, *(["--", *options] if options else []), ranks=ranks, timeout=timeout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return read_history(self.directory / output)

    def assert_refused(self, cases):
        """Inputs by what is said of each: they end with 2, and the message has a place in the input."""
        for message, wrong in cases.items():
            with self.subTest(message):
                self.write("in.yaml", wrong)
                done = self.call("run", "in.yaml")
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)
                self.assertRegex(done.stderr, r"in\.yaml:\d+:\d+: ")

    def assert_same_history(self, a, b, tolerance):
        """All columns agree, measured by the largest value of their kind, to a part of `tolerance`."""
        self.assertEqual(list(a), list(b))
        for names in kinds(a):
            scale = max(np.abs(a[name]).max() for name in names)
            for name in names:
                difference = np.abs(a[name] - b[name]).max()
                self.assertLessEqual(difference, tolerance * scale, f"column {name} of kind {names}")


def kinds(history):
    """Columns grouped by what they measure; components that are zero but for rounding are measured by their neighbours."""
    books = ("load_potential", "load_work", "support_work", "numerical_dissipation", "energy_balance_error")
    energies = [n for n in history if n.endswith("_energy") or n.startswith("dissipated_") or n in books]
    groups = [energies, ["px", "py", "pz"], ["Lx", "Ly", "Lz"]]
    plain = ["step", "time", "dt"]
    groups += [[name] for name in plain]
    counted = {"newton_iterations", "linear_iterations"}  # may differ where rounding decides
    rest = [n for n in history if n not in counted and not any(n in g for g in groups)]
    # Place, velocity, force with torque (bodies are about a metre large), impulse, rotation, angular velocity.
    for letters in (("",), ("u",), ("v",), ("f", "t"), ("j",), ("q",), ("w",)):
        suffixes = [f"_{letter}{axis}" for letter in letters for axis in "xyz"]
        for first in [n for n in rest if n.endswith(suffixes[0])]:
            stem = first[: -len(suffixes[0])]
            groups.append([stem + suffix for suffix in suffixes if stem + suffix in history])
            rest = [n for n in rest if n not in groups[-1]]
    return groups + [[name] for name in rest]


def box(n, size=(1.0, 1.0, 1.0), origin=(0.0, 0.0, 0.0), order=1, shape=None):
    """A box of n[0] x n[1] x n[2] bricks, each of six tetrahedra: points, triangles per side, tetrahedra.

    `order` 2 adds the nodes on the edges. `shape` maps points of the box to where they are wanted, shape (..., 3).
    """
    points = beam_mesh.vertices(n, size)
    cells = beam_mesh.tetrahedra(n).astype(np.int64)
    faces = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    faces, counts = np.unique(faces, axis=0, return_counts=True)
    boundary = faces[counts == 1]
    triangles = []
    for axis, end in itertools.product(range(3), (0.0, 1.0)):
        there = np.abs(points[:, axis] - end * size[axis]) < 1e-9 * size[axis]
        triangles.append(boundary[there[boundary].all(axis=1)])
    if order == 2:
        points, cells, triangles = with_edge_nodes(points, cells, triangles)
    points = points + np.array(origin)
    return (points if shape is None else shape(points)), triangles, cells


def with_edge_nodes(points, cells, triangles):
    """Quadratic tetrahedra and triangles with gmsh's order of nodes, edges straight in the box."""
    of_cell = [(0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1)]
    of_triangle = [(0, 1), (1, 2), (2, 0)]
    edges, inverse = np.unique(np.sort(cells[:, of_cell].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    number = {tuple(edge): len(points) + k for k, edge in enumerate(edges.tolist())}

    def completed(triangle):
        return [*triangle, *(number[tuple(sorted((triangle[i], triangle[j])))] for i, j in of_triangle)]

    quadratic = [np.array([completed(t) for t in side.tolist()]) for side in triangles]
    cells = np.hstack([cells, inverse.reshape(-1, 6) + len(points)])
    return np.vstack([points, points[edges].mean(axis=1)]), cells, quadratic


def write_mesh(path, points, triangles, cells, volumes=None):
    """A gmsh 2.2 text file with volume `body` (tag 7) and the sides; `volumes`: names and the volume of each cell."""
    names, volume_of_cell = volumes or (["body"], np.zeros(len(cells), dtype=int))
    quadratic = cells.shape[1] == 10
    groups = [f'2 {k + 1} "{name}"' for k, name in enumerate(SIDES)]
    groups += [f'3 {k + 7} "{name}"' for k, name in enumerate(names)]
    elements = []
    for k, side in enumerate(triangles):
        kind = TRIANGLE_6 if quadratic else TRIANGLE
        elements += [f"{kind} 2 {k + 1} {k + 1} " + " ".join(map(str, t + 1)) for t in side]
    kind = TETRAHEDRON_10 if quadratic else TETRAHEDRON
    elements += [f"{kind} 2 {v + 7} {v + 7} " + " ".join(map(str, c + 1)) for v, c in zip(volume_of_cell, cells)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups)), *groups, "$EndPhysicalNames",
             "$Nodes", str(len(points)), *(f"{k + 1} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(points.tolist())),
             "$EndNodes", "$Elements", str(len(elements)), *(f"{k + 1} {e}" for k, e in enumerate(elements)),
             "$EndElements", ""]
    pathlib.Path(path).write_text("\n".join(lines), encoding="ascii")
    return path


def write_box(path, n, size=(1.0, 1.0, 1.0), **more):
    return write_mesh(path, *box(n, size, **more))
