"""Nodes, elements, sets and surfaces of an input file of Abaqus or CalculiX."""
import collections
import re

import numpy as np

from .abaqus_deck import real, whole
from .cells import KINDS
from .model import free_name

# Prefix of a type; the rest of its name are letters: hybrid, incompatible modes, reduced integration, ...
SOLIDS = {"C3D4": "tetrahedron", "C3D5": "pyramid", "C3D6": "wedge", "C3D8": "brick", "C3D10": "quadratic tetrahedron",
          "C3D15": "quadratic wedge", "C3D20": "quadratic brick", "C3D13": "quadratic pyramid"}
LETTERS = "HIMRSTV"
# Nodes closer than this, relative to the extent, coincide (src/mesh/repair.cpp).
COINCIDENCE = 1e-10
GENERATING = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL")


def kind_of(name):
    match = re.match(rf"(C3D\d+)([{LETTERS}]*)\Z", name)
    return SOLIDS.get(match[1]) if match else None


class AbaqusMesh:
    """Reads the cards of the mesh; `model` gets points, elements, sets and surfaces."""

    def __init__(self, model, diagnostics):
        self.model, self.diagnostics = model, diagnostics
        self.tables = {"": ({}, {})}  # rows of nodes and of elements by number; of several instances by their names in capitals
        self.row_of_reference = {}  # of nodes of the assembly, which has numbers of its own
        self.label = {}  # number of a node by its row
        self.points = []
        self.left_out = collections.Counter()
        self.first_left_out = None
        self.unsorted = set()  # names of sets of nodes that keep the order of the file
        self.names = {}  # of sets as they were spelled first, by kind and capitals
        self.level, self.parts, self.instances = "model", 0, 0
        self.has_several = False  # instances, each with the cards of its part (abaqus_assembly.py)
        self.followers = []  # called with the first row and the function that moves points, when an instance is translated or rotated
        self.scope, self.placed = "", None  # of several instances the one that is read: its name in capitals; its card, name and first row
        self.handlers = {"NODE": self.read_nodes, "ELEMENT": self.read_elements, "NSET": self.read_node_set, "ELSET": self.read_element_set,
                         "SURFACE": self.read_surface, "PART": self.enter_part, "INSTANCE": self.enter_instance,
                         "ENDINSTANCE": self.leave_instance, "ENDPART": self.leave, "ASSEMBLY": self.enter_assembly, "ENDASSEMBLY": self.leave}

    def read(self, card):
        """Whether the card is one of the mesh."""
        if card.keyword in GENERATING:
            raise self.diagnostics.wrong(card.line, f"{card.title} is not supported: write the file with all nodes and elements (Abaqus/CAE does)")
        if card.keyword not in self.handlers:
            return False
        self.handlers[card.keyword](card)
        return True

    def finish(self):
        if not self.points:
            raise self.diagnostics.wrong(1, "the file has no nodes (*NODE)")
        self.model.points = np.array(self.points)
        if self.left_out:
            self.diagnostics.missing(self.first_left_out, "elements of types without a counterpart: "
                                  + ", ".join(f"{count} {name}" for name, count in self.left_out.items()))

    def note_coinciding(self):
        """Names the nodes of elements that lie where others do: parts are joined by nodes alone."""
        used = np.unique(np.concatenate([np.array(rows) for rows in self.model.elements] or [np.zeros(0, int)]))
        contact, tied = self.model.contact, any("tied_to" in keys for _, keys in self.model.constraints)
        if len(used) == 0 or contact.is_there or tied:
            return
        x = self.model.points[used]
        near = COINCIDENCE * float(np.linalg.norm(np.ptp(x, axis=0)) or 1.0)
        _, first, place = np.unique(np.round(x / near), axis=0, return_index=True, return_inverse=True)
        pairs = [(row, other) for row, other in zip(used, used[first[place.ravel()]]) if row != other]
        if pairs:
            said = ", ".join(f"{self.label_of(row)} on {self.label_of(other)}" for row, other in pairs[:5])
            self.diagnostics.note(None, f"{len(pairs)} nodes lie where others do ({said}{', ..' if len(pairs) > 5 else ''}): the parts that meet there are not joined, and `pliant check` asks "
                                  "what becomes of them: merge the nodes, or tie the surfaces (*TIE, or `tied_to` in the input)")

    @property
    def row_of_node(self):
        return self.tables[self.scope][0]

    @property
    def row_of_element(self):
        return self.tables[self.scope][1]

    def spelled(self, kind, name):
        """The name of the set that a reference means, as it was spelled first: names are compared without regard to case. A set of the
        assembly and one of the part are different sets, also if they have the same name."""
        own, scope = self.parted(name)
        found = self.names.get((kind, scope, own.upper()))
        if found or self.has_several and scope:
            return found or name  # of one of several instances, which has its own alone
        others = [spelling for (kind_there, _, there), spelling in self.names.items() if (kind_there, there) == (kind, own.upper())]
        return others[0] if len(others) == 1 else own

    def define(self, kind, name):
        """The same for a set that is defined here. Those of several instances have the instance's name before their own."""
        own, scope = self.parted(name)
        key = (kind, scope, own.upper())
        if key not in self.names:
            taken = {spelling for (kind_there, *_), spelling in self.names.items() if kind_there == kind}
            is_known = any((kind_there, there) == (kind, own.upper()) for kind_there, _, there in self.names)
            new = f"{self.placed[1]}_{own}" if self.has_several and scope else own + ("_part" if scope else "_assembly") if is_known and not self.has_several else own
            self.names[key] = free_name(new, taken)
        return self.names[key]

    def parted(self, name):
        """A name without its instance, and where it is one: in an instance, a part, or ""."""
        instance, _, own = name.rpartition(".") if self.instances else ("", "", name)
        if self.has_several:
            return own, self.scope or instance.upper()
        return own, "part" if instance or self.level == "part" else ""

    # ------------------------------------------------------------------ structure
    def enter_part(self, card):
        self.level = "part"
        self.parts += 1
        if self.parts > 1:
            raise self.diagnostics.wrong(card.line, "there is a second part, and no instance of it: write the file with its assembly")

    def enter_instance(self, card):
        self.level = "part"
        self.instances += 1
        if self.has_several:
            self.scope, self.placed = card.upper("NAME"), (card, card.value("NAME"), len(self.points))
            if self.scope in self.tables:
                raise self.diagnostics.wrong(card.line, f"a second instance has the name '{card.value('NAME')}', or none")
            self.tables[self.scope] = ({}, {})
        else:
            self.put(card, 0)

    def put(self, card, first):
        """Places the nodes from a row on."""
        places = [[real(entries, k, line, self.diagnostics, "a number that places the instance") for k in range(len(entries))] for line, entries in card.data]
        if any(any(numbers) for numbers in places):
            if len(self.points) == first:
                raise self.diagnostics.wrong(card.line, "the instance is translated or rotated, and its part has no nodes before this line")
            place = lambda x: self.place(np.array(x), places, card.data[-1][0])  # noqa: E731
            self.points[first:] = place(self.points[first:])
            for follow in self.followers:
                follow(first, place)

    def place(self, x, places, line):
        """Translates nodes, then rotates them about the axis from one point to another, by an angle in degrees."""
        x = x + np.resize(places[0] + [0.0] * 3, 3)
        if len(places) > 1:
            a, b = np.resize(places[1] + [0.0] * 6, 6).reshape(2, 3)
            length = np.linalg.norm(b - a)
            if len(places[1]) != 7 or length == 0:
                raise self.diagnostics.wrong(line, "a rotation of an instance has two different points on its axis, and an angle")
            axis, angle = (b - a) / length, np.radians(places[1][6])
            along = np.outer((x - a) @ axis, axis)
            x = a + along + np.cos(angle) * (x - a - along) + np.sin(angle) * np.cross(axis, x - a)
        return x.tolist()

    def enter_assembly(self, _):
        self.level = "assembly"

    def leave_instance(self, _):
        self.level = "assembly"
        if self.has_several:
            self.put(self.placed[0], self.placed[2])
            self.scope = ""

    def leave(self, _):
        self.level = "model"

    # ------------------------------------------------------------------ nodes and elements
    def read_nodes(self, card):
        table = self.row_of_reference if self.level == "assembly" else self.row_of_node
        if card.upper("SYSTEM", "R") not in ("", "R"):
            raise self.diagnostics.wrong(card.line, "nodes in cylindrical or spherical coordinates are not supported")
        members = self.node_set(card.value("NSET")) if card.has("NSET") else []
        for line, entries in card.data:
            label = whole(entries[0], line, self.diagnostics, "the number of a node")
            x = [real(entries, k, line, self.diagnostics, "a coordinate", 0.0) for k in (1, 2, 3)]
            if label in table:  # as in CalculiX, the later one counts
                self.points[table[label]] = x
            else:
                self.label[len(self.points)] = label
                table[label] = len(self.points)
                self.points.append(x)
            members.append(table[label])

    def read_elements(self, card):
        kind = kind_of(card.upper("TYPE"))
        name = card.value("ELSET")
        members = self.element_set(name) if name else []
        if kind is None:
            self.first_left_out = self.first_left_out or card.line
            self.left_out[card.upper("TYPE")] += len(card.data)
            return
        wanted = KINDS[kind].nodes + 1
        labels = []
        for line, entries in card.data:
            labels += [whole(entry, line, self.diagnostics, "the number of an element or node") for entry in entries if entry]
            if len(labels) < wanted:
                continue
            if len(labels) > wanted:
                raise self.diagnostics.wrong(line, f"an element of type {card.upper('TYPE')} has {wanted - 1} nodes, not {len(labels) - 1}")
            try:
                rows = [self.row_of_node[label] for label in labels[1:]]
            except KeyError as error:
                raise self.diagnostics.wrong(line, f"node {error} of element {labels[0]} is not defined before this line") from None
            members.append(self.add_element(labels[0], kind, rows, line))
            labels = []
        if labels:
            raise self.diagnostics.wrong(card.data[-1][0], f"element {labels[0]} has {len(labels) - 1} nodes, and one of type {card.upper('TYPE')} has {wanted - 1}")

    def add_element(self, label, kind, rows, line):
        """Its row; an element may be repeated as it is, in another set."""
        row = self.row_of_element.setdefault(label, len(self.model.elements))
        if row == len(self.model.elements):
            self.model.kinds.append(kind)
            self.model.elements.append(rows)
        elif (self.model.kinds[row], self.model.elements[row]) != (kind, rows):
            raise self.diagnostics.wrong(line, f"a second element has the number {label}")
        return row

    # ------------------------------------------------------------------ sets
    def node_set(self, name):
        return self.model.node_sets.setdefault(self.define("node", name), [])

    def element_set(self, name):
        return self.model.element_sets.setdefault(self.define("element", name), [])

    def rows(self, text, line, sets, kind, table):
        """Members of a set that a set's name or a number stands for; those that were left out are not among them."""
        name = self.spelled(kind, text)
        if name in sets:
            return sets[name]
        label = text.rpartition(".")[2] if self.instances else text
        if not label.isdigit():
            raise self.diagnostics.undefined(line, f"'{text}' is neither a number nor the name of a set of {kind}s before this line", text, sets)
        return [table[int(label)]] if int(label) in table else []

    def nodes(self, text, line):
        return self.rows(text, line, self.model.node_sets, "node", self.nodes_here(text))

    def table_of(self, instance, which):
        """Rows of nodes (0) or elements (1) by number, of an instance."""
        if not self.has_several:
            return self.tables[""][which]
        return self.tables.get(instance.upper(), ({}, {}))[which]

    def nodes_here(self, text, instance=""):
        """Rows by number. Where there is an instance, numbers without its name are those of the assembly, outside of the part."""
        if not self.instances or self.level == "part":
            return self.row_of_node
        instance = instance or text.rpartition(".")[0]
        return self.table_of(instance, 0) if instance else self.row_of_reference

    def elements_here(self, text, instance=""):
        if not self.instances or self.level == "part":
            return self.row_of_element
        instance = instance or text.rpartition(".")[0]
        return self.table_of(instance, 1) if instance else {}

    def row_of(self, text):
        """The row of a node by its number, with or without an instance; None if there is none."""
        label = text.rpartition(".")[2]
        return self.nodes_here(text).get(int(label)) if label.isdigit() else None

    def label_of(self, row):
        return self.label.get(row, row)

    def elements(self, text, line):
        return self.rows(text, line, self.model.element_sets, "element", self.elements_here(text) if self.has_several else self.row_of_element)

    def read_set(self, card, members, kind):
        table = (self.nodes_here if kind == "node" else self.elements_here)("", card.value("INSTANCE"))
        unknown = []
        for line, entries in card.data:
            if card.has("GENERATE"):
                first, last, step = (whole(entries[k] if k < len(entries) and entries[k] else "1", line, self.diagnostics, "a limit of the set") for k in range(3))
                step = max(step, 1)
                within = range(first, last + 1, step)
                members += [table[label] for label in (within if len(within) < len(table) else sorted(table)) if label in table and label in within]
                continue
            for entry in entries:
                if entry.isdigit():
                    members += [table[int(entry)]] if int(entry) in table else []
                    unknown += [] if int(entry) in table else [entry]
                elif entry:
                    members += (self.nodes if kind == "node" else self.elements)(entry, line)
        if unknown and not (kind == "element" and self.left_out):
            self.diagnostics.omit(card.line, f"{card.title}: {len(unknown)} of its numbers, the first one {unknown[0]}, are not {kind}s of the file")
        members[:] = dict.fromkeys(members)

    def read_node_set(self, card):
        members = self.node_set(card.value("NSET"))
        if card.has("UNSORTED"):
            self.unsorted.add(self.define("node", card.value("NSET")))
        if card.has("ELSET"):
            members += [node for e in self.elements(card.value("ELSET"), card.line) for node in self.model.elements[e]]
        self.read_set(card, members, "node")

    def read_element_set(self, card):
        name = card.value("ELSET")
        if card.has("INTERNAL"):
            self.model.internal_sets.add(self.define("element", name))
        self.read_set(card, self.element_set(name), "element")

    def read_surface(self, card):
        name, kind = card.value("NAME"), card.upper("TYPE", "ELEMENT")
        if kind == "NODE":
            members = self.node_set(name)
            for line, entries in card.data:
                members += self.nodes(entries[0], line)
            return
        if kind != "ELEMENT":
            self.diagnostics.omit(card.line, f"{card.title}, TYPE={kind}: an analytical surface is an obstacle of 'contact' in the input")
            return
        faces = self.model.surfaces.setdefault(self.define("surface", name), [])
        if card.upper("COMBINE", "UNION") != "UNION":
            self.diagnostics.missing(card.line, f"{card.title}, COMBINE={card.upper('COMBINE')}: give its faces one by one")
            return
        for line, entries in card.data:
            if card.has("COMBINE"):
                faces += [face for entry in entries if entry for face in self.faces_named(entry, line)]
                continue
            rows = self.elements(entries[0], line)
            side = entries[1].upper() if len(entries) > 1 else ""
            faces += self.outer_faces(rows) if not side else self.sides(rows, side, line)

    def faces_named(self, text, line):
        name = self.spelled("surface", text)
        if name not in self.model.surfaces:
            raise self.diagnostics.undefined(line, f"the surface '{text}' is not defined before this line", text, self.model.surfaces)
        return self.model.surfaces[name]

    def sides(self, rows, side, line):
        """Faces S1, S2, ... of elements, by their corners."""
        if not rows:
            return []  # of elements that are left out
        if not re.fullmatch(r"S[1-6]", side):
            raise self.diagnostics.wrong(line, f"'{side}' is not a side of a solid element: they are S1 to S6")
        faces = []
        for row in rows:
            kind = KINDS[self.model.kinds[row]]
            if int(side[1]) > len(kind.faces):
                raise self.diagnostics.wrong(line, f"an element has {len(kind.faces)} sides, not {side}")
            faces.append(tuple(self.model.elements[row][k] for k in kind.faces[int(side[1]) - 1]))
        return faces

    def outer_faces(self, rows):
        """Faces of these elements that one element of the model has."""
        count = collections.Counter(frozenset(face) for row in range(len(self.model.elements)) for face in self.faces_of(row))
        return [face for row in rows for face in self.faces_of(row) if count[frozenset(face)] == 1]

    def faces_of(self, row):
        return [tuple(self.model.elements[row][k] for k in face) for face in KINDS[self.model.kinds[row]].faces]
