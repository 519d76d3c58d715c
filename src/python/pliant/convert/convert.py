"""Writes an input of Pliant, and its mesh, from a model of Abaqus, CalculiX or FEBio."""
import os
import sys

from pliant.error import PliantError

from . import abaqus, contact, equations, febio, forces, msh
from ..command_line import Parser, exit_code
from .input_text import InputText
from .mesh import Mesh
from .model import Diagnostics, free_name
from .units import SYSTEMS, factor

READERS = {".inp": abaqus.read, ".feb": febio.read}
KEYS = {3: "volume", 2: "surface", 1: "curve", 0: "point"}
# A Poisson's ratio above which elements of the input lock without pressures of their own.
NEARLY_INCOMPRESSIBLE = 0.45
# Laws without a separate resistance to a change of volume.
WITHOUT_PRESSURE = ("linear", "saint-venant-kirchhoff")


def parser_of(program):
    parser = Parser(prog=program, description=__doc__)
    parser.add_argument("model", help="an input file of Abaqus or CalculiX (.inp), or a model of FEBio (.feb)")
    parser.add_argument("-o", "--output", help="the input to write, with its mesh (.msh) next to it; default: MODEL.yaml in the working directory")
    parser.add_argument("--units", choices=SYSTEMS, help="the units of the model, from which all numbers are converted to SI; default: those that "
                        "the file names, else its numbers are kept as they are")
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    return parser


def main(arguments, program):
    options = parser_of(program).parse_args(arguments)
    return exit_code(program, lambda: convert(options), PliantError, options.output, ".yaml")


def convert(options):
    stem, kind = os.path.splitext(options.model)
    if kind.lower() not in READERS:
        raise PliantError(f"{options.model}: the name must end in .inp (Abaqus, CalculiX) or .feb (FEBio)")
    output = options.output or os.path.basename(stem) + ".yaml"
    if os.path.splitext(output)[1] not in (".yaml", ".yml"):
        raise PliantError(f"{output}: the name must end in .yaml")
    mesh_file = os.path.splitext(output)[0] + ".msh"
    for file in (output, mesh_file):
        if os.path.exists(file) and not options.force:
            raise PliantError(f"{file} exists: name another file with --output, or replace it with --force")
    diagnostics = Diagnostics(options.model)
    model = READERS[kind.lower()](options.model, diagnostics)
    system = options.units or model.units or "SI"
    if not options.units and not model.units:
        diagnostics.note(None, "the file does not name its units: its numbers are kept and mean SI in the input; if they are millimetres, newtons "
                         "and MPa, convert again with --units mm-N-s")
    contact.separate_bodies(model)
    mesh = mesh_of(model, diagnostics)
    text = input_of(model, mesh, system, os.path.basename(mesh_file), diagnostics)
    msh.write(mesh_file, mesh, factor(system, (0, 1, 0)))
    with open(output, "w", encoding="utf-8") as out:
        out.write(head(model, diagnostics, system) + text)
    report(output, mesh_file, diagnostics)


def mesh_of(model, diagnostics):
    """The mesh with a group for each set and surface; groups of elements without a body are left out."""
    members = sorted({row for body in model.bodies for row in model.element_sets[body.elements]})
    if not members:
        others = [text for _, text in diagnostics.left_out if text.startswith("elements of types")]
        raise PliantError(f"{diagnostics.file}: no solid elements (bricks, wedges, pyramids, tetrahedra) have a material" + "".join(f"; {text}" for text in others))
    mesh = Mesh(model, members)
    if any("brick" in kind or "wedge" in kind or "pyramid" in kind for kind in mesh.by_kind):
        diagnostics.note(None, f"{sum(len(rows) for rows in mesh.by_kind.values())} elements were cut into {len(mesh.cells)} tetrahedra"
                         + ("" if mesh.quadratic else ", with quadratic displacements (element: P2)"))
    inverted, flat = mesh.inverted
    if inverted:
        diagnostics.note(None, f"{inverted} tetrahedra had their nodes in the order of a negative volume, and were reordered")
    if flat:
        diagnostics.note(None, f"{flat} tetrahedra have no volume: 'pliant check' will name them")
    present = set(members)
    used = {body.elements for body in model.bodies} | {selection.name for selection, _ in model.constraints + model.loads if selection}
    for name, rows in model.element_sets.items():
        if name in model.internal_sets and name not in used:
            continue  # Abaqus/CAE's own, such as those of the sides of a surface
        if present & set(rows):
            mesh.name_elements(name, present & set(rows))
    for name, faces in model.surfaces.items():
        mesh.name_faces(name, faces)
    taken = {*model.node_sets, *model.surfaces, *model.element_sets}
    for name, rows in model.node_sets.items():
        new = name
        if any(name in mesh.groups[dimension] for dimension in (3, 2)):
            new = free_name(f"{name}_nodes", taken)
            taken.add(new)
        model.node_sets[name] = (new, rows)
    model.dimensions = {new: mesh.name_nodes(new, rows) for new, rows in model.node_sets.values()}
    omit_stray_nodes(model, mesh, diagnostics)
    return mesh


def omit_stray_nodes(model, mesh, diagnostics):
    """Lists sets of nodes of which the groups lack some. Where a motion or a load needs these, a box stands for each of them; forces and equations find them."""
    most = 6
    conditions = [selection for selection, _ in model.constraints + model.loads if selection is not None and selection.kind == "node"]
    complete = {selection.name for selection in conditions} | {name for name, _ in model.nodal_forces}
    related = {row for terms, _ in model.equations for row, *_ in terms}
    stray = {name: len(set(mesh.loose[new]) - related) for name, (new, _) in model.node_sets.items() if name not in complete}
    found = [f"{name} ({count} of {len(set(model.node_sets[name][1]))})" for name, count in stray.items() if count]
    if found:
        others = [f"{len(found) - most + 1} others"] if len(found) > most else []
        diagnostics.omit(None, "nodes in the middle of edges whose ends are not both in their set, and which no group of the mesh can have: "
                         + ", ".join(found[:most - 1] + others if others else found))


def groups_of(model, mesh, selection):
    """Keys that select it, one for each dimension of its groups, and one for each node that no group can have."""
    if selection is None:
        return [{}]
    if selection.kind == "element":
        return [{"volume": selection.name}]
    if selection.kind == "face":
        return [{"surface": selection.name}]
    name = model.node_sets[selection.name][0]
    return [{KEYS[dimension]: name} for dimension in model.dimensions[name]] + [{"box": mesh.box_around(row)} for row in mesh.loose[name]]


def attach(model, mesh, diagnostics):
    """Names what the rigid bodies hold; those that hold neither one surface nor one volume are left out."""
    for body in list(model.rigid_bodies):
        key = "coupled" if "coupled" in body else "attached"
        groups = [group for group in groups_of(model, mesh, body[key]) if "box" not in group]  # without stray nodes in the middle of edges
        names = [group[kind] for group in groups for kind in ("surface", "volume") if kind in group]
        if len(groups) == 1 and names:
            body[key] = names
            continue
        diagnostics.missing(None, f"the nodes of {body[key].name} move with a reference node in the model, and are not one surface or volume: left out with its forces")
        model.rigid_bodies.remove(body)
        for entries in (model.constraints, model.loads):
            entries[:] = [(selection, keys) for selection, keys in entries if selection is not None or keys.get("volume") != body["name"]]


def input_of(model, mesh, system, mesh_file, diagnostics):
    attach(model, mesh, diagnostics)
    constraints, loads = [], []
    for selection, keys in model.constraints:
        groups = groups_of(model, mesh, selection)
        named = {} if selection is None or len(groups) == 1 and "surface" in groups[0] else {"name": selection.name}  # else without a column in the history
        if "rigid" in keys and len(groups) != 1:
            diagnostics.missing(None, f"the nodes of {selection.name} move as a rigid part in the model, and are not one surface or volume: left out")
            continue
        constraints += [{**named, **group, **keys} for group in groups]
    constraints += equations.equation_entries(model, mesh, diagnostics)
    for selection, keys in model.loads:
        loads += [{**group, **keys} for group in groups_of(model, mesh, selection)]
    loads += forces.add_loads(model, mesh, diagnostics)
    if mesh.crowded:
        diagnostics.missing(None, f"{len(mesh.crowded)} nodes in the middle of edges are at the places of others, as where instances touch: their conditions, at a 'box', "
                            "hold at all of these: correct them in the input")
    element = "P1" if mesh.is_linear_only else "P2"
    volumetric = volumetric_of(model, element, diagnostics)
    return "\n".join(InputText(model, system).lines(mesh_file, (element, volumetric), constraints, loads, contact.section(model, mesh, diagnostics))) + "\n"


def volumetric_of(model, element, diagnostics):
    replace_laws(model, diagnostics)
    laws = {body.elasticity["model"] for body in model.bodies if body.elasticity}
    hard = any(body.poisson > NEARLY_INCOMPRESSIBLE for body in model.bodies)
    needs_pressure = any(body.needs_pressure for body in model.bodies)
    if not hard and not needs_pressure:
        return "standard"
    if not laws & set(WITHOUT_PRESSURE) or needs_pressure:
        return "mixed"
    if element == "P2":
        return "mean-dilatation"
    diagnostics.note(None, "a body is nearly incompressible, and its linear tetrahedra will lock: use element: P2 with volumetric: mean-dilatation")
    return "standard"


def replace_laws(model, diagnostics):
    """Next to a body whose volume needs a pressure of its own, laws that cannot have one become others with the same constants."""
    first = next((body for body in model.bodies if body.needs_pressure), None)
    replaced = {}  # names of bodies, by their law in the model and the one that stands for it
    for body in model.bodies:
        if first and body.elasticity and body.elasticity["model"] in WITHOUT_PRESSURE:
            # The volumetric part of neo-hookean is Lame's lambda, that of neo-hookean-isochoric the bulk modulus.
            law = "neo-hookean" if body.elasticity["poissons_ratio"] > 0 else "neo-hookean-isochoric"
            replaced.setdefault((body.elasticity["model"], law), []).append(body.elements)
            body.elasticity = {**body.elasticity, "model": law}
            body.viscosity = [shape_branch(branch) for branch in body.viscosity]
        elif body.law_note:
            diagnostics.note(*body.law_note)
    for (law, other), names in replaced.items():
        diagnostics.note(None, f"{', '.join(names)}: {other} with the same Young's modulus and Poisson's ratio stands for {law}, from which it differs at large strains: "
                         f"{first.elements} needs volumetric: mixed, for which {law} has no separate volumetric part; changes of volume do not relax")


def shape_branch(branch):
    """A branch that relaxes the shape alone."""
    if branch.get("model") != "maxwell":
        return branch
    return {"model": "prony", "ratio": branch["shear_ratio"], "relaxation_time": branch["relaxation_time"]}


def head(model, diagnostics, system):
    lines = [f"Written by pliant convert from {diagnostics.file} ({model.program}); numbers in "
             + ("SI." if system == "SI" else f"SI, converted from {system}.")]
    for title, entries in (("Not in this input:", diagnostics.left_out), ("Note:", diagnostics.notes)):
        if entries:
            lines += [title, *("  " + line for line in diagnostics.lines(entries))]
    return "".join(f"# {line}\n" for line in lines)


def report(output, mesh_file, diagnostics):
    for line in diagnostics.lines(diagnostics.left_out):
        print(f"warning: {line}", file=sys.stderr)
    for line in diagnostics.lines(diagnostics.notes):
        print(f"note: {line}", file=sys.stderr)
    print(f"{output}\n{mesh_file}")
    if diagnostics.incomplete:
        print("warning: the input is not complete: see the warnings above, and what pliant check asks for", file=sys.stderr)
