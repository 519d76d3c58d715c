"""Where surfaces pass through one another in the frames of a run: a check by brute force that shares no code with the program.

Every edge is compared with every triangle, with signs of volumes that are exact, and every vertex of a body with the whole surface of
another one, by the solid angle under which it sees that surface. A quadratic facet stands for the four triangles between its nodes.
"""
import dataclasses
import fractions
import itertools

import h5py
import numpy as np

# Edges of a quadratic tetrahedron, in VTK's order of its last six nodes.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
ROUNDING = 1e-13  # of a volume, relative to the product of the sides


@dataclasses.dataclass
class Surface:
    """The outer surface of one body: vertices of triangles and edges, numbers of nodes."""

    triangles: np.ndarray
    edges: np.ndarray
    nodes: np.ndarray


@dataclasses.dataclass
class Overlap:
    frame: str
    what: str
    body: int
    other: int


def outer_triangles(cells):
    """Outward where cells are of positive volume; of quadratic cells four between the nodes of each facet."""
    faces = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])
    corners = cells[:, faces].reshape(-1, 3)
    _, place, count = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True)
    outer = place[count == 1]
    if cells.shape[1] == 4:
        return corners[outer]
    middle = {frozenset(edge): 4 + k for k, edge in enumerate(EDGES)}
    local = [[*face, *(middle[frozenset((face[i], face[(i + 1) % 3]))] for i in range(3))] for face in faces.tolist()]
    six = cells[:, np.array(local)].reshape(-1, 6)[outer]
    return six[:, [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]].reshape(-1, 3)


def surface_of(cells):
    triangles = outer_triangles(cells)
    edges = np.unique(np.sort(triangles[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1), axis=0)
    return Surface(triangles, edges, np.unique(triangles))


def boxes_meet(first, second):
    """Pairs of numbers of boxes (low, high) that overlap."""
    pairs = []
    for begin in range(0, len(first[0]), 256):
        low, high = first[0][begin : begin + 256, None], first[1][begin : begin + 256, None]
        i, j = np.nonzero(((low <= second[1]) & (high >= second[0])).all(axis=2))
        pairs.append(np.stack([i + begin, j], axis=1))
    return np.concatenate(pairs) if pairs else np.zeros((0, 2), dtype=int)


def box_of(x, numbers):
    return x[numbers].min(axis=1), x[numbers].max(axis=1)


def volumes(a, b, c, d):
    """Six times the volumes of tetrahedra, 0 where rounding hides the sign."""
    u, v, w = b - a, c - a, d - a
    det = np.einsum("ij,ij->i", np.cross(u, v), w)
    size = np.abs(u).max(axis=1) * np.abs(v).max(axis=1) * np.abs(w).max(axis=1)
    return np.where(np.abs(det) > ROUNDING * size, det, 0.0)


def exact_sign(a, b, c, d):
    a, b, c, d = ([fractions.Fraction(float(value)) for value in point] for point in (a, b, c, d))
    u, v, w = ([p - q for p, q in zip(point, a)] for point in (b, c, d))
    det = sum(w[k] * (u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]) for k in range(3))
    return (det > 0) - (det < 0)


def passes_exactly(p, q, a, b, c):
    """Whether a segment meets a triangle; both in one plane count as apart."""
    sides = exact_sign(a, b, c, p), exact_sign(a, b, c, q)
    if sides[0] * sides[1] > 0 or sides == (0, 0):
        return False
    around = [exact_sign(p, q, *edge) for edge in ((a, b), (b, c), (c, a))]
    return min(around) >= 0 or max(around) <= 0


def edges_through_triangles(x, edges, triangles):
    """Pairs of an edge and a triangle without a common vertex that meet."""
    pairs = boxes_meet(box_of(x, edges), box_of(x, triangles))
    e, t = edges[pairs[:, 0]], triangles[pairs[:, 1]]
    apart = ~(e[:, :, None] == t[:, None, :]).any(axis=(1, 2))
    e, t = e[apart], t[apart]
    p, q, a, b, c = x[e[:, 0]], x[e[:, 1]], x[t[:, 0]], x[t[:, 1]], x[t[:, 2]]
    sides = np.sign(volumes(a, b, c, p)) * np.sign(volumes(a, b, c, q))
    around = np.stack([np.sign(volumes(p, q, *edge)) for edge in ((a, b), (b, c), (c, a))])
    may_meet = (sides <= 0) & ((around >= 0).all(axis=0) | (around <= 0).all(axis=0))
    found = []
    for k in np.nonzero(may_meet)[0]:
        if passes_exactly(p[k], q[k], a[k], b[k], c[k]):
            found.append((e[k], t[k]))
    return found


def solid_angles(points, corners):
    """Of a closed surface at each point, in units of the whole sphere: 1 inside, 0 outside (van Oosterom & Strackee 1983)."""
    total = np.zeros(len(points))
    for k, point in enumerate(points):
        a, b, c = (corners[:, i] - point for i in range(3))
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        rest = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
        total[k] = 2 * np.arctan2(volume, rest).sum() / (4 * np.pi)
    return total


def nodes_inside(x, nodes, surface):
    low, high = x[surface.nodes].min(axis=0), x[surface.nodes].max(axis=0)
    near = nodes[((x[nodes] >= low) & (x[nodes] <= high)).all(axis=1)]
    return near[solid_angles(x[near], x[surface.triangles]) > 0.5]


def overlaps(file, touching=None):
    """All overlaps in the frames of result.h5 between bodies (i, j), i <= j, of `touching`; default: all, and each with itself."""
    found = []
    with h5py.File(file) as result:
        rest, cells, body = (result["mesh"][name][:] for name in ("coordinates", "cells", "body"))
        surfaces = {b: surface_of(cells[body == b]) for b in np.unique(body)}
        for name, frame in result["frames"].items():
            x = rest + frame["displacement"][:]
            for b, other in itertools.combinations_with_replacement(surfaces, 2):
                if touching is not None and (b, other) not in touching:
                    continue
                for one, two in {(b, other), (other, b)}:
                    for edge, triangle in edges_through_triangles(x, surfaces[one].edges, surfaces[two].triangles):
                        found.append(Overlap(name, f"edge {edge.tolist()} passes through triangle {triangle.tolist()}", one, two))
                    if one != two:
                        for node in nodes_inside(x, surfaces[one].nodes, surfaces[two]):
                            found.append(Overlap(name, f"node {node} is inside", one, two))
    return found
