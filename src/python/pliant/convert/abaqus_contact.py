"""Contact of an input file of Abaqus or CalculiX: pairs of surfaces, and contact of all surfaces."""
import dataclasses

from .abaqus_deck import real
from .model import FORCE_DENSITY, ContactPair, Quantity, Selection

# Parameters that choose how contact is computed, and those of *FRICTION and *SURFACE BEHAVIOR that the input needs none for.
WITHOUT_EFFECT = {"INTERACTION", "TYPE", "ADJUST", "TIED", "SMALLSLIDING", "SMOOTH", "SUPPLEMENTARYCONSTRAINTS", "TRACKING", "NOTHICKNESS", "WEIGHT", "EXTENSIONZONE",
                  "HCRIT", "SLIPTOLERANCE", "MECHANICALCONSTRAINT", "CPSET", "ITERATIONLIMIT"}
OF_BEHAVIOR = {"PRESSURE-OVERCLOSURE", "AUGMENTEDLAGRANGE", "DIRECT", "PENALTY"}
OF_FRICTION = {"SLIPTOLERANCE", "ELASTICSLIP", "LAGRANGE", "DEPENDENCIES"}
HARD = ("HARD", "")


@dataclasses.dataclass
class Interaction:
    """What *SURFACE INTERACTION with its *SURFACE BEHAVIOR and *FRICTION says."""

    friction: float = 0.0
    stiffness: "float | None" = None
    is_tied: bool = False


class AbaqusContact:
    """Reads the cards of contact; `finish` writes them into the model."""

    def __init__(self, model, mesh, steps, diagnostics):
        self.model, self.mesh, self.steps, self.diagnostics = model, mesh, steps, diagnostics
        self.interactions, self.last = {}, Interaction()
        self.pairs = []  # (card, line, entries)
        self.general, self.inclusions, self.exclusions, self.assigned = None, [], [], []
        self.handlers = {"SURFACEINTERACTION": self.read_interaction, "SURFACEBEHAVIOR": self.read_behavior, "FRICTION": self.read_friction,
                         "CONTACTPAIR": self.read_pairs, "CONTACT": self.read_general, "CONTACTINCLUSIONS": self.read_inclusions,
                         "CONTACTEXCLUSIONS": self.read_exclusions, "CONTACTPROPERTYASSIGNMENT": self.read_properties}

    def read(self, card):
        """Whether the card is one of contact."""
        if card.keyword not in self.handlers:
            return False
        if not self.steps.skipped:
            self.handlers[card.keyword](card)
        return True

    # ------------------------------------------------------------------ properties
    def read_interaction(self, card):
        self.last = self.interactions[card.upper("NAME")] = Interaction()

    def list_parameters(self, card, known):
        for name, value in card.parameters.items():
            if name not in known:
                self.diagnostics.missing(card.line, f"{card.title}, {name}{'=' + value if value else ''}: it has no counterpart in `contact`")

    def read_behavior(self, card):
        self.list_parameters(card, OF_BEHAVIOR)
        kind = "".join(card.upper("PRESSURE-OVERCLOSURE").split())
        line, entries = card.data[0] if card.data else (card.line, [])
        if kind == "LINEAR":
            self.last.stiffness = real(entries, 0, line, self.diagnostics, "the slope of the pressure")
            if self.last.stiffness <= 0:
                raise self.diagnostics.wrong(line, f"the slope of the pressure must be above 0, not {self.last.stiffness:g}")
        elif kind == "TIED":
            self.last.is_tied = True
        elif kind not in HARD:
            self.diagnostics.missing(card.line, f"{card.title}, PRESSURE-OVERCLOSURE={kind}: the pressure of a `penalty` is linear in the depth: hard contact stands for it; choose its "
                                     "`stiffness` in the input")

    def read_friction(self, card):
        self.list_parameters(card, OF_FRICTION)
        if not card.data:
            return
        line, entries = card.data[0]
        self.last.friction = real(entries, 0, line, self.diagnostics, "the coefficient of friction")
        if self.last.friction < 0:
            raise self.diagnostics.wrong(line, f"the coefficient of friction must not be below 0, and is {self.last.friction:g}")
        if len(card.data) > 1:
            self.diagnostics.missing(line, f"{card.title} that depends on slip, pressure or temperature: the first of its {len(card.data)} coefficients holds")

    # ------------------------------------------------------------------ surfaces
    def read_pairs(self, card):
        for name in card.parameters:
            if name not in WITHOUT_EFFECT:
                self.diagnostics.omit(card.line, f"{card.title}, {name}: the parameter")
        self.pairs += [(card, line, entries) for line, entries in card.data if entries[0]]

    def read_general(self, card):
        self.general = self.general or card

    def read_inclusions(self, card):
        self.inclusions.append((card, card.has("ALLEXTERIOR"), card.data))

    def read_exclusions(self, card):
        self.exclusions += [(card, line, entries) for line, entries in card.data]

    def read_properties(self, card):
        self.assigned += [(line, (entries + ["", "", ""])[:3]) for line, entries in card.data]

    def side(self, text, line):
        """The Selection of a surface, or of a set of nodes."""
        for kind, sets, name_of in (("face", self.model.surfaces, "surface"), ("node", self.model.node_sets, "node")):
            name = self.mesh.spelled(name_of, text)
            if name in sets:
                return Selection(kind, name)
        raise self.diagnostics.undefined(line, f"the surface '{text}' is not defined", text, [*self.model.surfaces, *self.model.node_sets])

    def pair(self, said, line, entries, interaction):
        names = [entry for entry in entries[:2] if entry]
        sides = [self.side(name, line) for name in names]
        if len(sides) == 2 and sides[0] == sides[1]:
            del sides[1]
        stiffness = None if interaction.stiffness is None else Quantity(interaction.stiffness, FORCE_DENSITY)
        return ContactPair(line, said, sides, interaction.friction, stiffness)

    def interaction(self, name, line):
        if not name:
            return Interaction()
        if name.upper() not in self.interactions:
            raise self.diagnostics.undefined(line, f"the surface interaction '{name}' is not defined", name, self.interactions)
        return self.interactions[name.upper()]

    # ------------------------------------------------------------------ the input
    def finish(self):
        """Writes pairs into the model; called before the time of the input is chosen."""
        for card, line, entries in self.pairs:
            self.add_pair(card, line, entries)
        if self.general is not None:
            self.add_general()

    def add_pair(self, card, line, entries):
        said = f"{card.title} of {' and '.join(entry for entry in entries[:2] if entry)}"
        interaction = self.interaction(card.value("INTERACTION"), line)
        pair = self.pair(said, line, entries, interaction)
        if not (interaction.is_tied or card.has("TIED")):
            self.model.contact.pairs.append(pair)
            self.model.contact.adjusts |= card.has("ADJUST")
        elif len(pair.sides) == 2 and all(side.kind == "face" for side in pair.sides):
            self.model.constraints.append((pair.sides[0], {"tied_to": pair.sides[1].name}))
        else:
            self.diagnostics.missing(line, f"{said}, tied: only two surfaces made of faces of elements can be tied")

    def properties_of(self, entries):
        """The name of the interaction of two surfaces of general contact: the last one assigned."""
        wanted = {name.upper() for name in entries[:2] if name}
        return next((name for _, (a, b, name) in reversed(self.assigned) if {side.upper() for side in (a, b) if side} == wanted), None)

    def add_general(self):
        contact, card = self.model.contact, self.general
        common = self.properties_of([]) or ""
        for inclusion, is_all, data in self.inclusions:
            if is_all:
                contact.is_all = True
                contact.general = self.pair(card.title, inclusion.line, [], self.interaction(common, inclusion.line))
                continue
            for line, entries in data:
                entries = (entries + [""])[:2]
                if not all(entries):
                    self.diagnostics.missing(line, f"{inclusion.title} of one surface with all others: list the pairs in `contact.pairs`")
                    continue
                said = f"{inclusion.title} of {' and '.join(entries)}"
                contact.pairs.append(self.pair(said, line, entries, self.interaction(self.properties_of(entries) or common, line)))
        if not self.inclusions:
            self.diagnostics.missing(card.line, f"{card.title} without *CONTACT INCLUSIONS: no surfaces touch")
        for line, (a, b, name) in self.assigned:
            if (a or b) and contact.is_all:
                self.diagnostics.missing(line, f"properties of contact of {' and '.join(side for side in (a, b) if side)} alone ({name}): with contact of all surfaces the same hold for all")
        for exclusion, line, entries in self.exclusions:
            if contact.is_all and entries[0]:
                contact.exclude.append(self.pair(exclusion.title, line, entries, Interaction()))
            else:
                self.diagnostics.missing(line, f"{exclusion.title} of {', '.join(entry for entry in entries if entry) or 'all surfaces'}: leave them out of `contact.pairs`")
