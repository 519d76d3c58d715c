"""Bodies cut open by a plane, and mirrored at planes.

A cut is one of the undeformed shape, so that all frames show the same section: the outside is cut, triangle by triangle, and the
section is drawn, tetrahedron by tetrahedron. Shells have their triangles cut only, and rods are left whole.
"""
import dataclasses
import re

import numpy as np

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
AXES = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
# Sides that a plane crosses, in their order around the polygon, by the number of corners below it, which come first.
CROSSED = {1: np.array([[0, 1], [0, 2], [0, 3]]), 2: np.array([[0, 2], [0, 3], [1, 3], [1, 2]]), 3: np.array([[0, 3], [1, 3], [2, 3]])}
# The 8 tetrahedra that the nodes of a quadratic one make (VTK's order).
PARTS = np.array([[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3], [4, 6, 7, 8], [4, 5, 6, 8], [6, 5, 9, 8], [6, 7, 8, 9]])


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
        section, cell, self._section, outlines = _section_of(mesh, cells, cut)
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
        return self._cut(self._whole.of_nodes(values), values)

    def field_of_nodes(self, values):
        return self._cut(self._whole.field_of_nodes(values), values)

    def of_cells(self, values):
        return self.field_of_nodes(self.nodal_means(values))

    def nodal_means(self, values):
        return self._whole.nodal_means(values)

    def _cut(self, outside, values):
        return np.concatenate([outside, _between(outside, *self._new), _between(values, *self._section)])[self._used]


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


def _section_of(mesh, cells, cut):
    """(triangles, cell, points, outlines): the polygons in which the plane cuts tetrahedra, seen counterclockwise from above; `points`
    are pairs of nodes and shares; `outlines` are the sides of elements."""
    stand_ins = np.isin(np.array(mesh.body_names), [*mesh.masses, *mesh.rods, *mesh.sections, *mesh.shells])
    cells = cells[~stand_ins[mesh.body[cells]]]
    nodes, owner = mesh.cells[cells], cells
    if nodes.shape[1] == 10:
        nodes, owner = nodes[:, PARTS].reshape(-1, 4), np.repeat(cells, len(PARTS))
    height = cut.heights(mesh.coordinates)
    below = height[nodes] <= 0
    polygons, owners = [], []
    for lower in (1, 2, 3):
        chosen = below.sum(axis=1) == lower
        # Corners below first. A plane crosses the sides that lead from those to the others: around a triangle, or a quadrilateral.
        sorted_nodes = np.take_along_axis(nodes[chosen], np.argsort(~below[chosen], axis=1, kind="stable"), axis=1)
        polygons.append(sorted_nodes[:, CROSSED[lower]])
        owners.append(owner[chosen])
    points, number = _crossings(np.vstack([sides.reshape(-1, 2) for sides in polygons]), height)
    x = _between(mesh.coordinates, *points)
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
    return triangles, np.concatenate(of_cells), points, _once_in_a_cell(np.vstack(outlines), np.concatenate(of_outlines))


def _once_in_a_cell(outlines, cell):
    """Without those between two of the tetrahedra that make a quadratic one."""
    _, first, count = np.unique(np.column_stack([cell, np.sort(outlines, axis=1)]), axis=0, return_index=True, return_counts=True)
    return outlines[np.sort(first[count == 1])]
