"""Nodes, elements, sets and surfaces of a model of FEBio."""
import collections
import re

import numpy as np

from .cells import KINDS
from .model import free_name

SOLIDS = {"tet4": "tetrahedron", "tet10": "quadratic tetrahedron", "tet15": "quadratic tetrahedron", "hex8": "brick", "hex20": "quadratic brick",
          "hex27": "quadratic brick", "penta6": "wedge", "penta15": "quadratic wedge", "pyra5": "pyramid", "pyra13": "quadratic pyramid"}
CORNERS_OF_FACES = {"tri3": 3, "tri6": 3, "tri7": 3, "tri10": 3, "quad4": 4, "quad8": 4, "quad9": 4}


class FebioMesh:
    """Reads `Mesh` (`Geometry` before version 3) and `MeshDomains`; `material_of`: the material of each set of elements that is a domain."""

    def __init__(self, root, model, diagnostics):
        self.model, self.diagnostics = model, diagnostics
        self.row_of_node, self.row_of_element, self.material_of = {}, {}, {}
        self.left_out = collections.Counter()
        self.other_domains = {}  # lines of domains without solid elements
        points = []
        section = root.child("Mesh") or root.child("Geometry")
        if section is None:
            raise diagnostics.wrong(root.line, "the model has no mesh in this file (Mesh, or Geometry)")
        self.given_names = {node.get("name") for node in section.children}
        for nodes in section.each("Nodes"):
            self.read_nodes(nodes.use(), points)
        model.points = np.array(points)
        for elements in section.each("Elements"):
            self.read_elements(elements.use())
        if self.left_out:
            diagnostics.missing(section.line, "elements of types without a counterpart: " + ", ".join(f"{n} {kind}" for kind, n in self.left_out.items()))
        self.check_names(section)
        for node_set in section.each("NodeSet"):
            model.node_sets[node_set.get("name")] = [self.row_of_node[label] for label in self.labels(node_set) if label in self.row_of_node]
        for element_set in section.each("ElementSet"):
            rows = [self.row_of_element[label] for label in self.labels(element_set) if label in self.row_of_element]
            self.name_element_set(element_set.get("name"), rows)
        for surface in section.each("Surface"):
            self.read_surface(surface.use())
        self.surface_pairs = {}
        for pair in section.each("SurfacePair"):
            sides = [pair.child(tag) or pair.child(old) for tag, old in (("primary", "slave"), ("secondary", "master"))]  # versions from 3 on, 2.5
            self.surface_pairs[pair.get("name")] = [side.text or side.get("surface") for side in sides if side is not None]
            pair.use()  # what names it is listed, if it is left out
        for unused in ("DiscreteSet", "Edge", "PartList"):
            for node in section.each(unused):
                self.diagnostics.omit(node.use().line, f"{unused} {node.get('name')}")
        domains = root.child("MeshDomains")
        for domain in domains.children if domains else ():
            domain.used = True
            self.read_domain(domain)

    def check_names(self, section):
        """Names of one kind are not given twice, as FEBio wants it."""
        seen = set()
        for node in section.children:
            key = (node.tag, node.get("name"))
            if node.tag in ("NodeSet", "ElementSet", "Surface", "SurfacePair") and key in seen:
                raise self.diagnostics.wrong(node.line, f"a second {node.tag} has the name '{key[1]}'")
            seen.add(key)

    def whole(self, text, line):
        try:
            return int(text)
        except ValueError:
            raise self.diagnostics.wrong(line, f"'{text.strip()}' is not the number of a node or element") from None

    def read_nodes(self, nodes, points):
        rows = []
        for node in nodes.each("node"):
            x = [self.diagnostics.number(part, node.line, "a coordinate") for part in node.text.split(",")]
            if len(x) != 3:
                raise self.diagnostics.wrong(node.line, f"three coordinates are expected, not '{node.text[:60]}'")
            rows.append(len(points))
            label = self.whole(node.get("id"), node.line)
            if label in self.row_of_node:
                raise self.diagnostics.wrong(node.line, f"a second node has the number {label}")
            self.row_of_node[label] = len(points)
            points.append(x)
        if nodes.get("name"):
            self.model.node_sets[nodes.get("name")] = rows

    def read_elements(self, elements):
        kind = SOLIDS.get(re.sub(r"g[il]?\d+$", "", elements.get("type").lower()))  # without the points of integration: HEX8G8
        if kind is None:
            self.left_out[elements.get("type")] += len(elements.children)
            self.other_domains[elements.get("name")] = elements.line
            return
        count = KINDS[kind].nodes
        rows, has_more = [], False
        for element in elements.each("elem"):
            labels = [self.whole(part, element.line) for part in element.text.split(",")]
            if len(labels) < count or any(label not in self.row_of_node for label in labels):
                raise self.diagnostics.wrong(element.line, f"element {element.get('id')} needs {count} nodes that are defined")
            has_more = has_more or len(labels) > count
            label = self.whole(element.get("id"), element.line)
            if label in self.row_of_element:
                raise self.diagnostics.wrong(element.line, f"a second element has the number {label}")
            self.row_of_element[label] = len(self.model.elements)
            rows.append(len(self.model.elements))
            self.model.kinds.append(kind)
            self.model.elements.append([self.row_of_node[label] for label in labels[:count]])
        if has_more:
            self.diagnostics.omit(elements.line, f"nodes in the middle of faces and elements: {elements.get('type')} becomes a {kind}, whose nodes are at corners and on edges")
        name = elements.get("name") or elements.get("elset") or free_name(f"part_{len(self.material_of) + 1}", self.given_names)
        self.name_element_set(name, rows)
        self.material_of[name] = (elements.get("mat"), elements.line)

    def name_element_set(self, name, rows):
        self.model.element_sets.setdefault(name, []).extend(rows)

    def labels(self, node):
        """Numbers in the text (version 4) or in the children."""
        node.use()
        if node.children:
            return [self.whole(child.get("id") or child.text, child.line) for child in node.children]
        return [self.whole(part, node.line) for part in re.split(r"[,\s]+", node.text) if part]

    def read_surface(self, surface):
        faces = self.model.surfaces.setdefault(surface.get("name"), [])
        for face in surface.children:
            corners = CORNERS_OF_FACES.get(face.tag)
            labels = [self.whole(part, face.line) for part in face.text.split(",")]
            if corners is None or len(labels) < corners or any(label not in self.row_of_node for label in labels):
                raise self.diagnostics.wrong(face.line, f"a face of the surface {surface.get('name')} is not a triangle or quadrilateral of defined nodes")
            faces.append(tuple(self.row_of_node[label] for label in labels[:corners]))

    def read_domain(self, domain):
        name = domain.get("name")
        if domain.tag == "SolidDomain" and name in self.material_of:
            domain.use()
            self.material_of[name] = (domain.get("mat"), domain.line)
        else:
            self.diagnostics.omit(domain.use().line, f"{domain.tag} {name}")

    def node_set_of(self, text, line):
        """The name of a set of nodes that an attribute `node_set` means: a name, or @surface:, @elem_set:, @part_list: and a name."""
        if not text.startswith("@"):
            if text not in self.model.node_sets:
                raise self.diagnostics.undefined(line, f"the node set '{text}' is not defined", text, self.model.node_sets)
            return text
        kind, _, name = text[1:].partition(":")
        if kind == "surface" and name in self.model.surfaces:
            rows = self.nodes_of_surface(name)
        elif kind in ("elem_set", "part_list") and name in self.model.element_sets:
            rows = [node for e in self.model.element_sets[name] for node in self.model.elements[e]]
        else:
            return None
        rows = list(dict.fromkeys(rows))
        if self.model.node_sets.get(name, rows) != rows:  # a node set has this name
            others = {other for other, members in self.model.node_sets.items() if members != rows}
            name = free_name(f"{name}_of_{kind}", others)
        self.model.node_sets.setdefault(name, rows)
        return name

    def nodes_of_surface(self, name):
        """With the nodes on edges of quadratic elements."""
        wanted = {frozenset(face) for face in self.model.surfaces[name]}
        rows = [node for face in self.model.surfaces[name] for node in face]
        for kind_name, nodes in zip(self.model.kinds, self.model.elements):
            kind = KINDS[kind_name]
            if kind.quadratic:
                for face in range(len(kind.faces)):
                    if frozenset(nodes[k] for k in kind.faces[face]) in wanted:
                        rows += [nodes[k] for k in kind.nodes_of_face(face)]
        return rows
