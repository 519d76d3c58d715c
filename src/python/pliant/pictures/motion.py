"""The motion of points as a few shapes that are added up, as morph targets are."""
import dataclasses

import numpy as np

TOLERANCE = 1e-4  # of the size of the scene: how far a point may be from where it was computed


@dataclasses.dataclass(frozen=True)
class Motion:
    """x(f) = base + sum over k of weights[f, k] shapes[k], up to the tolerance."""

    shapes: np.ndarray  # num_shapes x num_points x 3
    weights: np.ndarray  # num_frames x num_shapes, from 0 to 1: Blender cuts off what is outside


def motion_of(positions, base, tolerance):
    """As few shapes as bring all points, frames x points x 3, to within `tolerance` of where they are: the principal components of
    x - base, which for a rigid motion are at most twelve, whatever the number of frames. Their weights have both signs; what
    makes them positive is added as a constant shape, and taken away by one more, whose weight is 1."""
    rest = (positions - base).reshape(len(positions), -1)
    _, modes = np.linalg.eigh(np.einsum("fp,gp->fg", rest, rest, dtype=np.float64, optimize=True))
    modes = modes[:, ::-1]  # those with the largest share first
    count = 0
    while count < len(modes) and _largest(rest) > tolerance:
        rest = rest - np.outer(modes[:, count], modes[:, count] @ rest)
        count += 1
    weights, shapes = modes[:, :count], np.einsum("fk,fpc->kpc", modes[:, :count], positions - base, optimize=True)
    if count == 0:
        return Motion(shapes.astype(np.float32), weights.astype(np.float32))
    low, high = weights.min(axis=0), weights.max(axis=0)
    weights = np.column_stack([(weights - low) / (high - low), np.ones(len(weights))])
    shapes = np.concatenate([shapes * (high - low)[:, None, None], np.einsum("k,kpc->pc", low, shapes)[None]])
    return Motion(shapes.astype(np.float32), weights.astype(np.float32))


def along(motion, values, base):
    """The shapes of other values of the points, such as normals, frames x points x 3, which follow the weights of a motion: the
    best in the sense of least squares."""
    change = (values - base).reshape(len(values), -1)
    shapes = np.linalg.lstsq(motion.weights.astype(np.float64), change.astype(np.float64), rcond=None)[0]
    return shapes.reshape(len(shapes), -1, 3).astype(np.float32)


def _largest(rest):
    """The largest length of a vector."""
    return np.sqrt((rest.reshape(len(rest), -1, 3) ** 2).sum(axis=2).max())
