"""Rigid bodies and couplings of an input file of Abaqus or CalculiX, with the conditions on their reference nodes.

A part whose reference node has no force becomes a constraint `rigid`; else, and where it is coupled in the mean, one of `rigid_bodies` without
a mass. Degrees of freedom 1 to 3 of the reference node are the translation of the center, 4 to 6 rotations about axes through it.
"""
import dataclasses

from .conditions import rotation_of
from .model import FORCE, LENGTH, TORQUE, Quantity, Selection


@dataclasses.dataclass
class Part:
    """`kind`, `name`: what moves with the reference node `node`, which is a name or number of the file."""

    card: object
    kind: str
    name: str
    node: str
    rotation_node: str = ""
    is_mean: bool = False
    is_left_out: bool = False


class AbaqusRigid:
    """Reads *RIGID BODY and *COUPLING with *KINEMATIC or *DISTRIBUTING."""

    def __init__(self, model, mesh, diagnostics):
        self.model, self.mesh, self.diagnostics = model, mesh, diagnostics
        self.parts = []
        self.coupling = None  # the last card *COUPLING, whose kind follows
        self.handlers = {"RIGIDBODY": self.read_rigid_body, "COUPLING": self.read_coupling, "KINEMATIC": self.read_kind, "DISTRIBUTING": self.read_kind}

    def read(self, card):
        """Whether the card is one of rigid bodies or couplings."""
        if card.keyword not in self.handlers:
            return False
        self.handlers[card.keyword](card)
        return True

    def read_rigid_body(self, card):
        kinds = {"ELSET": "element", "NSET": "node", "TIENSET": "node", "PINNSET": "node", "ANALYTICALSURFACE": "analytical"}
        found = [(kind, card.value(name)) for name, kind in kinds.items() if card.has(name)]
        if len(found) != 1 or found[0][0] == "analytical" or card.has("PINNSET"):
            self.diagnostics.missing(card.line, f"{card.title} of {', '.join(name for name in kinds if card.has(name)) or 'nothing'}: it has no counterpart in the input")
            return
        self.parts.append(Part(card, *found[0], card.value("REFNODE"), card.value("ROTNODE")))

    def read_coupling(self, card):
        self.coupling = card

    def read_kind(self, card):
        coupling = self.coupling
        if coupling is None:
            raise self.diagnostics.wrong(card.line, f"{card.title} stands without *COUPLING")
        part = Part(coupling, "face", coupling.value("SURFACE"), coupling.value("REFNODE"), is_mean=card.keyword == "DISTRIBUTING")
        self.parts.append(part)
        held = set()
        for line, entries in card.data:
            if entries[0]:
                first, last = (int(text) if text.isdigit() else 0 for text in (entries[0], (entries + [""])[1] or entries[0]))
                held.update(range(first, last + 1) if 1 <= first <= last <= 6 else (0,))
        if held and not {1, 2, 3} <= held or 0 in held:
            self.diagnostics.missing(card.line, f"{card.title} of some degrees of freedom: only a surface whose displacements are all coupled has a counterpart; "
                                     "left out with the conditions on its reference node")
            part.is_left_out = True

    # ------------------------------------------------------------------ the input
    def finish(self, prescribed, forces, value):
        """Writes rigid parts into the model, with the conditions on their reference nodes, which leave the tables; returns these nodes."""
        references, loaded = set(), set()
        for part in self.parts:
            row, rotation_row = (self.row(node, part) for node in (part.node, part.rotation_node or part.node))
            motion, force = (self.six(table, row, rotation_row) for table in (prescribed, forces))
            if row in references and not part.is_left_out:
                free = any(course is None for course in motion)
                if free:
                    self.diagnostics.missing(part.card.line, f"{part.card.title} shares its reference node with another rigid part or coupling: both become "
                                             "rigid parts of their own, which may move apart where the motion of the node is free")
                if row in loaded:
                    force = [None] * 6  # the first part has it
            references |= {row, rotation_row}
            if not part.is_left_out:
                loaded.add(row)
                self.add(part, row, motion, force, value)
        for table in (prescribed, forces):
            table.remove(references)
        return references - {None}

    def row(self, text, part):
        name = self.mesh.spelled("node", text)
        rows = self.model.node_sets.get(name) or [self.mesh.row_of(text)]
        if len(set(rows)) != 1 or rows[0] is None:
            said = f"the reference node '{text}' of {part.card.title} is not defined, or more than one node"
            raise self.diagnostics.undefined(part.card.line, said, text, self.model.node_sets if name not in self.model.node_sets else ())
        return rows[0]

    @staticmethod
    def six(table, row, rotation_row):
        """Functions of time of the degrees of freedom 1 to 6; degrees 1 to 3 of a node of rotation are 4 to 6."""
        found = table.of_node(row)
        if rotation_row != row:
            found.update({c + 3: course for c, course in table.of_node(rotation_row).items() if c < 3})
        return [found.get(c) for c in range(6)]

    def add(self, part, row, motion, force, value):
        card, center = part.card, [Quantity(float(x), LENGTH) for x in self.mesh.points[row]]
        selection = self.selection(part)
        rotation = rotation_of(motion[3:], value)
        if selection is None or rotation is None:
            what = f"{part.name}, which the input does not have as one group" if selection is None else "rotations about several axes, of which some are free or not 0"
            self.diagnostics.missing(card.line, f"{card.title} with {what}: left out with the conditions on its reference node")
            return
        name = self.mesh.spelled("node", part.node)
        if name not in self.model.node_sets or self.is_taken(name):
            name = self.model.new_name("reference")
        rigid = {"translation": ["free" if course is None else value(course, LENGTH) for course in motion[:3]], "rotation": rotation, "center": center}
        moves = any(course is not None for course in motion)
        if not part.is_mean and not any(force):
            self.model.constraints.append((selection, {"name": name, "rigid": rigid}))
            return
        self.model.rigid_bodies.append({"name": name, "center": center, "coupled" if part.is_mean else "attached": selection})
        if part.is_mean:
            self.diagnostics.note(card.line, f"{card.title}, DISTRIBUTING: the mean is over the area of the surface, not over its nodes")
        if moves:
            self.model.constraints.append((None, {"volume": name, "rigid": {key: rigid[key] for key in ("translation", "rotation")}}))
        for key, components, dimension in (("force", force[:3], FORCE), ("torque", force[3:], TORQUE)):
            if any(components):
                vector = [0 if course is None else value(course, dimension) for course in components]
                self.model.loads.append((None, {key: vector, "volume": name}))

    def is_taken(self, name):
        return "," in name or name in self.model.element_sets or name in self.model.surfaces or any(body["name"] == name for body in self.model.rigid_bodies)

    def selection(self, part):
        """The group of the input; None if there is none, or several."""
        name = self.mesh.spelled(part.kind, part.name)
        if part.kind == "face":
            return Selection("face", name) if self.model.surfaces.get(self.mesh.spelled("surface", part.name)) else self.of_nodes(self.mesh.spelled("node", part.name))
        if part.kind == "element":
            with_body = {row for body in self.model.bodies for row in self.model.element_sets[body.elements]}
            return Selection("element", name) if with_body & set(self.model.element_sets.get(name, ())) else None
        return self.of_nodes(name)

    def of_nodes(self, name):
        return Selection("node", name) if self.model.node_sets.get(name) else None
