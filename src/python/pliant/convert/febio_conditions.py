"""Boundary conditions, loads and initial conditions of FEBio."""
import math

from .conditions import add_prescribed, inward_faces, normal_of
from .course import Course, Segment
from .febio_contact import FebioContact
from .febio_rigid import FebioRigid
from .model import ACCELERATION, LENGTH, STRESS, VELOCITY, Quantity, Selection

COMPONENTS = {"x": 0, "y": 1, "z": 2, "u": 0, "v": 1, "w": 2}
MOST_REPEATS = 50  # of a load curve, as a formula
ROTATIONS = {"sx", "sy", "sz", "Rx", "Ry", "Rz", "U", "V", "W"}


class FebioConditions:
    """Reads the sections Boundary, Loads and Initial of the model and of its steps."""

    def __init__(self, root, model, mesh, curves, diagnostics):
        self.root, self.model, self.mesh, self.curves, self.diagnostics = root, model, mesh, curves, diagnostics
        self.prescribed = {}  # name of a set -> {component: course}
        self.window = None  # of the present step, None: all of the time
        self.of_step = {}  # displacements of the present step: {name of a set: {component: line}}
        self.forces = {}
        self.contact = FebioContact(model, mesh, diagnostics)

    def read(self, rigid_bodies):
        self.rigid = FebioRigid(self.model, rigid_bodies, self, self.diagnostics)
        self.read_sections(self.root)
        steps = [step for section in self.root.each("Step") for step in (list(section.each("step")) or [section])]
        for k, step in enumerate(steps):
            start = self.model.step_ends[k - 1] if k else 0.0
            self.window = (start, self.model.step_ends[k]) if len(steps) > 1 else None
            before, self.of_step = self.of_step, {}
            self.read_sections(step)
            self.list_released(before, start)
        add_prescribed(self.model, self.diagnostics, self.prescribed, Quantity)
        self.rigid.finish()
        self.model.nodal_forces = [(name, [components.get(c) for c in range(3)]) for name, components in self.forces.items()]

    def list_released(self, before, time):
        """Displacements of the step before end with it in FEBio."""
        for name, components in before.items():
            ended = [axis for axis, c in zip("xyz", range(3)) if c in components and c not in self.of_step.get(name, ())]
            if ended:
                self.diagnostics.missing(min(components.values()), f"the displacement of {name} in {', '.join(ended)} is released at the end of its step, t = {time:g}: "
                                         "a constraint holds to the end of a run, and it remains")

    def read_sections(self, owner):
        for section, read in (("Boundary", self.read_boundary), ("Loads", self.read_load), ("Initial", self.read_initial), ("Constraints", self.read_constraint),
                              ("Rigid", self.rigid.read), ("Contact", self.read_contact)):
            for node in owner.each(section):
                for child in node.children:
                    read(child)

    # ------------------------------------------------------------------ values
    def course(self, node, scale=1.0, is_load=True):
        """The value of an element with its load curve; None if it cannot be written. Loads act in their step only."""
        node.use()
        try:
            value = float(node.text or 1) * scale
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.diagnostics.missing(node.line, f"<{node.tag}> is not a number but '{node.text[:40]}': write the formula into the input")
            return None
        return self.follow(node, value, is_load)

    def follow(self, node, value, is_load=True):
        curve = node.get("lc")
        if curve in ("", "0"):
            course = Course.constant(value)
        elif self.curves.get(curve) is None:
            if curve not in self.curves:
                raise self.diagnostics.wrong(node.line, f"the load curve {curve} is not defined")
            return None
        else:
            course, repeats = self.curves[curve]
            first, last = course.segments[0].start, course.segments[-1].end
            if repeats and first < last < self.model.end:
                if self.model.end - last > MOST_REPEATS * (last - first):
                    self.diagnostics.missing(node.line, f"the load curve {curve} repeats more than {MOST_REPEATS} times: write its formula of t into the input")
                    return None
                course = course.repeated(self.model.end, repeats == "REPEAT OFFSET")
            course = course.scaled(value)
        return self.windowed(course) if self.window and is_load else course

    def windowed(self, course):
        """Zero outside the step."""
        start, end = self.window
        parts = [Course.constant(0.0).within(0.0, start)] if start > 0 else []
        parts.append(course.within(start, end))
        if end < self.model.end:
            parts.append(Course((Segment(end, self.model.end, 0.0, 0.0),)))
        segments = tuple(s for part in parts for s in part.segments)
        return Course(segments)

    def vector(self, node, tag):
        child = node.child(tag)
        if child is None:
            return None
        try:
            numbers = [float(x) for x in child.use().text.split(",")]
            if len(numbers) == 3 and all(map(math.isfinite, numbers)):
                return numbers
        except ValueError:
            pass
        self.diagnostics.missing(child.line, f"<{tag}> has three numbers, not '{child.text[:40]}'")
        return None

    # ------------------------------------------------------------------ boundary conditions
    def read_boundary(self, node):
        kind = node.tag if node.tag in ("fix", "prescribe") else node.get("type")
        if kind not in ("fix", "zero displacement", "prescribe", "prescribed displacement", "normal displacement"):
            return  # it is listed
        node.used = True
        if kind == "normal displacement":
            return self.read_normal(node)
        name = self.mesh.node_set_of(node.get("node_set"), node.line)
        if name is None:
            self.diagnostics.omit(node.use().line, f"<{node.tag} type={kind}> on {node.get('node_set')}")
            return
        if kind in ("fix", "zero displacement"):
            self.prescribe(node, name, self.fixed_components(node), Course.constant(0.0))
        else:
            self.read_prescribed(node, name)

    def fixed_components(self, node):
        """x_dof, y_dof, z_dof are 1 (version 4), or a list of letters."""
        flags = [tag for tag in "xyz" if (flag := node.child(f"{tag}_dof")) is not None and flag.text == "1"]
        dofs = node.child("dofs")
        return flags or self.letters(node, dofs.text if dofs is not None else node.get("bc"))

    def letters(self, node, text):
        found = [part.strip() for part in text.split(",") if part.strip()]
        if any(part in ROTATIONS for part in found):
            self.diagnostics.omit(node.line, f"degrees of freedom of shells: {', '.join(part for part in found if part in ROTATIONS)}")
        return [part for part in found if part in COMPONENTS]

    def read_prescribed(self, node, name):
        dof, value, relative = node.child("dof"), node.child("value") or node.child("scale"), node.child("relative")
        letters = self.letters(node, dof.text if dof is not None else node.get("bc"))
        is_relative = relative is not None and relative.text not in ("0", "")
        course = self.course(value, is_load=False) if value is not None else Course.constant(0.0)
        if course is not None:
            self.prescribe(node, name, letters, course, is_relative)

    def prescribe(self, node, name, letters, course, is_relative=False):
        """`is_relative`: to what the displacement is at the start of the step."""
        components = self.prescribed.setdefault(name, {})
        for letter in letters:
            c = COMPONENTS[letter]
            if self.window and self.window[0] > 0:
                if c not in components:
                    self.diagnostics.missing(node.line, f"a displacement of {name} in {letter} that is prescribed from t = {self.window[0]:g} on: a constraint holds from the "
                                             "start of a run, and this one is left out")
                    continue
                here = course.raised(components[c].at(self.window[0])) if is_relative else course
                components[c] = components[c].within(0.0, self.window[0]).followed_by(here.within(*self.window))
            else:
                components[c] = course.within(*self.window) if self.window else course
            if self.window:
                self.of_step.setdefault(name, {})[c] = node.line
        if not components:
            del self.prescribed[name]

    def read_normal(self, node):
        scale = node.child("scale")
        course = self.course(scale) if scale is not None else None
        if course is not None and node.get("surface") in self.model.surfaces:
            self.model.constraints.append((Selection("face", node.get("surface")), {"normal_displacement": Quantity(course, LENGTH)}))
        else:
            self.diagnostics.omit(node.use().line, "<bc type=normal displacement>")

    def read_contact(self, node):
        self.contact.read(node, self.window is not None)

    def read_constraint(self, node):
        if self.rigid.joints.read(node):
            return
        if node.get("type") == "symmetry plane" and node.get("surface") in self.model.surfaces:
            node.use()
            self.model.constraints.append((Selection("face", node.get("surface")), {"symmetry": "plane"}))

    # ------------------------------------------------------------------ loads
    def read_load(self, node):
        readers = {("surface_load", "pressure"): self.read_pressure, ("surface_load", "traction"): self.read_traction,
                   ("nodal_load", "nodal_load"): self.read_nodal_load, ("nodal_load", "nodal_force"): self.read_nodal_force,
                   ("nodal_load", ""): self.read_nodal_load, ("body_load", "const"): self.read_const, ("body_load", "body force"): self.read_body_force}
        reader = readers.get((node.tag, node.get("type")))
        if reader is not None:
            node.used = True
            reader(node)

    def surface(self, node):
        name = node.get("surface")
        if name not in self.model.surfaces:
            raise self.diagnostics.undefined(node.line, f"the surface '{name}' is not defined", name, self.model.surfaces)
        return name

    def read_pressure(self, node):
        surface, value, linear = self.surface(node), node.child("pressure") or node.child("value"), node.child("linear")
        course = self.course(value) if value is not None else None
        if course is None:
            return
        inward = inward_faces(self.model, surface)
        if inward:
            if inward < len(self.model.surfaces[surface]):
                self.diagnostics.missing(node.line, f"a pressure on {surface}, some of whose faces point inward: its direction differs between them")
                return
            self.diagnostics.note(node.line, f"the faces of {surface} point inward: the sign of the pressure is changed")
            course = course.scaled(-1)
        normal = normal_of(self.model, surface) if linear is not None and linear.text == "1" else None
        if normal is not None:
            sign = -1 if not inward else 1
            keys = {"traction": [0 if n == 0 else Quantity(course.scaled(sign * n), STRESS) for n in normal]}
        else:
            if linear is not None and linear.text == "1":
                self.diagnostics.note(node.line, f"the pressure on the curved surface {surface} follows it; linear pressures of FEBio do not")
            keys = {"pressure": Quantity(course, STRESS)}
        self.model.loads.append((Selection("face", surface), keys))

    def read_traction(self, node):
        surface, traction, scale, linear = self.surface(node), self.vector(node, "traction"), node.child("scale"), node.child("linear")
        course = self.course(scale) if scale is not None else Course.constant(1.0)
        if traction is None or course is None:
            return
        if linear is None or linear.text != "1":
            self.diagnostics.note(node.line, f"the traction on {surface} is per area at the start; in FEBio it is per present area")
        vector = [0 if t == 0 else Quantity(course.scaled(t), STRESS) for t in traction]
        self.model.loads.append((Selection("face", surface), {"traction": vector}))

    def nodes(self, node):
        name = self.mesh.node_set_of(node.get("node_set"), node.line)
        if name is None:
            self.diagnostics.omit(node.use().line, f"<{node.tag} type={node.get('type')}> on {node.get('node_set')}")
        return name

    def add_force(self, name, component, course):
        if component in self.forces.setdefault(name, {}):
            self.diagnostics.missing(None, f"a second force on {name} in the direction {'xyz'[component]}: add it to the first one in the input")
        else:
            self.forces[name][component] = course

    def read_nodal_load(self, node):
        name, dof, scale = self.nodes(node), node.child("dof"), node.child("scale") or node.child("value")
        letters = self.letters(node, dof.text if dof is not None else node.get("bc"))
        factor = node.child("value") if node.child("scale") is not None else None
        course = self.course(scale, self.diagnostics.number(factor.text, factor.line, "value") if factor is not None and factor.text else 1.0) if scale is not None else None
        if name is not None and course is not None:
            for letter in letters:
                self.add_force(name, COMPONENTS[letter], course)

    def read_nodal_force(self, node):
        name, value = self.nodes(node), self.vector(node, "value")
        if name is None or value is None:
            return
        for component, number in enumerate(value):
            course = self.follow(node.child("value"), number) if number else None
            if course is not None:
                self.add_force(name, component, course)

    def add_gravity(self, node, vector):
        """FEBio applies the opposite of a body force, times the density."""
        name = node.get("elem_set")
        selection = Selection("element", name) if name in self.model.element_sets else None
        if name and selection is None:
            raise self.diagnostics.undefined(node.line, f"the element set '{name}' is not defined", name, self.model.element_sets)
        gravity = [Quantity(course.scaled(-1), ACCELERATION) if course is not None else 0 for course in vector]
        if any(gravity):
            self.model.loads.append((selection, {"gravity": gravity}))

    def read_const(self, node):
        vector = []
        for tag in "xyz":
            child = node.child(tag)
            course = self.course(child) if child is not None else None
            vector.append(course if course is not None and any(s.first or s.last for s in course.segments) else None)
        self.add_gravity(node, vector)

    def read_body_force(self, node):
        force = self.vector(node, "force")
        if force is not None:
            self.add_gravity(node, [self.follow(node.child("force"), f) if f else None for f in force])

    # ------------------------------------------------------------------ initial conditions
    def read_initial(self, node):
        if node.get("type") not in ("velocity", "initial velocity"):
            return
        node.used = True
        name, value = self.nodes(node), self.vector(node, "value")
        used = {row for rows in self.model.elements for row in rows}
        if name is None or value is None:
            return
        if not used <= set(self.model.node_sets[name]):
            self.diagnostics.omit(node.line, "an initial velocity of a part of the nodes: `initial.velocity` is one formula of x, y, z for all")
            return
        self.model.initial_velocity = [Quantity(v, VELOCITY) if v else 0 for v in value]
