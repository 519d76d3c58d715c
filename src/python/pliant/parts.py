"""What a result holds: the mesh with its groups, and what is drawn of obstacles, tendons, springs, rods and joints."""
import dataclasses

import numpy as np

from .checks import array_of, short
from .error import MissingError, did_you_mean


@dataclasses.dataclass(frozen=True)
class MeshGroup:
    """A named part of the mesh (physical group), as numbers of nodes and cells: rows of the arrays of mesh and fields."""

    name: str  #: or its number, where it has no name
    kind: str  #: "volume", "surface", "curve" or "point"
    nodes: np.ndarray  #: ascending
    #: num_facets x 3 or 6, node numbers, of a surface: corners, then the middles of the sides 01 12 02
    facets: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    cells: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(0, dtype=np.int64))  #: of a volume, ascending

    def __repr__(self) -> str:
        parts = [f"{len(self.nodes):,} nodes"] + [f"{len(found):,} {what}" for what, found in (("facets", self.facets), ("cells", self.cells)) if len(found)]
        return f"MeshGroup({self.kind} {self.name!r}: {', '.join(parts)})"


@dataclasses.dataclass(frozen=True)
class Mesh:
    """Tetrahedra in VTK's order of nodes."""

    coordinates: np.ndarray  #: num_nodes x 3, reference positions [m]
    cells: np.ndarray  #: num_cells x 4, or 10: then the middles of the edges 01 12 02 03 13 23 come last
    body: np.ndarray  #: index of the body of each cell
    body_names: "list[str]"
    #: Rigid bodies without a mesh and a surface: their cells make the tetrahedron with the same moments of inertia.
    masses: "list[str]" = dataclasses.field(default_factory=list)
    #: Rods, whose cells are slim tetrahedra along the axis, and their sections that are held.
    rods: "list[str]" = dataclasses.field(default_factory=list)
    sections: "list[str]" = dataclasses.field(default_factory=list)
    #: Free shells, whose cells are triangles, each with an apex near its middle.
    shells: "list[str]" = dataclasses.field(default_factory=list)
    #: Those of the rods that have a rectangular section.
    rectangular_rods: "list[str]" = dataclasses.field(default_factory=list)
    rigid: "list[str]" = dataclasses.field(default_factory=list)  #: rigid bodies with a mesh
    #: Volumes, surfaces, curves and points of the mesh that have names, or numbers.
    groups: "list[MeshGroup]" = dataclasses.field(default_factory=list)

    @property
    def bodies_with_surface(self) -> "list[str]":
        """Names of the bodies that are neither rods nor parts of them. Fibres, which only stretch, are rods with a name here and no cells."""
        has_cells = np.bincount(self.body, minlength=len(self.body_names)) > 0
        return [name for name, is_there in zip(self.body_names, has_cells) if is_there and name not in (*self.rods, *self.sections)]

    def surface(self, name: str) -> MeshGroup:
        """`result[-1]["displacement"][mesh.surface("tip").nodes]`. MissingError, a KeyError, if there is none of this name."""
        return self._group("surface", name)

    def volume(self, name: str) -> MeshGroup:
        """Bodies are among them."""
        return self._group("volume", name)

    def curve(self, name: str) -> MeshGroup:
        return self._group("curve", name)

    def point(self, name: str) -> MeshGroup:
        return self._group("point", name)

    def _group(self, kind: str, name: str) -> MeshGroup:
        names = [group.name for group in self.groups if group.kind == kind]
        if name not in names:
            near = did_you_mean(str(name), names)
            raise MissingError(f"the mesh has no {kind} {short(name)}; {near}{'It' if near else 'it'} has {', '.join(names) or 'none'}")
        return next(group for group in self.groups if (group.kind, group.name) == (kind, name))

    def __repr__(self) -> str:
        return f"Mesh({len(self.coordinates):,} nodes, {len(self.cells):,} cells; {', '.join([*self.bodies_with_surface, *self.rods])})"


@dataclasses.dataclass(frozen=True)
class Obstacles:
    """The surfaces of obstacles, and where they are in a frame."""

    points: np.ndarray  #: num_points x 3, current positions [m]
    triangles: np.ndarray  #: num_triangles x 3, counterclockwise seen from outside
    obstacle: np.ndarray  #: index of the obstacle of each triangle
    names: "list[str]"

    def __repr__(self) -> str:
        return f"Obstacles({', '.join(self.names)}; {len(self.triangles):,} triangles)"

    def planes(self) -> "list[np.ndarray]":
        """The four points of each plane's square, in order around it: two triangles, where what is closed has more."""
        found = [self.triangles[self.obstacle == k] for k in range(len(self.names))]
        return [np.append(triangles[0], triangles[1, 2]) for triangles in found if len(triangles) == 2]

    def vessels(self) -> "list[int]":
        """Those that bodies are inside of (`side: inside`): their triangles face their middle. Indices into names."""
        return [k for k in range(len(self.names)) if _faces_its_middle(self.points[self.triangles[self.obstacle == k]])]

    def points_of_others(self) -> np.ndarray:
        """Positions of the obstacles that are not planes."""
        count = np.bincount(self.obstacle, minlength=len(self.names))
        return self.points[np.unique(self.triangles[count[self.obstacle] != 2])]


def _faces_its_middle(x: np.ndarray) -> bool:
    """Whether triangles (rows x 3 corners x 3) enclose the side that they face: their mean distance from their middle along their normals,
    which is 0 of a plane, is negative, by more than a hundredth of their extent. Tubes and bowls that are open count, too."""
    if len(x) == 0:
        return False
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    area, middle = np.linalg.norm(normal, axis=1), x.mean(axis=1)
    center = area @ middle / max(area.sum(), 1e-300)
    extent = np.linalg.norm(np.ptp(x.reshape(-1, 3), axis=0))
    return bool(np.einsum("ij,ij->", normal, middle - center) < -0.01 * extent * area.sum())


@dataclasses.dataclass(frozen=True)
class Mechanisms:
    """Tendons, springs, rods and joints as lines, and where they are in a frame."""

    names: "list[str]"  #: of tendons, then springs, then rods, then joints
    kinds: "list[str]"  #: of each: "tendon", "spring", "rod", or the type of a joint
    points: np.ndarray  #: num_points x 3, current positions [m]
    segments: np.ndarray  #: num_segments x 2, point numbers
    part: np.ndarray  #: index into names of each segment
    tension: np.ndarray  #: of each segment [N]; 0 of joints
    joints: np.ndarray  #: the point where each joint is; joints are the last of the names
    axes: np.ndarray  #: num_joints x 3, of unit length; zero of joints without an axis

    def __repr__(self) -> str:
        return f"Mechanisms({', '.join(f'{name}: {kind}' for name, kind in zip(self.names, self.kinds))}; {len(self.segments):,} segments)"

    def points_along(self, part: int) -> np.ndarray:
        """The points of a tendon, a spring or a rod in their order, numbers."""
        segments = self.segments[self.part == part]
        return np.append(segments[:, 0], segments[-1:, 1])


@dataclasses.dataclass(frozen=True)
class Line:
    """A tendon, a spring or a rod in all frames."""

    points: np.ndarray  #: num_frames x num_points x 3, from the pulled end of a tendon [m]
    tension: np.ndarray  #: num_frames x (num_points - 1), of each segment; of a spring its force, positive where it pulls [N]

    def __repr__(self) -> str:
        return f"Line({self.points.shape[0]} frames, {self.points.shape[1]} points)"


@dataclasses.dataclass(frozen=True)
class Joint:
    """A joint in all frames."""

    type: str  #: "hinge", "ball", ...
    point: np.ndarray  #: num_frames x 3, where it is on its second body [m]
    axis: np.ndarray  #: num_frames x 3, of unit length, with its first body; zero if it has none

    def __repr__(self) -> str:
        return f"Joint({self.type}, {len(self.point)} frames)"


@dataclasses.dataclass(frozen=True)
class Field:
    """Values on nodes or cells."""

    values: np.ndarray  #: rows x components; symmetric tensors have xx yy zz xy yz xz
    unit: str
    on_nodes: bool

    def __repr__(self) -> str:
        rows, components = self.values.shape
        return f"Field({rows:,} {'nodes' if self.on_nodes else 'cells'} x {components}{', ' + self.unit if self.unit else ''})"


def von_mises(stress: np.ndarray) -> np.ndarray:
    """sqrt(3/2 s:s), s the deviator, of symmetric tensors, rows x 6 (xx yy zz xy yz xz)."""
    xx, yy, zz, xy, yz, xz = array_of(stress, "von_mises", (None, 6)).T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(normal / 2 + 3 * (xy**2 + yz**2 + xz**2))
