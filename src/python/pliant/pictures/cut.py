"""Bodies cut open by a plane, and mirrored at planes.

A cut is one of the undeformed shape, so that all frames show the same section: the outside is cut, triangle by triangle, and the
section is drawn, tetrahedron by tetrahedron. Both divide curved elements in the same way, so that no gap is between them. Shells have their
triangles cut only, and rods are left whole.
"""
import dataclasses
import itertools
import re

import numpy as np

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
AXES = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
# Sides that a plane crosses, in their order around the polygon, by the number of corners below it, which come first.
CROSSED = {1: np.array([[0, 1], [0, 2], [0, 3]]), 2: np.array([[0, 2], [0, 3], [1, 3], [1, 2]]), 3: np.array([[0, 3], [1, 3], [2, 3]])}
SIDES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])  # on which a quadratic tetrahedron has its other nodes (VTK's order)


@dataclasses.dataclass(frozen=True)
class Plane:
    """All X with normal . X = offset; without an offset through the middle of the bodies."""

    normal: np.ndarray  # of unit length
    offset: "float | None"  # [m]

    def heights(self, points):
        """Above the plane, along the normal [m]."""
        return points @ self.normal - self.offset

    def reflected(self, points):
        """Images of points, ... x 3."""
        return points - 2 * self.heights(points)[..., None] * self.normal


def _length(text):
    """A number [m], or with a unit of length."""
    number, unit = re.fullmatch(r"(.*?)\s*([a-zµ]*m)?", text).groups()
    if unit is not None and unit not in LENGTHS:
        raise ValueError
    return float(number) * LENGTHS[unit or "m"]


def plane(text):
    """`y`, `y=0.01`, `y=10mm`, `1,0,1=0.02`; ValueError if it is none of these."""
    match = re.fullmatch(r"\s*([xyz]|[^=]+,[^=]+,[^=]+?)\s*(?:=\s*(.+?)\s*)?", text)
    if match is None:
        raise ValueError
    normal = np.array(AXES.get(match[1]) or [float(part) for part in match[1].split(",")], dtype=float)
    offset = None if match[2] is None else _length(match[2])
    length = np.linalg.norm(normal)
    if not (normal.shape == (3,) and 0 < length < np.inf and (offset is None or np.isfinite(offset))):
        raise ValueError
    return Plane(normal / length, offset)


def mirror(text):
    """Like a plane along an axis: `x` or `x=0.01`; without an offset at 0."""
    found = plane(text)
    if not (np.abs(found.normal) == 1).any():
        raise ValueError
    return Plane(np.abs(found.normal), found.offset or 0.0)


class CutSurface:
    """What of a surface (pliant.Surface) is below a plane, and the section of its `cells`; its attributes and functions are those of a
    surface."""

    def __init__(self, whole, mesh, cells, cut):
        self._whole = whole
        points = whole.of_nodes(mesh.coordinates)
        height = cut.heights(points)
        triangles, owner, self._new = _clipped(whole.triangles, height)
        self._inside, section, cell, self._section, outlines = _section_of(mesh, cells, cut, whole.divisions)
        first = len(points) + len(self._new[0])
        self.triangles = np.vstack([triangles, first + section])
        self.face_of_triangle = np.append(whole.face_of_triangle[owner], len(whole.cell_of_face) + np.arange(len(section)))
        self.cell_of_face = np.append(whole.cell_of_face, cell)
        lines = whole.element_edges
        segments = np.stack([lines[:, :-1], lines[:, 1:]], axis=2).reshape(-1, 2)
        self.element_edges = np.vstack([segments[(height[segments] <= 0).all(axis=1)], first + outlines])
        self._keep_used_points()

    def _keep_used_points(self):
        """Those above the plane would be seen by the camera and in the range of colours."""
        self._used, number = np.unique(np.append(self.triangles, self.element_edges), return_inverse=True)
        number = number.ravel()
        self.triangles, self.element_edges = (number[:self.triangles.size].reshape(-1, 3), number[self.triangles.size:].reshape(-1, 2))

    def of_nodes(self, values):
        return self._cut(self._whole.of_nodes(values), self._inside.of_nodes(values))

    def field_of_nodes(self, values):
        return self._cut(self._whole.field_of_nodes(values), self._inside.field_of_nodes(values))

    def of_cells(self, values):
        return self.field_of_nodes(self.nodal_means(values))

    def nodal_means(self, values):
        return self._whole.nodal_means(values)

    def _cut(self, outside, inside):
        return np.concatenate([outside, _between(outside, *self._new), _between(inside, *self._section)])[self._used]


class Lattice:
    """Points in elements, shared between neighbours: the parts of `cells`, each divided into `divisions`^3 tetrahedra, whose faces are those
    that pliant.Surface has. `parts`: their corners, as numbers of points."""

    def __init__(self, mesh, cells, divisions):
        nodes = mesh.cells[cells]
        corners = _divided(divisions)
        barycentric, number = np.unique(corners.reshape(-1, 4), axis=0, return_inverse=True)
        # As in pliant.Surface: a point is named by the corners, each as often as its share.
        labels = np.random.default_rng(0).integers(1, 2**63, size=len(mesh.coordinates), dtype=np.uint64)
        names = (labels[nodes[:, None, :4]] * barycentric[None].astype(np.uint64)).sum(axis=2, dtype=np.uint64)
        _, first, point = np.unique(names.ravel(), return_index=True, return_inverse=True)
        cell, position = np.divmod(first, len(barycentric))
        self._nodes, self._weights = nodes[cell], _shape_functions(barycentric / divisions, nodes.shape[1])[position]
        self.parts = point.reshape(names.shape)[:, number.ravel()].reshape(-1, 4)
        self.cell_of_part = np.repeat(cells, len(corners))

    def of_nodes(self, values):
        return np.einsum("pk,pkc->pc", self._weights, values[self._nodes])

    def field_of_nodes(self, values):
        """Not beyond the values of the nodes around."""
        of_nodes, around = values[self._nodes], (self._weights != 0)[..., None]
        return np.clip(self.of_nodes(values), np.where(around, of_nodes, np.inf).min(axis=1, initial=np.inf), np.where(around, of_nodes, -np.inf).max(axis=1, initial=-np.inf))


def _divided(n):
    """The corners of n^3 tetrahedra that make one, as n times their barycentric coordinates: those of 1 >= x >= y >= z >= 0 that lie in cubes cut
    along their diagonals (Freudenthal's division)."""
    corners = []
    for cube, order in itertools.product(itertools.product(range(n), repeat=3), itertools.permutations(range(3))):
        x = np.array(cube) + np.cumsum(np.vstack([np.zeros(3, dtype=int), np.eye(3, dtype=int)[list(order)]]), axis=0)
        if (x[:, :-1] >= x[:, 1:]).all():
            corners.append(np.column_stack([n - x[:, 0], x[:, 0] - x[:, 1], x[:, 1] - x[:, 2], x[:, 2]]))
    return np.array(corners)


def _shape_functions(barycentric, num_nodes):
    """Values of those of the linear or quadratic tetrahedron: points x num_nodes."""
    if num_nodes == 4:
        return barycentric
    return np.column_stack([barycentric * (2 * barycentric - 1), 4 * barycentric[:, SIDES[:, 0]] * barycentric[:, SIDES[:, 1]]])


def _crossed(mesh, cells, cut):
    """Those of the cells that the plane may cross: the control points of a curved one, around it, are not all on one side."""
    height = cut.heights(mesh.coordinates)[mesh.cells[cells]]
    if height.shape[1] == 10:
        height[:, 4:] = 2 * height[:, 4:] - height[:, SIDES].mean(axis=2)
    return cells[(height.min(axis=1) <= 0) & (height.max(axis=1) > 0)]


def _between(values, pairs, share):
    """Where a share of the way from the first to the second of each pair has been gone."""
    return (1 - share[:, None]) * values[pairs[:, 0]] + share[:, None] * values[pairs[:, 1]]


def _crossings(pairs, height):
    """Points where lines between points of these heights cross the plane: pairs and shares, each once; the number of that of each
    line."""
    pairs, number = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    below, above = height[pairs[:, 0]], height[pairs[:, 1]]
    return (pairs, below / (below - above)), number.ravel()


def _clipped(triangles, height):
    """(triangles, owner, new): what is left below the plane, of which triangle each is a part, and the points that are added."""
    below = height[triangles] <= 0
    count = below.sum(axis=1)
    kept, one, two = (np.nonzero(count == k)[0] for k in (3, 1, 2))
    odd = [below[one].argmax(axis=1), below[two].argmin(axis=1)]  # the corner that is alone on its side
    (a, b, c), (d, e, f) = (tuple(np.take_along_axis(triangles[chosen], (at[:, None] + k) % 3, axis=1)[:, 0] for k in range(3))
                            for chosen, at in zip((one, two), odd))
    pairs = np.vstack([np.stack(pair, axis=1) for pair in ((a, b), (a, c), (d, e), (d, f))])
    new, number = _crossings(pairs, height)
    ab, ac, de, df = np.split(len(height) + number, np.cumsum([len(one), len(one), len(two)]))
    parts = [triangles[kept], np.stack([a, ab, ac], axis=1), np.stack([e, f, df], axis=1), np.stack([e, df, de], axis=1)]
    return np.vstack(parts), np.concatenate([kept, one, two, two]), new


def _section_of(mesh, cells, cut, divisions):
    """(inside, triangles, cell, points, outlines): the polygons in which the plane cuts tetrahedra, seen counterclockwise from above; `points`
    are pairs of points of the Lattice `inside` and shares; `outlines` are the sides of elements."""
    stand_ins = np.isin(np.array(mesh.body_names), [*mesh.masses, *mesh.rods, *mesh.sections, *mesh.shells])
    cells = _crossed(mesh, cells[~stand_ins[mesh.body[cells]]], cut)
    inside = Lattice(mesh, cells, divisions if mesh.cells.shape[1] == 10 else 1)
    nodes, owner = inside.parts, inside.cell_of_part
    x_inside = inside.of_nodes(mesh.coordinates)
    height = cut.heights(x_inside)
    below = height[nodes] <= 0
    polygons, owners = [], []
    for lower in (1, 2, 3):
        chosen = below.sum(axis=1) == lower
        # Corners below first. A plane crosses the sides that lead from those to the others: around a triangle, or a quadrilateral.
        sorted_nodes = np.take_along_axis(nodes[chosen], np.argsort(~below[chosen], axis=1, kind="stable"), axis=1)
        polygons.append(sorted_nodes[:, CROSSED[lower]])
        owners.append(owner[chosen])
    points, number = _crossings(np.vstack([sides.reshape(-1, 2) for sides in polygons]), height)
    x = _between(x_inside, *points)
    triangles, of_cells, outlines, of_outlines, start = [], [], [], [], 0
    for sides, of_cell in zip(polygons, owners):
        corners = number[start:start + sides.shape[0] * sides.shape[1]].reshape(sides.shape[:2])
        start += corners.size
        outlines += [corners[:, [k, k - 1]] for k in range(corners.shape[1])]
        of_outlines += [of_cell] * corners.shape[1]
        for k in range(1, corners.shape[1] - 1):
            triangles.append(corners[:, [0, k, k + 1]])
            of_cells.append(of_cell)
    triangles = np.vstack(triangles)
    a, b, c = (x[triangles[:, k]] for k in range(3))
    turned = np.cross(b - a, c - a) @ cut.normal < 0
    triangles[turned] = triangles[turned][:, ::-1]
    return inside, triangles, np.concatenate(of_cells), points, _once_in_a_cell(np.vstack(outlines), np.concatenate(of_outlines))


def _once_in_a_cell(outlines, cell):
    """Without those between two of the tetrahedra that make an element."""
    _, first, count = np.unique(np.column_stack([cell, np.sort(outlines, axis=1)]), axis=0, return_index=True, return_counts=True)
    return outlines[np.sort(first[count == 1])]
