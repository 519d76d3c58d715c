"""Reads a model of FEBio (.feb, versions 2.5, 3 and 4)."""
import os

from .course import Course, Segment
from .febio_conditions import FebioConditions
from .febio_materials import FebioMaterials
from .febio_mesh import FebioMesh
from .model import DENSITY, TIME, Body, Model, Quantity
from .units import SYSTEMS
from .xml_tree import read_tree

OLDEST = 2.5
# Sections whose absence in the input needs one line and not one for each entry.
SUMMARISED = {"Output": "requests of output: `output` and `probes` of the input", "Globals": "constants of other kinds of physics", "Code": "",
              "solver": "settings of the solver: `solver` of the input", "time_stepper": "the choice of steps: a failed step is cut in half here too",
              "contact": "this kind of interface has no counterpart; `contact.pairs` of the input has surfaces that touch"}
# Of Control; what concerns output and the solver.
WITHOUT_EFFECT = ("plot_zero_state", "plot_range", "plot_level", "output_level", "plot_stride", "output_stride", "adaptor_re_solve", "title",
                  "restart", "symmetric_stiffness", "max_refs", "max_ups", "dtol", "etol", "rtol", "lstol", "lsmin", "lsiter", "optimize_bw",
                  "min_residual", "qnmethod", "rhoi", "diverge_reform", "reform_each_time_step", "cmax", "linear_solver", "integration", "alpha", "beta", "gamma",
                  "plot_interval", "plot_level", "print_level", "bwopt", "ignore_missing_nodes")
# Sections whose entries change the result.
DECISIVE = {"Boundary", "Loads", "Initial", "Constraints", "Rigid", "Contact", "Discrete", "MeshData", "MeshAdaptor", "bc", "fix", "prescribe", "surface_load", "nodal_load",
            "body_load", "edge_load", "ic", "init", "constraint", "rigid_bc", "rigid_constraint", "rigid_load", "rigid_connector", "rigid_body", "contact", "Step", "step"}
INTERPOLATIONS = {"LINEAR": "linear", "STEP": "step", "SMOOTH STEP": "smooth"}


def read(file, diagnostics):
    """The model; what is left out of it goes to the diagnostics. Raises PliantError with the line for what cannot be read."""
    root = read_tree(file)
    if root.tag != "febio_spec":
        raise diagnostics.wrong(root.line, f"not a model of FEBio: it begins with <{root.tag}>, not <febio_spec>")
    version = root.get("version")
    if not version.replace(".", "", 1).isdigit() or float(version) < OLDEST:
        raise diagnostics.wrong(root.line, f"the version {version or 'of the file'} is too old: open it in FEBio Studio and save it in version 4")
    root.used = True
    for section in (root, *root.children):
        for node in (section, *section.children):
            if node.get("from"):
                raise diagnostics.wrong(node.line, f"<{node.tag}> is in another file, '{node.get('from')}': put it into this one (FEBio Studio writes one file)")
    module = root.child("Module")
    if module is not None and module.get("type") not in ("", "solid"):
        raise diagnostics.wrong(module.line, f"the module '{module.get('type')}' is not supported: only 'solid' is")
    model = Model(f"FEBio {version}", title=os.path.splitext(os.path.basename(file))[0])
    units = module.child("units") if module else None
    if units is not None and units.text in SYSTEMS:
        model.units = units.text
    elif units is not None:
        diagnostics.note(units.line, f"the system of units '{units.text}' is unknown: give --units")
    mesh = FebioMesh(root, model, diagnostics)
    curves = read_curves(root, diagnostics)
    is_dynamic = read_time(root, model, diagnostics)
    rigid = add_bodies(root, model, mesh, diagnostics, is_dynamic)
    FebioConditions(root, model, mesh, curves, diagnostics).read(rigid)
    list_the_rest(root, diagnostics)
    return model


def read_curves(root, diagnostics):
    """Load curves by their number; None for those that are not tables."""
    curves = {}
    data = root.child("LoadData")
    for node in data.children if data else ():
        node.use()
        is_table = node.tag == "loadcurve" or node.get("type") == "loadcurve"
        points = node if node.tag == "loadcurve" else node.child("points")
        pairs = [pair_of(point, diagnostics) for point in (points.children if points else ()) if point.tag in ("point", "pt", "loadpoint")]
        if not is_table or not pairs:
            diagnostics.missing(node.line, f"load controller {node.get('id')} of the type '{node.get('type')}': write its formula of t into the input; "
                                "conditions with it are left out")
            curves[node.get("id")] = None
            continue
        interpolation = setting(node, "interpolate", "type", "LINEAR")
        extend = setting(node, "extend", "extend", "CONSTANT")
        if interpolation not in INTERPOLATIONS and len(pairs) > 2:
            diagnostics.note(node.line, f"load curve {node.get('id')} is linear between its points, not {interpolation}")
        course = Course.through(pairs, INTERPOLATIONS.get(interpolation, "linear"))
        if extend == "EXTRAPOLATE" and len(pairs) > 1 and interpolation not in ("STEP", "SMOOTH STEP"):
            course = extrapolated(course)
        curves[node.get("id")] = (course, extend if extend in ("REPEAT", "REPEAT OFFSET") else "")
    return curves


def extrapolated(course):
    """With the slopes of its ends before and after."""
    first, last = course.segments[0], course.segments[-1]
    far = last.end + 1e6 * (last.end - last.start)
    before = (Segment(0.0, first.start, first.first - (first.last - first.first) * first.start / (first.end - first.start), first.first),) if first.start > 0 else ()
    return Course((*before, *course.segments, Segment(last.end, far, last.last, last.last + 1e6 * (last.last - last.first))))


def pair_of(point, diagnostics):
    numbers = [diagnostics.number(part, point.line, "a number of the load curve") for part in point.text.split(",")]
    if len(numbers) != 2:
        raise diagnostics.wrong(point.line, f"a point of a load curve has a time and a value, not '{point.text[:40]}'")
    return tuple(numbers)


def setting(node, child, attribute, default):
    found = node.child(child)
    return (found.text if found is not None else node.get(attribute) if node.tag == "loadcurve" else "").upper() or default


def steps_of(root):
    """All steps of the model: Step/step, or Step before version 3."""
    for section in root.each("Step"):
        steps = list(section.each("step"))
        yield from steps or [section]


def read_time(root, model, diagnostics):
    """Method, step and end; returns whether the model is dynamic."""
    steps = list(steps_of(root))
    controls = [control for owner in (root, *steps) for control in owner.each("Control")]
    if not controls:
        raise diagnostics.wrong(root.line, "the model has no Control")
    for step in steps:
        if step.child("Control") is None or root.child("Control") is not None:
            raise diagnostics.wrong(step.line, "a model with steps has one Control in each of them, and none outside")
    sizes, dynamic = [], []
    for control in controls:
        number = {tag: diagnostics.number(control.child(tag).text, control.line, tag) if control.child(tag) is not None else default
                  for tag, default in (("time_steps", 10.0), ("step_size", 0.1), ("final_time", 0.0))}  # FEBio's defaults
        final = number.pop("final_time")
        if number["time_steps"] == -1 and number["step_size"] > 0:
            number["time_steps"] = final / number["step_size"]
        analysis = control.child("analysis")
        kind = ((analysis.get("type") or analysis.text) if analysis is not None else "static").lower()
        dynamic.append(kind in ("dynamic", "transient", "1"))
        if min(number.values()) <= 0:
            raise diagnostics.wrong(control.line, "time_steps and step_size must be above 0")
        sizes.append(number["step_size"])
        model.step_ends.append(model.end + number["time_steps"] * number["step_size"])
        model.end = model.step_ends[-1]
        for tag in WITHOUT_EFFECT:
            for node in control.each(tag):
                node.use()
    if len(set(dynamic)) > 1:
        diagnostics.missing(controls[1].line, "some steps are static and some dynamic: an input has one method, here a dynamic one for all")
    method = "implicit-midpoint" if any(dynamic) else "quasistatic"
    model.time = {"method": method, "step": Quantity(min(sizes), TIME), "end": Quantity(model.end, TIME)}
    return any(dynamic)


def add_bodies(root, model, mesh, diagnostics, is_dynamic):
    """Bodies of all domains; returns the rigid ones for the section `Rigid`, by number and name of their material."""
    section = root.child("Material")
    nodes = {key: node for node in (section.each("material") if section else ()) for key in (node.get("id"), node.get("name")) if key}
    reader = FebioMaterials(diagnostics)
    bodies, rigid = {}, {}  # rigid: material -> names of its domains
    for name, (material, line) in mesh.material_of.items():
        if material not in nodes:
            raise diagnostics.undefined(line, f"the material '{material}' of {name} is not defined", material, nodes)
        node = nodes[material]
        if node.get("type") == "rigid body":
            rigid.setdefault(id(node), (node, []))[1].append(name)
            continue
        if id(node) not in bodies:
            bodies[id(node)] = reader.read(node)
        body = bodies[id(node)]
        if is_dynamic and body.density is None:
            diagnostics.note(node.line, f"material {node.get('name') or material} has no density: 1 in the units of the file, as in FEBio")
            body.density = Quantity(1.0, (1, -3, 0))
        model.bodies.append(type(body)(name, body.elasticity, body.density, body.viscosity, body.poisson, body.shape_relaxes))
    found = {key: (name, center) for node, names in rigid.values() for name, center in (add_rigid_body(node, names, model, reader),)
             for key in (node.get("id"), node.get("name")) if key}
    for node in nodes.values():
        node.use()
    return found


def add_rigid_body(node, names, model, reader):
    """All domains of a rigid material move as one body. Returns its set of elements, and its center of mass where the file gives it."""
    name = names[0]
    if len(names) > 1:
        name = model.new_name("rigid")
        model.element_sets[name] = [row for one in names for row in model.element_sets[one]]
    model.bodies.append(Body(name, density=Quantity(reader.number(node, "density", 1.0), DENSITY), is_rigid=True))
    center = node.child("center_of_mass")
    numbers = [reader.diagnostics.number(x, center.line, "a number of center_of_mass") for x in center.text.split(",")] if center is not None else None
    if numbers and len(numbers) != 3:
        raise reader.diagnostics.wrong(center.line, f"center_of_mass has three numbers, not {len(numbers)}")
    return name, numbers


def list_the_rest(root, diagnostics):
    """What nothing was made of."""
    for node in root.unused():
        name = node.get("name")
        kind = node.get("type")
        reason = SUMMARISED.get(node.tag, "")
        if node.tag == "Globals" and all(constant.text in ("0", "") for constants in node.children for constant in constants.children):
            continue
        if node.tag == "symmetric_stiffness" or not node.children and node.text in ("", "0") and not node.attributes:
            continue
        listed = diagnostics.missing if node.tag in DECISIVE else diagnostics.omit
        listed(node.line, f"<{node.tag}{f' type={kind}' if kind else ''}{f' name={name}' if name else ''}>" + (f": {reason}" if reason else ""))
