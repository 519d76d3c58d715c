"""Local axes of nodes (*TRANSFORM) of an input file of Abaqus or CalculiX, and the conditions along them."""
import numpy as np

from .abaqus_deck import real
from .model import LENGTH, Selection

MOST_DIRECTIONS = 500  # of one set, along axes that differ from node to node
MOST_NAMED = 5  # nodes in a message
SAME = 1e-9


class LocalAxes:
    """Reads *TRANSFORM. The degrees of freedom 1 to 3 of its nodes are along axes of their own."""

    def __init__(self, model, mesh, diagnostics):
        self.model, self.mesh, self.diagnostics = model, mesh, diagnostics
        self.systems = {}  # row -> (kind, the six numbers)
        self.on_axis = set()  # nodes of conditions
        mesh.followers.append(self.follow)

    def read(self, card):
        kind = card.upper("TYPE", "R")[:1]
        if kind not in ("R", "C"):
            self.diagnostics.missing(card.line, f"{card.title}, TYPE={card.upper('TYPE')}: conditions on its nodes are along local axes, and stand in the input along x, y, z: "
                                     "correct them there")
            return
        line, entries = card.data[0] if card.data else (card.line, [])
        a, b = np.array([real(entries, k, line, self.diagnostics, "a coordinate of the local axes") for k in range(6)]).reshape(2, 3)
        if np.linalg.norm(np.cross(a, b) if kind == "R" else b - a) < SAME * max(np.abs(a).max(), np.abs(b).max(), 1e-300):
            raise self.diagnostics.wrong(line, f"{card.title}: its two points do not define axes")
        for row in self.mesh.nodes(card.value("NSET"), card.line):
            self.systems[row] = (kind, a, b)

    def follow(self, first, place):
        """Moves the axes of a part with its instance, whose nodes are those from a row on."""
        origin = np.array(place([[0.0, 0.0, 0.0]])[0])
        for row, (kind, a, b) in self.systems.items():
            if row >= first:
                a, b = np.array(place([a, b])) - (origin if kind == "R" else 0)
                self.systems[row] = kind, a, b

    def of(self, row):
        """The local axes as rows of a matrix, or None."""
        if row not in self.systems:
            return None
        kind, a, b = self.systems[row]
        if kind == "R":
            first = a / np.linalg.norm(a)
            third = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
            return np.array([first, np.cross(third, first), third])
        third = (b - a) / np.linalg.norm(b - a)
        radius = self.model.points[row] - a
        across = radius - (radius @ third) * third
        if np.linalg.norm(across) < SAME * max(np.linalg.norm(radius), np.linalg.norm(b - a)):
            self.on_axis.add(row)
            return None
        first = across / np.linalg.norm(across)
        return np.array([first, np.cross(third, first), third])

    def direction(self, row, component):
        """Of a degree of freedom, 0 to 2."""
        axes = self.of(row)
        return np.eye(3)[component] if axes is None else clean(axes[component])

    # ------------------------------------------------------------------ conditions
    def list_nodes_on_axes(self):
        if self.on_axis:
            some = ", ".join(str(self.mesh.label_of(row)) for row in sorted(self.on_axis)[:MOST_NAMED]) + (", ..." if len(self.on_axis) > MOST_NAMED else "")
            self.diagnostics.missing(None, f"*TRANSFORM, TYPE=C: a node on the axis has no radial direction: the conditions of {len(self.on_axis)} such nodes stand along x, y, z: "
                                     f"node {some}")

    def list_references(self, references):
        for row in sorted(references & self.systems.keys()):
            self.diagnostics.missing(None, f"*TRANSFORM of node {self.mesh.label_of(row)}, a reference node: its conditions stand along x, y, z: correct them in the input")

    def turn_forces(self, forces):
        """Forces along local axes become those along x, y, z."""
        by_target = {}
        for target, component in forces.said:
            for row in forces.rows(target):
                if component < 3 and row in self.systems and (row, component) in forces.course:
                    by_target.setdefault(target, {})[row] = None
        done = set()
        for target, rows in by_target.items():
            turned = {}
            for row in rows.keys() - done:
                local = {c: forces.course.pop((row, c)) for c in range(3) if (row, c) in forces.course}
                for c, course in along_axes(local, [self.direction(row, k) for k in range(3)]).items():
                    turned.setdefault((c, course), []).append(row)
            done |= rows.keys()
            for (c, course), some in turned.items():
                forces.set(target, c, sorted(some), course)

    def take_displacements(self, prescribed, used, value):
        """Takes the displacements along local axes out of the table and into the model: as prescribed components where the axes are x, y and z or all
        three are given, else along a direction."""
        pieces = {}  # row -> {component: (target, course)}
        for target, component, course, rows in prescribed.by_target():
            for row in rows:
                if component < 3 and row in self.systems and row in used:
                    pieces.setdefault(row, {})[component] = target, course
        # All before the first is written: what is written is along x, y, z, at the same nodes.
        for row, local in pieces.items():
            for c in local:
                prescribed.course.pop((row, c), None)
        plain, along = {}, {}  # by the target, of which they are
        for row, local in pieces.items():
            axes = [self.direction(row, k) for k in range(3)]
            together = [(next(iter(local.values()))[0], {c: course for c, (_, course) in local.items()})]
            one_by_one = [(target, {c: course}) for c, (target, course) in local.items()]
            for target, courses in together if len(local) == 3 else one_by_one:
                (component, course), *more = courses.items()
                if more or np.count_nonzero(axes[component]) == 1:
                    for c, part in along_axes(courses, axes).items():
                        plain.setdefault(target, {}).setdefault((c, part), []).append(row)
                else:
                    along.setdefault(target, {}).setdefault((tuple(axes[component]), course), []).append(row)
        for target, some in plain.items():
            self.write_plain(prescribed, target, some)
        for target, some in along.items():
            self.write_along(target, some, value)

    @staticmethod
    def write_plain(prescribed, target, plain):
        for (c, course), rows in plain.items():
            prescribed.set(target, c, rows, course)

    @property
    def adds_nodes(self):
        """Whether the tetrahedra of the input have nodes that the model has not: not if all are tetrahedra of one order."""
        kinds = {self.model.kinds[row] for body in self.model.bodies for row in self.model.element_sets[body.elements]}
        return kinds not in ({"tetrahedron"}, {"quadratic tetrahedron"})

    def write_along(self, target, along, value):
        if len(along) > MOST_DIRECTIONS:
            self.diagnostics.missing(None, f"*TRANSFORM: the displacements of {target} are along more than {MOST_DIRECTIONS} directions: left out")
            return
        if len({direction for direction, _ in along}) > 3 and self.adds_nodes:
            self.diagnostics.note(None, f"*TRANSFORM: the displacements of {target} are along directions that differ from node to node: nodes that element: P2 adds between two "
                                  "of them are free")
        for (direction, course), some in along.items():
            name = target
            if not isinstance(target, str) or set(some) != set(self.model.node_sets[target]):
                name = self.model.new_name(target if isinstance(target, str) else "nodes")
                self.model.node_sets[name] = sorted(some)
            self.model.constraints.append((Selection("node", name), {"displacement_along": value(course, LENGTH), "direction": [float(x) for x in direction]}))


def clean(direction):
    """Without what is rounding, so that nodes with the same direction are found."""
    rounded = np.round(direction, 12)
    return rounded + 0.0


def along_axes(local, axes):
    """Functions of time along x, y, z by component, from those along axes; those that are 0 are among them where all three are given."""
    result = {}
    for c, course in local.items():
        for k in range(3):
            if axes[c][k]:
                part = course.scaled(float(axes[c][k]))
                result[k] = result[k].plus(part) if k in result else part
    return result
