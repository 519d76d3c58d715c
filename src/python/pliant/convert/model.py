"""A model of another program as an input of Pliant can hold it, in the units of the model."""
import dataclasses
import difflib
import math
import os
from typing import Any

import numpy as np

from pliant.error import PliantError


class Diagnostics:
    """What became of a model besides what stands in the input, in the order of the file."""

    def __init__(self, file):
        self.file = os.path.basename(file)
        self.left_out, self.notes, self.incomplete = [], [], False

    def omit(self, line, text):
        """Something of the model is not in the input."""
        self._add(self.left_out, line, text)

    def note(self, line, text):
        """Something is in the input, but not as it was."""
        self._add(self.notes, line, text)

    def missing(self, line, text):
        """The input needs something that the model has in a form Pliant does not have; `pliant check` asks for it."""
        self.incomplete = True
        self.omit(line, text)

    def number(self, text, line, what):
        """A finite number."""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.wrong(line, f"{what} is missing or not a number: '{text.strip()[:40]}'")
        return value

    def wrong(self, line, text):
        """The exception for a file that cannot be converted."""
        return PliantError(f"{self.file}:{line}: {text}")

    def undefined(self, line, text, name, known):
        """The same for a name that nothing has, with the one of those known that is like it, regardless of case."""
        spelled = {one.upper(): one for one in known if one}
        own = name.upper().rpartition(".")[2]  # without the instance
        near = [own] if own in spelled and own != name.upper() else difflib.get_close_matches(name.upper(), spelled, 1)
        return self.wrong(line, text + (f" (did you mean '{spelled[near[0]]}'?)" if near else ""))

    def _add(self, to, line, text):
        entry = (line, text)
        if entry not in to:
            to.append(entry)

    def lines(self, entries):
        for line, text in sorted(entries, key=lambda entry: entry[0] or 0):
            yield f"{self.file}:{line}: {text}" if line else f"{self.file}: {text}"


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A number, or a course of time, with its dimension: exponents of kilogram, metre and second."""

    value: Any
    dimension: tuple


STRESS, DENSITY, LENGTH, TIME = (1, -1, -2), (1, -3, 0), (0, 1, 0), (0, 0, 1)
VELOCITY, ACCELERATION, FORCE, FORCE_DENSITY, RATE = (0, 1, -1), (0, 1, -2), (1, 1, -2), (1, -2, -2), (0, 0, -1)
STIFFNESS, TORQUE, DAMPING = (1, 0, -2), (1, 2, -2), (1, 0, -1)


@dataclasses.dataclass
class Body:
    """Elements and what they are made of; `elements`: name of their set. `poisson`: at small strain."""

    elements: str
    elasticity: "dict | None" = None
    density: Any = None
    viscosity: list = dataclasses.field(default_factory=list)
    poisson: float = 0.0
    shape_relaxes: bool = False  # and its volume does not
    is_rigid: bool = False
    expansion: Any = None  # the stretch of a free body
    law_note: "tuple | None" = None  # (line, text) of a note about the law

    @property
    def needs_pressure(self):
        """Whether its volume needs a pressure of its own."""
        return bool(self.elasticity and (self.elasticity.get("incompressible") or self.shape_relaxes))


@dataclasses.dataclass
class Selection:
    """A group of the mesh; `kind` is node, face or element."""

    kind: str
    name: str


@dataclasses.dataclass
class ContactPair:
    """`sides`: Selections of faces or nodes, one for a surface that touches itself; `said`: the card or entry, for messages."""

    line: int
    said: str
    sides: list
    friction: float = 0.0
    stiffness: Any = None  # pressure per penetration


@dataclasses.dataclass
class Contact:
    """`is_all`: the surfaces of all bodies touch one another, with what `general` has."""

    pairs: list = dataclasses.field(default_factory=list)
    exclude: list = dataclasses.field(default_factory=list)  # pairs
    is_all: bool = False
    general: "Pair | None" = None
    adjusts: bool = False  # surfaces that overlap are moved apart without strain

    @property
    def is_there(self):
        return self.is_all or bool(self.pairs)

    @property
    def has_friction(self):
        return any(pair.friction for pair in [*self.pairs, *([self.general] if self.is_all else [])])


@dataclasses.dataclass
class Model:
    """Elements have their nodes as rows of `points` in Abaqus's order; sets hold rows of `points` or of `elements`; a surface holds
    the corners of its faces."""

    program: str
    title: str = ""
    points: np.ndarray = None
    kinds: list = dataclasses.field(default_factory=list)
    elements: list = dataclasses.field(default_factory=list)
    node_sets: dict = dataclasses.field(default_factory=dict)
    element_sets: dict = dataclasses.field(default_factory=dict)
    internal_sets: set = dataclasses.field(default_factory=set)  # names of element sets that no user has made
    surfaces: dict = dataclasses.field(default_factory=dict)
    bodies: list = dataclasses.field(default_factory=list)
    constraints: list = dataclasses.field(default_factory=list)  # (Selection, keys)
    loads: list = dataclasses.field(default_factory=list)  # (Selection or None, keys)
    equations: list = dataclasses.field(default_factory=list)  # ([(row of a node, component, coefficient)], value or None)
    nodal_forces: list = dataclasses.field(default_factory=list)  # (name of a node set, course or None for each component), on each node
    rigid_bodies: list = dataclasses.field(default_factory=list)  # keys of each; `attached` or `coupled`: a Selection
    joints: list = dataclasses.field(default_factory=list)  # keys of each
    springs: list = dataclasses.field(default_factory=list)  # the same
    contact: Contact = dataclasses.field(default_factory=Contact)
    initial_velocity: Any = None
    time: dict = dataclasses.field(default_factory=dict)
    end: float = 0.0
    step_ends: list = dataclasses.field(default_factory=list)
    units: "str | None" = None
    dimensions: dict = dataclasses.field(default_factory=dict)  # of the groups of node sets, by name

    def new_name(self, stem):
        """A name that nothing has yet: stem_1, ..."""
        taken = {*self.node_sets, *self.surfaces, *self.element_sets, *(body["name"] for body in self.rigid_bodies)}
        return next(f"{stem}_{k}" for k in range(1, len(taken) + 2) if f"{stem}_{k}" not in taken)


def free_name(name, taken):
    """The name, or one like it that is not among those taken."""
    names = (name if k == 1 else f"{name}_{k}" for k in range(1, len(taken) + 2))
    return next(new for new in names if new not in taken)


def lame(young, poisson):
    """Shear modulus and Lame's first parameter."""
    return young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))


def poisson_of(shear, bulk):
    total = 2 * (3 * bulk + shear)
    return (3 * bulk - 2 * shear) / total if total else 0.0  # constants that are missing
