"""Where the viewer stands."""
import dataclasses

import numpy as np

VIEW_ANGLE = 24.0  # [degrees], of the picture's height
VIEWS = {"iso": (0.62, -1.0, 0.48), "front": (0, -1, 0), "back": (0, 1, 0), "right": (1, 0, 0), "left": (-1, 0, 0),
         "top": (0, 0, 1), "bottom": (0, 0, -1)}


@dataclasses.dataclass(frozen=True)
class Camera:
    position: np.ndarray
    target: np.ndarray
    up: np.ndarray

    def axes(self):
        """Unit vectors to the right, upwards and toward the viewer: rows."""
        back = self.position - self.target
        back = back / np.linalg.norm(back)
        right = np.cross(self.up, back)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(back, right), back])

    def height_seen(self):
        """What the picture's height shows in the depth of the target [m]."""
        return 2 * np.tan(np.radians(VIEW_ANGLE / 2)) * np.linalg.norm(self.position - self.target)


def fitted_camera(direction, clouds, size):
    """The camera that looks against `direction` and just sees all points of all clouds."""
    back = np.asarray(direction, dtype=float)
    back /= np.linalg.norm(back)
    up = np.array([0, 0, 1.0]) if abs(back[2]) < 0.99 else np.array([0, 1.0, 0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    axes = np.stack([right, up, back])
    half_height = np.tan(np.radians(VIEW_ANGLE / 2)) * 0.93  # a margin of 7 %
    slopes = np.array([half_height * size[0] / size[1], half_height])
    local = np.concatenate([extreme(points @ axes.T) for points in clouds])
    # A point is seen from distance d over the shift s if |p - s| <= slope (d - depth); both bounds together give the least d.
    planes = [(local[:, k, None] * [1, -1] + slopes[k] * local[:, 2, None]).max(axis=0) for k in (0, 1)]
    distance = max(sum(planes[k]) / (2 * slopes[k]) for k in (0, 1))
    shift = np.array([(planes[0][0] - planes[0][1]) / 2, (planes[1][0] - planes[1][1]) / 2, 0])
    deepest = local[:, 2].max()
    distance = max(distance, deepest + 1e-3 * (np.ptp(local) or 1))
    target = (shift + [0, 0, local[:, 2].mean()]) @ axes
    return Camera((shift + [0, 0, distance]) @ axes, target, up)


def extreme(points):
    """Some points of a cloud that bound it: those farthest in 200 directions."""
    directions = np.random.default_rng(1).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return points[np.unique((points @ directions.T).argmax(axis=0))]


def sheet(corners, points):
    """The rectangle in the plane of a square's corners, with the same sides, that has the points over it, and a margin."""
    along = [corners[1] - corners[0], corners[3] - corners[0]]
    axes = np.array([side / np.linalg.norm(side) for side in along])
    local = (points - corners[0]) @ axes.T
    margin = 0.15 * np.ptp(points, axis=0).max()
    low, high = local.min(axis=0) - margin, local.max(axis=0) + margin
    return corners[0] + np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]) @ axes
