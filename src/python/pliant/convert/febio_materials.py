"""Materials of FEBio.

Source: FEBio User's Manual and the energies in its code (FEBioMech): Ogden is sum c_i/m_i^2 (l1^m_i + l2^m_i + l3^m_i - 3), which is twice Pliant's
mu_i; uncoupled materials have U(J) = k/2 (ln J)^2 unless `pressure_model` says otherwise; a viscoelastic material relaxes to its elastic one.
"""
import math
import re

from .abaqus_materials import ARRUDA_BOYCE
from .model import DENSITY, STRESS, TIME, Body, Quantity, poisson_of

# By number or name of pressure_model
VOLUMETRIC = {"0": "log", "default": "log", "1": "mixed", "NIKE3D": "mixed", "2": "quadratic", "Abaqus": "quadratic", "3": "mixed", "Abaqus (GOH)": "mixed"}
LINEAR_TERMS = 6
# Entries of materials that are read elsewhere, belong to terms that are 0, or are axes of isotropic laws.
WITHOUT_EFFECT = re.compile(r"([cmgt]\d+|density|k|mat_axis|fiber)\Z")


class FebioMaterials:
    """Turns an element `material` into a body without elements."""

    def __init__(self, diagnostics):
        self.diagnostics = diagnostics
        self.readers = {"neo-Hookean": self.neo_hookean, "isotropic elastic": self.isotropic_elastic, "Mooney-Rivlin": self.mooney_rivlin,
                        "coupled Mooney-Rivlin": self.coupled_mooney_rivlin, "Ogden": self.ogden, "Yeoh": self.yeoh,
                        "Arruda-Boyce": self.arruda_boyce, "Holzapfel-Gasser-Ogden": self.holzapfel_gasser_ogden,
                        "viscoelastic": self.viscoelastic, "uncoupled viscoelastic": self.viscoelastic}

    def read(self, node):
        """The body, or one without elasticity where there is no counterpart."""
        body = Body("")
        self.read_into(body, node)
        density = node.child("density")
        if density is not None:
            body.density = Quantity(self.number(node, "density"), DENSITY)
        node.use()
        return body

    def read_into(self, body, node):
        kind = node.get("type")
        node.used = True
        if kind not in self.readers:
            self.diagnostics.missing(node.line, f"material {node.get('name') or node.tag}: the law '{kind}' is not supported")
            return
        self.readers[kind](body, node)
        for child in node.children:
            if not child.used and not WITHOUT_EFFECT.match(child.tag) and child.text not in ("0", "0.0"):
                self.diagnostics.missing(child.line, f"material {node.get('name') or node.tag}: <{child.tag}> of '{kind}' has no counterpart")

    def number(self, node, tag, default=0.0):
        child = node.child(tag)
        if child is None:
            return default
        child.use()
        if child.get("lc") not in ("", "0"):
            self.diagnostics.missing(child.line, f"{tag} of a material follows a load curve: its constant is used")
        try:
            value = float(child.text)
        except ValueError:
            value = math.nan
        if math.isfinite(value):
            return value
        self.diagnostics.missing(child.line, f"{tag} is not a number but '{child.text[:40]}': write the formula of x, y, z into the input")
        return default

    def young_and_poisson(self, body, node, model):
        young, poisson = self.number(node, "E"), self.number(node, "v")
        body.poisson = poisson
        body.elasticity = {"model": model, "youngs_modulus": Quantity(young, STRESS), "poissons_ratio": poisson}

    def neo_hookean(self, body, node):
        self.young_and_poisson(body, node, "neo-hookean")

    def isotropic_elastic(self, body, node):
        self.young_and_poisson(body, node, "saint-venant-kirchhoff")

    def coupled_mooney_rivlin(self, body, node):
        c1, c2, k = (self.number(node, tag) for tag in ("c1", "c2", "k"))
        body.poisson = poisson_of(2 * (c1 + c2), k + 4 * c2 + 4 / 3 * (c1 + c2))
        body.elasticity = {"model": "mooney-rivlin-coupled", "c1": Quantity(c1, STRESS), "c2": Quantity(c2, STRESS), "lambda": Quantity(k, STRESS)}

    def uncoupled(self, body, node, model, constants, shear, default="0"):
        """`k` may stand in the material around this one."""
        bulk, pressure_model = self.bulk or self.number(node, "k"), node.child("pressure_model")
        body.poisson = poisson_of(shear, bulk) if bulk > 0 else 0.5
        kind = pressure_model.text.strip() if pressure_model else default
        body.elasticity = {"model": model, **constants, "bulk_modulus": Quantity(bulk, STRESS), "volumetric_energy": VOLUMETRIC.get(kind, VOLUMETRIC[default])}
        if kind not in VOLUMETRIC:
            self.diagnostics.missing(pressure_model.line, f"pressure_model {kind[:40]} is not supported: {', '.join(VOLUMETRIC)} are")
        if bulk <= 0:
            self.diagnostics.missing(node.line, "the bulk modulus k is missing")

    bulk = None  # of an uncoupled viscoelastic material

    def mooney_rivlin(self, body, node):
        c1, c2 = self.number(node, "c1"), self.number(node, "c2")
        if c2 == 0:
            self.uncoupled(body, node, "neo-hookean-isochoric", {"shear_modulus": Quantity(2 * c1, STRESS)}, 2 * c1)
        else:
            self.uncoupled(body, node, "mooney-rivlin", {"c10": Quantity(c1, STRESS), "c01": Quantity(c2, STRESS)}, 2 * (c1 + c2))

    def terms(self, node, most, law):
        """Numbers of those of six constants c1, c2, ... that are not 0; None if there are more than the law has."""
        found = [k for k in range(1, LINEAR_TERMS + 1) if self.number(node, f"c{k}") != 0]
        if len(found) <= most:
            return found
        self.diagnostics.missing(node.line, f"material {node.get('name')}: {law} has up to {most} terms")
        return None

    def ogden(self, body, node):
        found = self.terms(node, 4, "ogden")
        if found is None:
            return
        constants, shear = {}, 0.0
        for k, n in enumerate(found, 1):
            constants[f"mu{k}"] = Quantity(self.number(node, f"c{n}") / 2, STRESS)
            constants[f"alpha{k}"] = self.number(node, f"m{n}", 1.0)
            shear += constants[f"mu{k}"].value
        self.uncoupled(body, node, "ogden", constants, shear)

    def yeoh(self, body, node):
        found = self.terms(node, LINEAR_TERMS, "yeoh")
        if max(found, default=0) > 3:
            self.diagnostics.missing(node.line, f"material {node.get('name')}: yeoh has up to 3 terms")
            return
        constants = {f"c{n}0": Quantity(self.number(node, f"c{n}"), STRESS) for n in found}
        self.uncoupled(body, node, "yeoh", constants, 2 * self.number(node, "c1"))

    def arruda_boyce(self, body, node):
        mu, links = self.number(node, "mu"), self.number(node, "N", 1.0)
        shear = mu * (1 + sum(a / links**k for k, a in enumerate(ARRUDA_BOYCE, 1)))
        self.uncoupled(body, node, "arruda-boyce", {"shear_modulus": Quantity(shear, STRESS), "locking_stretch": math.sqrt(links)}, shear)

    def holzapfel_gasser_ogden(self, body, node):
        axes = self.axes(node)
        if axes is None:
            return
        c, angle = self.number(node, "c"), math.radians(self.number(node, "gamma"))
        constants = {"shear_modulus": Quantity(c, STRESS), "k1": Quantity(self.number(node, "k1"), STRESS), "k2": self.number(node, "k2"),
                     "dispersion": self.number(node, "kappa")}
        for name, sign in (("fibre", 1), ("fibre2", -1)):
            constants[name] = [math.cos(angle) * a + sign * math.sin(angle) * b for a, b in zip(*axes)]
        self.uncoupled(body, node, "holzapfel-gasser-ogden", constants, c, "3")

    def axes(self, node):
        """The first two axes of the material, or None."""
        axis = node.child("mat_axis")
        if axis is None:
            return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        if axis.get("type") != "vector":
            self.diagnostics.missing(axis.use().line, f"material {node.get('name')}: mat_axis of the type {axis.get('type')}: give `fibre` and `fibre2`")
            return None
        a, d = ([self.diagnostics.number(x, axis.line, "a number of mat_axis") for x in axis.child(tag).text.split(",")] for tag in ("a", "d"))
        length = math.sqrt(sum(x * x for x in a))
        a = [x / length for x in a]
        along = sum(x * y for x, y in zip(a, d))
        b = [y - along * x for x, y in zip(a, d)]
        length = math.sqrt(sum(x * x for x in b))
        return a, [x / length for x in b]

    def viscoelastic(self, body, node):
        elastic = node.child("elastic")
        if elastic is None:
            self.diagnostics.missing(node.line, f"material {node.get('name')}: its elastic material is missing")
            return
        is_uncoupled = node.get("type").startswith("uncoupled")
        self.bulk = (self.number(node, "k") or None) if is_uncoupled else None
        self.read_into(body, elastic)
        self.bulk = None
        density = elastic.child("density")
        if density is not None:
            body.density = Quantity(self.number(elastic, "density"), DENSITY)
        rest = self.number(node, "g0", 1.0)
        for k in range(1, LINEAR_TERMS + 1):
            ratio = self.number(node, f"g{k}")
            if ratio:
                body.viscosity.append({"model": "prony", "ratio": ratio / rest, "relaxation_time": Quantity(self.number(node, f"t{k}", 1.0), TIME)})
        if rest != 1 and body.elasticity:
            self.scale(body, node, rest, is_uncoupled)
        body.shape_relaxes = is_uncoupled

    def scale(self, body, node, rest, is_uncoupled):
        """All moduli of the elastic law are multiplied by g0; those of an uncoupled one without the bulk modulus."""
        self.diagnostics.note(node.line, f"material {node.get('name')}: the moduli are those at rest, g0 = {rest:g} times those of the file")
        for name, value in body.elasticity.items():
            if isinstance(value, Quantity) and not (is_uncoupled and name == "bulk_modulus"):
                body.elasticity[name] = Quantity(value.value * rest, value.dimension)
