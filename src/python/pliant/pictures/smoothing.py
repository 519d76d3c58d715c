"""Triangles with smooth normals, apart from sharp edges."""
import numpy as np

SHARP = np.cos(np.radians(35))  # an angle between neighbours beyond which an edge is seen as one


def split(triangles, points, colour_of_triangle=None):
    """(triangles, source): vertices for each point, as many as there are sides between sharp edges at it, so that each can have
    a normal and a colour of its own; `source`: the point of each vertex. `colour_of_triangle`: numbers that must not be shared."""
    normal = _cross(triangles, points)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    order = np.lexsort(np.sort(sides, axis=1).T)
    ends = np.sort(sides, axis=1)[order]
    same = np.nonzero((ends[1:] == ends[:-1]).all(axis=1))[0]  # this side and the next are of one edge
    first, second = order[same], order[same + 1]
    smooth = np.einsum("ij,ij->i", normal[first // 3], normal[second // 3]) > SHARP
    if colour_of_triangle is not None:
        smooth &= colour_of_triangle[first // 3] == colour_of_triangle[second // 3]
    first, second = first[smooth], second[smooth]
    # A side begins at its corner, and ends at the next one; neighbours run along an edge in opposite directions.
    following = lambda side: side // 3 * 3 + (side + 1) % 3  # noqa: E731
    turned = sides[first, 0] != sides[second, 0]
    at_start = np.where(turned, following(second), second)
    at_end = np.where(turned, second, following(second))
    labels = _components(triangles.size, np.append(first, following(first)), np.append(at_start, at_end))
    _, corner, vertex = np.unique(labels, return_index=True, return_inverse=True)
    return vertex.reshape(triangles.shape), triangles.ravel()[corner]


def normals(triangles, points):
    """Of unit length, at each point: the mean over its triangles, weighted by their areas."""
    areas = _cross(triangles, points)
    total = np.stack([np.bincount(triangles.ravel(), np.repeat(areas[:, k], 3), len(points)) for k in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1)
    total[length == 0] = [0, 0, 1]
    return total / np.where(length == 0, 1, length)[:, None]


def _cross(triangles, points):
    a, b, c = (points[triangles[:, k]].astype(float) for k in range(3))
    return np.cross(b - a, c - a)


def _components(count, first, second):
    """A number for each of `count` things, the same for those that are joined by a chain of pairs."""
    labels = np.arange(count)
    while True:
        lower = np.minimum(labels[first], labels[second])
        before = labels.copy()
        np.minimum.at(labels, first, lower)
        np.minimum.at(labels, second, lower)
        labels = labels[labels]
        if (labels == before).all():
            return labels
