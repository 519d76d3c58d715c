"""Connectors between rigid bodies of FEBio as joints and springs of the input.

Source: FEBio's FERigidRevoluteJoint.cpp and its neighbours. A prescribed rotation or translation is that of the second body against the first; a moment or force acts on
the first body, and the opposite one on the second.
"""
from .course import Course
from .model import DAMPING, FORCE, LENGTH, STIFFNESS, TORQUE, Quantity

# By FEBio's name: the type of the joint, the tag of its place and that of its axis.
JOINTS = {"rigid joint": ("ball", "joint", None), "rigid spherical joint": ("ball", "joint_origin", None), "rigid revolute joint": ("hinge", "joint_origin", "rotation_axis"),
          "rigid prismatic joint": ("slider", "joint_origin", "translation_axis"), "rigid cylindrical joint": ("cylindrical", "joint_origin", "joint_axis"),
          "rigid planar joint": ("planar", "joint_origin", "rotation_axis"), "rigid lock": ("fixed", "joint_origin", None)}
SPRINGS = {"rigid spring": ("stiffness", "k", STIFFNESS), "rigid damper": ("damping", "c", DAMPING)}
AXES = {"hinge": [0.0, 0.0, 1.0], "slider": [1.0, 0.0, 0.0]}  # where the file has none
# Of a hinge and a slider: the tag that says whether the motion is given, that of the motion, that of the effort, and their dimensions.
DRIVES = {"hinge": ("prescribed_rotation", "rotation", "moment", (0, 0, 0), TORQUE), "slider": ("prescribed_translation", "translation", "force", LENGTH, FORCE)}
# How the joint is enforced, and axes across the free one, which change no motion.
WITHOUT_EFFECT = {"laugon", "tolerance", "gaptol", "angtol", "force_penalty", "moment_penalty", "penalty", "minaug", "maxaug", "auto_penalty", "transverse_axis", "first_axis",
                  "second_axis", "translation_axis_1", "symmetric_stiffness"}


class FebioJoints:
    """Reads <rigid_connector>, and <constraint> of older versions. `body_of`: the name in the input of what a file calls a rigid body."""

    def __init__(self, model, conditions, body_of, diagnostics):
        self.model, self.conditions, self.body_of, self.diagnostics = model, conditions, body_of, diagnostics

    def read(self, node):
        """Whether it is a connector, which is in the model then, or listed."""
        kind = node.get("type")
        if kind not in JOINTS and kind not in SPRINGS:
            return False
        node.used = True
        bodies = [self.body_of(child.text) if (child := node.child(tag)) is not None else None for tag in ("body_a", "body_b")]
        if None in bodies:
            self.diagnostics.missing(node.use().line, f"<{node.tag} type={kind}>: body_a and body_b must be rigid bodies of the model")
        elif self.conditions.window is not None:
            self.diagnostics.missing(node.use().line, f"<{node.tag} type={kind}> stands in one of several steps: a joint holds from the start to the end of a run; left out")
        elif kind in JOINTS:
            self.read_joint(node, JOINTS[kind], bodies)
        else:
            self.read_spring(node, SPRINGS[kind], bodies)
        return True

    def name_of(self, node):
        name = node.get("name").replace(",", " ").replace('"', "'") or node.get("type").replace("rigid ", "").replace(" ", "_")
        taken = {entry["name"] for entry in self.model.joints + self.model.springs}
        return name if name not in taken else next(f"{name}_{k}" for k in range(2, len(taken) + 3) if f"{name}_{k}" not in taken)

    def read_joint(self, node, kind, bodies):
        joint, place, axis = kind
        point = self.conditions.vector(node, place) or [0.0, 0.0, 0.0]
        entry = {"name": self.name_of(node), "type": joint, "between": bodies, "point": [Quantity(x, LENGTH) for x in point]}
        if axis:
            entry["axis"] = self.conditions.vector(node, axis) or AXES.get(joint)
            if entry["axis"] is None:
                self.diagnostics.missing(node.use().line, f"<{node.tag} type={node.get('type')}>: it has no {axis}")
                return
        if joint in DRIVES:
            self.read_drive(node, entry, *DRIVES[joint])
        self.model.joints.append(entry)
        for child in node.children:
            if child.tag not in WITHOUT_EFFECT and not child.used and child.text not in ("", "0"):
                self.diagnostics.missing(child.line, f"<{child.tag}> of a {node.get('type')}: it has no counterpart")
            child.use()

    def read_drive(self, node, entry, switch, motion, effort, dimension, effort_dimension):
        flag, value, push = node.child(switch), node.child(motion), node.child(effort)
        if flag is not None and flag.text not in ("", "0") and value is not None:
            course = self.conditions.course(value, is_load=False)
            if course is not None:
                entry["motion"] = Quantity(course, dimension)
        elif push is not None:
            course = self.conditions.course(push, -1.0, is_load=False) if push.text not in ("", "0") else None
            if course is not None:
                entry["motor"] = {"effort": Quantity(course, effort_dimension)}

    def read_spring(self, node, kind, bodies):
        key, tag, dimension = kind
        value = node.child(tag)
        places = [self.conditions.vector(node, f"insertion_{side}") for side in "ab"]
        if value is None or value.get("lc") not in ("", "0") or None in places:
            self.diagnostics.missing(node.use().line, f"<{node.tag} type={node.get('type')}>: it needs a constant {tag}, insertion_a and insertion_b")
            return
        entry = {"name": self.name_of(node), "points": [{"body": body, "point": [Quantity(x, LENGTH) for x in place]} for body, place in zip(bodies, places)],
                 key: Quantity(self.diagnostics.number(value.text, value.line, tag), dimension)}
        rest = node.child("free_length")
        if rest is not None and key == "stiffness" and self.diagnostics.number(rest.text, rest.line, "free_length") > 0:  # 0: the length at the start
            entry["rest"] = Quantity(float(rest.text), LENGTH)
        self.model.springs.append(entry)

    def finish(self, motions):
        """Bodies that are held are the ground of joints; joints of bodies whose rotation is given otherwise are left out. `motions`: six functions of time, or None, by body."""
        still = Course.constant(0.0)
        held = {body for body, six in motions.items() if all(course == still for course in six)}
        turned = {body for body, six in motions.items() if any(six[3:])} - held
        for entry in list(self.model.joints):
            entry["between"] = ["ground" if body in held else body for body in entry["between"]]
            given = [body for body in entry["between"] if body in turned]
            if given or set(entry["between"]) == {"ground"}:
                self.diagnostics.missing(None, f"the joint {entry['name']} is left out: " + (f"it connects {given[0]}, whose rotation is given: move it by the joint's `motion` instead" if given
                                         else "both of its bodies are held"))
                self.model.joints.remove(entry)
