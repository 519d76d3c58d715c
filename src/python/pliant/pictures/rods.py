"""Rods as they are: a prism around each segment, with the section of the rod."""
import itertools

import numpy as np

SIDES_OF_CIRCLE = 16
HAIRLINE = 0.0012  # the least distance of a rod's surface from its axis, as a fraction of the scene's size
_ANGLES = 2 * np.pi * np.arange(SIDES_OF_CIRCLE) / SIDES_OF_CIRCLE
CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
SQUARE = np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1]])
# Corners of a segment's cell that may be x_0, x_1, p_1, p_2.
ORDERS = np.array([[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]])


class RodShapes:
    """The segments of all rods of a mesh: x_0 and x_1 are the ends of the axis of each, p_1 and p_2 points of its surface across the
    axis from the middle m, so that p_1 - m and p_2 - m are at right angles to it and to each other (src/io/rod_surface.cpp)."""

    def __init__(self, mesh):
        names = np.array(mesh.body_names)
        cells = np.nonzero(np.isin(names, mesh.rods)[mesh.body])[0]
        self.cells, self.names = cells, names[mesh.body[cells]]
        self.is_rectangular = np.isin(self.names, mesh.rectangular_rods)
        corners = mesh.cells[cells, :4]
        errors, lengths = zip(*(self._fit(mesh.coordinates[corners[:, order]]) for order in ORDERS))
        # Where two orders fit, the axis is the longest.
        fits = np.array(errors) < np.min(errors, axis=0, initial=np.inf) + 1e-6
        best = np.where(fits, lengths, -1).argmax(axis=0)
        self._nodes = np.take_along_axis(corners, ORDERS[best], axis=1)

    @staticmethod
    def _fit(x):
        """How far from right angles, and how long, segments x_0, x_1, p_1, p_2 are."""
        middle, along = (x[:, 0] + x[:, 1]) / 2, x[:, 1] - x[:, 0]
        axes = [vector / np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None] for vector in (along, x[:, 2] - middle, x[:, 3] - middle)]
        error = sum(np.abs(np.einsum("ij,ij->i", a, b)) for a, b in itertools.combinations(axes, 2))
        return error, np.linalg.norm(along, axis=1)

    def at(self, positions):
        """Segments x 4 x 3: both ends of the axis, then how the surface lies from it in two directions. `positions`: of the nodes."""
        x = positions[self._nodes]
        middle = (x[:, 0] + x[:, 1]) / 2
        return np.stack([x[:, 0], x[:, 1], x[:, 2] - middle, x[:, 3] - middle], axis=1)


def prisms(segments, is_rectangular, least):
    """(points, triangles, segment): around segments as RodShapes.at has them, at least so thick [m]; the segment of each triangle."""
    points, triangles, owners, first = [], [], [], 0
    for outline, chosen in ((CIRCLE, ~is_rectangular), (SQUARE, is_rectangular)):
        number = np.nonzero(chosen)[0]
        if len(number) == 0:
            continue
        ends, directors = segments[number, :2], segments[number, 2:]
        thickness = np.linalg.norm(directors, axis=2, keepdims=True)
        directors = directors * np.maximum(1, least / np.maximum(thickness, 1e-300))
        around = np.einsum("pk,nkc->npc", outline, directors)
        rings = ends[:, :, None, :] + around[:, None]
        n = len(outline)
        side = np.arange(n)
        following = (side + 1) % n
        mantle = np.concatenate([np.stack([side, following, n + following], axis=1), np.stack([side, n + following, n + side], axis=1)])
        fan = np.stack([np.zeros(n - 2, dtype=int), side[1:-1], side[2:]], axis=1)
        shape = np.concatenate([mantle, fan[:, ::-1], n + fan])
        # The frame of some is left-handed.
        turned = np.einsum("ij,ij->i", ends[:, 1] - ends[:, 0], np.cross(directors[:, 0], directors[:, 1])) < 0
        of_each = np.where(turned[:, None, None], shape[None, :, ::-1], shape[None])
        triangles.append((first + 2 * n * np.arange(len(number))[:, None, None] + of_each).reshape(-1, 3))
        owners.append(np.repeat(number, len(shape)))
        points.append(rings.reshape(-1, 3))
        first += len(points[-1])
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(owners)
