"""result.h5: the mesh and the fields of a run over time, read when they are asked for."""
import dataclasses
import os
from collections.abc import Sequence
from typing import Any, Optional, Union, overload

import h5py
import numpy as np

from . import notebook
from .checks import array_of, number_of, path_of, positive_of, short
from .error import FILE, InputError, MissingError, PliantError, did_you_mean
from .files import opened, refuse_input, text


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

    @property
    def bodies_with_surface(self) -> "list[str]":
        """Names of the bodies that are neither rods nor parts of them. Fibres, which only stretch, are rods with a name here and no cells."""
        has_cells = np.bincount(self.body, minlength=len(self.body_names)) > 0
        return [name for name, is_there in zip(self.body_names, has_cells) if is_there and name not in (*self.rods, *self.sections)]

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


class Frame:
    """One instant of the time series; its numbers are read when they are asked for."""

    def __init__(self, result: "Result", name: str) -> None:
        group = result.open_file["frames"][name]
        self.result = result
        self.name = name  #: its group in result.h5: "000012"
        self.time = float(group.attrs["time"])  #: [s]; of a static run the load factor, or the length of its path
        self.step = int(group.attrs["step"])
        self.label = text(group.attrs.get("label", ""))  #: "mode 3, 12.4 Hz" where a frame is a mode; else empty
        self.mesh_group = text(group.attrs.get("mesh", "/mesh"))

    def __repr__(self) -> str:
        return f"Frame({self.label})" if self.label else f"Frame(time={self.time:g}, step={self.step})"

    @property
    def _group(self) -> h5py.Group:
        return self.result.open_file["frames"][self.name]

    @property
    def mesh(self) -> Mesh:
        return self.result.mesh(self.mesh_group)

    @property
    def field_names(self) -> "list[str]":
        """Names that `field` knows, those in the file first."""
        names = sorted(self._group)
        if "cauchy_stress" in names and "von_mises_stress" not in names:
            names.append("von_mises_stress")
        return [*names, "body", "rank"]

    def field(self, name: str) -> Field:
        """Values with their unit; `von_mises_stress` also where only `cauchy_stress` was written."""
        group = self._group
        is_name = isinstance(name, str) and name in self.field_names
        if is_name and name in group:
            dataset = group[name]
            on_nodes = text(dataset.attrs.get("location", "node")) == "node"
            values = dataset[()]
            return Field(values.reshape(len(values), -1), text(dataset.attrs.get("unit", "")), on_nodes)
        if is_name and name == "von_mises_stress" and "cauchy_stress" in group:
            stress = self.field("cauchy_stress")
            return Field(von_mises(stress.values)[:, None], stress.unit, stress.on_nodes)
        if is_name:
            return Field(self.result.open_file[self.mesh_group][name][()].astype(float)[:, None], "", False)
        having = [frame for frame in self.result.frames if name in frame.field_names]
        if having:
            raise MissingError(f"{self!r} has no field '{name}'; it is in {len(having)} of {len(self.result)} frames, from {having[0]!r} to "
                              f"{having[-1]!r}: the run was resumed with other output.fields")
        near = did_you_mean(str(name), self.field_names)
        raise MissingError(f"the result has no field '{name}'; {near}{'It' if near else 'it'} has {', '.join(self.field_names)}")

    def __getitem__(self, name: str) -> np.ndarray:
        """Values alone: rows x components, of fields with one component as many as rows."""
        values = self.field(name).values
        return values[:, 0] if values.shape[1] == 1 else values

    def displacement(self) -> np.ndarray:
        """num_nodes x 3 [m]; zero where the result has none."""
        if "displacement" in self._group:
            return self.field("displacement").values
        return np.zeros_like(self.mesh.coordinates)

    def positions(self) -> np.ndarray:
        """Current positions, num_nodes x 3 [m]."""
        return self.mesh.coordinates + self.displacement()

    @property
    def obstacles(self) -> Optional[Obstacles]:
        """Where they are; None if the run had none."""
        path = self.mesh_group.replace("mesh", "obstacles")
        if path not in self.result.open_file:
            return None
        group = self.result.open_file[path]
        moved = f"frames/{self.step:06}/points"
        names = text(group["obstacle"].attrs["names"]).split("\n")
        return Obstacles(group[moved if moved in group else "points"][()], group["triangles"][()], group["obstacle"][()], names)

    @property
    def mechanisms(self) -> Optional[Mechanisms]:
        """Lines that show tendons, springs and joints; None if the run had none."""
        path = self.mesh_group.replace("mesh", "mechanisms")
        if path not in self.result.open_file:
            return None
        group = self.result.open_file[path]
        now, part = group[f"frames/{self.step:06}"], group["part"]
        names, kinds = (text(part.attrs[key]).split("\n") for key in ("names", "kinds"))
        joints = group["joints"][()] if "joints" in group else np.zeros(0, dtype=int)
        axes = now["axes"][()] if "axes" in now else np.zeros((0, 3))
        return Mechanisms(names, kinds, now["points"][()], group["segments"][()], part[()], now["tension"][()], joints, axes)

    def to_meshio(self) -> Any:
        """A meshio.Mesh in the current shape with all fields; `.write("frame.vtu")` writes any format that meshio knows."""
        try:
            import meshio
        except ImportError:
            raise PliantError("to_meshio needs meshio: install the package python3-meshio, or `pip install meshio`") from None
        mesh = self.mesh
        of_nodes, of_cells = {}, {}
        for name in self.field_names:
            field = self.field(name)
            values = field.values[:, 0] if field.values.shape[1] == 1 else field.values
            if field.on_nodes:
                of_nodes[name] = values
            else:
                of_cells[name] = [values]
        kind = "tetra" if mesh.cells.shape[1] == 4 else "tetra10"
        return meshio.Mesh(self.positions(), [(kind, mesh.cells)], point_data=of_nodes, cell_data=of_cells)


VERSION = 1  # of the format of result.h5


def _newest_frame(h5: h5py.File) -> None:
    """A frame may come between the file's header and the list of frames, which then names more than can be read."""
    if "frames" in h5:
        for name in sorted(h5["frames"])[-1:]:
            _ = h5["frames"][name].attrs["time"]


class Result(Sequence[Frame]):
    """A run's frames, in order of time: `result[-1]["displacement"]`, `for frame in result: ...`, `len(result)`.

    Opened while the run is active, it has the frames that were complete then; `refresh()` looks for more.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """`path`: the output directory of a run, its result.h5 or its result.xdmf."""
        self.file = self._find(path_of(path, "Result"))
        self.directory = os.path.dirname(os.path.abspath(self.file))
        self._meshes: "dict[str, Mesh]" = {}
        self.refresh()

    def refresh(self) -> None:
        """Opens the file anew, with the frames that were added meanwhile."""
        self.close()
        self.h5 = opened(self.file, _newest_frame)  #: the file itself, for what is not here
        if text(self.h5.attrs.get("format", "")) != "pliant-result":
            raise PliantError(f"{self.file} is not a result of Pliant", FILE)
        version = self.h5.attrs["version"]
        if version != VERSION:
            raise PliantError(f"{self.file} has version {version} of the format, and this module reads version {VERSION}; "
                              "read it with the Pliant that wrote it", FILE)
        self.title = text(self.h5.attrs.get("title", ""))
        self.frames = [Frame(self, name) for name in sorted(self.h5["frames"])]
        if not self.frames:
            raise PliantError(f"{self.file} holds no frame yet", FILE)

    @staticmethod
    def _find(path: str) -> str:
        refuse_input(path)
        if os.path.isdir(path):
            path = os.path.join(path, "result.h5")
        elif path.endswith(".xdmf"):
            path = path[: -len(".xdmf")] + ".h5"
        if not os.path.isfile(path):
            raise PliantError(f"there is no result: {path} does not exist", FILE)
        return path

    @property
    def open_file(self) -> h5py.File:
        """`h5`; PliantError after `close`."""
        if not self.h5:
            raise PliantError(f"the result {self.file} is closed; refresh() opens it again")
        return self.h5

    def close(self) -> None:
        if hasattr(self, "h5"):
            self.h5.close()

    def __enter__(self) -> "Result":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> "list[Frame]": ...
    def __getitem__(self, index: Union[int, slice]) -> "Union[Frame, list[Frame]]":
        if isinstance(index, str):
            raise InputError(f"frames have numbers, and fields belong to one of them: result[-1][{index!r}]")
        try:
            return self.frames[index]
        except IndexError:
            raise MissingError(f"{self.file} has the frames 0 to {len(self) - 1}, not {index}") from None
        except TypeError:
            raise InputError(f"the number of a frame is expected, 0 to {len(self) - 1}, not {short(index)}") from None

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        return notebook.result_in_a_line(self)

    def _repr_html_(self) -> str:
        """For notebooks: mesh, bodies, the fields at the end, and a small picture where matplotlib is installed."""
        return notebook.result_as_html(self)

    def show(self, *, output: "Optional[Union[str, os.PathLike[str]]]" = None, size: float = 10, height: int = 640) -> None:
        """The page of `pliant report`: in a notebook inline, elsewhere as a file, whose name is printed.

        `output`: the file, by default report.html next to the result. `size`: the largest size of the page [MB]; frames are left out
        if it would be larger. `height`: that of the page in the notebook [px]. PliantError with the program's message if it fails.
        """
        from .runs import completed  # which needs results

        page = os.path.join(self.directory, "report.html") if output is None else os.path.abspath(path_of(output, "output"))
        megabytes, pixels = positive_of(size, "size"), int(positive_of(height, "height"))
        done = completed(["report", self.file, "--output", page, "--size", f"{megabytes:g}"], 1, (), None)
        if notebook.is_notebook():
            notebook.show_page(page, pixels)
        else:
            print(done.stdout.strip())

    @property
    def times(self) -> np.ndarray:
        """Of the frames [s]; of a static run load factors, or lengths of its path."""
        return np.array([frame.time for frame in self.frames])

    def at(self, time: float) -> Frame:
        """The frame nearest to a time [s]."""
        return self.frames[int(np.abs(self.times - number_of(time, "the time of a frame [s]")).argmin())]

    def mesh(self, group: str = "/mesh") -> Mesh:
        """Of all frames, unless the run was resumed: `Frame.mesh` is that of a frame."""
        if group not in self._meshes:
            known = [f"/{name}" for name, item in self.open_file.items() if isinstance(item, h5py.Group) and "cells" in item]
            if group not in known:
                raise MissingError(f"{self.file} has no mesh {short(group)}; it has {', '.join(known)}")
            given = self.open_file[group]
            names, *others = (text(given["body"].attrs.get(key, "")).split("\n") for key in ("names", "masses", "rods", "sections", "shells", "rectangular_rods"))
            self._meshes[group] = Mesh(given["coordinates"][()], given["cells"][()], given["body"][()], names,
                                       *(other if other[0] else [] for other in others))
        return self._meshes[group]

    def series(self, name: str, rows: Any = slice(None)) -> np.ndarray:
        """A field over time: frames x rows x components; `rows` chooses nodes or cells, in the order of the file. Reads frame
        by frame, and only those rows are kept."""
        if len({frame.mesh_group for frame in self.frames}) > 1:
            raise PliantError(f"{self.file}: the run was resumed, and nodes and cells have another order since; read the frames")
        try:
            return np.stack([frame.field(name).values[rows] for frame in self.frames])
        except IndexError as error:
            if isinstance(error, PliantError):
                raise
            raise InputError(f"rows: numbers of nodes or cells are expected, or as many booleans as there are: {error}") from None

    @property
    def tendons(self) -> "dict[str, Line]":
        """In all frames, by name: `result.tendons["flexor"].points[-1]`."""
        return self._lines("tendon")

    @property
    def springs(self) -> "dict[str, Line]":
        """In all frames, by name."""
        return self._lines("spring")

    @property
    def rods(self) -> "dict[str, Line]":
        """In all frames, by name: `result.rods["wire"].points[-1]`; `tension` is the axial force."""
        return self._lines("rod")

    @property
    def joints(self) -> "dict[str, Joint]":
        """In all frames, by name: `result.joints["knuckle"].axis[-1]`."""
        frames = self._mechanisms()
        if not frames:
            return {}
        first, joints = frames[0], {}
        for j, place in enumerate(first.joints):
            part = j - len(first.joints)
            joints[first.names[part]] = Joint(first.kinds[part], np.stack([frame.points[place] for frame in frames]),
                                              np.stack([frame.axes[j] for frame in frames]))
        return joints

    def _lines(self, kind: str) -> "dict[str, Line]":
        frames, lines = self._mechanisms(), {}
        for part, name in enumerate(frames[0].names if frames else []):
            if frames[0].kinds[part] == kind:
                along, of_part = frames[0].points_along(part), frames[0].part == part
                lines[name] = Line(np.stack([frame.points[along] for frame in frames]),
                                   np.stack([frame.tension[of_part] for frame in frames]))
        return lines

    def _mechanisms(self) -> "list[Mechanisms]":
        found = [frame.mechanisms for frame in self.frames]
        return [one for one in found if one is not None]
