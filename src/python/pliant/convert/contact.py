"""Contact of a model as the section `contact` of the input: which law, which widths, and what differs from the model."""
import dataclasses
import re

import numpy as np

from .cells import KINDS
from .model import LENGTH, VELOCITY, Quantity, free_name

# Half of the distance over which a penalty's kink is rounded in runs without inertia, relative to a facet: surfaces sink in by that much more.
WIDTH_PER_FACET = 1e-4
# How far what sticks may creep in a run without inertia, relative to a facet: the elastic slip that Abaqus allows.
CREEP_PER_FACET = 5e-3
STIFFLY_ACCURATE = ("bdf2", "quasistatic", "static")



# ------------------------------------------------------------------ bodies
def separate_bodies(model):
    """Parts of one set of elements that are not connected become bodies of their own where contact may join them: a penalty acts between bodies."""
    contact = model.contact
    if not contact.is_there:
        return
    elements_of = elements_by_face(model)
    at_pairs = [[row for side in pair.sides for row in elements_at(model, side, elements_of)] for pair in contact.pairs]
    for body in list(model.bodies):
        part_of = parts_of(model, model.element_sets[body.elements])
        count = max(part_of.values(), default=0) + 1
        if count < 2 or not (contact.is_all or any(len({part_of[row] for row in rows if row in part_of}) > 1 for rows in at_pairs)):
            continue
        at = model.bodies.index(body)
        pieces = []
        for k in range(count):
            name = model.new_name(body.elements)
            model.element_sets[name] = [row for row, part in part_of.items() if part == k]
            pieces.append(dataclasses.replace(body, elements=name))
        model.bodies[at:at + 1] = pieces


def elements_by_face(model):
    """Rows of elements with a body, by the corners of their faces."""
    result = {}
    for body in model.bodies:
        for row in model.element_sets[body.elements]:
            nodes = model.elements[row]
            for face in KINDS[model.kinds[row]].faces:
                result.setdefault(frozenset(nodes[k] for k in face), []).append(row)
    return result


def parts_of(model, rows):
    """The number of the connected part of each of these elements, by its row."""
    parent = {}

    def root(node):
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    for row in rows:
        nodes = model.elements[row]
        for node in nodes:
            parent.setdefault(node, node)
        first = root(nodes[0])
        for node in nodes[1:]:
            parent[root(node)] = first
    numbers = {}
    return {row: numbers.setdefault(root(model.elements[row][0]), len(numbers)) for row in rows}


def elements_at(model, side, elements_of):
    """The elements with a body at a side."""
    if side.kind == "face":
        return [row for face in model.surfaces[side.name] for row in elements_of.get(frozenset(face), ())]
    given = model.node_sets[side.name]
    nodes = set(given[1] if isinstance(given, tuple) else given)  # a tuple with the name of its group once the mesh has groups
    return [row for face, rows in elements_of.items() if face <= nodes for row in rows]


# ------------------------------------------------------------------ the input
def section(model, mesh, diagnostics):
    """The section `contact`, or None."""
    contact = model.contact
    if not contact.is_there:
        return None
    writer = Writer(model, mesh, diagnostics)
    keys = writer.all_bodies(contact.general) if contact.is_all else writer.listed()
    return writer.finish(keys)


class Writer:
    """Writes the pairs, and what differs from the model."""

    def __init__(self, model, mesh, diagnostics):
        self.model, self.mesh, self.diagnostics, self.contact = model, mesh, diagnostics, model.contact
        self.has_inertia = model.time["method"] not in ("static", "quasistatic")
        self.elements_of = elements_by_face(model)
        self.body_of = {row: k for k, body in enumerate(model.bodies) for row in model.element_sets[body.elements]}
        self.sizes, self.springs, self.laws = [], [], set()
        named = (*model.rigid_bodies, *model.joints, *model.springs)
        self.taken = {*model.node_sets, *model.element_sets, *model.surfaces, *(keys["name"] for keys in named if "name" in keys)}

    def listed(self):
        entries = [entry for entry in map(self.entry, self.contact.pairs) if entry]
        return {"pairs": entries} if entries else None

    def all_bodies(self, general):
        law = "penalty" if len(self.model.bodies) > 1 else "barrier"
        self.laws.add(law)
        corners = [np.array([face[:count] for face, count in zip(self.mesh.faces, self.mesh.face_corners) if count == size]) for size in (3, 4)]
        size = self.size_of(np.concatenate([faces[:, :3] for faces in corners if len(faces)]))
        keys = {"law": law, **self.pressure_of(general, law, size), "pairs": "all"}
        if law == "penalty":
            self.diagnostics.note(general.line, f"{general.said}: bodies touch one another, and none touches itself: law: barrier does both")
        for pair in self.contact.pairs:
            self.diagnostics.missing(pair.line, f"{pair.said}: next to contact of all surfaces, whose properties hold here too")
        excluded = [[self.group_of(side) for side in pair.sides] for pair in self.contact.exclude]
        excluded = [(names * 2)[:2] for names in excluded if all(names)]
        return {**keys, **({"exclude": excluded} if excluded else {})}

    def entry(self, pair):
        """Of the list `pairs`; None where a side is not in the input."""
        names = [self.group_of(side) for side in pair.sides]
        if not all(names):
            lost = pair.sides[names.index(None)].name
            self.diagnostics.missing(pair.line, f"{pair.said}: {lost} has no faces of solid elements in the input, and the pair is left out; a rigid shape may be an obstacle "
                                     "(`contact.obstacles`)")
            return None
        law = "penalty" if len(names) == 2 and not self.is_one_body(pair) else "barrier"
        self.laws.add(law)
        size = self.size_of(np.concatenate([triangles for name in names for triangles in self.mesh.groups[2][name]]))
        return {**self.name_of(names), "surface": names[0], **({"with": names[1]} if len(names) == 2 else {}), **({"law": law} if law == "barrier" else {}),
                **self.pressure_of(pair, law, size)}

    def name_of(self, names):
        """The key `name` of a pair of two surfaces, with which its columns of history.csv begin."""
        if len(names) < 2:
            return {}
        name = free_name(re.sub(r"[,;\"'\s]+", "_", "_".join(names)), self.taken)
        self.taken.add(name)
        return {"name": name}

    def pressure_of(self, pair, law, size):
        keys = {"friction": pair.friction} if pair.friction else {}
        if pair.stiffness is not None and law == "penalty":
            keys["stiffness"] = pair.stiffness
            self.springs.append(pair)
        if law == "penalty" and not self.has_inertia:
            keys["width"] = Quantity(WIDTH_PER_FACET * size, LENGTH)
        self.sizes.append(size)
        return keys

    def group_of(self, side):
        """The name of the group of surfaces, or None."""
        if side.kind == "face":
            return side.name if side.name in self.mesh.groups[2] else None
        name = self.model.node_sets[side.name][0]
        return name if 2 in self.model.dimensions[name] else None

    def is_one_body(self, pair):
        """Whether both sides belong to one body: a penalty does not act within it."""
        return len({self.body_of[row] for side in pair.sides for row in elements_at(self.model, side, self.elements_of)}) < 2

    def size_of(self, triangles):
        """The mean length of edges."""
        x = self.mesh.points[triangles]
        return float(np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2).mean())

    def finish(self, keys):
        if keys is None:
            return None
        contact, note = self.contact, lambda text: self.diagnostics.note(None, f"contact: {text}")
        size = min(self.sizes)
        if contact.has_friction and not self.has_inertia:
            velocity = CREEP_PER_FACET * size / (self.model.end or 1.0)
            keys = {"stick_velocity": Quantity(velocity, VELOCITY), **keys}
            note(f"friction acts on velocities: what sticks creeps by up to stick_velocity, here {100 * CREEP_PER_FACET:g} % of a facet in the whole run")
        if contact.adjusts:
            keys = {"start": "resolve", **keys}
            note("surfaces that overlap are moved apart in the mesh, without strain (start: resolve); gaps are not closed: `pliant check` lists them")
        else:
            note("gaps and overlaps at the start are those of the mesh (`pliant check` lists them); what overlaps is pushed apart from the start")
        if "penalty" in self.laws:
            note("a penalty of Pliant's stiffness, 10 Young's moduli per size of a facet, stands for hard contact, and surfaces sink in by a tenth of the compression of their "
                 "elements: a larger `stiffness` reduces it" if len(self.springs) < len(self.sizes) else "springs have the stiffness of the model")
        if "barrier" in self.laws:
            self.use_barrier(note)
        return keys

    def use_barrier(self, note):
        note("law: barrier where a body touches itself: surfaces keep a small distance")
        if self.model.time["method"] not in STIFFLY_ACCURATE:
            note(f"the method is bdf2, and not {self.model.time['method']}, which a barrier does not allow")
            self.model.time["method"] = "bdf2"
