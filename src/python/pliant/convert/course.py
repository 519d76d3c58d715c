"""Functions of time: amplitudes and load curves as formulas of t."""
import bisect
import dataclasses
import math

SMOOTH_PARTS = 16  # linear ones in place of a smooth one


@dataclasses.dataclass(frozen=True)
class Segment:
    """From `start` to `end` the value changes from `first` to `last`: linearly, or by Abaqus's smooth step."""

    start: float
    end: float
    first: float
    last: float
    smooth: bool = False

    def at(self, t):
        x = min(max((t - self.start) / (self.end - self.start), 0.0), 1.0) if self.end > self.start else 1.0
        return self.first + (self.last - self.first) * (x**3 * (10 - 15 * x + 6 * x * x) if self.smooth else x)

    @property
    def corners(self):
        """Times between which it is linear, or almost."""
        return [self.start + (self.end - self.start) * k / SMOOTH_PARTS for k in range(SMOOTH_PARTS + 1)] if self.smooth else [self.start, self.end]


@dataclasses.dataclass(frozen=True)
class Course:
    """Segments in their order, without gaps; constant before and after."""

    segments: tuple

    @staticmethod
    def constant(value):
        return Course((Segment(0.0, 0.0, value, value),))

    @staticmethod
    def through(points, interpolation="linear"):
        """Of a table of (time, value); `interpolation`: linear, smooth, or step: the value of the next point."""
        points = sorted(points, key=lambda point: point[0])
        if len(points) == 1:
            return Course.constant(points[0][1])
        pairs = [(p, q) for p, q in zip(points, points[1:]) if q[0] > p[0]]
        if not pairs:
            return Course.constant(points[-1][1])
        return Course(tuple(Segment(p[0], q[0], q[1] if interpolation == "step" else p[1], q[1], interpolation == "smooth") for p, q in pairs))

    def at(self, t):
        index = bisect.bisect_left([s.end for s in self.segments], t)
        return self.segments[min(index, len(self.segments) - 1)].at(t)

    def scaled(self, factor):
        return Course(tuple(dataclasses.replace(s, first=s.first * factor, last=s.last * factor) for s in self.segments))

    def raised(self, by):
        return Course(tuple(dataclasses.replace(s, first=s.first + by, last=s.last + by) for s in self.segments))

    def repeated(self, until, offset):
        """The same again and again after its end, each time starting at its last value with `offset`, up to the time `until`."""
        length, rise = self.segments[-1].end - self.segments[0].start, self.segments[-1].last - self.segments[0].first if offset else 0.0
        segments = list(self.segments)
        for k in range(1, math.ceil((until - self.segments[-1].end) / length) + 1):
            segments += self.shifted(k * length).raised(k * rise).segments
        return Course(tuple(segments))

    def within(self, start, end):
        """The same from `start` to `end`; a smooth segment that is cut becomes a chain of linear ones."""
        cut = []
        for s in self.segments:
            low, high = max(s.start, start), min(s.end, end)
            if high <= low:
                continue
            if s.smooth and (low, high) != (s.start, s.end):
                times = [low + (high - low) * k / SMOOTH_PARTS for k in range(SMOOTH_PARTS + 1)]
                cut += [Segment(a, b, s.at(a), s.at(b)) for a, b in zip(times, times[1:])]
            else:
                cut.append(Segment(low, high, s.at(low), s.at(high), s.smooth))
        if not cut or cut[0].start > start:
            cut.insert(0, Segment(start, cut[0].start if cut else end, self.at(start), self.at(start)))
        if cut[-1].end < end:
            cut.append(Segment(cut[-1].end, end, cut[-1].last, cut[-1].last))
        return Course(tuple(cut))

    def plus(self, other):
        """The sum; where the parts of the two differ, a smooth one becomes a chain of linear ones."""
        if other.is_constant:
            return self.raised(other.at(0.0))
        if self.is_constant:
            return other.raised(self.at(0.0))
        if [(s.start, s.end, s.smooth) for s in self.segments] == [(s.start, s.end, s.smooth) for s in other.segments]:
            return Course(tuple(dataclasses.replace(s, first=s.first + o.first, last=s.last + o.last) for s, o in zip(self.segments, other.segments)))
        times = sorted({t for s in self.segments + other.segments for t in s.corners})
        return Course(tuple(Segment(a, b, self.value_in(a, b, a) + other.value_in(a, b, a), self.value_in(a, b, b) + other.value_in(a, b, b)) for a, b in zip(times, times[1:])))

    def value_in(self, start, end, t):
        """The value at t in the part that has the interval from `start` to `end`, also where it jumps at one of its ends."""
        middle = (start + end) / 2
        index = bisect.bisect_left([s.end for s in self.segments], middle)
        if index == len(self.segments) or middle < self.segments[0].start:
            return self.at(middle)
        return self.segments[index].at(t)

    def shifted(self, by):
        return Course(tuple(dataclasses.replace(s, start=s.start + by, end=s.end + by) for s in self.segments))

    def followed_by(self, other):
        return Course(self.segments + other.segments)

    @property
    def is_constant(self):
        return len({value for s in self.segments for value in (s.first, s.last)}) == 1

    def formula(self, until, unit=1.0, unit_of_time=1.0):
        """A number, or a formula of t in SI, that is right up to the time `until`."""
        joined = []
        for s in self.segments:
            is_flat = s.first == s.last
            if joined and is_flat and joined[-1].first == joined[-1].last == s.first:
                joined[-1] = dataclasses.replace(joined[-1], end=s.end)
            else:
                joined.append(s)
        parts = [term(s, unit, unit_of_time) for s in joined]
        ends = [s.end for s in joined]
        if ends[-1] < until * (1 - 1e-12) and joined[-1].first != joined[-1].last:
            parts.append(number(joined[-1].last * unit))
            ends.append(until)
        if joined[0].start > 0 and joined[0].first != joined[0].last:
            parts.insert(0, number(joined[0].first * unit))
            ends.insert(0, joined[0].start)
        while len(parts) > 1 and ends[-2] >= until * (1 - 1e-12):
            del parts[-1], ends[-1]
        if len(parts) == 1:
            try:
                return float(parts[0])
            except ValueError:
                return parts[0]
        return " : ".join([f"t < {number(end * unit_of_time)} ? {part}" for end, part in zip(ends[:-1], parts[:-1])] + [parts[-1]])


def number(value):
    return f"{value + 0.0:.12g}"  # -0 is 0


def term(s, unit, unit_of_time):
    first, change = s.first * unit, (s.last - s.first) * unit
    start, length = s.start * unit_of_time, (s.end - s.start) * unit_of_time
    if change == 0:
        return number(first)
    since = "t" if start == 0 else f"(t - {number(start)})"
    if s.smooth:
        x = since if length == 1 else f"({since}/{number(length)})"
        factor, rest = change, f"{x}^3*(10 - 15*{x} + 6*{x}^2)"
    else:
        factor, rest = change / length, since
    size = rest if abs(factor) == 1 else f"{number(abs(factor))}*{rest}"
    if first == 0:
        return size if factor > 0 else f"-{size}"
    return f"{number(first)} {'+' if factor > 0 else '-'} {size}"
