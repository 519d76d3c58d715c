"""Rigid bodies of FEBio: domains of the material `rigid body`, and the section `Rigid` with their motions and forces."""
import numpy as np

from .cells import KINDS, tetrahedra_of
from .conditions import rotation_of
from .course import Course
from .febio_joints import FebioJoints
from .model import FORCE, LENGTH, TORQUE, Quantity, Selection

# Degrees of freedom: translations and rotations of the center of mass, by the names that versions give them.
DEGREES = {"Rx": 0, "Ry": 1, "Rz": 2, "x": 0, "y": 1, "z": 2, "Ru": 3, "Rv": 4, "Rw": 5, "u": 3, "v": 4, "w": 5}
FIXING, MOVING = ("rigid_fixed", "fix"), ("rigid_displacement", "rigid_rotation", "prescribe")
PUSHING = ("rigid_force", "rigid_moment", "force")


class FebioRigid:
    """`bodies`: (name of the set of elements, center of mass or None) by number and name of the material."""

    def __init__(self, model, bodies, conditions, diagnostics):
        self.model, self.bodies, self.conditions, self.diagnostics = model, bodies, conditions, diagnostics
        self.motions, self.forces = {}, {}  # {body: {degree of freedom: Course}}
        self.joints = FebioJoints(model, conditions, lambda name: bodies.get(name, (None,))[0], diagnostics)

    def read(self, node):
        """An entry of the section."""
        if self.joints.read(node):
            return
        if not self.is_read(node):
            self.diagnostics.missing(node.line, f"<{node.tag} type={node.get('type')}>: it has no counterpart, or stands in one of several steps")
        node.use()

    def is_read(self, node):
        kind, body = node.get("type"), self.body_of(node)
        dof, value = node.child("dof"), node.child("value")
        if body is None or self.conditions.window is not None:
            return False
        if kind in FIXING:
            names = [child.tag[:-4] for child in node.children if child.tag.endswith("_dof") and child.text == "1"]
            names += [part.strip() for child in node.children if child.tag == "dofs" for part in child.text.split(",")]
            self.motions.setdefault(body, {}).update({DEGREES[name]: Course.constant(0.0) for name in names if name in DEGREES})
            return all(name in DEGREES for name in names)
        table = self.motions if kind in MOVING else self.forces if kind in PUSHING else None
        if table is None or dof is None or dof.text not in DEGREES or value is None or not self.is_plain(node):
            return False
        degree, course = DEGREES[dof.text], self.conditions.course(value, is_load=False)
        if table is self.forces and degree in table.get(body, {}):
            return False
        if course is not None:
            table.setdefault(body, {})[degree] = course
        return True

    @staticmethod
    def is_plain(node):
        """Neither relative to another state, nor one that follows the body."""
        return all(child.text.strip() in ("", "0", "LOAD") for child in node.children if child.tag in ("relative", "load_type"))

    def body_of(self, node):
        rb = node.child("rb")
        name = rb.text if rb is not None else node.get("mat")
        return self.bodies.get(name, (None,))[0]

    def finish(self):
        self.joints.finish({body: [motion.get(c) for c in range(6)] for body, motion in self.motions.items()})
        centers = dict(self.bodies.values())
        for body, motion in self.motions.items():
            six = [motion.get(c) for c in range(6)]
            rotation = rotation_of(six[3:], Quantity)
            if rotation is None:
                self.diagnostics.missing(None, f"the rigid body {body} rotates about several axes, of which some are free or not 0: its motion is left out")
                continue
            center = centers[body] or center_of_mass(self.model, body)
            keys = {"translation": ["free" if course is None else Quantity(course, LENGTH) for course in six[:3]], "rotation": rotation,
                    "center": [Quantity(float(x), LENGTH) for x in center]}
            self.model.constraints.append((Selection("element", body), {"rigid": keys}))
        for body, forces in self.forces.items():
            for key, first, dimension in (("force", 0, FORCE), ("torque", 3, TORQUE)):
                if any(c in forces for c in range(first, first + 3)):
                    vector = [Quantity(forces[c], dimension) if c in forces else 0 for c in range(first, first + 3)]
                    self.model.loads.append((Selection("element", body), {key: vector}))


def center_of_mass(model, elements):
    """The center of a set of elements of one density."""
    volume, moment = 0.0, np.zeros(3)
    for row in model.element_sets[elements]:
        kind = KINDS[model.kinds[row]]
        cells, _ = tetrahedra_of(kind, np.array([model.elements[row][:kind.corners]]))
        x = model.points[cells]
        volumes = np.abs(np.linalg.det(x[:, 1:] - x[:, :1])) / 6
        volume += volumes.sum()
        moment += volumes @ x.mean(axis=1)
    return moment / volume
