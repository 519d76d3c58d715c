"""Reads an input file of Abaqus or CalculiX."""
import difflib
import os

from .abaqus_assembly import assembled, has_several_instances
from .abaqus_conditions import AbaqusConditions
from .abaqus_contact import AbaqusContact
from .abaqus_deck import read_cards
from .abaqus_materials import AbaqusMaterials
from .abaqus_mesh import AbaqusMesh
from .abaqus_rigid import AbaqusRigid
from .abaqus_steps import AbaqusSteps
from .model import Body, Model

OUTPUT = {"NODEPRINT", "ELPRINT", "NODEFILE", "ELFILE", "OUTPUT", "NODEOUTPUT", "ELEMENTOUTPUT", "CONTACTFILE", "CONTACTPRINT", "CONTACTOUTPUT",
          "SECTIONPRINT", "FACEPRINT", "ENERGYPRINT", "ENERGYOUTPUT", "ENERGYFILE", "FILEOUTPUT", "PREPRINT", "RESTART", "MONITOR", "PRINT",
          "ELEMENTPRINT", "TIMEPOINTS"}
# What changes nothing by itself: properties of elements that are named as left out, controls of contact, and axes of isotropic laws.
WITHOUT_EFFECT = {"ORIENTATION", "SHELLSECTION", "BEAMSECTION", "MEMBRANESECTION", "SHELLGENERALSECTION",
                  "BEAMGENERALSECTION", "PHYSICALCONSTANTS", "DISTRIBUTION", "DISTRIBUTIONTABLE", "CONSTRAINTCONTROLS", "CONTACTINITIALIZATION", "CONDUCTIVITY",
                  "SPECIFICHEAT", "CONTACTCONTROLS", "SURFACEPROPERTYASSIGNMENT"}
STRUCTURE = {"PART", "ENDPART", "INSTANCE", "ENDINSTANCE", "ASSEMBLY", "ENDASSEMBLY", "STEP", "ENDSTEP"}
FIRST = {"NODE": 0, "ELEMENT": 1, "SOLIDSECTION": 3}
OTHERS = 2  # their place
# The most frequent keywords that are read, for what is misspelt.
READ = {title.replace(" ", "").lstrip("*"): title for title in (
    "*NODE", "*ELEMENT", "*NSET", "*ELSET", "*SURFACE", "*MATERIAL", "*DENSITY", "*ELASTIC", "*HYPERELASTIC", "*VISCOELASTIC", "*EXPANSION", "*DAMPING",
    "*SOLID SECTION", "*AMPLITUDE", "*BOUNDARY", "*STEP", "*END STEP", "*STATIC", "*DYNAMIC", "*VISCO", "*CLOAD", "*DLOAD", "*DSLOAD", "*TEMPERATURE",
    "*INITIAL CONDITIONS", "*CONTACT PAIR", "*SURFACE INTERACTION", "*SURFACE BEHAVIOR", "*FRICTION", "*TIE", "*EQUATION", "*TRANSFORM", "*COUPLING",
    "*KINEMATIC", "*DISTRIBUTING", "*RIGID BODY", "*PART", "*INSTANCE", "*ASSEMBLY", "*HEADING", "*INCLUDE")}
CONTROLS = {"CONTROLS", "SOLVERCONTROLS", "HOURGLASSSTIFFNESS", "SECTIONCONTROLS"}


def in_order(cards):
    """Nodes, then elements, come before what names them, and sections after sets, within a part, an instance or the assembly; the file may have any order."""
    block = []
    for card in cards:
        if card.keyword in STRUCTURE:
            yield from sorted(block, key=lambda one: FIRST.get(one.keyword, OTHERS))
            yield card
            block = []
        else:
            block.append(card)
    yield from sorted(block, key=lambda one: FIRST.get(one.keyword, OTHERS))


def read(file, diagnostics):
    """The model; what is left out of it goes to the diagnostics. Raises PliantError with the line for what cannot be read."""
    model = Model("Abaqus or CalculiX", title=os.path.splitext(os.path.basename(file))[0])
    mesh, materials = AbaqusMesh(model, diagnostics), AbaqusMaterials(diagnostics)
    steps, rigid = AbaqusSteps(diagnostics), AbaqusRigid(model, mesh, diagnostics)
    conditions, contact = AbaqusConditions(model, mesh, steps, rigid, diagnostics), AbaqusContact(model, mesh, steps, diagnostics)
    sections, output, controls = [], [], []
    cards = read_cards(file, diagnostics)
    mesh.has_several = has_several_instances(cards)
    for card in in_order(assembled(cards, diagnostics) if mesh.has_several else cards):
        if card.keyword == "PARAMETER":
            raise diagnostics.wrong(card.line, f"{card.title}: names of numbers are not supported: write the numbers in place of <name>")
        if mesh.read(card) or materials.read(card) or rigid.read(card) or conditions.read(card) or contact.read(card) or steps.read(card):
            continue
        if card.keyword == "HEADING":
            model.title = next((" ".join(", ".join(entry for entry in entries if entry).split()) for _, entries in card.data if any(entries)), model.title)
        elif card.keyword == "SOLIDSECTION":
            sections.append((mesh.spelled("element", card.value("ELSET")), card))
        elif card.keyword == "RESTART" and card.has("READ"):
            raise diagnostics.wrong(card.line, f"{card.title}, READ: the model is in the files of another run: convert the file of that run")
        elif card.keyword in OUTPUT:
            output.append(card)
        elif card.keyword in CONTROLS:
            controls.append(card)
        else:
            leave_out(card, diagnostics)
    mesh.finish()
    for cards, text in ((output, "requests of output: `output` and `probes` of the input"), (controls, "controls of the solver: `solver` of the input")):
        if cards:
            diagnostics.omit(cards[0].line, f"{', '.join(dict.fromkeys(card.title for card in cards))}: {text}")
    nonlinear = steps.is_nonlinear or any(m.elasticity and not m.is_linear for m in materials.by_name.values())
    if nonlinear and not steps.is_nonlinear and steps.kind is not None:
        diagnostics.note(None, "no step has NLGEOM: displacements are large in the input, whose laws are not linear")
    finished, material_of = set(), {}
    for name, card in sections:
        name = name if name in model.element_sets else mesh.spelled("element", name)  # a set that is defined after its section
        add_body(model, name, card, materials, (nonlinear, steps), finished, diagnostics)
        material_of[name] = materials.by_name[card.upper("MATERIAL")]
    without = set(range(len(model.elements))).difference(*(model.element_sets.get(body.elements, ()) for body in model.bodies))
    if model.bodies and without:
        diagnostics.missing(None, f"{len(without)} of {len(model.elements)} elements have no *SOLID SECTION, and are left out with what is on them alone")
    contact.finish()
    conditions.finish(nonlinear, material_of)
    mesh.note_coinciding()
    return model


def leave_out(card, diagnostics):
    """A keyword that nothing reads."""
    said = card.title + "".join(f", {name}{'=' + value if value else ''}" for name, value in card.parameters.items())
    if card.keyword in WITHOUT_EFFECT:
        diagnostics.omit(card.line, f"{said}: left out; the input is the same without it")
        return
    near = difflib.get_close_matches(card.keyword, READ, 1, 0.9)  # *PLASTIC is not meant to be *ELASTIC
    diagnostics.missing(card.line, f"{said}: left out; pliant convert does not know this keyword" + (f" (did you mean {READ[near[0]]}?)" if near else ""))


def add_body(model, name, card, materials, analysis, finished, diagnostics):
    material = materials.by_name.get(card.upper("MATERIAL"))
    if name not in model.element_sets:
        raise diagnostics.undefined(card.line, f"the set of elements '{name}' is not defined", name, model.element_sets)
    if not card.has("MATERIAL"):
        raise diagnostics.wrong(card.line, f"{card.title} of {name} names no material (MATERIAL=..)")
    if material is None:
        raise diagnostics.undefined(card.line, f"the material '{card.value('MATERIAL')}' is not defined", card.value("MATERIAL"), (m.name for m in materials.by_name.values()))
    if card.has("ORIENTATION"):
        diagnostics.omit(card.line, f"{card.title}, ORIENTATION")
    if not model.element_sets[name]:
        return  # elements without a counterpart
    if material.name not in finished:
        materials.finish(material, *analysis)
        finished.add(material.name)
    if material.elasticity is None:
        diagnostics.missing(material.line, f"material {material.name}: it has no elastic law that could be converted")
    model.bodies.append(Body(name, material.elasticity, material.density, material.viscosity, material.poisson,
                             bool(material.prony and material.elasticity) and not material.is_linear, law_note=material.law_note))
