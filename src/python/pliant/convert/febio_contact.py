"""Contact interfaces of FEBio: surfaces that slide become pairs of `contact`, surfaces that are tied constraints."""
from .model import FORCE_DENSITY, LENGTH, ContactPair, Quantity, Selection

TIES = {"tied", "tied-elastic", "tied-node-on-facet", "tied-facet-on-facet"}
# With the names of versions before 3.
SLIDING = {"sliding-elastic", "sliding-node-on-facet", "sliding-facet-on-facet", "sliding_with_gaps", "facet-to-facet sliding", "sliding-tension-compression"}
# What else changes the result if it is not 0.
DECISIVE = ("tension", "offset")
# What chooses how contact is found and enforced.
SETTINGS = ("laugon", "penalty", "auto_penalty", "update_penalty", "two_pass", "tolerance", "gaptol", "minaug", "maxaug", "knmult", "ktmult", "search_tol", "search_radius",
            "symmetric_stiffness", "seg_up", "smooth_aug", "fric_penalty", "fric_coeff", "node_reloc", "smooth_fls", "flip_primary", "flip_secondary", "shell_bottom_primary",
            "shell_bottom_secondary", "use_contact_area", "closest_point")


class FebioContact:
    """Reads the section `Contact`."""

    def __init__(self, model, mesh, diagnostics):
        self.model, self.mesh, self.diagnostics = model, mesh, diagnostics

    def read(self, node, in_step):
        """An entry; one that is neither tied nor sliding is listed with what nothing was made of. `in_step`: of several."""
        kind, said = node.get("type"), f"<{node.tag} type={node.get('type')}>"
        if kind not in TIES | SLIDING:
            return
        sides = self.mesh.surface_pairs.get(node.get("surface_pair"), [])
        if len(sides) != 2 or any(side not in self.model.surfaces for side in sides):
            self.diagnostics.missing(node.use().line, f"{said}: the surface pair '{node.get('surface_pair')}' has not two surfaces of the mesh")
        elif in_step:
            self.diagnostics.missing(node.use().line, f"{said} stands in one of several steps: surfaces are tied or touch from the start to the end of a run; left out")
        elif kind in TIES:
            self.tie(node, sides)
        else:
            self.slide(node, sides, said)

    def tie(self, node, sides):
        keys, distance = {"tied_to": sides[1]}, node.child("max_distance")
        if distance is not None and self.diagnostics.number(distance.text, distance.line, "max_distance") > 0:
            keys["tolerance"] = Quantity(float(distance.text), LENGTH)
        node.use()
        self.model.constraints.append((Selection("face", sides[0]), keys))

    def slide(self, node, sides, said):
        for child in node.children:
            if child.tag in SETTINGS:
                child.use()
            if child.tag in DECISIVE and child.use().text not in ("", "0"):
                self.diagnostics.missing(child.line, f"{said}: <{child.tag}> has no counterpart in `contact`")
        friction = self.constant(node, "fric_coeff", said)
        # Without multipliers the pressure is the penalty times the gap, where FEBio does not choose the penalty itself.
        chosen = self.constant(node, "auto_penalty", said) or self.augments(node)
        penalty = 0.0 if chosen else self.constant(node, "penalty", said, 1.0)
        node.used = True
        surfaces = [Selection("face", side) for side in dict.fromkeys(sides)]
        self.model.contact.pairs.append(ContactPair(node.line, f"{said} of {' and '.join(sides)}", surfaces, friction, Quantity(penalty, FORCE_DENSITY) if penalty > 0 else None))
        self.model.contact.adjusts |= bool(self.constant(node, "node_reloc", said))

    def augments(self, node):
        laugon = node.child("laugon")
        return laugon is not None and laugon.text.strip().upper() not in ("", "0", "PENALTY")

    def constant(self, node, tag, said, default=0.0):
        child = node.child(tag)
        if child is None:
            return default
        if child.get("lc") not in ("", "0"):
            self.diagnostics.missing(child.line, f"{said}: <{tag}> follows a load curve: the value without it stands in the input")
        return self.diagnostics.number(child.text, child.line, tag)
