"""What colours the bodies: a field of the result, or a component of one."""
import dataclasses

import numpy as np

from pliant import PliantError

COMPONENTS = {3: "x y z".split(), 6: "xx yy zz xy yz xz".split(),
              9: "xx xy xz yx yy yz zx zy zz".split()}
PRINCIPAL = "principal_"  # fields of three values in descending order
OF_RODS = "rod_"  # fields of the segments of rods alone
# Fields that rigid bodies have as others do: those of everything, of contact and of shells.
OF_RIGID_BODIES = ("displacement", "velocity", "acceleration", "contact_", "membrane_", "principal_membrane_", "bending_moment", "principal_bend", "principal_curvature")
AT_REST = {"volume_ratio": 1.0, "principal_stretches": 1.0}


@dataclasses.dataclass(frozen=True)
class Quantity:
    """What colours the body: a field of the result, or a component or the length of it."""

    field: str
    component: int  # -1: the length of a vector
    label: str
    unit: str
    names: list  # of a quantity that counts bodies or ranks, empty ones of those that are not drawn; else empty
    axes: str = ""  # of a component: "x", "xy"; empty where it does not depend on them

    @property
    def is_of_deformable_bodies(self):
        return not self.names and not self.field.startswith((OF_RODS, *OF_RIGID_BODIES))

    def at_points(self, frame, surface, is_rigid=False):
        """Values at the points of the surface; of counted things, at its faces. `is_rigid`: it is that of rigid bodies, whose nodes have the
        values of others that they share them with."""
        field = frame.field(self.field)
        if self.names:
            return field.values[surface.cell_of_face, 0]
        if is_rigid and self.is_of_deformable_bodies:
            return np.full(len(surface.of_nodes(frame.mesh.coordinates)), AT_REST.get(self.field, 0.0))
        values = field.values if field.on_nodes else surface.nodal_means(field.values)
        values = np.linalg.norm(values, axis=1, keepdims=True) if self.component < 0 else values[:, [self.component]]
        return _of_nodes(surface, values)[:, 0]


def _of_nodes(surface, values):
    """Nodal values at the points of the surface: infinite ones, such as gaps where nothing is near, stay so."""
    infinite = np.isposinf(values)
    if not infinite.any():
        return surface.field_of_nodes(values)
    finite = values[np.isfinite(values)]
    at_points = surface.field_of_nodes(np.where(infinite, finite.max() if len(finite) > 0 else 0.0, values))
    return np.where(surface.of_nodes(infinite.astype(float)) != 0, np.inf, at_points)


def quantity_of(result, name, frame=None):
    """`displacement`, `displacement_z`, `cauchy_stress_xx`, ... as a Quantity. `frame`: one that has the field; default: the first."""
    frame = frame or result.frames[0]
    known = frame.field_names
    base, _, suffix = name.rpartition("_")
    if name not in known and base in known:
        field = frame.field(base)
        components = components_of(base, field)
        if suffix not in components:
            raise PliantError(f"the field '{base}' has no component '{suffix}'; it has {', '.join(components) or 'only one'}")
        return Quantity(base, components.index(suffix), f"{words_of(base)} {suffix}", field.unit, [], "" if base.startswith(PRINCIPAL) else suffix)
    field = frame.field(name)
    if name == "body":
        drawn = frame.mesh.bodies_with_surface
        return Quantity(name, 0, "body", "", [body if body in drawn else "" for body in frame.mesh.body_names])
    if name == "rank":
        return Quantity(name, 0, "rank", "", [str(i) for i in range(_num_ranks(result))])
    components = field.values.shape[1]
    if components > 3:
        example = COMPONENTS[components][0]
        raise PliantError(f"'{name}' is a tensor: choose a component such as {name}_{example}, or von_mises_stress")
    if name.startswith(PRINCIPAL):
        raise PliantError(f"'{name}' has three values: choose {name}_1 (the largest), {name}_2 or {name}_3")
    return Quantity(name, -1 if components == 3 else 0, words_of(name), field.unit, [])


def _num_ranks(result):
    """The largest number of ranks that have written frames: a run may be resumed on more or on fewer."""
    of_mesh = {frame.mesh_group: frame for frame in result.frames}
    return max(int(frame["rank"].max()) for frame in of_mesh.values()) + 1


def components_of(name, field):
    """Their names; none of a number."""
    return ["1", "2", "3"] if name.startswith(PRINCIPAL) else COMPONENTS.get(field.values.shape[1], [])


NAMES = {"von mises": "von Mises", "cauchy": "Cauchy", "first piola kirchhoff": "first Piola-Kirchhoff", "green lagrange": "Green-Lagrange"}


def words_of(field):
    """`first_piola_kirchhoff_stress_xx` as "first Piola-Kirchhoff stress xx"."""
    words = field.replace("_", " ")
    for plain, spelt in NAMES.items():
        words = words.replace(plain, spelt)
    return words
