"""What a result of Pliant holds, as numpy arrays; and its surface, fine enough to show the curved faces of quadratic elements.

Read with h5py straight from result.h5, also while the run that writes it goes on.
"""
import dataclasses
import os
import time

import h5py
import numpy as np


class UserError(Exception):
    """A mistake of the user; its text is the one line to print."""


@dataclasses.dataclass(frozen=True)
class Frame:
    """One instant of the time series."""

    name: str  # its group in result.h5
    time: float  # [s]
    step: int
    mesh: str  # the group of its mesh


@dataclasses.dataclass(frozen=True)
class Mesh:
    """Tetrahedra in VTK's node order."""

    coordinates: np.ndarray  # num_nodes x 3, reference positions [m]
    cells: np.ndarray  # num_cells x 4 or 10
    body: np.ndarray  # index of the body of each cell
    body_names: list


@dataclasses.dataclass(frozen=True)
class Obstacles:
    """The surfaces of obstacles, and where they are in a frame."""

    points: np.ndarray  # num_points x 3, current positions [m]
    triangles: np.ndarray  # num_triangles x 3, counterclockwise seen from outside
    obstacle: np.ndarray  # index of the obstacle of each triangle
    names: list

    def planes(self):
        """The four points of each plane's square, in order around it: two triangles, where what is closed has more."""
        found = [self.triangles[self.obstacle == k] for k in range(len(self.names))]
        return [np.append(triangles[0], triangles[1, 2]) for triangles in found if len(triangles) == 2]

    def points_of_others(self):
        """Positions of what is no plane."""
        count = np.bincount(self.obstacle, minlength=len(self.names))
        return self.points[np.unique(self.triangles[count[self.obstacle] != 2])]


@dataclasses.dataclass(frozen=True)
class Field:
    """Values on nodes or cells."""

    values: np.ndarray  # rows x components
    unit: str
    on_nodes: bool


def von_mises(stress):
    """sqrt(3/2 s:s), s the deviator, of symmetric tensors (xx yy zz xy yz xz)."""
    xx, yy, zz, xy, yz, xz = stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(normal / 2 + 3 * (xy**2 + yz**2 + xz**2))


class Result:
    """An open result.h5."""

    def __init__(self, path):
        self.directory, file = self._find(path)
        self._h5 = self._open(file)
        if "frames" not in self._h5 or "mesh" not in self._h5:
            raise UserError(f"{file} is not a result of Pliant")
        self.title = str(_text(self._h5.attrs.get("title", "")))
        self.frames = [
            Frame(name, float(group.attrs["time"]), int(group.attrs["step"]), _text(group.attrs.get("mesh", "/mesh")))
            for name, group in sorted(self._h5["frames"].items())
        ]
        if not self.frames:
            raise UserError(f"{file} holds no frame yet")
        self._meshes = {}

    @staticmethod
    def _find(path):
        if os.path.isdir(path):
            path = os.path.join(path, "result.h5")
        elif path.endswith(".xdmf"):
            path = path[: -len(".xdmf")] + ".h5"
        if not os.path.isfile(path):
            raise UserError(f"there is no result: {path} does not exist")
        return os.path.dirname(os.path.abspath(path)), path

    @staticmethod
    def _open(file):
        # A run that is just adding a frame may be met between two of its writes; a moment later all is well.
        for attempt in range(5):
            try:
                return h5py.File(file, "r")
            except OSError as error:
                reason = str(error)
                time.sleep(0.2 * attempt)
        raise UserError(f"{file} cannot be read: {reason}")

    def mesh(self, frame):
        if frame.mesh not in self._meshes:
            group = self._h5[frame.mesh]
            names = _text(group["body"].attrs.get("names", "")).split("\n")
            self._meshes[frame.mesh] = Mesh(group["coordinates"][()], group["cells"][()], group["body"][()], names)
        return self._meshes[frame.mesh]

    def field_names(self, frame):
        """Names that `field` knows, those in the file first."""
        names = sorted(self._h5["frames"][frame.name])
        if "cauchy_stress" in names and "von_mises_stress" not in names:
            names.append("von_mises_stress")
        return names + ["body", "rank"]

    def field(self, frame, name):
        group = self._h5["frames"][frame.name]
        if name in group:
            dataset = group[name]
            on_nodes = _text(dataset.attrs.get("location", "node")) == "node"
            values = dataset[()]
            return Field(values.reshape(len(values), -1), _text(dataset.attrs.get("unit", "")), on_nodes)
        if name == "von_mises_stress" and "cauchy_stress" in group:
            stress = self.field(frame, "cauchy_stress")
            return Field(von_mises(stress.values)[:, None], stress.unit, stress.on_nodes)
        if name in ("body", "rank"):
            return Field(self._h5[frame.mesh][name][()].astype(float)[:, None], "", False)
        known = ", ".join(self.field_names(frame))
        raise UserError(f"the result has no field '{name}'; it has {known}")

    def obstacles(self, frame):
        """Where they are; None if the run had none."""
        path = frame.mesh.replace("mesh", "obstacles")
        if path not in self._h5:
            return None
        group = self._h5[path]
        moved = f"frames/{frame.step:06}/points"
        names = _text(group["obstacle"].attrs["names"]).split("\n")
        return Obstacles(group[moved if moved in group else "points"][()], group["triangles"][()], group["obstacle"][()], names)

    def displacement(self, frame):
        """Zero where the result has none."""
        if "displacement" in self._h5["frames"][frame.name]:
            return self.field(frame, "displacement").values
        return np.zeros_like(self.mesh(frame).coordinates)


def _text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


# The faces of a tetrahedron, seen from outside counterclockwise: corners, then the nodes on the sides 01, 12, 20.
_FACES = np.array([[0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9], [0, 2, 1, 6, 5, 4]])


class Surface:
    """The outer faces of a mesh, each divided into `divisions`^2 triangles, with points shared between neighbours.

    Everything is topology: `positions`, `of_nodes` and `of_cells` turn nodal and cell values into values at the points, for any
    frame.
    """

    def __init__(self, mesh, divisions=None):
        rng = np.random.default_rng(0)
        # Sums of random 64-bit numbers name sets of nodes: equal sets have equal sums, others practically never.
        self._label = rng.integers(1, 2**63, size=len(mesh.coordinates), dtype=np.uint64)
        self._mesh = mesh
        quadratic = mesh.cells.shape[1] == 10
        faces, self.cell_of_face = self._outer_faces(mesh.cells)
        if divisions is None:
            divisions = 1 if not quadratic else 4 if len(faces) < 40_000 else 2
        self._n = divisions
        self._divide(faces if quadratic else faces[:, :3])

    def _outer_faces(self, cells):
        corners = cells[:, _FACES[:, :3]].reshape(-1, 3)
        names = self._label[corners].sum(axis=1, dtype=np.uint64)
        _, first, count = np.unique(names, return_index=True, return_counts=True)
        outer = np.sort(first[count == 1])
        cell, face = np.divmod(outer, 4)
        width = 6 if cells.shape[1] == 10 else 3
        return cells[cell[:, None], _FACES[face][:, :width]], cell

    def _divide(self, faces):
        n = self._n
        lattice = np.array([(n - i - j, i, j) for j in range(n + 1) for i in range(n + 1 - j)])
        at = {tuple(b): k for k, b in enumerate(lattice)}
        triangles = []
        for j in range(n):
            for i in range(n - j):
                a, b, c = (n - i - j, i, j), (n - i - j - 1, i + 1, j), (n - i - j - 1, i, j + 1)
                triangles.append([at[a], at[b], at[c]])
                if i + j < n - 1:
                    triangles.append([at[b], at[(n - i - j - 2, i + 1, j + 1)], at[c]])
        # A point is named by its corner nodes, each as often as its share in n: the same from each face it lies on.
        names = (self._label[faces[:, None, :3]] * lattice[None].astype(np.uint64)).sum(axis=2, dtype=np.uint64)
        _, first, point = np.unique(names.ravel(), return_index=True, return_inverse=True)
        point = point.reshape(names.shape)
        face, position = np.divmod(first, len(lattice))
        self._nodes = faces[face]
        self._weights = _shape_functions(lattice / n, faces.shape[1])[position]
        self.triangles = point[:, triangles].reshape(-1, 3)
        self.face_of_triangle = np.repeat(np.arange(len(faces)), len(triangles))
        sides = [[at[(n - k, k, 0)] for k in range(n + 1)], [at[(0, n - k, k)] for k in range(n + 1)],
                 [at[(k, 0, n - k)] for k in range(n + 1)]]
        lines = point[:, sides].reshape(-1, n + 1)
        ends = np.sort(lines[:, [0, -1]], axis=1)
        _, first = np.unique(ends, axis=0, return_index=True)
        self.element_edges = lines[first]

    def of_nodes(self, values):
        """Nodal values (rows x components) at the points."""
        return np.einsum("pk,pkc->pc", self._weights, values[self._nodes])

    def of_cells(self, values):
        """Cell values at the points: first averaged to the nodes, weighted by volume."""
        corners = self._mesh.cells[:, :4]
        a, b, c, d = (self._mesh.coordinates[corners[:, i]] for i in range(4))
        volume = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))
        num_nodes = len(self._mesh.coordinates)
        nodes = self._mesh.cells.ravel()
        weight = np.repeat(volume, self._mesh.cells.shape[1])
        total = np.bincount(nodes, weight, num_nodes)
        total[total == 0] = 1
        at_nodes = np.stack(
            [np.bincount(nodes, weight * np.repeat(column, self._mesh.cells.shape[1]), num_nodes) / total
             for column in values.T], axis=1)
        return self.of_nodes(at_nodes)


def _shape_functions(barycentric, num_nodes):
    """Values of the linear or quadratic triangle's shape functions: points x num_nodes."""
    if num_nodes == 3:
        return barycentric
    corner = barycentric * (2 * barycentric - 1)
    a, b, c = barycentric.T
    return np.column_stack([corner, 4 * a * b, 4 * b * c, 4 * c * a])
