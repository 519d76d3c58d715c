"""Linear equations between degrees of freedom (*EQUATION) of an input file of Abaqus or CalculiX.

Nodes of no element are unknowns of their own there: where one has a prescribed displacement, this is the right-hand side here; where it is free,
one of its equations says what it is, and the others, and the force on it, are without it.
"""
from .abaqus_deck import real, whole
from .course import Course
from .model import LENGTH

NEGLIGIBLE = 1e-12  # of the largest coefficient


class AbaqusEquations:
    """Reads *EQUATION."""

    def __init__(self, model, mesh, axes, diagnostics):
        self.model, self.mesh, self.axes, self.diagnostics = model, mesh, axes, diagnostics
        self.equations = []  # (line, {(row, component): coefficient}), along local axes

    def read(self, card):
        if card.has("REMOVE") or card.has("REMOVEALL"):
            self.diagnostics.missing(card.line, f"{card.title}, {next(iter(card.parameters))}: an equation holds from the start to the end of a run")
            return
        count, terms, first = None, [], card.line
        for line, entries in card.data:
            if count is None:
                count, terms, first = whole(entries[0], line, self.diagnostics, "the number of terms of an equation"), [], line
                continue
            for k in range(0, len(entries), 3):
                terms.append((self.rows(entries[k], line), whole(entries[k + 1] if k + 1 < len(entries) else "", line, self.diagnostics, "the degree of freedom"),
                              real(entries, k + 2, line, self.diagnostics, "the coefficient")))
            if len(terms) >= count:
                self.add(first, terms, count)
                count = None
        if count is not None:
            raise self.diagnostics.wrong(first, f"{card.title}: {len(terms)} of {count} terms are there")

    def rows(self, text, line):
        rows = self.mesh.nodes(text, line)
        if not rows:
            raise self.diagnostics.wrong(line, f"node {text} is not defined, or the set has no nodes")
        name = self.mesh.spelled("node", text)
        is_sorted = name in self.model.node_sets and name not in self.mesh.unsorted
        return sorted(set(rows), key=self.mesh.label_of) if is_sorted else list(rows)

    def add(self, line, terms, count):
        """Sets stand for as many equations as they have nodes; a single node is in each."""
        if len(terms) > count:
            raise self.diagnostics.wrong(line, f"an equation with {count} terms has {len(terms)}")
        size = max(len(rows) for rows, _, _ in terms)
        if any(len(rows) not in (1, size) for rows, _, _ in terms):
            raise self.diagnostics.wrong(line, f"the sets of an equation have {' and '.join(str(len(rows)) for rows, _, _ in terms)} nodes: they must have as many as one another")
        if any(not 1 <= dof <= 3 for _, dof, _ in terms):
            self.diagnostics.missing(line, "*EQUATION of degrees of freedom that are not displacements: left out")
            return
        for k in range(size):
            equation = {}
            for rows, dof, coefficient in terms:
                key = (rows[k % len(rows)], dof - 1)
                equation[key] = equation.get(key, 0.0) + coefficient
            self.equations.append((line, equation))

    # ------------------------------------------------------------------ the input
    def finish(self, prescribed, forces, used, references, quantity):
        """Equations of nodes of elements alone; returns the other nodes, whose conditions are in them. `used`: nodes of elements; `quantity`: of a
        function of time and a dimension."""
        left, dummies = [], set()
        for line, equation in self.equations:
            if any(row in references for row, _ in equation):
                self.diagnostics.missing(line, "*EQUATION with the reference node of a rigid part or coupling: left out; a joint of `joints` may say the same")
                continue
            outside = {row for row, _ in equation if row not in used}
            dummies |= outside
            terms, value = dict(equation), Course.constant(0.0)
            for key in [key for key in terms if key[0] in outside and key in prescribed.course]:
                value = value.plus(prescribed.course[key].scaled(-terms.pop(key)))
            left.append((line, terms, value))
        for key in sorted({key for _, terms, _ in left for key in terms if key[0] in dummies}):
            left = self.eliminate(key, left, forces)
        for key, course in forces.course.items():
            if key[0] in dummies and key not in prescribed.course and any(s.first or s.last for s in course.segments):
                self.diagnostics.missing(None, f"*CLOAD on node {self.mesh.label_of(key[0])}, which belongs to no element, and to no equation that says where it moves: left out")
        for line, terms, value in left:
            self.write(line, terms, value, quantity)
        return dummies

    def eliminate(self, key, equations, forces):
        """The displacement of a node of no element from the first of its equations, in the others, and in the work of the force on it."""
        pivot = next((entry for entry in equations if entry[1].get(key)), None)
        if pivot is None:
            return equations
        _, terms, value = pivot
        factor = terms[key]
        result = []
        for entry in equations:
            if entry is pivot:
                continue
            line, others, right = entry
            if key in others:
                ratio = others[key] / factor
                others = {name: others.get(name, 0.0) - ratio * terms.get(name, 0.0) for name in {**others, **terms} if name != key}
                right = right.plus(value.scaled(-ratio))
            result.append((line, others, right))
        force = forces.course.pop(key, None)
        if force is not None:
            for (row, component), coefficient in terms.items():
                if (row, component) != key:
                    share = force.scaled(-coefficient / factor)
                    before = forces.course.get((row, component))
                    forces.set(row, component, [row], share if before is None else before.plus(share))
        return result

    def write(self, line, terms, value, quantity):
        """Along x, y, z."""
        result = {}
        for (row, component), coefficient in terms.items():
            for c, part in enumerate(self.axes.direction(row, component)):
                result[row, c] = result.get((row, c), 0.0) + part * coefficient
        largest = max(map(abs, result.values()), default=0.0)
        result = {key: coefficient for key, coefficient in result.items() if abs(coefficient) > NEGLIGIBLE * largest}
        is_zero = value.is_constant and value.at(0.0) == 0
        if not result and not is_zero:
            raise self.diagnostics.wrong(line, "the equation prescribes different displacements of one node")
        if result:
            self.model.equations.append(([(row, c, coefficient) for (row, c), coefficient in result.items()], None if is_zero else quantity(value, LENGTH)))
