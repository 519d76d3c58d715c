"""The mesh of a model as tetrahedra with groups."""
import numpy as np

from .cells import KINDS, tetrahedra_of, triangles_of
from .model import LENGTH, Quantity, free_name

TETRAHEDRON_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3))  # gmsh's order of the nodes on them
TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
EDGE = ((0, 1),)
NEAR = 1e-6  # of the size of the model: half of the edge of the box around a node


class Mesh:
    """Tetrahedra of `points`, with groups of them and of triangles, edges and points.

    Groups of nodes are covered by what their nodes belong to completely: elements, faces, edges; the rest are points. So a prescribed
    motion holds everywhere where it holds in the model, also at nodes that quadratic tetrahedra add.
    """

    def __init__(self, model, members):
        """`members`: rows of the elements that have a body."""
        self.points = np.asarray(model.points, dtype=float)
        self.by_kind = {}
        for row in members:
            self.by_kind.setdefault(model.kinds[row], []).append(row)
        self.nodes = {kind: np.array([model.elements[row] for row in rows], dtype=np.int64) for kind, rows in self.by_kind.items()}
        self.quadratic = any(KINDS[kind].quadratic for kind in self.by_kind)
        self.is_linear_only = set(self.by_kind) <= {"tetrahedron"}
        cells, parents = [], []
        for kind, rows in self.by_kind.items():
            cut, of = tetrahedra_of(KINDS[kind], self.nodes[kind])
            cells.append(cut)
            parents.append(np.asarray(rows)[of])
        self.cells, self.parents = np.concatenate(cells), np.concatenate(parents)
        self.inverted = self._orient()
        self._collect_faces()
        self.mids = self._mid_nodes() if self.quadratic else None
        self._known_faces = None
        self.groups = {3: {}, 2: {}, 1: {}, 0: {}}
        self.names_given = {}  # the number of the last new name with a stem
        self.near, self.places, self.crowded = None, None, set()  # box_around
        self.loose = {}  # by the name of a set: its nodes in the middle of edges whose ends are not in it, which no group can have

    def _orient(self):
        """Gives all tetrahedra a positive volume; returns how many had a negative one, or none."""
        x = self.points[self.cells]
        volumes = np.linalg.det(x[:, 1:] - x[:, :1])
        negative = volumes < 0
        self.cells[negative] = self.cells[negative][:, [0, 2, 1, 3]]
        return int(negative.sum()), int((np.abs(volumes) <= 1e-14 * np.abs(volumes).max()).sum())

    def _collect_faces(self):
        """All faces of the elements, once each: their nodes, filled up by -1, and how many corners they have."""
        rows, corners = [], []
        for kind, nodes in self.nodes.items():
            for face in range(len(KINDS[kind].faces)):
                local = KINDS[kind].nodes_of_face(face)
                rows.append(np.pad(nodes[:, local], ((0, 0), (0, 8 - len(local))), constant_values=-1))
                corners.append(np.full(len(nodes), len(KINDS[kind].faces[face])))
        rows, corners = np.concatenate(rows), np.concatenate(corners)
        _, first, count = np.unique(np.sort(rows, axis=1), axis=0, return_index=True, return_counts=True)
        self.faces, self.face_corners, self.is_outer = rows[first], corners[first], count == 1

    def _keys(self, edges):
        edges = np.sort(edges, axis=1)
        return edges[:, 0] * len(self.points) + edges[:, 1]

    def _mid_nodes(self):
        """Nodes on the edges of the tetrahedra, shape (cells, 6): those of the elements; on a diagonal that cuts a quadratic element or one
        of its faces a new one where the element has its middle; on any other edge a new one halfway."""
        keys, places = [], []
        new_points, count = [], len(self.points)
        for kind_name, nodes in self.nodes.items():
            kind = KINDS[kind_name]
            if not kind.quadratic:
                continue
            for local, edge in enumerate(kind.edges):
                keys.append(self._keys(nodes[:, edge]))
                places.append(nodes[:, kind.corners + local])
            for face in range(len(kind.faces)):
                local = kind.nodes_of_face(face)
                if len(local) == 8:
                    x = self.points[nodes[:, local]]
                    middle = x[:, 4:].sum(axis=1) / 2 - x[:, :4].sum(axis=1) / 4
                    count = self._add(keys, places, new_points, count, middle, [nodes[:, local[:3:2]], nodes[:, local[1:4:2]]])
            if kind.corners == 8:
                x = self.points[nodes]
                middle = x[:, 8:].sum(axis=1) / 4 - x[:, :8].sum(axis=1) / 4
                count = self._add(keys, places, new_points, count, middle, [nodes[:, [0, 6]], nodes[:, [1, 7]], nodes[:, [2, 4]], nodes[:, [3, 5]]])
        known, first = np.unique(np.concatenate(keys), return_index=True)
        known_places = np.concatenate(places)[first]
        edges = self.cells[:, TETRAHEDRON_EDGES].reshape(-1, 2)
        wanted, back = np.unique(self._keys(edges), return_inverse=True)
        at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
        found = known[at] == wanted
        result = np.where(found, known_places[at], -1)
        ends = np.stack(np.divmod(wanted[~found], len(self.points)), axis=1)
        result[~found] = count + np.arange(len(ends))
        self.key_of_edge, self.mid_of_edge = wanted, result
        self.points_with_mids = np.concatenate([self.points, *new_points, self.points[ends].mean(axis=1).reshape(-1, 3)])
        return result[back].reshape(-1, 6)

    def _add(self, keys, places, new_points, count, middle, diagonals):
        for diagonal in diagonals:
            keys.append(self._keys(diagonal))
            places.append(count + np.arange(len(middle)))
        new_points.append(middle)
        return count + len(middle)

    def name_elements(self, name, rows):
        """A group of tetrahedra."""
        self._name(3, name, np.flatnonzero(np.isin(self.parents, np.asarray(list(rows), dtype=np.int64))))

    def name_faces(self, name, corners):
        """A group of triangles, of faces by their corners; those of other elements than these are left out."""
        known = {frozenset(row[:count]) for row, count in zip(self.faces.tolist(), self.face_corners.tolist())} if self._known_faces is None else self._known_faces
        self._known_faces = known
        for count in (3, 4):
            some = np.array([face for face in corners if len(face) == count and frozenset(map(int, face)) in known], dtype=np.int64).reshape(-1, count)
            if len(some):
                self._name(2, name, np.concatenate(triangles_of(some)))

    def name_nodes(self, name, rows):
        """Groups of a set of nodes; returns their dimensions."""
        inside = np.zeros(len(self.points) + 1, dtype=bool)  # the last for -1
        inside[np.asarray(list(rows), dtype=np.int64)] = True
        rest = inside.copy()
        inside[-1] = True
        dimensions = []
        whole = [np.asarray(self.by_kind[kind])[inside[nodes].all(axis=1)] for kind, nodes in self.nodes.items()]
        whole = np.concatenate(whole)
        if len(whole):
            self.name_elements(name, whole)
            dimensions.append(3)
            for kind, nodes in self.nodes.items():
                rest[nodes[np.isin(self.by_kind[kind], whole)].ravel()] = False
        covered = inside[self.faces].all(axis=1) & rest[self.faces].any(axis=1)
        faces, counts = self.faces[covered], self.face_corners[covered]
        if len(faces):
            self.name_faces(name, [face[:count] for face, count in zip(faces, counts)])
            dimensions.append(2)
            rest[faces[faces >= 0]] = False
        if not self.is_linear_only:
            dimensions += self._name_edges(name, inside, rest)
        left = np.flatnonzero(rest[:-1])
        points = self.corners_among(left)
        if len(points):
            self._name(0, name, points)
            dimensions.append(0)
        self.loose[name] = np.setdiff1d(self.of_elements(left), points).tolist()
        return dimensions

    def name_points(self, name, rows):
        """A group of all these nodes as points, as forces need them; returns its name."""
        there = self.groups[0].get(name)
        if there is not None and len(np.concatenate(there)) == len(rows):
            return name
        name = name if there is None else free_name(name + "_points", set().union(*self.groups.values()))
        self._name(0, name, rows)
        return name

    def _name_edges(self, name, inside, rest):
        """Edges of elements with all their nodes in the set: quadratic tetrahedra have a node between the ends."""
        edges = []
        for kind_name, nodes in self.nodes.items():
            kind = KINDS[kind_name]
            for local, edge in enumerate(kind.edges):
                middle = nodes[:, kind.corners + local] if kind.quadratic else nodes[:, edge[0]]
                edges.append(np.column_stack([np.sort(nodes[:, edge], axis=1), middle])[nodes[:, edge[0]] != nodes[:, edge[1]]])
        edges = np.unique(np.concatenate(edges), axis=0)
        edges = edges[inside[edges].all(axis=1) & rest[edges].any(axis=1)]
        if not len(edges):
            return []
        self._name(1, name, edges[:, :2])
        rest[edges.ravel()] = False
        return [1]

    def of_elements(self, rows):
        """Those of some nodes that belong to elements."""
        return np.intersect1d(rows, np.concatenate([nodes.ravel() for nodes in self.nodes.values()]))

    def box_around(self, row):
        """Two opposite corners of a box that has this node alone, and those at the same place, which `crowded` counts."""
        if self.near is None:
            x = self.points[self.cells]
            self.near = NEAR * float((x.max(axis=(0, 1)) - x.min(axis=(0, 1))).max())
            self.places = self.points[self.of_elements(np.arange(len(self.points)))]
        half = self.near
        if np.count_nonzero((np.abs(self.places - self.points[row]) <= half).all(axis=1)) > 1:
            self.crowded.add(row)
        return [[Quantity(float(x) + sign * half, LENGTH) for x in self.points[row]] for sign in (-1, 1)]

    def corners_among(self, rows):
        """Those of some nodes that are corners of elements, once each."""
        return np.intersect1d(np.asarray(list(rows), dtype=np.int64), self.cells)

    def _name(self, dimension, name, members):
        parts = self.groups[dimension].setdefault(name, [])
        parts.append(members)

    def mids_of(self, corners, edges):
        """Nodes on edges, of cells by their corners."""
        at = np.searchsorted(self.key_of_edge, self._keys(corners[:, edges].reshape(-1, 2)))
        return self.mid_of_edge[at].reshape(len(corners), -1)
