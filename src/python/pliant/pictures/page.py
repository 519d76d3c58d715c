"""The page around a rendered scene: title, time and colour scale, drawn with numbers and units a reader can take in."""
import os
import re

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

BACKGROUND = (250, 250, 252)
INK = (45, 49, 57)
FAINT_INK = (120, 126, 136)
AXES = ((200, 62, 62), (47, 140, 84), (58, 104, 190))  # colours of x, y, z


def font(size, bold=False):
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(os.path.join(matplotlib.get_data_path(), "fonts", "ttf", name), round(size))


def prefixed(unit, largest):
    """The factor and the unit that give handy numbers: 2.3e5 Pa as 230 kPa."""
    if unit not in ("m", "s", "Pa", "m/s", "N", "J", "W", "m/s^2", "N/m^2"):
        return 1.0, unit
    for prefix, factor in (("µ", 1e-6), ("m", 1e-3), ("", 1.0), ("k", 1e3), ("M", 1e6), ("G", 1e9)):
        if largest < 1000 * factor:
            break
    if unit.startswith(("m", "s")) and factor > 1:
        prefix, factor = "", 1.0
    return factor, prefix + unit


def ticks(low, high):
    """About five round numbers from low to high, and how many decimals they need."""
    step = (high - low) / 5
    power = 10 ** np.floor(np.log10(step))
    step = power * min((1, 2, 2.5, 5, 10), key=lambda m: abs(m - step / power))
    values = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1) * step
    return values, decimals_of(values, step)


def decimals_of(values, step):
    """How many decimals values need that are `step` apart."""
    decimals = 0
    while decimals < 8 and not np.allclose(np.round(values, decimals), values, rtol=0, atol=1e-6 * step):
        decimals += 1
    return decimals


def round_length(most):
    """The largest of 1, 2 and 5 times a power of ten that is not longer."""
    power = 10 ** np.floor(np.log10(most))
    return power * max(m for m in (1, 2, 5) if m * power <= most * (1 + 1e-9))


class Page:
    """The picture around the scene: title, time, colour bar."""

    def __init__(self, size, title, quantity, colours):
        self.size = size
        self._unit = size[1] / 100  # lengths go with the picture's height
        self.bar_width = round(23 * self._unit) if quantity is not None else 0
        self.header = round(10 * self._unit)
        self._title, self._quantity, self._colours = title, quantity, colours

    @property
    def scene_size(self):
        return self.size[0] - self.bar_width, self.size[1] - self.header

    def compose(self, pixels, instant, camera=None):
        """`camera`: for the axes and the scale bar; None: without them."""
        page = Image.new("RGB", self.size, BACKGROUND)
        scene = Image.fromarray(pixels).resize(self.scene_size, Image.LANCZOS)
        page.paste(scene, (0, self.header))
        draw = ImageDraw.Draw(page)
        h = self._unit
        draw.text((4 * h, 4.4 * h), self._title, INK, font(3.4 * h, bold=True))
        draw.text((self.size[0] - 4 * h, 4.6 * h), instant, INK, font(3.0 * h), anchor="ra")
        if camera is not None:
            self._draw_axes(page, draw, camera)
            self._draw_scale(page, draw, camera)
        if self._quantity is not None:
            (self._draw_names if self._quantity.names else self._draw_bar)(page, draw)
        return page

    @staticmethod
    def _fade(page, *box):
        """What the scene shows there, so faint that ink is seen on it; between two corners."""
        box = [round(x) for x in box]
        behind = page.crop(box)
        page.paste(Image.blend(behind, Image.new("RGB", behind.size, BACKGROUND), 0.8), box)

    def _draw_axes(self, page, draw, camera):
        """The directions x, y, z as the viewer sees them, the nearest one last."""
        h = self._unit
        middle = np.array([8 * h, self.size[1] - 9 * h])
        self._fade(page, *(middle - 7.8 * h), *(middle + 7.8 * h))
        across = np.stack(camera.axes()[:2])
        for k in np.argsort(camera.axes()[2]):
            arrow = across[:, k] * [1, -1]
            tip = middle + 4.5 * h * arrow
            draw.line([*middle, *tip], AXES[k], max(1, round(0.45 * h)))
            if np.linalg.norm(arrow) > 0.15:
                label = middle + (4.5 * h + 1.7 * h / np.linalg.norm(arrow)) * arrow
                draw.text(tuple(label), "xyz"[k], AXES[k], font(2.6 * h, bold=True), anchor="mm")

    def _draw_scale(self, page, draw, camera):
        """A bar of a round length, as long as it is in the depth of the bodies' middle."""
        h = self._unit
        length_of_pixel = camera.height_seen() / self.scene_size[1]
        length = round_length(0.22 * self.scene_size[1] * length_of_pixel)
        factor, unit = prefixed("m", length)
        x, y, width = 17 * h, self.size[1] - 4.2 * h, length / length_of_pixel
        self._fade(page, 15.8 * h, y - 4.8 * h, x + width + 1.5 * h, y + 3 * h)
        for line in ([x, y, x + width, y], [x, y - 0.8 * h, x, y + 0.8 * h], [x + width, y - 0.8 * h, x + width, y + 0.8 * h]):
            draw.line(line, INK, max(1, round(0.3 * h)))
        draw.text((x + width / 2, y - 1.2 * h), f"{length / factor:g} {unit}", INK, font(2.4 * h), anchor="mb")

    def _draw_bar(self, page, draw):
        h, c = self._unit, self._colours
        x, width = self.size[0] - self.bar_width + 2 * h, round(2.6 * h)
        top, bottom = round(27 * h), round(88 * h)
        values = np.linspace(c.high, c.low, bottom - top) if c.only is None else np.full(bottom - top, c.only)
        strip = np.repeat(c(values)[:, None, :], width, axis=1)
        page.paste(Image.fromarray(strip), (round(x), top))
        factor, unit = prefixed(self._quantity.unit, max(abs(c.low), abs(c.high)))
        low, high = c.low / factor, c.high / factor
        exponent = int(np.floor(np.log10(max(abs(low), abs(high)))))
        if -3 <= exponent < 5:
            exponent = 0
        values, decimals = ticks(low / 10.0**exponent, high / 10.0**exponent)
        if c.only is not None:
            values, decimals = self._only_tick(c.only / factor / 10.0**exponent)
        for value in values:
            y = bottom + (value * 10.0**exponent - low) / (high - low) * (top - bottom)
            draw.line([(x + width, y), (x + width + 0.8 * h, y)], FAINT_INK, max(1, round(0.2 * h)))
            draw.text((x + width + 1.5 * h, y), f"{value + 0.0:.{decimals}f}".replace("-", "\u2212"), INK,
                      font(2.4 * h), anchor="lm")
        scale = f"10{_superscript(exponent)} " if exponent else ""
        self._draw_label(draw, x, f"[{scale}{typeset(unit)}]" if unit or scale else "")

    @staticmethod
    def _only_tick(value):
        """The value that is everywhere, and decimals for four digits of it."""
        return [value], 0 if value == 0 else max(0, 3 - int(np.floor(np.log10(abs(value)))))

    def _draw_label(self, draw, x, unit):
        h = self._unit
        letters, room = font(2.5 * h, bold=True), self.size[0] - x - h
        lines = _wrapped(self._quantity.label, letters.getlength, room)
        longest = max(letters.getlength(line) for line in lines)
        letters = font(2.5 * h * min(1.0, room / longest), bold=True)
        for i, line in enumerate(lines):
            draw.text((x, (23.4 - 3.2 * (len(lines) - i)) * h), line, INK, letters, anchor="ls")
        draw.text((x, 23.4 * h), unit, FAINT_INK, font(2.4 * h), anchor="ls")

    def _draw_names(self, _, draw):
        h = self._unit
        x = self.size[0] - self.bar_width + 2 * h
        self._draw_label(draw, x, "")
        drawn = [(number, name) for number, name in enumerate(self._quantity.names) if name]
        for i, (number, name) in enumerate(drawn[:16]):
            y = (24.5 + 4 * i) * h
            draw.rectangle([x, y, x + 2.4 * h, y + 2.4 * h], fill=tuple(self._colours(np.array([number]))[0]))
            draw.text((x + 3.6 * h, y + 1.2 * h), name, INK, font(2.4 * h), anchor="lm")


def _wrapped(text, length, room):
    """Lines of words; `length` of a line is at most `room`, unless it is a single word."""
    lines = [""]
    for word in text.split():
        if lines[-1] and length(f"{lines[-1]} {word}") > room:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def _superscript(exponent):
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def typeset(unit):
    """A unit as people write it: kg/m³ for kg/m^3."""
    return re.sub(r"\^(-?\d+)(?![\d.])", lambda match: _superscript(match[1]), unit).replace("*", "·")


def instants_as_text(frames, counted=""):
    """Times with as many decimals as distinguish neighbouring frames, in a handy unit; of frames that have labels, these.

    `counted`: what takes the place of time, which has no unit."""
    times = np.array([frame.time for frame in frames])
    last = abs(times).max()
    factor, unit = (1, "s") if last >= 0.1 or last == 0 or counted else (1e3, "ms") if last >= 1e-4 else (1e6, "µs")
    times = times * factor
    gap = np.diff(np.unique(times)).min() if len(np.unique(times)) > 1 else max(abs(times).max(), 1) / 100
    decimals = int(np.clip(np.ceil(-np.log10(gap) + 0.001), 0, 6))
    if counted:
        return [frame.label or f"{counted} {t:.{decimals}f}" for frame, t in zip(frames, times)]
    return [frame.label or f"t = {t:.{decimals}f} {unit}" for frame, t in zip(frames, times)]
