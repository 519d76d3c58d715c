"""Temperatures and expansion of an input file of Abaqus or CalculiX: *TEMPERATURE with *EXPANSION as `expansion` of bodies.

The strain of a free body is e = alpha(T) (T - Tz) - alpha(T0) (T0 - Tz), with T0 at the start and Tz of *EXPANSION, ZERO (Abaqus Theory Guide 3.2.2, CalculiX
CrunchiX User's Manual, *EXPANSION); with one alpha it is alpha (T - T0). The stretch is 1 + e.
"""
import numpy as np

from .abaqus_deck import real
from .abaqus_nodes import NodeTable
from .course import SMOOTH_PARTS, Course, Segment

NONE = (0, 0, 0)


class AbaqusTemperature:
    """Reads *TEMPERATURE, and *INITIAL CONDITIONS, TYPE=TEMPERATURE."""

    def __init__(self, model, mesh, steps, diagnostics):
        self.model, self.mesh, self.steps, self.diagnostics = model, mesh, steps, diagnostics
        self.table, self.start, self.first = NodeTable(model), {}, None
        self.begin_step()

    def begin_step(self):
        self.before = {}  # of nodes with a temperature of the present step

    def read_initial(self, card):
        for line, entries in card.data:
            value = real(entries, 1, line, self.diagnostics, "the temperature")
            self.start.update({row: value for row in self.mesh.nodes(entries[0], line)})

    def read(self, card):
        self.first = self.first or card
        is_new = card.upper("OP") == "NEW" and self.steps.start > 0
        if not card.data and not is_new or any(card.has(name) for name in ("FILE", "USER", "BSTEP", "ESTEP")):
            self.diagnostics.missing(card.line, f"{card.title} of a file or a subroutine: write `expansion: {{stretch: ..}}` of the bodies as a formula of x, y, z, t")
            return
        if is_new:
            for row, component in [key for key in self.table.course if key not in self.before]:
                course = self.steps.course_of(card, self.table.course[row, component], self.start.get(row, 0.0))
                self.before[row, component] = self.table.course[row, component]
                self.table.set(row, component, [row], course)
        for line, entries in card.data:
            value = real(entries, 1, line, self.diagnostics, "the temperature")
            for row in self.mesh.nodes(entries[0], line):
                before = self.before.setdefault((row, 0), self.table.course.get((row, 0), Course.constant(self.start.get(row, 0.0))))
                course = self.steps.course_of(card, before, value)
                if course is not None:
                    self.table.set(row, 0, [row], course)

    def finish(self, material_of, value):
        """Expansion of the bodies; `material_of`: by the set of elements of a body."""
        for body in self.model.bodies:
            material = material_of[body.elements]
            nodes = {row for element in self.model.element_sets[body.elements] for row in self.model.elements[element]}
            if not material.expansion or not any((row, 0) in self.table.course for row in nodes):
                continue
            pairs = {(self.start.get(row, 0.0), self.table.course.get((row, 0))) for row in nodes}
            if len(pairs) > 1:
                self.list_field(body.elements, material, pairs)
                continue
            (start, course), = pairs
            body.expansion = value(self.stretch(material, start, course), NONE)

    def list_field(self, name, material, pairs):
        """Temperatures that differ within a body: its `stretch` may be a formula, and not data of nodes."""
        first = [start for start, _ in pairs]
        last = [start if course is None else course.at(self.steps.end) for start, course in pairs]
        between = lambda values: f"{min(values):g}" if min(values) == max(values) else f"from {min(values):g} to {max(values):g}"  # noqa: E731
        alpha = f"{material.expansion[0][0]:g}" if len({row[0] for row in material.expansion}) == 1 else "alpha"
        start = f"{min(first):g}" if min(first) == max(first) else "T0"
        self.diagnostics.missing(self.first.line, f"{self.first.title}: the nodes of {name} have different temperatures, {between(first)} at the start and {between(last)} at the end, and "
                                 f"its expansion is left out: give the body `expansion: {{stretch: \"1 + {alpha}*(T - {start})\"}}` with the temperature T as a formula of x, y, z, t, "
                                 "or cut it into bodies of one temperature each")

    def stretch(self, material, start, course):
        table, zero = material.expansion, material.expansion_zero
        alpha = lambda t: float(np.interp(t, [row[1] for row in table], [row[0] for row in table]))  # noqa: E731
        if len({row[0] for row in table}) == 1:
            return course.raised(-start).scaled(table[0][0]).raised(1.0)
        at = lambda t: 1 + alpha(t) * (t - zero) - alpha(start) * (start - zero)  # noqa: E731
        self.diagnostics.note(material.line, f"material {material.name}: its coefficient of expansion depends on the temperature, and the stretch becomes a chain of linear pieces")
        parts = []
        for s in course.segments:
            times = [s.start + (s.end - s.start) * k / SMOOTH_PARTS for k in range(SMOOTH_PARTS + 1)] if s.end > s.start and s.first != s.last else [s.start, s.end]
            parts += [Segment(a, b, at(s.at(a) if b > a else s.last), at(s.at(b))) for a, b in zip(times, times[1:])]
        return Course(tuple(parts))
