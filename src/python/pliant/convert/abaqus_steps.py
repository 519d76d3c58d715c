"""Conditions and steps of an input file of Abaqus or CalculiX."""
import math
import re

from .abaqus_deck import real, whole
from .conditions import add_prescribed, normal_of
from .course import Course, Segment
from .forces import constant_at_end
from .model import ACCELERATION, FORCE_DENSITY, LENGTH, STRESS, TIME, VELOCITY, Quantity, Selection

NAMED_SUPPORTS = {"ENCASTRE": (1, 2, 3), "PINNED": (1, 2, 3), "XSYMM": (1,), "YSYMM": (2,), "ZSYMM": (3,)}
STATIC, DYNAMIC = ("STATIC", "VISCO"), ("DYNAMIC",)
OTHER_ANALYSES = ("FREQUENCY", "BUCKLE", "MODALDYNAMIC", "STEADYSTATEDYNAMICS", "HEATTRANSFER", "COUPLEDTEMPERATURE-DISPLACEMENT", "GREEN",
                  "UNCOUPLEDTEMPERATURE-DISPLACEMENT", "ELECTROMAGNETICS", "SENSITIVITY", "COMPLEXFREQUENCY", "SUBSTRUCTUREGENERATE", "NOANALYSIS")
KNOWN_PARAMETERS = {"BOUNDARY": {"OP", "AMPLITUDE", "TYPE", "TIMEDELAY", "USER", "SUBMODEL"}, "CLOAD": {"OP", "AMPLITUDE", "TIMEDELAY"},
                    "DLOAD": {"OP", "AMPLITUDE", "TIMEDELAY", "FOLLOWER"}, "DSLOAD": {"OP", "AMPLITUDE", "TIMEDELAY", "FOLLOWER"},
                    "STEP": {"NLGEOM", "INC", "NAME", "AMPLITUDE"}, "AMPLITUDE": {"NAME", "DEFINITION", "TIME", "SHIFTX"},
                    "TIE": {"NAME", "POSITIONTOLERANCE", "CYCLICSYMMETRY", "MULTISTAGE", "TYPE"}}
# The longest run of equal steps that follows from a first increment which the program would have let grow.
MOST_STEPS = 100


class AbaqusSteps:
    """Reads boundary conditions, loads and steps; each condition becomes a function of time over all steps."""

    def __init__(self, model, mesh, diagnostics):
        self.model, self.mesh, self.diagnostics = model, mesh, diagnostics
        self.amplitudes = {}
        self.prescribed = {}  # (name of a set or number of a node, component) -> Course
        self.forces = {}  # the same
        self.pressures = {}  # (surface or element, label) -> Course
        self.others = {}  # (kind, set or surface, direction) -> Course
        self.faces = {}  # of a pressure on elements
        self.velocities = []
        self.start = self.end = 0.0
        self.in_step = self.is_nonlinear = self.step_is_nonlinear = self.skipped = self.has_amplitudes = False
        self.given = {}  # in the present step, by table and key: the course before it, and [card, value] of the step
        self.kind, self.procedure = None, ""
        self.num_steps, self.increment, self.procedure_read = 0, 0.0, False
        self.handlers = {"AMPLITUDE": self.read_amplitude, "BOUNDARY": self.read_boundary, "CLOAD": self.read_forces, "DLOAD": self.read_loads,
                         "DSLOAD": self.read_loads, "INITIALCONDITIONS": self.read_initial, "TIE": self.read_tie, "STEP": self.begin_step,
                         "ENDSTEP": self.end_step, **{name: self.read_procedure for name in (*STATIC, *DYNAMIC)},
                         **{name: self.read_other_analysis for name in OTHER_ANALYSES}}

    def read(self, card):
        """Whether the card is one of conditions or steps."""
        if card.keyword not in self.handlers:
            return False
        if self.skipped and card.keyword not in ("STEP", "ENDSTEP"):
            return True
        for name in card.parameters:
            if name not in KNOWN_PARAMETERS.get(card.keyword, card.parameters):
                self.diagnostics.omit(card.line, f"{card.title}, {name}: the parameter")
        self.handlers[card.keyword](card)
        return True

    # ------------------------------------------------------------------ steps
    def begin_step(self, card):
        self.in_step, self.procedure_read, self.step_card = True, False, card
        self.step_is_nonlinear = card.has("NLGEOM") and card.upper("NLGEOM") != "NO"
        self.skipped = False
        self.given = {}

    def end_step(self, _):
        if self.in_step and not self.skipped:
            self.start = self.end
        self.in_step = self.skipped = False

    def skip(self, card, reason):
        self.skipped = True
        self.diagnostics.omit(card.line, f"the step with {card.title}, and its conditions: {reason}")

    def read_other_analysis(self, card):
        reason = "natural frequencies: run `pliant modes` on the input" if card.keyword == "FREQUENCY" else "Pliant has no analysis of this kind"
        self.skip(card, reason)

    def read_procedure(self, card):
        kind = "dynamic" if card.keyword in DYNAMIC else "static"
        if self.kind not in (None, kind):
            self.skip(card, f"an input has one method, and the steps before are {self.kind}")
            return
        if not self.in_step:
            raise self.diagnostics.wrong(card.line, f"{card.title} stands outside of a step (*STEP)")
        self.kind, self.procedure = kind, card.keyword
        entries = card.data[0][1] if card.data else []
        line = card.data[0][0] if card.data else card.line
        increment = real(entries, 0, line, self.diagnostics, "the first increment", 1.0)
        period = real(entries, 1, line, self.diagnostics, "the length of the step", 1.0)
        if period <= 0:
            raise self.diagnostics.wrong(line, "the length of the step must be above 0")
        self.end = self.start + period
        self.num_steps += 1
        self.is_nonlinear = self.is_nonlinear or self.step_is_nonlinear
        if card.has("EXPLICIT"):
            self.diagnostics.note(card.line, f"{card.title}, EXPLICIT becomes an implicit method with a step of 1/{MOST_STEPS} of the period")
            increment = 0
        if not 0 < increment <= period or increment < period / MOST_STEPS and not card.has("DIRECT"):
            increment = period / MOST_STEPS
            self.diagnostics.note(card.line, f"{card.title}: increments that the program chooses become equal steps of 1/{MOST_STEPS} of the period; "
                                  "`time.adaptive` follows the error of a motion")
        self.increment = min(self.increment or increment, increment)
        if card.has("RIKS"):
            self.diagnostics.missing(card.line, f"{card.title}, RIKS: write `time: {{method: static, path: {{max_load: ..}}}}` into the input")
        for name in card.parameters:
            if name not in ("DIRECT", "EXPLICIT", "SOLVER", "ALPHA", "RIKS"):
                self.diagnostics.omit(card.line, f"{card.title}, {name}")

    # ------------------------------------------------------------------ conditions
    def read_amplitude(self, card):
        kind = card.upper("DEFINITION", "TABULAR")
        name = card.upper("NAME")
        flat = [real(entries, k, line, self.diagnostics, "a number of the amplitude") for line, entries in card.data
                for k in range(len(entries)) if entries[k]]
        points = list(zip(flat[::2], flat[1::2]))
        if kind not in ("TABULAR", "SMOOTHSTEP", "SMOOTH STEP") or not points:
            self.diagnostics.missing(card.line, f"{card.title}, DEFINITION={kind}: write its formula of t into the input; conditions with it are left out")
            self.amplitudes[name] = None
            return
        by = real([card.value("SHIFTX")], 0, card.line, self.diagnostics, "SHIFTX", 0.0)
        course = Course.through(points, "linear" if kind == "TABULAR" else "smooth").shifted(by)
        self.amplitudes[name] = (course, card.upper("TIME").startswith("TOTAL"))

    def course_of(self, card, before, value):
        """The function of time with this magnitude in the present step; None if its amplitude is unknown."""
        if not self.in_step:
            return Course.constant(value)
        if not self.procedure_read and self.end <= self.start:
            raise self.diagnostics.wrong(card.line, f"{card.title} stands before the procedure of its step (*STATIC, *DYNAMIC)")
        name = card.upper("AMPLITUDE")
        if name:
            if name not in self.amplitudes:
                raise self.diagnostics.wrong(card.line, f"the amplitude '{card.value('AMPLITUDE')}' is not defined before this line")
            if self.amplitudes[name] is None:
                return None
            self.has_amplitudes = True
            course, is_total = self.amplitudes[name]
            course = course.shifted(real([card.value("TIMEDELAY")], 0, card.line, self.diagnostics, "TIME DELAY", 0.0))
            course = (course if is_total else course.shifted(self.start)).scaled(value)
            piece = course.within(self.start, max(self.end, course.segments[-1].end) if is_total else self.end)
        else:
            first = before.at(self.start) if before is not None else 0.0
            ramps = self.step_card.upper("AMPLITUDE", "RAMP" if self.procedure == "STATIC" else "STEP") == "RAMP"
            piece = Course((Segment(self.start, self.end, first if ramps else value, value),))
        if self.start > 0:
            return (before or Course.constant(0.0)).within(0.0, self.start).followed_by(piece)
        return piece

    def change(self, card, table, key, value, adds=False):
        """What the present step gives replaces what was before; loads of one step add up."""
        before, given = self.given.setdefault((id(table), key), (table.get(key), []))
        if adds and given and given[0].upper("AMPLITUDE") != card.upper("AMPLITUDE"):
            self.diagnostics.missing(card.line, f"{card.title}: a second load on the same place, with another amplitude: add it to the first one in the input")
            return
        if not adds or not given:
            given[:] = [card, 0.0]
        given[1] += value
        course = self.course_of(card, before, given[1])
        if course is not None:
            table[key] = Course.constant(course.at(0.0)) if course.is_constant else course

    def reset(self, card, *tables):
        """OP=NEW: what was before is removed."""
        if card.upper("OP") != "NEW" or self.num_steps < 2:
            return
        if self.prescribed in tables and self.prescribed:
            self.diagnostics.omit(card.line, f"{card.title}, OP=NEW: constraints of earlier steps cannot be released, and remain")
            return
        for table in tables:
            for key in table:
                if (id(table), key) in self.given:
                    continue  # given or removed by another card of this step
                self.change(card, table, key, 0.0)
                self.given[id(table), key][1].clear()  # what follows replaces it

    def target(self, text, line):
        """The name of a set of nodes, or the number of a node."""
        name = self.mesh.spelled("node", text)
        if name in self.model.node_sets:
            return name
        if not text.isdigit():
            raise self.diagnostics.wrong(line, f"the set of nodes '{text}' is not defined before this line")
        return int(text)

    def read_boundary(self, card):
        if card.upper("TYPE", "DISPLACEMENT") != "DISPLACEMENT":
            self.diagnostics.missing(card.line, f"{card.title}, TYPE={card.upper('TYPE')}: write the displacement as a formula of t")
            return
        if card.has("SUBMODEL") or card.has("USER"):
            self.diagnostics.missing(card.line, f"{card.title} of another model or of a subroutine")
            return
        self.reset(card, self.prescribed)
        for line, entries in card.data:
            target = self.target(entries[0], line)
            named = entries[1].upper() if len(entries) > 1 else ""
            if named in NAMED_SUPPORTS:
                components, value = NAMED_SUPPORTS[named], 0.0
            else:
                first = whole(named, line, self.diagnostics, "the first degree of freedom")
                last = whole(entries[2] if len(entries) > 2 and entries[2] else named, line, self.diagnostics, "the last degree of freedom")
                components = range(first, last + 1)
                value = real(entries, 3, line, self.diagnostics, "the displacement", 0.0)
            if any(c > 6 for c in components):
                self.diagnostics.omit(line, f"{card.title} of degrees of freedom that are not displacements")
            for c in components:
                if c <= 3:
                    self.change(card, self.prescribed, (target, c - 1), value)

    def read_forces(self, card):
        self.reset(card, self.forces)
        for line, entries in card.data:
            component = whole(entries[1] if len(entries) > 1 else "", line, self.diagnostics, "the degree of freedom")
            if not 1 <= component <= 3:
                self.diagnostics.missing(line, f"{card.title}: a moment, or a flux")
                continue
            self.change(card, self.forces, (self.target(entries[0], line), component - 1), real(entries, 2, line, self.diagnostics, "the force"), adds=True)

    def read_loads(self, card):
        self.reset(card, self.pressures, self.others)
        for line, entries in card.data:
            if len(entries) < 2:
                raise self.diagnostics.wrong(line, f"{card.title} needs a set or surface, a type and a magnitude")
            on, label = self.mesh.spelled("element", entries[0]), entries[1].upper()
            value = real(entries, 2, line, self.diagnostics, "the magnitude")
            surface = self.mesh.spelled("surface", entries[0])
            if label == "P" and surface in self.model.surfaces:
                self.change(card, self.pressures, (surface, "P"), value, adds=True)
            elif re.fullmatch(r"P[1-6]", label):
                self.faces[on, label] = self.mesh.sides(self.mesh.elements(on, line), "S" + label[1], line)
                self.change(card, self.pressures, (on, label), value, adds=True)
            elif label in ("GRAV", "TRVEC") and (label == "GRAV" or surface in self.model.surfaces):
                direction = [real(entries, k, line, self.diagnostics, "the direction") for k in (3, 4, 5)]
                length = math.sqrt(sum(x * x for x in direction))
                if length == 0:
                    raise self.diagnostics.wrong(line, "the direction has no length")
                if label == "TRVEC" and card.upper("FOLLOWER", "YES") != "NO":
                    self.diagnostics.note(line, f"{card.title}, TRVEC: the traction keeps its direction, and does not rotate with the surface")
                self.change(card, self.others, (label, surface if label == "TRVEC" else on, tuple(x / length for x in direction)), value, adds=True)
            elif label in ("BX", "BY", "BZ"):
                self.change(card, self.others, ("B", on, tuple(float(label == b) for b in ("BX", "BY", "BZ"))), value, adds=True)
            else:
                self.diagnostics.missing(line, f"{card.title} of the type {label}")

    def read_initial(self, card):
        if card.upper("TYPE") != "VELOCITY":
            self.diagnostics.omit(card.line, f"{card.title}, TYPE={card.upper('TYPE')}")
            return
        for line, entries in card.data:
            component = whole(entries[1] if len(entries) > 1 else "", line, self.diagnostics, "the degree of freedom")
            self.velocities.append((line, self.mesh.nodes(entries[0], line), component, real(entries, 2, line, self.diagnostics, "the velocity")))

    def read_tie(self, card):
        if card.has("CYCLICSYMMETRY") or card.has("MULTISTAGE"):
            self.diagnostics.omit(card.line, f"{card.title} of a sector: periodic conditions across a rotation")
            return
        for line, entries in card.data:
            dependent, independent = (self.mesh.spelled("surface", entry) for entry in (entries + [""])[:2])
            if dependent not in self.model.surfaces or independent not in self.model.surfaces:
                self.diagnostics.omit(line, f"{card.title} of surfaces that are not made of faces of elements")
                continue
            keys = {"tied_to": independent}
            if card.value("POSITIONTOLERANCE"):
                keys["tolerance"] = Quantity(self.diagnostics.number(card.value("POSITIONTOLERANCE"), card.line, "the tolerance"), LENGTH)
            self.model.constraints.append((Selection("face", dependent), keys))

    # ------------------------------------------------------------------ the input
    def finish(self, nonlinear):
        """Writes constraints, loads and time into the model."""
        self.model.end = self.end
        if self.kind is None:
            self.diagnostics.note(None, "no step is static or dynamic: the input is static")
        relaxes = any(body.viscosity for body in self.model.bodies)
        self.is_one_state = self.kind != "dynamic" and not (nonlinear or relaxes) and self.num_steps <= 1 and not self.has_amplitudes
        if self.is_one_state:
            self.model.time = {"method": "static"}
        else:
            self.model.time = {"method": "bdf2" if self.kind == "dynamic" else "quasistatic", "step": Quantity(self.increment, TIME),
                               "end": Quantity(self.end, TIME)}
        add_prescribed(self.model, self.diagnostics, self.by_target(self.prescribed), self.value)
        self.add_forces()
        self.add_pressures(nonlinear)
        for (kind, on, direction), course in self.others.items():
            self.add_other(kind, on, direction, course)
        self.add_velocity()

    def value(self, course, dimension):
        if self.is_one_state:
            course = Course.constant(course.at(self.end))
        return Quantity(course, dimension)

    def by_target(self, table):
        """Conditions of sets by name; numbers of nodes become sets, one for each condition."""
        sets, numbers = {}, {}
        for (target, component), course in table.items():
            (sets if isinstance(target, str) else numbers).setdefault(target, {})[component] = course
        alike = {}
        for label, components in numbers.items():
            if label not in self.mesh.row_of_node:
                raise self.diagnostics.wrong(None, f"node {label} of a condition is not defined")
            alike.setdefault(tuple(sorted(components.items())), []).append(self.mesh.row_of_node[label])
        for components, rows in alike.items():
            name = self.new_name("nodes")
            self.model.node_sets[name] = rows
            sets[name] = dict(components)
        return sets

    def new_name(self, stem):
        taken = {*self.model.node_sets, *self.model.surfaces, *self.model.element_sets}
        return next(f"{stem}_{k}" for k in range(1, len(taken) + 2) if f"{stem}_{k}" not in taken)

    def add_forces(self):
        for name, components in self.by_target(self.forces).items():
            courses = [components.get(c) for c in range(3)]
            self.model.nodal_forces.append((name, constant_at_end(courses, self.end) if self.is_one_state else courses))

    def add_pressures(self, nonlinear):
        by_course = {}
        for (on, label), course in self.pressures.items():
            if label == "P":
                self.add_pressure(on, course, nonlinear)
            elif on.isdigit():
                by_course.setdefault(course, []).extend(self.faces[on, label])
            else:
                self.model.surfaces[f"{on}_{label}"] = self.faces[on, label]
                self.add_pressure(f"{on}_{label}", course, nonlinear)
        for course, faces in by_course.items():
            name = self.new_name("pressure")
            self.model.surfaces[name] = faces
            self.add_pressure(name, course, nonlinear)

    def add_pressure(self, surface, course, nonlinear):
        """In a linear analysis the pressure acts on the shape at the start: on a plane surface it is a traction."""
        normal = None if nonlinear else normal_of(self.model, surface)
        if normal is not None:
            keys = {"traction": [0 if n == 0 else self.value(course.scaled(-n), STRESS) for n in normal]}
        else:
            keys = {"pressure": self.value(course, STRESS)}
            if not nonlinear:
                self.diagnostics.note(None, f"the pressure on the curved surface {surface} follows it; in the linear analysis of the model it does not")
        self.model.loads.append((Selection("face", surface), keys))

    def add_other(self, kind, on, direction, course):
        dimension = {"GRAV": ACCELERATION, "TRVEC": STRESS, "B": FORCE_DENSITY}[kind]
        vector = [0 if d == 0 else self.value(course.scaled(d), dimension) for d in direction]
        key = {"GRAV": "gravity", "TRVEC": "traction", "B": "force_density"}[kind]
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
            name = self.new_name("element")
            self.model.element_sets[name] = self.mesh.elements(on, 0)
            self.model.loads.append((Selection("element", name), {key: vector}))

    def add_velocity(self):
        velocity, used = [0.0, 0.0, 0.0], {row for rows in self.model.elements for row in rows}
        for line, rows, component, value in self.velocities:
            if not used <= set(rows) or not 1 <= component <= 3:
                self.diagnostics.omit(line, "*INITIAL CONDITIONS, TYPE=VELOCITY of a part of the nodes: `initial.velocity` is one formula of x, y, z for all")
                continue
            velocity[component - 1] = value
        if any(velocity):
            self.model.initial_velocity = [Quantity(v, VELOCITY) if v else 0 for v in velocity]
