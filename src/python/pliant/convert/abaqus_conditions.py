"""Boundary conditions, loads and ties of an input file of Abaqus or CalculiX."""
import re

from .abaqus_axes import LocalAxes
from .abaqus_deck import real, whole
from .abaqus_equations import AbaqusEquations
from .abaqus_loads import DistributedLoads
from .abaqus_nodes import NodeTable
from .abaqus_temperature import AbaqusTemperature
from .conditions import add_prescribed
from .course import Course
from .forces import constant_at_end
from .model import LENGTH, TIME, VELOCITY, Quantity, Selection

NAMED_SUPPORTS = {"ENCASTRE": (1, 2, 3, 4, 5, 6), "PINNED": (1, 2, 3), "XSYMM": (1, 5, 6), "YSYMM": (2, 4, 6), "ZSYMM": (3, 4, 5), "XASYMM": (2, 3, 4),
                  "YASYMM": (1, 3, 5), "ZASYMM": (1, 2, 6)}
KNOWN_PARAMETERS = {"BOUNDARY": {"OP", "AMPLITUDE", "TYPE", "TIMEDELAY", "USER", "SUBMODEL", "FIXED"}, "CLOAD": {"OP", "AMPLITUDE", "TIMEDELAY"},
                    "DLOAD": {"OP", "AMPLITUDE", "TIMEDELAY", "FOLLOWER"}, "DSLOAD": {"OP", "AMPLITUDE", "TIMEDELAY", "FOLLOWER"},
                    "TIE": {"NAME", "POSITIONTOLERANCE", "CYCLICSYMMETRY", "MULTISTAGE", "TYPE"}}
# Parameters without which a condition means something else.
DECISIVE = {"BOUNDARY": {"PHANTOM", "FILE"}, "CLOAD": {"FOLLOWER", "FILE"}, "DLOAD": {"FILE"}, "DSLOAD": {"ORIENTATION", "CONSTANTRESULTANT"}}
AXES = "xyz"


class AbaqusConditions:
    """Reads conditions; each becomes a function of time over all steps."""

    def __init__(self, model, mesh, steps, rigid, diagnostics):
        self.model, self.mesh, self.steps, self.rigid, self.diagnostics = model, mesh, steps, rigid, diagnostics
        self.prescribed, self.forces = NodeTable(model), NodeTable(model)
        self.loads = DistributedLoads(model, mesh, steps, diagnostics)
        self.axes = LocalAxes(model, mesh, diagnostics)
        self.equations = AbaqusEquations(model, mesh, self.axes, diagnostics)
        self.temperature = AbaqusTemperature(model, mesh, steps, diagnostics)
        self.velocities = []
        self.lines = {}  # the first one of a target
        self.late = []  # displacements that begin in a later step: (card, line, target, component, rows, time)
        self.begin_step()
        self.handlers = {"BOUNDARY": self.read_boundary, "CLOAD": self.read_forces, "DLOAD": self.loads.read, "DSLOAD": self.loads.read,
                         "INITIALCONDITIONS": self.read_initial, "TIE": self.read_tie, "EQUATION": self.equations.read, "TRANSFORM": self.axes.read,
                         "TEMPERATURE": self.temperature.read}

    def begin_step(self):
        self.displaced = {}  # in the present step: (row, component) -> the course before it
        self.forced = {}  # the same -> [the course before it, amplitude, value of the step]
        self.new = None  # the first card with OP=NEW of displacements
        self.loads.begin_step()
        self.temperature.begin_step()

    def read(self, card):
        """Whether the card is one of conditions."""
        if card.keyword == "STEP":
            self.begin_step()
        if card.keyword == "ENDSTEP":
            self.end_step()
        if card.keyword not in self.handlers:
            return False
        if self.steps.skipped:
            return True
        if self.has_what_it_needs(card):
            self.handlers[card.keyword](card)
        return True

    def has_what_it_needs(self, card):
        for name in card.parameters:
            if name in DECISIVE.get(card.keyword, ()):
                self.diagnostics.missing(card.line, f"{card.title}, {name}: it has no counterpart, and its data are left out")
                return False
            if name not in KNOWN_PARAMETERS.get(card.keyword, card.parameters):
                self.diagnostics.omit(card.line, f"{card.title}, {name}: the parameter")
        return True

    def is_new(self, card):
        """Whether the card removes what earlier steps gave."""
        return card.upper("OP") == "NEW" and self.steps.start > 0

    def target(self, text, line):
        """The name of a set of nodes, or the row of a node."""
        name = self.mesh.spelled("node", text)
        if name not in self.model.node_sets:
            name = self.mesh.row_of(text)
            if name is None:
                if text.rpartition(".")[2].isdigit():
                    raise self.diagnostics.wrong(line, f"node {text} is not defined")
                raise self.diagnostics.undefined(line, f"the set of nodes '{text}' is not defined before this line", text, self.model.node_sets)
        self.lines.setdefault(name, line)
        return name

    # ------------------------------------------------------------------ displacements
    def read_boundary(self, card):
        if card.upper("TYPE", "DISPLACEMENT") != "DISPLACEMENT":
            self.diagnostics.missing(card.line, f"{card.title}, TYPE={card.upper('TYPE')}: write the displacement as a formula of t")
            return
        if card.has("SUBMODEL") or card.has("USER"):
            self.diagnostics.missing(card.line, f"{card.title} of another model or of a subroutine")
            return
        if self.is_new(card):
            self.new = self.new or card
        for line, entries in card.data:
            target = self.target(entries[0], line)
            named = entries[1].upper() if len(entries) > 1 else ""
            value = 0.0
            if named in NAMED_SUPPORTS:
                components = NAMED_SUPPORTS[named]
            elif named.isalpha():
                raise self.diagnostics.undefined(line, f"'{entries[1]}' is not a support", named, NAMED_SUPPORTS)
            else:
                first = whole(named, line, self.diagnostics, "the first degree of freedom")
                last = whole(entries[2] if len(entries) > 2 and entries[2] else named, line, self.diagnostics, "the last degree of freedom")
                components = range(first, last + 1)
                if last < first:
                    raise self.diagnostics.wrong(line, f"the last degree of freedom, {last}, is below the first, {first}")
                value = real(entries, 3, line, self.diagnostics, "the displacement", 0.0)
            if any(not 1 <= c <= 6 for c in components[:7]):
                self.diagnostics.omit(line, f"{card.title} of degrees of freedom that are not displacements")
            for c in components[:7]:
                if 1 <= c <= 6:
                    self.prescribe(card, line, target, c - 1, value)

    def prescribe(self, card, line, target, component, value):
        groups = {}  # by what was before the step
        for row in self.prescribed.rows(target):
            key = (row, component)
            groups.setdefault(self.displaced.get(key, self.prescribed.course.get(key)), []).append(row)
        if None in groups and self.steps.in_step and self.steps.start > 0:
            rows = [row for some in groups.values() for row in some]
            self.late.append((card, line, target, component, rows, self.steps.start))  # of a part of a set, too: none of it moves
            return
        for before, rows in groups.items():
            course = self.steps.kept(before) if card.has("FIXED") and before is not None else self.steps.course_of(card, before, value)
            self.displaced.update({(row, component): before for row in rows})
            if course is not None:
                self.prescribed.set(target, component, rows, Course.constant(course.at(0.0)) if course.is_constant else course)

    def end_step(self):
        """Displacements that OP=NEW does not repeat are released; they remain here."""
        if self.new is None or self.steps.skipped:
            return
        names = {}
        for target, component in self.prescribed.said:
            rows = self.prescribed.rows(target)
            if component < 3 and any((row, component) in self.prescribed.course and (row, component) not in self.displaced for row in rows):
                names.setdefault(target, []).append(AXES[component])
        for target, components in names.items():
            self.diagnostics.missing(self.new.line, f"{self.new.title}, OP=NEW releases the displacements of {self.said(target)} in {', '.join(components)} at "
                                     f"t = {self.steps.start:g}: a constraint holds to the end of a run, and they remain")

    def said(self, target):
        return target if isinstance(target, str) else f"node {self.mesh.label_of(target)}"

    def list_late(self, references):
        listed = {}
        for card, line, target, component, rows, time in self.late:
            if component < 3 or any(row in references for row in rows):
                listed.setdefault((card.title, line, target, time), []).append(str(component + 1))
        for (title, line, target, time), components in listed.items():
            self.diagnostics.missing(line, f"{title} on {self.said(target)} (degrees of freedom {', '.join(components)}) begins at t = {time:g}: a constraint holds "
                                     "from the start of a run, and this one is left out")

    # ------------------------------------------------------------------ forces
    def read_forces(self, card):
        if self.is_new(card):
            for key, course in self.forces.course.items():
                if key not in self.forced:
                    self.forced[key] = [course, None, 0.0]
                    self.forces.course[key] = self.steps.removed(course)
        for line, entries in card.data:
            component = whole(entries[1] if len(entries) > 1 else "", line, self.diagnostics, "the degree of freedom")
            if not 1 <= component <= 6:
                self.diagnostics.missing(line, f"{card.title}: a flux")
                continue
            self.force(card, line, self.target(entries[0], line), component - 1, real(entries, 2, line, self.diagnostics, "the force"))

    def force(self, card, line, target, component, value):
        """Forces of one step on one node add up."""
        amplitude, groups = card.upper("AMPLITUDE"), {}
        for row in self.forces.rows(target):
            before, given, so_far = self.forced.get((row, component), [self.forces.course.get((row, component)), None, 0.0])
            if given not in (None, amplitude):
                self.diagnostics.missing(line, f"{card.title}: a second load on the same place, with another amplitude: add it to the first one in the input")
                return
            groups.setdefault((before, so_far + value), []).append(row)
        for (before, total), rows in groups.items():
            course = self.steps.course_of(card, before, total)
            if course is not None:
                self.forces.set(target, component, rows, Course.constant(course.at(0.0)) if course.is_constant else course)
                self.forced.update({(row, component): [before, amplitude, total] for row in rows})

    # ------------------------------------------------------------------ other conditions
    def read_initial(self, card):
        if card.upper("TYPE") == "TEMPERATURE" and card.data and not card.has("FILE"):
            self.temperature.read_initial(card)
            return
        if card.upper("TYPE") != "VELOCITY":
            self.diagnostics.missing(card.line, f"{card.title}, TYPE={card.upper('TYPE')}")
            return
        for line, entries in card.data:
            component = whole(entries[1] if len(entries) > 1 else "", line, self.diagnostics, "the degree of freedom")
            self.velocities.append((line, self.mesh.nodes(entries[0], line), component, real(entries, 2, line, self.diagnostics, "the velocity")))

    def read_tie(self, card):
        if card.has("CYCLICSYMMETRY") or card.has("MULTISTAGE"):
            self.diagnostics.missing(card.line, f"{card.title} of a sector: periodic conditions across a rotation")
            return
        for line, entries in card.data:
            dependent, independent = (self.mesh.spelled("surface", entry) for entry in (entries + [""])[:2])
            if dependent not in self.model.surfaces or independent not in self.model.surfaces:
                self.diagnostics.missing(line, f"{card.title} of surfaces that are not made of faces of elements")
                continue
            keys = {"tied_to": independent}
            if card.value("POSITIONTOLERANCE"):
                keys["tolerance"] = Quantity(self.diagnostics.number(card.value("POSITIONTOLERANCE"), card.line, "the tolerance"), LENGTH)
            self.model.constraints.append((Selection("face", dependent), keys))

    # ------------------------------------------------------------------ the input
    def finish(self, nonlinear, material_of):
        """Writes constraints, loads, expansion and time into the model. `material_of`: by the set of elements of a body."""
        steps = self.steps
        self.model.end = steps.end
        if steps.kind is None:
            self.diagnostics.note(None, "no step is static or dynamic: the input is static")
        relaxes = any(body.viscosity for body in self.model.bodies)
        self.is_one_state = steps.kind is None or steps.kind == "static" and not (nonlinear or relaxes or self.model.contact.is_there) and steps.num_steps <= 1 and not steps.has_amplitudes
        if self.is_one_state:
            self.model.time = {"method": "static"}
        else:
            self.model.time = {"method": "bdf2" if steps.kind == "dynamic" else "quasistatic", "step": Quantity(steps.increment, TIME),
                               "end": Quantity(steps.end, TIME)}
        self.used = {node for body in self.model.bodies for row in self.model.element_sets[body.elements] for node in self.model.elements[row]}
        references = self.rigid.finish(self.prescribed, self.forces, self.value)
        self.list_late(references)
        self.axes.list_references(references)
        references = references | self.equations.finish(self.prescribed, self.forces, self.used, references, self.value)
        self.axes.turn_forces(self.forces)
        self.axes.take_displacements(self.prescribed, self.used, self.value)
        self.axes.list_nodes_on_axes()
        add_prescribed(self.model, self.diagnostics, self.by_set(references), self.value)
        self.add_forces(references)
        self.loads.finish(nonlinear, self.value)
        self.add_velocity()
        self.temperature.finish(material_of, self.value)

    def value(self, course, dimension):
        if self.is_one_state:
            course = Course.constant(course.at(self.steps.end))
        return Quantity(course, dimension)

    def in_elements(self, target, rows, references, what):
        """Those of the rows that belong to elements; the others are listed."""
        others = [row for row in rows if row not in references]
        inside = [row for row in others if row in self.used]
        lost = len(others) - len(inside)
        if lost > 0:
            whose = f"node {self.mesh.label_of(target)}, which belongs" if not isinstance(target, str) else f"{lost} of {len(rows)} nodes of {target}, which belong"
            self.diagnostics.missing(self.lines[target], f"{what} on {whose} to no element of the input, and to no rigid part or coupling that it has: left out")
        return inside

    def by_set(self, references):
        """Displacements by sets; nodes without a set, and those of a set that keep its displacement, become sets of their own."""
        sets, alike, parts = {}, {}, {}
        for target, component, course, rows in self.prescribed.by_target():
            if component > 2:
                continue
            inside = self.in_elements(target, rows, references, "*BOUNDARY")
            if not inside:
                continue
            if not isinstance(target, str):
                alike.setdefault(target, {})[component] = course
            elif len(inside) == sum(row in self.used for row in self.prescribed.rows(target)):
                sets.setdefault(target, {})[component] = course
            else:
                parts.setdefault((target, tuple(inside)), {})[component] = course
        for row, components in alike.items():
            parts.setdefault(("nodes", tuple(sorted(components.items()))), []).append(row)
        for (stem, key), value in parts.items():
            rows, components = (value, dict(key)) if isinstance(value, list) else (list(key), value)
            if not isinstance(value, list) and not self.are_turned(stem, rows):
                self.diagnostics.note(None, f"*BOUNDARY: {len(rows)} nodes of {stem} keep its displacement in {', '.join(AXES[c] for c in components)}, and later "
                                      "ones hold for the others, as in the model")
            name = self.model.new_name(stem)
            self.model.node_sets[name] = rows
            sets[name] = components
        return sets

    def are_turned(self, target, rows):
        """Whether the other nodes of a set have axes of their own, along which their displacements are written."""
        return all(row in self.axes.systems for row in set(self.prescribed.rows(target)) - set(rows))

    def add_forces(self, references):
        pieces, names, done = {}, {}, set()  # pieces: nodes by (name of a set or "", component, course), each node once
        for target, component in self.forces.said:
            inside = self.in_elements(target, self.forces.rows(target), references, "*CLOAD")
            if component > 2:
                if inside:
                    self.diagnostics.missing(self.lines[target], "*CLOAD: left out; nodes of solid elements take forces and no moment")
                continue
            name = target if isinstance(target, str) else ""
            for row in inside:
                if (row, component) not in done and (row, component) in self.forces.course:
                    pieces.setdefault((name, component, self.forces.course[row, component]), []).append(row)
                    done.add((row, component))
            names.setdefault(frozenset(inside), name)
        forces = {}  # by nodes
        for (_, component, course), rows in pieces.items():
            forces.setdefault(frozenset(rows), [None] * 3)[component] = course
        for rows, courses in forces.items():
            name = names.get(rows)
            if not name or len(self.model.node_sets[name]) != len(rows):
                name = self.model.new_name("nodes")
                self.model.node_sets[name] = sorted(rows)
            self.model.nodal_forces.append((name, constant_at_end(courses, self.steps.end) if self.is_one_state else courses))

    def add_velocity(self):
        velocity, used = [0.0, 0.0, 0.0], {row for rows in self.model.elements for row in rows}
        for line, rows, component, value in self.velocities:
            if not used <= set(rows) or not 1 <= component <= 3:
                self.diagnostics.missing(line, "*INITIAL CONDITIONS, TYPE=VELOCITY of a part of the nodes: `initial.velocity` is one formula of x, y, z for all")
                continue
            velocity[component - 1] = value
        if any(velocity):
            self.model.initial_velocity = [Quantity(v, VELOCITY) if v else 0 for v in velocity]
