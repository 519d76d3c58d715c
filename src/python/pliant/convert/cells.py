"""Kinds of elements, in the numbering of Abaqus, and how they are cut into tetrahedra."""
import dataclasses

import numpy as np

TETRAHEDRON_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
BRICK_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
WEDGE_FACES = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
PYRAMID_FACES = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
BRICK_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
WEDGE_EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
PYRAMID_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4))


@dataclasses.dataclass(frozen=True)
class Kind:
    """Faces are ordered by the right-hand rule, outward; a quadratic kind has a node on each edge, in the order of `edges`."""

    corners: int
    faces: tuple
    edges: tuple
    quadratic: bool

    @property
    def nodes(self):
        return self.corners + (len(self.edges) if self.quadratic else 0)

    def nodes_of_face(self, face):
        """Corners, then the nodes on its edges, of a quadratic kind."""
        corners = self.faces[face]
        if not self.quadratic:
            return corners
        pairs = [frozenset(edge) for edge in self.edges]
        return corners + tuple(self.corners + pairs.index(frozenset(edge)) for edge in zip(corners, corners[1:] + corners[:1]))


KINDS = {
    "tetrahedron": Kind(4, TETRAHEDRON_FACES, TETRAHEDRON_EDGES, False),
    "brick": Kind(8, BRICK_FACES, BRICK_EDGES, False),
    "wedge": Kind(6, WEDGE_FACES, WEDGE_EDGES, False),
    "pyramid": Kind(5, PYRAMID_FACES, PYRAMID_EDGES, False),
    "quadratic tetrahedron": Kind(4, TETRAHEDRON_FACES, TETRAHEDRON_EDGES, True),
    "quadratic brick": Kind(8, BRICK_FACES, BRICK_EDGES, True),
    "quadratic wedge": Kind(6, WEDGE_FACES, WEDGE_EDGES, True),
    "quadratic pyramid": Kind(5, PYRAMID_FACES, PYRAMID_EDGES, True),
}


def triangles_of(face):
    """Corners of the triangles of faces with 3 or 4 corners, shape (faces, 3 or 4): both, shape (faces, 3), or one. A quadrilateral is cut
    through its node of the lowest number, so that neighbours agree."""
    if face.shape[1] == 3:
        return [face]
    through_first = (face.argmin(axis=1) % 2 == 0)[:, None]
    return [np.where(through_first, face[:, [0, 1, 2]], face[:, [0, 1, 3]]), np.where(through_first, face[:, [0, 2, 3]], face[:, [1, 2, 3]])]


def tetrahedra_of(kind, corners):
    """Cuts elements of a convex kind, `corners` of shape (elements, corners): each is the cone from its node of the lowest number over the
    faces that do not have it. Returns the corners of the tetrahedra and the rows of their elements."""
    if kind.corners == 4:
        return corners[:, :4], np.arange(len(corners))
    cells, parents = [], []
    lowest = corners.argmin(axis=1)
    for apex in range(kind.corners):
        rows = np.flatnonzero(lowest == apex)
        for face in kind.faces:
            if apex in face:
                continue
            for triangle in triangles_of(corners[rows][:, face]):
                cells.append(np.column_stack([triangle[:, [0, 2, 1]], corners[rows, apex]]))
                parents.append(rows)
    cells, parents = np.concatenate(cells), np.concatenate(parents)
    ordered = np.sort(cells, axis=1)
    whole = (ordered[:, 1:] != ordered[:, :-1]).all(axis=1)  # collapsed bricks have some nodes twice
    return cells[whole], parents[whole]
