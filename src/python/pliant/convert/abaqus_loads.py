"""Distributed loads of an input file of Abaqus or CalculiX: *DLOAD, *DSLOAD."""
import dataclasses
import math
import re

from .abaqus_deck import real
from .conditions import normal_of
from .course import Course
from .model import ACCELERATION, FORCE_DENSITY, STRESS, Selection

KNOWN = re.compile(r"P|P[1-6]|GRAV|TRVEC|B[XYZ]")  # types
KEYS = {"GRAV": ("gravity", ACCELERATION), "TRVEC": ("traction", STRESS), "B": ("force_density", FORCE_DENSITY)}


@dataclasses.dataclass
class Load:
    """A pressure, or a component of a vector, on `members`: faces by their corners, or rows of elements."""

    keyword: str
    members: frozenset
    course: "Course | None" = None


class DistributedLoads:
    """Reads loads. `loads`: by (kind, set or surface, component); the kind is P, P1, ..., GRAV, TRVEC or B."""

    def __init__(self, model, mesh, steps, diagnostics):
        self.model, self.mesh, self.steps, self.diagnostics = model, mesh, steps, diagnostics
        self.loads = {}
        self.faces = {}  # of a pressure on elements, in the order of their corners
        self.begin_step()

    def begin_step(self):
        self.given = {}  # in the present step: [the course before it, amplitude, value of the step]

    def read(self, card):
        if card.upper("OP") == "NEW" and self.steps.start > 0:
            self.remove(card)
        for line, entries in card.data:
            if len(entries) < 2:
                raise self.diagnostics.wrong(line, f"{card.title} needs a set or surface, a type and a magnitude")
            on, label = self.mesh.spelled("element", entries[0]), entries[1].upper()
            value = real(entries, 2, line, self.diagnostics, "the magnitude", None if KNOWN.fullmatch(label) else 0.0)
            surface = self.mesh.spelled("surface", entries[0])
            if card.keyword == "DSLOAD":
                self.mesh.faces_named(entries[0], line)
            if label == "P" and surface in self.model.surfaces:
                self.change(card, line, ("P", surface, None), value, self.model.surfaces[surface])
            elif re.fullmatch(r"P[1-6]", label):
                self.faces[on, label] = self.mesh.sides(self.mesh.elements(on, line), "S" + label[1], line)
                self.change(card, line, (label, on, None), value, self.faces[on, label])
            elif label == "GRAV":
                self.change_vector(card, line, ("GRAV", on), value, self.direction(entries, line))
            elif label == "TRVEC" and surface in self.model.surfaces:
                if card.upper("FOLLOWER", "YES") != "NO":
                    self.diagnostics.note(line, f"{card.title}, TRVEC: the traction keeps its direction, and does not rotate with the surface")
                self.change_vector(card, line, ("TRVEC", surface), value, self.direction(entries, line))
            elif label in ("BX", "BY", "BZ"):
                self.change(card, line, ("B", on, "XYZ".index(label[1])), value, self.elements(on, line))
            else:
                self.diagnostics.missing(line, f"{card.title} of the type {label}: left out; loads of this type have no counterpart")

    def direction(self, entries, line):
        direction = [real(entries, k, line, self.diagnostics, "the direction") for k in (3, 4, 5)]
        length = math.sqrt(sum(x * x for x in direction))
        if length == 0:
            raise self.diagnostics.wrong(line, "the direction has no length")
        return [x / length for x in direction]

    def elements(self, on, line):
        """Rows of elements; those of the whole model for a load without a set."""
        return range(len(self.model.elements)) if not on else self.mesh.elements(on, line)

    def change_vector(self, card, line, key, value, direction):
        members = self.model.surfaces[key[1]] if key[0] == "TRVEC" else self.elements(key[1], line)
        keys = [(*key, component) for component in range(3)]
        before = [self.loads[one].course.at(self.steps.start) if one in self.loads and one not in self.given else 0.0 for one in keys]
        turned = [before[a] * direction[b] - before[b] * direction[a] for a, b in ((0, 1), (1, 2), (2, 0))]
        if max(map(abs, turned)) > 1e-9 * max(map(abs, before)):
            self.diagnostics.note(line, f"{card.title}, {key[0]} on {key[1] or 'the model'} replaces that of an earlier step, which has another direction, as in Abaqus; "
                                  "CalculiX adds them")
        for one, part in zip(keys, direction):
            if part or one in self.loads:
                self.change(card, line, one, value * part, members)

    def change(self, card, line, key, value, members):
        """What the present step gives replaces what was before; loads of one step add up."""
        if not members:
            self.diagnostics.missing(line, f"{card.title} of the type {key[0]} on {key[1]}, which has no elements of the input: left out")
            return
        members = frozenset(map(frozenset, members)) if key[0][0] in "PT" else frozenset(members)
        key = self.known(card, key, members)
        if key is None:
            self.diagnostics.missing(line, f"{card.title} on a part of what has such a load of an earlier step by another name: left out")
            return
        load = self.loads.get(key)
        amplitude = card.upper("AMPLITUDE")
        before, given, so_far = self.given.get(key, [load.course if load else None, None, 0.0])
        if given not in (None, amplitude):
            self.diagnostics.missing(line, f"{card.title}: a second load on the same place, with another amplitude: add it to the first one in the input")
            return
        course = self.steps.course_of(card, before, so_far + value)
        if course is not None:
            self.loads[key] = Load(card.keyword, members, Course.constant(course.at(0.0)) if course.is_constant else course)
            self.given[key] = [before, amplitude, so_far + value]

    def known(self, card, key, members):
        """The key of a load of an earlier step on the same members, whatever their name, or this one; None if it is on some of them."""
        if key in self.loads or self.steps.start == 0:
            return key
        for other, load in self.loads.items():
            if load.keyword == card.keyword and other not in self.given and other[2] == key[2] and other[0][0] == key[0][0] and load.members & members:
                return other if load.members == members else None
        return key

    def remove(self, card):
        """OP=NEW removes the loads of this keyword that earlier steps gave."""
        for key, load in self.loads.items():
            if key in self.given or load.course.is_constant and load.course.at(0.0) == 0:
                continue
            if load.keyword != card.keyword:
                self.diagnostics.note(card.line, f"{card.title}, OP=NEW: the loads of *{load.keyword} of earlier steps remain, as in Abaqus; CalculiX removes them")
                continue
            self.given[key] = [load.course, None, 0.0]
            load.course = self.steps.removed(load.course)

    # ------------------------------------------------------------------ the input
    def finish(self, nonlinear, value):
        """Writes the loads into the model; `value` makes a quantity of a course."""
        self.add_pressures(nonlinear, value)
        vectors = {}
        for (kind, on, component), load in self.loads.items():
            if component is not None:
                vectors.setdefault((kind, on), [0, 0, 0])[component] = value(load.course, KEYS[kind][1])
        for (kind, on), vector in vectors.items():
            self.add_vector(kind, on, vector)

    def add_pressures(self, nonlinear, value):
        by_course = {}
        for (label, on, component), load in self.loads.items():
            if component is not None:
                continue
            if label == "P":
                self.add_pressure(on, load.course, nonlinear, value)
            elif on.isdigit():
                by_course.setdefault(load.course, []).extend(self.faces[on, label])
            else:
                name = f"{on}_{label}"
                if name in self.model.surfaces:
                    name = self.model.new_name(name)
                self.model.surfaces[name] = self.faces[on, label]
                self.add_pressure(name, load.course, nonlinear, value)
        for course, faces in by_course.items():
            name = self.model.new_name("pressure")
            self.model.surfaces[name] = faces
            self.add_pressure(name, course, nonlinear, value)

    def add_pressure(self, surface, course, nonlinear, value):
        """In a linear analysis the pressure acts on the shape at the start: on a plane surface it is a traction."""
        normal = None if nonlinear else normal_of(self.model, surface)
        if normal is not None:
            keys = {"traction": [0 if n == 0 else value(course.scaled(-n), STRESS) for n in normal]}
        else:
            keys = {"pressure": value(course, STRESS)}
            if not nonlinear:
                self.diagnostics.note(None, f"the pressure on the curved surface {surface} follows it; in the linear analysis of the model it does not")
        self.model.loads.append((Selection("face", surface), keys))

    def add_vector(self, kind, on, vector):
        key = KEYS[kind][0]
        if kind == "TRVEC":
            self.model.loads.append((Selection("face", on), {key: vector}))
            return
        name = on if on in self.model.element_sets else self.mesh.spelled("element", on)
        everything = {row for body in self.model.bodies for row in self.model.element_sets[body.elements]}
        if not on or name in self.model.element_sets and everything <= set(self.model.element_sets[name]):
            self.model.loads.append((None, {key: vector}))
        elif name in self.model.element_sets:
            self.model.loads.append((Selection("element", name), {key: vector}))
        else:
            name = self.model.new_name("element")
            self.model.element_sets[name] = self.mesh.elements(on, 0)
            self.model.loads.append((Selection("element", name), {key: vector}))
