"""Steps and amplitudes of an input file of Abaqus or CalculiX."""
from .abaqus_deck import real
from .course import Course, Segment

STATIC, DYNAMIC = ("STATIC", "VISCO"), ("DYNAMIC",)
OTHER_ANALYSES = ("FREQUENCY", "BUCKLE", "MODALDYNAMIC", "STEADYSTATEDYNAMICS", "HEATTRANSFER", "COUPLEDTEMPERATURE-DISPLACEMENT", "GREEN",
                  "UNCOUPLEDTEMPERATURE-DISPLACEMENT", "ELECTROMAGNETICS", "SENSITIVITY", "COMPLEXFREQUENCY", "SUBSTRUCTUREGENERATE", "NOANALYSIS")
# The longest run of equal steps that follows from a first increment which the program would have let grow.
MOST_STEPS = 100


class AbaqusSteps:
    """Reads steps, whose times follow one another, and amplitudes; makes a function of time of a value that a step gives."""

    def __init__(self, diagnostics):
        self.diagnostics = diagnostics
        self.amplitudes = {}
        self.start = self.end = 0.0
        self.in_step = self.is_nonlinear = self.step_is_nonlinear = self.skipped = self.has_amplitudes = self.is_perturbation = False
        self.kind, self.procedure, self.rates = None, "", []
        self.num_steps, self.increment = 0, 0.0
        self.handlers = {"AMPLITUDE": self.read_amplitude, "STEP": self.begin_step, "ENDSTEP": self.end_step,
                         **{name: self.read_procedure for name in (*STATIC, *DYNAMIC)}, **{name: self.read_other_analysis for name in OTHER_ANALYSES}}

    def read(self, card):
        """Whether the card is one of steps."""
        if card.keyword not in self.handlers:
            return False
        if not self.skipped or card.keyword in ("STEP", "ENDSTEP"):
            self.handlers[card.keyword](card)
        return True

    def begin_step(self, card):
        if self.in_step:
            raise self.diagnostics.wrong(card.line, f"the step before this one, of line {self.step_card.line}, has no *END STEP")
        self.in_step, self.step_card = True, card
        self.step_is_nonlinear = card.has("NLGEOM") and card.upper("NLGEOM") != "NO"
        self.skipped = False
        if self.num_steps and (card.has("PERTURBATION") or self.is_perturbation):
            self.skip(card, "a linear perturbation is a run of its own")
        self.is_perturbation = self.is_perturbation or card.has("PERTURBATION")
        for name in card.parameters:
            if name not in ("NLGEOM", "INC", "NAME", "AMPLITUDE", "PERTURBATION", "UNSYMM", "EXTRAPOLATION", "CONVERTSDI", "SOLVER"):
                self.diagnostics.omit(card.line, f"{card.title}, {name}: the parameter")

    def end_step(self, _):
        if self.in_step and not self.skipped:
            self.start = self.end
        self.in_step = self.skipped = False

    def skip(self, card, reason, report=None):
        self.skipped = True
        (report or self.diagnostics.missing)(card.line, f"the step with {card.title}, and its conditions: {reason}")

    def read_other_analysis(self, card):
        if card.keyword == "FREQUENCY":
            self.skip(card, "natural frequencies: run `pliant modes` on the input", self.diagnostics.omit)
        else:
            self.skip(card, "Pliant has no analysis of this kind")

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
        if self.step_is_nonlinear and not self.is_nonlinear and self.num_steps > 1:
            self.diagnostics.note(self.step_card.line, f"{self.step_card.title}, NLGEOM: displacements are large in the input from the first step on")
        self.is_nonlinear = self.is_nonlinear or self.step_is_nonlinear
        self.rates.append("long term" if card.has("LONGTERM") else "none" if card.keyword == "STATIC" else "all")
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
            if name not in ("DIRECT", "EXPLICIT", "SOLVER", "ALPHA", "RIKS", "LONGTERM"):
                self.diagnostics.omit(card.line, f"{card.title}, {name}")

    # ------------------------------------------------------------------ functions of time
    def read_amplitude(self, card):
        kind = "".join(card.upper("DEFINITION", "TABULAR").split())
        name = card.upper("NAME")
        for parameter in card.parameters:
            if parameter not in ("NAME", "DEFINITION", "TIME", "SHIFTX", "SHIFTY", "VALUE"):
                self.diagnostics.omit(card.line, f"{card.title}, {parameter}: the parameter")
        if kind not in ("TABULAR", "SMOOTHSTEP") or not card.data or card.upper("VALUE", "RELATIVE") != "RELATIVE":
            said = f"VALUE={card.value('VALUE')}" if kind in ("TABULAR", "SMOOTHSTEP") and card.data else f"DEFINITION={kind}"
            self.diagnostics.missing(card.line, f"{card.title}, {said}: write its formula of t into the input; conditions with it are left out")
            self.amplitudes[name] = None
            return
        by, up = (self.shift(card, parameter) for parameter in ("SHIFTX", "SHIFTY"))
        points = [(t, value + up) for t, value in self.points(card)]
        course = Course.through(points, "linear" if kind == "TABULAR" else "smooth").shifted(by)
        self.amplitudes[name] = (course, card.upper("TIME").startswith("TOTAL"))

    def shift(self, card, parameter):
        return real([card.value(parameter)], 0, card.line, self.diagnostics, parameter, 0.0)

    def points(self, card):
        """Pairs of a time and a value; no pair is on two lines."""
        last = None
        for line, entries in card.data:
            if len(entries) % 2:
                raise self.diagnostics.wrong(line, f"{card.title} {card.value('NAME')}: a line has pairs of a time and a value, not {len(entries)} numbers")
            for k in range(0, len(entries), 2):
                point = tuple(real(entries, k + j, line, self.diagnostics, what) for j, what in enumerate(("a time of the amplitude", "a value of the amplitude")))
                if last is not None and point[0] < last:
                    raise self.diagnostics.wrong(line, f"{card.title} {card.value('NAME')}: its times must not decrease: {point[0]:g} follows {last:g}")
                last = point[0]
                yield point

    def course_of(self, card, before, value):
        """The function of time with this magnitude in the present step, after another one; None if its amplitude is unknown."""
        if not self.in_step:
            return Course.constant(value)
        if self.end <= self.start:
            raise self.diagnostics.wrong(card.line, f"{card.title} stands before the procedure of its step (*STATIC, *DYNAMIC)")
        name = card.upper("AMPLITUDE")
        if name:
            if name not in self.amplitudes:
                raise self.diagnostics.undefined(card.line, f"the amplitude '{card.value('AMPLITUDE')}' is not defined before this line", name, self.amplitudes)
            if self.amplitudes[name] is None:
                return None
            self.has_amplitudes = True
            course, is_total = self.amplitudes[name]
            course = course.shifted(self.shift(card, "TIMEDELAY"))
            course = (course if is_total else course.shifted(self.start)).scaled(value)
            piece = course.within(self.start, max(self.end, course.segments[-1].end) if is_total else self.end)
        else:
            first = before.at(self.start) if before is not None else 0.0
            piece = Course((Segment(self.start, self.end, first if self.default == "RAMP" else value, value),))
        if self.start > 0:
            return (before or Course.constant(0.0)).within(0.0, self.start).followed_by(piece)
        return piece

    def removed(self, before):
        """The function of time of what the present step removes."""
        first = before.at(self.start) if self.default == "RAMP" else 0.0
        return before.within(0.0, self.start).followed_by(Course((Segment(self.start, self.end, first, 0.0),)))

    def kept(self, before):
        """The function of time of what keeps the value that it has at the start of the present step."""
        value = before.at(self.start)
        return before.within(0.0, self.start).followed_by(Course((Segment(self.start, self.end, value, value),)))

    @property
    def default(self):
        """How values change without an amplitude: RAMP or STEP."""
        return self.step_card.upper("AMPLITUDE", "RAMP" if self.procedure == "STATIC" else "STEP")
