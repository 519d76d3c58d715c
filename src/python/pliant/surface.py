"""The outer surface of a mesh, fine enough to show the curved faces of quadratic elements."""
from typing import Optional

import numpy as np

from .checks import array_of, short
from .error import InputError
from .parts import Mesh

# The faces of a tetrahedron, seen from outside counterclockwise: corners, then the nodes on the sides 01, 12, 20.
_FACES = np.array([[0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9], [0, 2, 1, 6, 5, 4]])

_OPPOSITE = np.array([1, 2, 0, 3])  # the face that does not have this corner


class Surface:
    """The outer faces of a mesh, or of some of its cells, each divided into `divisions`^2 triangles, with points shared between
    neighbours.

    A body that is only a mass (`Mesh.masses`) is the ellipsoid with its moments of inertia. Rods (`Mesh.rods`) have no surface.
    Free shells (`Mesh.shells`) are their triangles, which are seen from both sides.

    Everything is topology: `positions`, `of_nodes` and `of_cells` turn nodal and cell values into values at the points, for any
    frame.
    """

    def __init__(self, mesh: Mesh, divisions: Optional[int] = None, *, cells: Optional[np.ndarray] = None) -> None:
        """`cells`: numbers of those whose outside is meant, such as `np.nonzero(mesh.body == 1)[0]`; default: all."""
        if not isinstance(mesh, Mesh):
            raise InputError(f"Surface: a mesh is expected, such as result.mesh(), not {short(mesh)}")
        if divisions is not None and (not isinstance(divisions, (int, np.integer)) or divisions < 1):
            raise InputError(f"divisions: a whole number from 1 is expected, not {short(divisions)}")
        rng = np.random.default_rng(0)
        # Sums of random 64-bit numbers name sets of nodes: equal sets have equal sums, others practically never.
        self._label = rng.integers(1, 2**63, size=len(mesh.coordinates), dtype=np.uint64)
        self._mesh = mesh
        self._cells = np.arange(len(mesh.cells)) if cells is None else _numbers_of(cells, len(mesh.cells))
        quadratic = mesh.cells.shape[1] == 10
        is_mass, is_rod = (np.isin(np.array(mesh.body_names), names)[mesh.body[self._cells]] for names in (mesh.masses, mesh.rods + mesh.sections))
        of_mesh, masses = self._cells[~(is_mass | is_rod)], self._cells[is_mass]
        is_shell = np.isin(np.array(mesh.body_names), mesh.shells)[mesh.body[of_mesh]]
        faces, cell = self._outer_faces(mesh.cells[of_mesh], is_shell)
        self.cell_of_face = of_mesh[cell]
        if divisions is None:
            divisions = 1 if not quadratic else 4 if len(faces) < 40_000 else 2
        self.divisions = divisions  #: of each side of a face
        self._divide(faces if quadratic else faces[:, :3])
        if len(masses) > 0:
            self._add_ellipsoids(masses)

    def _outer_faces(self, cells: np.ndarray, is_shell: np.ndarray) -> "tuple[np.ndarray, np.ndarray]":
        corners = cells[:, _FACES[:, :3]].reshape(-1, 3)
        names = self._label[corners].sum(axis=1, dtype=np.uint64)
        _, first, count = np.unique(names, return_index=True, return_counts=True)
        outer = np.sort(first[count == 1])
        cell, face = np.divmod(outer, 4)
        # The apex of a shell's cell belongs to no other cell and is nearest to the middle; the triangle lies opposite to it.
        of_shells = cells[is_shell, :4]
        places = self._mesh.coordinates[of_shells]
        distance = np.linalg.norm(places - places.mean(axis=1, keepdims=True), axis=2)
        num_cells = np.bincount(self._mesh.cells[:, :4].ravel(), minlength=len(self._mesh.coordinates))
        apex = np.where(num_cells[of_shells] == 1, distance, np.inf).argmin(axis=1)
        opposite = np.full(len(cells), -1)
        opposite[is_shell] = _OPPOSITE[apex]
        drawn = ~is_shell[cell] | (face == opposite[cell])
        cell, face = cell[drawn], face[drawn]
        width = 6 if cells.shape[1] == 10 else 3
        return cells[cell[:, None], _FACES[face][:, :width]], cell

    def _divide(self, faces: np.ndarray) -> None:
        n = self.divisions
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

    def _add_ellipsoids(self, cells: np.ndarray) -> None:
        """The unit sphere, as the corners (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1) around it are mapped to those of each body: nodes
        that belong to one cell."""
        mesh, tetrahedra = self._mesh, []
        bodies, firsts = np.unique(mesh.body[cells], return_index=True)
        for body in bodies:
            nodes, count = np.unique(mesh.cells[cells[mesh.body[cells] == body], :4], return_counts=True)
            tetrahedra.append(nodes[count == 1])
        cells, tetrahedra = cells[firsts], np.array(tetrahedra)
        sphere, triangles = _sphere()
        weights = (1 + sphere @ np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]).T) / 4
        width = max(self._nodes.shape[1], 4)
        padding = [(0, 0), (0, width - self._nodes.shape[1])]
        corners = np.pad(tetrahedra, [(0, 0), (0, width - 4)], mode="edge")
        first = len(self._nodes) + len(sphere) * np.arange(len(cells))
        self._nodes = np.vstack([np.pad(self._nodes, padding, mode="edge"), np.repeat(corners, len(sphere), axis=0)])
        self._weights = np.vstack([np.pad(self._weights, padding), np.tile(np.pad(weights, [(0, 0), (0, width - 4)]), (len(cells), 1))])
        a, b, c, d = (mesh.coordinates[tetrahedra[:, k]] for k in range(4))
        mirrored = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) * np.linalg.det([[0, -2, -2], [-2, 0, -2], [-2, -2, 0]]) < 0
        for start, is_mirrored in zip(first, mirrored):
            self.triangles = np.vstack([self.triangles, start + (triangles[:, ::-1] if is_mirrored else triangles)])
        faces = len(self.cell_of_face) + np.arange(len(cells))
        self.cell_of_face = np.append(self.cell_of_face, cells)
        self.face_of_triangle = np.append(self.face_of_triangle, np.repeat(faces, len(triangles)))

    def of_nodes(self, values: np.ndarray) -> np.ndarray:
        """Nodal values (rows x components) at the points, interpolated by the shape functions of the elements, as positions are. Those of
        quadratic elements overshoot: between nodes with the values 0, 0 and 1 they are negative."""
        values = array_of(values, "nodal values", (len(self._mesh.coordinates), None))
        return np.einsum("pk,pkc->pc", self._weights, values[self._nodes])

    def field_of_nodes(self, values: np.ndarray) -> np.ndarray:
        """Nodal values (rows x components) at the points as `of_nodes` has them, but not beyond those of the nodes around each point: for
        fields, which would otherwise seem to have values that occur nowhere."""
        values = array_of(values, "nodal values", (len(self._mesh.coordinates), None))
        of_nodes, around = values[self._nodes], (self._weights != 0)[..., None]
        low = np.where(around, of_nodes, np.inf).min(axis=1)
        high = np.where(around, of_nodes, -np.inf).max(axis=1)
        return np.clip(self.of_nodes(values), low, high)

    def of_cells(self, values: np.ndarray) -> np.ndarray:
        """Cell values at the points: first averaged to the nodes, then as `field_of_nodes`."""
        return self.field_of_nodes(self.nodal_means(values))

    def nodal_means(self, values: np.ndarray) -> np.ndarray:
        """Cell values averaged to the nodes of the mesh, weighted by volume; 0 away from the cells of the surface."""
        values = array_of(values, "cell values", (len(self._mesh.cells), None))
        cells = self._mesh.cells[self._cells]
        corners = cells[:, :4]
        a, b, c, d = (self._mesh.coordinates[corners[:, i]] for i in range(4))
        volume = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))
        num_nodes = len(self._mesh.coordinates)
        nodes = cells.ravel()
        weight = np.repeat(volume, cells.shape[1])
        total = np.bincount(nodes, weight, num_nodes)
        total[total == 0] = 1
        return np.stack(
            [np.bincount(nodes, weight * np.repeat(column, cells.shape[1]), num_nodes) / total
             for column in values[self._cells].T], axis=1)


def _numbers_of(cells: object, count: int) -> np.ndarray:
    """Numbers of cells, below `count`."""
    numbers = np.asarray(cells)
    if numbers.dtype == bool and numbers.shape == (count,):
        return np.nonzero(numbers)[0]
    if numbers.size == 0:
        numbers = numbers.astype(int)
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer) or np.any((numbers < 0) | (numbers >= count)):
        raise InputError(f"cells: numbers from 0 to {count - 1} are expected, or a boolean for each cell, not {short(cells)}")
    return numbers


def _sphere(divisions: int = 3) -> "tuple[np.ndarray, np.ndarray]":
    """Points of the unit sphere, and triangles between them: an octahedron whose triangles are divided into four, `divisions` times."""
    points = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(divisions):
        a, b, c = triangles.T
        sides = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        ends, number = np.unique(sides, axis=0, return_inverse=True)
        middles = points[ends].sum(axis=1)
        ab, bc, ca = (len(points) + number.ravel()).reshape(3, -1)
        points = np.vstack([points, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        triangles = np.stack([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca], axis=1).reshape(-1, 3)
    return points, triangles


def _shape_functions(barycentric: np.ndarray, num_nodes: int) -> np.ndarray:
    """Values of the linear or quadratic triangle's shape functions: points x num_nodes."""
    if num_nodes == 3:
        return barycentric
    corner = barycentric * (2 * barycentric - 1)
    a, b, c = barycentric.T
    return np.column_stack([corner, 4 * a * b, 4 * b * c, 4 * c * a])
