"""Materials of Abaqus and CalculiX.

Sources: Abaqus Theory Guide 4.6.1 (hyperelasticity), 4.8.2 (viscoelasticity); CalculiX CrunchiX User's Manual, *HYPERELASTIC. In Abaqus
D1 is 2 over the bulk modulus, and the energy of a change of volume (J - 1)^2/D1; that of Arruda-Boyce is ((J^2 - 1)/2 - ln J)/D.
"""
import dataclasses

from .abaqus_deck import real, whole
from .model import DENSITY, RATE, STRESS, TIME, Quantity, lame, poisson_of

POISSON_OF_CALCULIX = 0.475  # where D1 is 0
# Of the series of Arruda & Boyce: mu over the modulus at rest is 1 / (1 + sum of these / lm^2, lm^4, ...)
ARRUDA_BOYCE = (3 / 5, 99 / 175, 513 / 875, 42039 / 67375)


@dataclasses.dataclass
class Material:
    """What was read; `shear`, `bulk`: at small strain, or None for the bulk modulus of an incompressible material."""

    name: str
    line: int
    elasticity: "dict | None" = None
    density: "Quantity | None" = None
    viscosity: list = dataclasses.field(default_factory=list)
    damping: list = dataclasses.field(default_factory=list)  # in motion only
    damping_line: int = 0
    shear: float = 0.0
    bulk: "float | None" = None
    is_linear: bool = False
    instantaneous: bool = False
    prony: list = dataclasses.field(default_factory=list)
    prony_line: int = 0
    expansion: list = dataclasses.field(default_factory=list)  # rows: coefficient, temperature
    law_note: "tuple | None" = None  # (line, text) of a note about the law
    expansion_zero: float = 0.0

    @property
    def poisson(self):
        return 0.5 if self.bulk is None else poisson_of(self.shear, self.bulk)


class AbaqusMaterials:
    """Reads the cards from *MATERIAL on."""

    def __init__(self, diagnostics):
        self.diagnostics = diagnostics
        self.by_name = {}
        self.current = None
        self.handlers = {"ELASTIC": self.read_elastic, "HYPERELASTIC": self.read_hyperelastic, "DENSITY": self.read_density,
                         "VISCOELASTIC": self.read_viscoelastic, "DAMPING": self.read_damping, "EXPANSION": self.read_expansion}

    def read(self, card):
        """Whether the card belongs to a material."""
        if card.keyword == "MATERIAL":
            self.current = Material(card.value("NAME"), card.line)
            self.by_name[card.upper("NAME")] = self.current
            return True
        if self.current is None or card.keyword not in self.handlers:
            return False
        self.handlers[card.keyword](card)
        return True

    def row(self, card, count, what):
        """The numbers of the card, of its lowest temperature."""
        flat = [(line, entry) for line, entries in card.data for entry in entries]
        if not flat:
            raise self.diagnostics.wrong(card.line, f"{card.title} has no data")
        entries = [entry for _, entry in flat]
        filled = len([entry for entry in entries if entry])
        if filled > count + 1:
            self.diagnostics.note(card.line, f"{card.title}: the constants of the first temperature are used")
        return [real(entries, k, card.line, self.diagnostics, what, 0.0) for k in range(count)]

    def read_expansion(self, card):
        if card.upper("TYPE", "ISO") != "ISO" or card.has("USER"):
            self.diagnostics.missing(card.line, f"{card.title}, {'USER' if card.has('USER') else 'TYPE=' + card.upper('TYPE')}: `expansion` is the same in all directions")
            return
        self.current.expansion = [(real(entries, 0, line, self.diagnostics, "the coefficient of expansion"), real(entries, 1, line, self.diagnostics, "the temperature", 0.0))
                                  for line, entries in card.data]
        self.current.expansion.sort(key=lambda row: row[1])
        self.current.expansion_zero = real([card.value("ZERO")], 0, card.line, self.diagnostics, "ZERO", 0.0)

    def read_density(self, card):
        self.current.density = Quantity(self.row(card, 1, "the density")[0], DENSITY)

    def read_elastic(self, card):
        kind = card.upper("TYPE", "ISOTROPIC")
        if kind not in ("ISOTROPIC", "ISO", ""):
            self.diagnostics.missing(card.line, f"{card.title}, TYPE={kind}: Pliant has no law of this kind; `pliant materials` lists those with fibres")
            return
        material = self.current
        young, poisson = self.row(card, 2, "Young's modulus or Poisson's ratio")
        if not (-1 < poisson < 0.5 and young > 0):
            raise self.diagnostics.wrong(card.line, f"{card.title}: Young's modulus must be above 0 and Poisson's ratio between -1 and 0.5, not {young:g} and "
                                         f"{poisson:g}; for an incompressible body give *HYPERELASTIC, NEO HOOKE with D1 = 0")
        material.is_linear = True
        material.instantaneous = card.upper("MODULI") == "INSTANTANEOUS"
        material.shear, lam = lame(young, poisson)
        material.bulk = lam + 2 / 3 * material.shear
        material.elasticity = {"model": "linear", "youngs_modulus": Quantity(young, STRESS), "poissons_ratio": poisson}

    def read_hyperelastic(self, card):
        names = {"NEOHOOKE": self.neo_hooke, "MOONEY-RIVLIN": self.mooney_rivlin, "YEOH": self.yeoh, "OGDEN": self.ogden,
                 "ARRUDA-BOYCE": self.arruda_boyce, "REDUCEDPOLYNOMIAL": self.reduced_polynomial, "POLYNOMIAL": self.polynomial}
        if "TESTDATAINPUT" in card.parameters:
            self.diagnostics.missing(card.line, f"{card.title}, TEST DATA INPUT: find the constants with `pliant fit`")
            return
        self.current.instantaneous = card.upper("MODULI") == "INSTANTANEOUS"
        known = [name for name in names if card.has(name)]
        others = [name for name in card.parameters if name not in (*names, "N", "MODULI", "PROPERTIES", "BETA")]
        if not known and others:
            self.diagnostics.missing(card.line, f"{card.title}, {others[0]}: Pliant has no law of this kind; `pliant materials` lists its laws")
            return
        names[known[0] if known else "POLYNOMIAL"](card, whole(card.value("N") or "1", card.line, self.diagnostics, "N"))

    def set_law(self, card, model, constants, shear, compliances, volumetric="quadratic"):
        """`compliances`: D1, D2, ..."""
        law = {"model": model, **constants}
        material = self.current
        material.shear = shear
        if any(compliances[1:]):
            self.diagnostics.note(card.line, f"{card.title}: of the constants D1, D2, ... only D1 is used: the bulk modulus at small changes of volume")
        if compliances[0] > 0:
            material.bulk = 2 / compliances[0]
            law["bulk_modulus"] = Quantity(material.bulk, STRESS)
            law["volumetric_energy"] = volumetric
        else:
            nu = POISSON_OF_CALCULIX
            law["incompressible"] = True
            self.diagnostics.note(card.line, f"{card.title}: D1 is 0, and the body is incompressible, as in Abaqus; CalculiX takes a Poisson's ratio "
                                  f"of {nu} there: `bulk_modulus: {2 * shear * (1 + nu) / (3 * (1 - 2 * nu)):.9g}` in the units of the file instead of `incompressible`")
        material.elasticity = law

    @staticmethod
    def stresses(**constants):
        return {name: Quantity(value, STRESS) for name, value in constants.items() if value != 0 or name in ("c10", "c01")}

    def neo_hooke(self, card, _):
        c10, d = self.row(card, 2, "C10 or D1")
        self.set_law(card, "neo-hookean-isochoric", self.stresses(shear_modulus=2 * c10), 2 * c10, [d])

    def mooney_rivlin(self, card, _):
        c10, c01, d = self.row(card, 3, "C10, C01 or D1")
        self.set_law(card, "mooney-rivlin", self.stresses(c10=c10, c01=c01), 2 * (c10 + c01), [d])

    def yeoh(self, card, _):
        c10, c20, c30, *d = self.row(card, 6, "C10, C20, C30, D1, D2 or D3")
        self.set_law(card, "yeoh", self.stresses(c10=c10, c20=c20, c30=c30), 2 * c10, d)

    def reduced_polynomial(self, card, n):
        if n > 3:
            self.diagnostics.missing(card.line, f"{card.title}, REDUCED POLYNOMIAL, N={n}: yeoh has up to 3 terms")
            return
        constants = self.row(card, 2 * n, "a constant")
        named = dict(zip(("c10", "c20", "c30"), constants[:n]))
        self.set_law(card, "yeoh", self.stresses(**named), 2 * named["c10"], constants[n:])

    def polynomial(self, card, n):
        if n == 1:
            self.mooney_rivlin(card, n)
        elif n == 2:
            c10, c01, c20, c11, c02, *d = self.row(card, 7, "a constant")
            self.set_law(card, "mooney-rivlin-5", self.stresses(c10=c10, c01=c01, c20=c20, c11=c11, c02=c02), 2 * (c10 + c01), d)
        else:
            self.diagnostics.missing(card.line, f"{card.title}, POLYNOMIAL, N={n}: mooney-rivlin-5 is the one with N=2")

    def ogden(self, card, n):
        """Abaqus's mu_i is Pliant's: 2 mu_i/alpha_i^2 (l1^alpha_i + ...)."""
        if n > 4:
            self.diagnostics.missing(card.line, f"{card.title}, OGDEN, N={n}: ogden has up to 4 terms")
            return
        constants = self.row(card, 3 * n, "a constant")
        law = {}
        for k in range(n):
            law[f"mu{k + 1}"] = Quantity(constants[2 * k], STRESS)
            law[f"alpha{k + 1}"] = constants[2 * k + 1]
        self.set_law(card, "ogden", law, sum(constants[0:2 * n:2]), constants[2 * n:])

    def arruda_boyce(self, card, _):
        mu, locking, d = self.row(card, 3, "mu, lambda_m or D")
        if locking <= 1:
            raise self.diagnostics.wrong(card.line, f"{card.title}, ARRUDA-BOYCE: lambda_m must be above 1, not {locking:g}")
        shear = mu * (1 + sum(a / locking ** (2 * k) for k, a in enumerate(ARRUDA_BOYCE, 1)))
        self.set_law(card, "arruda-boyce", {"shear_modulus": Quantity(shear, STRESS), "locking_stretch": locking}, shear, [d], "mixed")

    def read_viscoelastic(self, card):
        if card.upper("TIME") != "PRONY":
            self.diagnostics.missing(card.line, f"{card.title}: only TIME=PRONY has a counterpart (viscosity: prony, maxwell)")
            return
        self.current.prony = [tuple(real(entries, k, line, self.diagnostics, "a constant of the Prony series", 0.0) for k in range(3))
                              for line, entries in card.data]
        self.current.prony_line = card.line

    def read_damping(self, card):
        self.current.damping_line = card.line
        for name, value in card.parameters.items():
            if name == "ALPHA":
                self.current.damping.append({"model": "mass-proportional", "decay_rate": Quantity(self.diagnostics.number(value, card.line, name), RATE)})
            elif name == "BETA":
                self.current.damping.append({"model": "stiffness-proportional", "time": Quantity(self.diagnostics.number(value, card.line, name), TIME)})
            else:
                self.diagnostics.omit(card.line, f"{card.title}, {name}")

    def finish(self, material, nonlinear, steps):
        """Turns the Prony series into branches: ratios of Abaqus refer to the modulus of fast motion, Pliant's to that at rest."""
        if material.is_linear and nonlinear and material.elasticity:
            material.elasticity["model"] = "saint-venant-kirchhoff"
            material.law_note = (material.line, f"material {material.name}: *ELASTIC with large displacements becomes saint-venant-kirchhoff, which is "
                                 "CalculiX's law; Abaqus's differs at large strains, and neo-hookean is the better choice there")
        if steps.kind == "static" and material.damping:
            self.diagnostics.note(material.damping_line, "*DAMPING acts in motion only, as in the model, and static steps are without it")
        else:
            material.viscosity += material.damping
        if not material.prony or not material.elasticity:
            return
        at_rest = [1 - sum(row[k] for row in material.prony) for k in (0, 1)]
        if min(at_rest) <= 0:
            raise self.diagnostics.wrong(material.prony_line, "the ratios of the Prony series add up to 1 or more: nothing is left at rest")
        if steps.rates and "all" not in steps.rates:
            self.without_rates(material, at_rest, steps)
            return
        if "all" in steps.rates and len(set(steps.rates)) > 1:
            self.diagnostics.missing(material.prony_line, "*VISCOELASTIC: the material relaxes in the static steps, too, which in Abaqus it does not: make them short "
                                     "against its relaxation times")
        if material.instantaneous:
            self.scale(material, *at_rest)
        self.add_branches(material, *at_rest)

    def without_rates(self, material, at_rest, steps):
        """Static steps have the moduli of fast motion; with LONG TERM those at rest."""
        is_long = set(steps.rates) == {"long term"}
        if is_long and material.instantaneous:
            self.scale(material, *at_rest)
        if not is_long and not material.instantaneous:
            self.scale(material, *(1 / rest for rest in at_rest))
        material.prony = []
        self.diagnostics.note(material.prony_line, f"*VISCOELASTIC: static steps {'with' if is_long else 'without'} LONG TERM have the moduli "
                              f"{'at rest' if is_long else 'of fast motion'}, as in Abaqus; for relaxation the model needs *VISCO")
        if not is_long and "long term" in steps.rates:
            self.diagnostics.missing(material.prony_line, "*VISCOELASTIC: some static steps are with LONG TERM, and have the moduli of fast motion here, too")

    def add_branches(self, material, shear_rest, bulk_rest):
        if material.elasticity["model"] in ("linear", "saint-venant-kirchhoff"):
            material.viscosity += [{"model": "maxwell", "shear_ratio": g / shear_rest, "bulk_ratio": k / bulk_rest, "relaxation_time": Quantity(time, TIME)}
                                   for g, k, time in material.prony]
            return
        material.viscosity += [{"model": "prony", "ratio": g / shear_rest, "relaxation_time": Quantity(time, TIME)} for g, _, time in material.prony]
        if any(k != 0 for _, k, _ in material.prony):
            self.diagnostics.note(material.prony_line, "*VISCOELASTIC: with volumetric: mixed, a change of volume does not relax: the ratios of the bulk modulus "
                                  "are left out")

    @staticmethod
    def scale(material, shear_factor, bulk_factor):
        """Multiplies the moduli."""
        law = material.elasticity
        material.shear *= shear_factor
        material.bulk = None if material.bulk is None else material.bulk * bulk_factor
        if material.is_linear:
            shear, bulk = material.shear, material.bulk
            law["youngs_modulus"] = Quantity(9 * bulk * shear / (3 * bulk + shear), STRESS)
            law["poissons_ratio"] = poisson_of(shear, bulk)
            return
        for name, value in law.items():
            if isinstance(value, Quantity):
                law[name] = Quantity(value.value * (bulk_factor if name == "bulk_modulus" else shear_factor), value.dimension)
