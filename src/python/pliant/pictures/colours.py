"""Values to colours."""
import matplotlib
import numpy as np


class Colours:
    """Values to colours: one scale for all frames, perceptually uniform; diverging about zero for values of both signs."""

    def __init__(self, low, high):
        self.diverging = low < -0.02 * (high - low) and high > 0.02 * (high - low)
        if self.diverging:
            low, high = -max(-low, high), max(-low, high)
        if not high > low:
            low, high = (low, low + 1) if low == 0 else (low - abs(low) / 2, low + abs(low) / 2)
        self.low, self.high = low, high
        self._map = matplotlib.colormaps["RdBu_r" if self.diverging else "viridis"]
        # Shading needs colours that can become darker: the darkest ends of the maps are left out.
        self._ends = (0.07, 0.93) if self.diverging else (0.12, 1.0)

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
