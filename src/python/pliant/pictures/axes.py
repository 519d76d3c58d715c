"""Axes of plots that a reader can take in: handy units instead of powers of ten, and columns by what they are."""
import re

import matplotlib
import numpy as np

from .page import decimals_of, prefixed, typeset

# Endings of the columns of a history with a direction after them, and without one, and what they are.
OF_DIRECTIONS = (("_f", "force of {} in {}"), ("_t", "torque of {} about {}"), ("_j", "impulse of {} in {}"), ("_v", "velocity of {} in {}"),
                 ("_u", "displacement of {} in {}"), ("_", "position of {} in {}"))
OTHERS = (("_pressure", "pressure in {}"), *((f"_{what}", f"{what} of {{}}") for what in ("volume", "length", "travel", "tension", "force", "angle", "effort")))
VOLUMES = (("mm³", 1e-9), ("cm³", 1e-6), ("m³", 1.0))


def column_in_words(name, unit):
    """`chamber_pressure` as "pressure in chamber"; of columns without a known unit the name itself."""
    if not unit:
        return name
    for ending, words in OF_DIRECTIONS:
        match = re.fullmatch(rf"(.+){ending}([xyz])", name)
        if match:
            return words.format(*match.groups())
    for ending, words in OTHERS:
        if name.endswith(ending) and name != ending:
            return words.format(name.removesuffix(ending))
    return name.replace("_", " ")


def handy(unit, largest):
    """The factor and the unit with a prefix that suit values up to `largest`."""
    if not 0 < largest < np.inf or (unit == "s" and 0.1 <= largest):
        return 1.0, unit
    if unit in ("m³", "m^3"):
        return next(((factor, name) for name, factor in VOLUMES if largest < 1000 * factor), (1.0, "m³"))
    first, _, rest = unit.partition(" ")
    factor, first = prefixed(first, largest) if rest in ("", "m", "s") else (1.0, first)
    return factor, f"{first} {rest}".strip()


class InUnits(matplotlib.ticker.Formatter):
    """Numbers at an axis whose values are in SI units, in a unit that is `factor` of those, all with as many decimals."""

    def __init__(self, factor):
        self._factor = factor

    def __call__(self, value, _=None):
        return self.format_ticks([value])[0]

    def format_ticks(self, values):
        scaled = np.asarray(values) / self._factor
        step = np.diff(scaled).min() if len(scaled) > 1 else abs(scaled[0]) or 1.0
        return [f"{value + 0.0:.{decimals_of(scaled, step)}f}".replace("-", "\u2212") for value in scaled.round(12)]


def use_handy_units(axes):
    """Where a label ends in a unit in brackets, as "force [N]", and values of that size have a better one."""
    for axis, interval in ((axes.xaxis, axes.dataLim.intervalx), (axes.yaxis, axes.dataLim.intervaly)):
        match = re.fullmatch(r"(.*)\[([^\[\],]+)\]", axis.get_label_text())
        if match is None:
            continue
        factor, unit = handy(match[2], np.abs(interval).max()) if axis.get_scale() == "linear" else (1.0, match[2])
        axis.set_label_text(f"{match[1]}[{typeset(unit)}]")
        if factor != 1.0:
            axis.set_major_formatter(InUnits(factor))
