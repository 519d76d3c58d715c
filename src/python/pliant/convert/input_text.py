"""A model as the text of an input."""
import math
import re

from .course import Course
from .model import Quantity
from .units import factor

PLAIN = re.compile(r"[A-Za-z_][\w.+-]*( [\w.+-]+)*\Z")
MEANT_OTHERWISE = {"true", "false", "yes", "no", "on", "off", "null", "y", "n", "~"}


class InputText:
    """Writes values in SI; `system`: the units of the model."""

    def __init__(self, model, system):
        self.model, self.system = model, system

    def number(self, quantity):
        """A number, or a formula of t."""
        unit = factor(self.system, quantity.dimension)
        if isinstance(quantity.value, Course):
            return quantity.value.formula(self.model.end, unit, factor(self.system, (0, 0, 1)))
        return quantity.value * unit

    def flow(self, value):
        """A value in YAML's flow style."""
        if isinstance(value, Quantity):
            value = self.number(value)
        if isinstance(value, dict):
            return "{" + ", ".join(f"{key}: {self.flow(item)}" for key, item in value.items()) + "}"
        if isinstance(value, (list, tuple)):
            return "[" + ", ".join(self.flow(item) for item in value) + "]"
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, (int, float)):
            return plain_number(value)
        if PLAIN.match(value) and value.lower() not in MEANT_OTHERWISE:
            return value
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'

    def entries(self, key, items):
        if not items:
            return []
        return [f"{key}:"] + [f"  - {self.flow(item)}" for item in items]

    def lines(self, mesh_file, elements, constraints, loads, contact):
        """`elements`: the keys `element` and `volumetric`; `constraints`, `loads`: entries with the groups of the mesh; `contact`: keys, or None."""
        model = self.model
        element, volumetric = elements
        yield f"title: {self.flow(model.title)}"
        yield f"mesh: {self.flow({'file': mesh_file})}"
        yield f"element: {element}"
        if volumetric != "standard":
            yield f"volumetric: {volumetric}"
        yield "bodies:"
        for body in model.bodies:
            yield f"  - volume: {self.flow(body.elements)}"
            if body.density is not None:
                yield f"    density: {self.flow(body.density)}"
            if body.is_rigid:
                yield "    rigid: true"
            if body.elasticity is not None:
                yield f"    elasticity: {self.flow(body.elasticity)}"
            if body.expansion is not None:
                yield f"    expansion: {self.flow({'stretch': body.expansion})}"
            if body.viscosity:
                yield "    viscosity:"
                yield from (f"      - {self.flow(branch)}" for branch in body.viscosity)
        yield from self.entries("rigid_bodies", model.rigid_bodies)
        yield from self.entries("joints", model.joints)
        yield from self.entries("springs", model.springs)
        yield from self.entries("constraints", constraints)
        yield from self.entries("loads", loads)
        if contact is not None:
            yield from self.contact_lines(contact)
        if model.initial_velocity is not None:
            yield f"initial: {self.flow({'velocity': model.initial_velocity})}"
        yield f"time: {self.flow(model.time)}"

    def contact_lines(self, contact):
        yield "contact:"
        for key, value in contact.items():
            if key == "pairs" and value != "all":
                yield "  pairs:"
                yield from (f"    - {self.flow(pair)}" for pair in value)
            else:
                yield f"  {key}: {self.flow(value)}"


def plain_number(value):
    """YAML and Pliant read 1e+06 as a number; 12 digits are more than any table has."""
    if isinstance(value, int) or value == int(value) and abs(value) < 1e6:
        return str(int(value))
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    text = f"{value:.12g}"
    return re.sub(r"e([+-])0*(\d+)", lambda e: f"e{'-' if e[1] == '-' else ''}{e[2]}", text)
