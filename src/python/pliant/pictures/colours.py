"""Values to colours."""
import matplotlib
import numpy as np


# Names of the maps, what they are in matplotlib, and the part of them that is taken: shading needs colours that can become darker, so
# the darkest ends are left out. All are perceptually uniform or, `diverging`, symmetric about zero; `cividis` is the same for every
# colour vision.
MAPS = {"viridis": ("viridis", 0.12, 1.0), "cividis": ("cividis", 0.08, 1.0), "inferno": ("inferno", 0.15, 1.0),
        "greys": ("Greys_r", 0.15, 0.95), "diverging": ("RdBu_r", 0.07, 0.93)}


class Colours:
    """Values to colours: one scale for all frames. `name`: of MAPS, or "auto": diverging for values of both signs, else viridis."""

    def __init__(self, low, high, name="auto"):
        if name == "auto":
            name = "diverging" if low < -0.02 * (high - low) and high > 0.02 * (high - low) else "viridis"
        self.diverging = name == "diverging"
        if self.diverging:
            low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
        self.only = None if high > low else low  # the value of all, where it is the same
        if not high > low:
            low, high = (low, low + 1) if low == 0 else (low - abs(low) / 2, low + abs(low) / 2)
        self.low, self.high = low, high
        name, *self._ends = MAPS[name]
        self._map = matplotlib.colormaps[name]

    def __call__(self, values):
        share = np.clip((values - self.low) / (self.high - self.low), 0, 1)
        first, last = self._ends
        return (self._map(first + (last - first) * share)[..., :3] * 255).astype(np.uint8)


class NamedColours:
    """A colour for each body or rank."""

    def __init__(self, count):
        self.count = count
        self._table = np.array([matplotlib.colormaps["tab10"](i % 10)[:3] for i in range(count)]) * 0.85 + 0.15

    def __call__(self, values):
        return (self._table[values.astype(int)] * 255).astype(np.uint8)
