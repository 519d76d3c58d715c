"""What both kinds of models share: prescribed displacements by set and component, and normals of surfaces."""
import numpy as np

from .cells import KINDS
from .course import Course
from .model import LENGTH, Selection


def add_prescribed(model, diagnostics, by_set, value):
    """Constraints of the input. `by_set`: {name of a node set: {component: course}}; `value` makes a quantity of a course."""
    course_of = {}  # (node, component)
    for name, components in by_set.items():
        for component, course in components.items():
            rows = model.node_sets[name]
            others = sum(course_of.get((row, component), course) != course for row in rows)
            if others:
                diagnostics.note(None, f"{others} nodes of {name} have another prescribed displacement in the direction {'xyz'[component]} too: "
                                 "`pliant check` reports the conflict")
            course_of.update({(row, component): course for row in rows})
    for name, components in by_set.items():
        keys = [value(components[c], LENGTH) if c in components else "free" for c in range(3)]
        model.constraints.append((Selection("node", name), {"displacement": keys}))


def normal_of(model, surface):
    """The normal of a plane surface by the order of its corners, else None."""
    normals = []
    for face in model.surfaces[surface]:
        x = model.points[list(face)]
        normal = np.cross(x[1] - x[0], x[2] - x[0])
        normals.append(normal / np.linalg.norm(normal))
    normals = np.array(normals)
    if not len(normals) or np.abs(normals - normals[0]).max() > 1e-9:
        return None
    return [0.0 if abs(n) < 1e-12 else float(n) for n in normals[0]]


def inward_faces(model, surface):
    """How many faces of a surface have their corners in the order of an inward normal."""
    wanted = {frozenset(face): face for face in model.surfaces[surface]}
    count = 0
    for kind, nodes in zip(model.kinds, model.elements):
        for face in KINDS[kind].faces:
            corners = tuple(nodes[k] for k in face)
            given = wanted.get(frozenset(corners))
            if given is not None:
                start = given.index(corners[0])
                count += given[start:] + given[:start] != corners
    return count


def rotation_of(courses, value):
    """The key `rotation` of a rigid part for rotations about x, y and z (None: free): all free, all fixed, or one axis with the others
    fixed; None for what the key cannot say."""
    if not any(courses):
        return "free"
    changing = [c for c, course in enumerate(courses) if course is None or course != Course.constant(0.0)]
    if not changing:
        return "fixed"
    if len(changing) > 1:
        return None
    axis = [int(c == changing[0]) for c in range(3)]
    course = courses[changing[0]]
    return {"axis": axis, "angle": "free" if course is None else value(course, (0, 0, 0))}
