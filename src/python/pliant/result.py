"""result.h5: the mesh and the fields of a run over time, read when they are asked for."""
import os
from collections.abc import Sequence
from typing import Any, Optional, Union, overload

import h5py
import numpy as np

from . import notebook
from .checks import number_of, path_of, positive_of, short
from .error import FILE, InputError, MissingError, PliantError, did_you_mean
from .files import opened, refuse_input, results_elsewhere, text
from .parts import Field, Joint, Line, Mechanisms, Mesh, MeshGroup, Obstacles, von_mises


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
        """`path`: the output directory of a run, its result.h5 or its result.xdmf; or the directory post-mortem in it."""
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
        place = path
        if os.path.isdir(path):
            of_run, of_post_mortem = (os.path.join(path, name) for name in ("result.h5", "state.h5"))
            path = of_post_mortem if os.path.isfile(of_post_mortem) and not os.path.isfile(of_run) else of_run
        elif path.endswith(".xdmf"):
            path = path[: -len(".xdmf")] + ".h5"
        if not os.path.isfile(path):
            raise PliantError(f"no result: {path} does not exist{results_elsewhere(place, 'result.h5')}", FILE)
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
            names, *others = (text(given["body"].attrs.get(key, "")).split("\n") for key in ("names", "masses", "rods", "sections", "shells", "rectangular_rods", "rigid"))
            others = [other if other[0] else [] for other in others]
            cells, body = given["cells"][()], given["body"][()]
            self._meshes[group] = Mesh(given["coordinates"][()], cells, body, names, *others, groups=self._groups(group, cells, body, names))
        return self._meshes[group]

    def _groups(self, mesh: str, cells: np.ndarray, body: np.ndarray, body_names: "list[str]") -> "list[MeshGroup]":
        """Bodies, then the other groups in the order of the file; of results of earlier versions bodies alone."""
        def volume(name: str, its_cells: np.ndarray) -> MeshGroup:
            return MeshGroup(name, "volume", np.unique(cells[its_cells]), cells=its_cells)

        found = [volume(name, np.nonzero(body == k)[0]) for k, name in enumerate(body_names)]
        path = mesh.replace("mesh", "groups")
        if path not in self.open_file:
            return found
        written = self.open_file[path]
        rows = {what: written[what][()] if what in written else np.zeros((0, 2), dtype=np.int64) for what in ("nodes", "facets", "cells")}
        for k, (name, dimension) in enumerate(zip(*(text(written.attrs[key]).split("\n") for key in ("names", "dimensions")))):
            of_group = {what: table[table[:, 0] == k, 1:] for what, table in rows.items()}
            if dimension == "3":
                found.append(volume(name, np.sort(of_group["cells"][:, 0])))
            elif dimension == "2":
                found.append(MeshGroup(name, "surface", np.unique(of_group["facets"]), of_group["facets"]))
            else:
                found.append(MeshGroup(name, "curve" if dimension == "1" else "point", np.sort(of_group["nodes"][:, 0])))
        return found

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
