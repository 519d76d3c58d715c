"""Forces on nodes as loads of the input: as a traction where they are one, else on points."""
import itertools

import numpy as np

from .course import Course
from .model import FORCE, STRESS, Quantity

# The part of the area that a node of a face has in a uniform traction: corners, nodes on edges.
SHARES = {(3, False): (1 / 3, 0), (4, False): (1 / 4, 0), (3, True): (0, 1 / 3), (4, True): (-1 / 12, 1 / 3)}
TOLERANCE = 2e-3  # of nodal forces, which are given with few digits


def add_loads(model, mesh, diagnostics):
    """Entries of `loads`, with their groups, for `model.nodal_forces`."""
    alike = {}  # (component, course of greatest value 1) -> {set: force on each of its nodes}
    for name, components in model.nodal_forces:
        for component, course in enumerate(components):
            peak = peak_of(course)
            if peak:
                alike.setdefault((component, course.scaled(1 / peak)), {})[name] = peak
    entries, done = [], set()  # done: (set, component)
    for (component, course), peaks in alike.items():
        # All sets with the same course together, as corners and middles of faces have different forces; else each set alone.
        for some in dict.fromkeys([tuple(peaks), *((name,) for name in peaks)]):
            if done & {(name, component) for name in some}:
                continue
            force = np.zeros(len(mesh.points))
            for name in some:
                force[model.node_sets[name][1]] += peaks[name]
            found = uniform_traction(mesh, force)
            if found is None:
                continue
            faces, value = found
            surface = new_name(mesh, "traction")
            mesh.name_faces(surface, faces)
            entries.append({"surface": surface, "traction": along(component, Quantity(course.scaled(value), STRESS))})
            done |= {(name, component) for name in some}
            diagnostics.note(None, f"forces on the nodes of {', '.join(some)} in the direction {'xyz'[component]} are those of a uniform traction on "
                             f"{len(faces)} faces: surface {surface}")
    for name, components in model.nodal_forces:
        rest = [course if peak_of(course) and (name, c) not in done else None for c, course in enumerate(components)]
        entries += on_points(model, mesh, name, rest, diagnostics)
    return entries


def peak_of(course):
    """The value that is farthest from 0."""
    return 0.0 if course is None else max((value for s in course.segments for value in (s.first, s.last)), key=abs)


def along(component, quantity):
    return [quantity if c == component else 0 for c in range(3)]


def new_name(mesh, stem):
    """A name that no group has: stem_1, ..., each once."""
    for k in itertools.count(mesh.names_given.get(stem, 0) + 1):
        name = f"{stem}_{k}"
        if all(name not in groups for groups in mesh.groups.values()):
            mesh.names_given[stem] = k
            return name


def uniform_traction(mesh, force):
    """Faces of the surface and the traction on them that has these forces, or None."""
    loaded = np.append(np.abs(force) > TOLERANCE * np.abs(force).max(), True)
    rows, counts = mesh.faces[mesh.is_outer], mesh.face_corners[mesh.is_outer]
    nodes = np.pad(rows, ((0, 0), (0, 1)), constant_values=-1)  # a face has its corners first; a node that is missing, -1, counts as loaded
    is_corner = np.arange(nodes.shape[1]) < counts[:, None]
    is_quadratic = (np.where(is_corner, -1, nodes) >= 0).any(axis=1)
    whole = (loaded[nodes] | (is_corner == is_quadratic[:, None])).all(axis=1)
    if not whole.any():
        return None
    shares = np.zeros_like(force)
    for row, count in zip(rows[whole], counts[whole]):
        x = mesh.points[row[:count]]
        area = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0]) if count == 3 else np.cross(x[2] - x[0], x[3] - x[1])) / 2
        at_corner, at_edge = SHARES[int(count), bool(row[count:].max(initial=-1) >= 0)]
        np.add.at(shares, row[:count], at_corner * area)
        np.add.at(shares, row[count:][row[count:] >= 0], at_edge * area)
    value = force.sum() / shares.sum()
    if np.abs(force - value * shares).max() > TOLERANCE * np.abs(force).max():
        return None
    return [tuple(row[:count]) for row, count in zip(rows[whole], counts[whole])], value


def on_points(model, mesh, name, rest, diagnostics):
    """Forces on the nodes of a set that are not those of a traction."""
    group, rows = model.node_sets[name]
    if not any(rest):
        return []
    corners = mesh.corners_among(rows)
    if not len(corners):
        diagnostics.missing(None, f"forces on the nodes of {name}, all in the middle of edges: give them as a traction or a force on a surface")
        return []
    if len(corners) < len(set(rows)):
        diagnostics.note(None, f"forces on the nodes of {name}: those in the middle of edges went to the {len(corners)} nodes at corners")
    force = [0 if course is None else Quantity(course.scaled(len(set(rows))), FORCE) for course in rest]
    return [{"point": mesh.name_points(group, corners), "force": force}]


def constant_at_end(components, end):
    """Of a single state."""
    return [None if course is None else Course.constant(course.at(end)) for course in components]
