"""Frames of a result as a model in glTF that moves, for Blender and for pages on the web."""
import dataclasses

import numpy as np

from pliant import PliantError, Surface

from .gltf import LINES, TRIANGLES, VERTICES, Document, linear, y_up
from .motion import TOLERANCE, along, motion_of
from .shown import OBSTACLE, PLAIN_BODY, TRANSPARENT, Shown
from .smoothing import normals, split

MOST_FINE_FACES = 20_000  # curved faces are divided into four triangles where there are fewer


@dataclasses.dataclass
class Part:
    """What becomes a node: vertices that move, and the cells between them."""

    name: str
    cells: np.ndarray  # triangles or lines
    positions: np.ndarray  # frames x vertices x 3
    colours: "np.ndarray | None"  # 8-bit, of each vertex
    plain: "tuple[float, float, float]"  # sRGB, where there are none
    opacity: float = 1.0
    is_open: bool = False  # seen from both sides

    @property
    def is_surface(self):
        return self.cells.shape[1] == 3


class Model:
    """`frames` of a result, of which `shown` has the colours and is the shape at rest; with several frames they are an animation,
    in which the frames are at `times` [s]."""

    def __init__(self, result, frames, shown, options):
        self._frames, self._at, self._options = frames, frames.index(shown), options
        self._shown = Shown(result, frames, options)
        self._result = result
        self._tolerance = TOLERANCE * np.linalg.norm(np.ptp(self._shown.bodies, axis=0))
        self._document = Document("Pliant")
        self._channels, self._samplers = [], []

    def write(self, file, times):
        groups = []
        for number, frame in enumerate(self._frames):  # a run that was resumed has several meshes
            if not groups or self._frames[groups[-1][0]].mesh_group != frame.mesh_group:
                groups.append([])
            groups[-1].append(number)
        for group in groups:
            for part in self._parts(group):
                self._add(part, group, times, len(groups) > 1)
        if self._channels:
            self._document.add("animations", {"name": "motion", "samplers": self._samplers, "channels": self._channels})
        self._describe()
        self._document.write(file)

    def _describe(self):
        quantity, colours, shown = self._shown.quantity, self._shown.colours, self._frames[self._at]
        extras = {"title": self._result.title, "time": shown.time, "step": shown.step}
        if quantity is not None:
            extras.update({"colours": quantity.label, "unit": quantity.unit})
            extras.update({"names": [name for name in quantity.names if name]} if quantity.names else {"range": [float(colours.low), float(colours.high)]})
        title = self._options.title if self._options.title is not None else self._result.title
        self._document.describe(title or "Pliant", extras)

    # ------------------------------------------------------------------------------------------------ what it consists of

    def _parts(self, group):
        """Bodies, obstacles and mechanisms in the frames of a group, which have one mesh."""
        frames = [self._frames[i] for i in group]
        coloured = self._frames[self._resting(group)]
        return [*self._bodies(frames, coloured), *self._obstacles(frames), *self._mechanisms(frames, coloured)]

    def _resting(self, group):
        """The frame of the group that is next to the shown one: the shape at rest, and the colours."""
        return min(max(self._at, group[0]), group[-1])

    def _bodies(self, frames, coloured):
        mesh, options, shown = frames[0].mesh, self._options, self._shown
        bodies, ghosts = [], shown.ghosts(mesh)
        for number, name in enumerate(mesh.body_names):
            if name in options.hide:
                continue
            cells = np.nonzero(mesh.body == number)[0]
            surface = Surface(mesh, 1, cells=cells)
            if len(surface.triangles) == 0:  # a rod or a fibre, which the mechanisms have
                continue
            if mesh.cells.shape[1] == 10 and len(surface.cell_of_face) < MOST_FINE_FACES:
                surface = Surface(mesh, 2, cells=cells)
            of_triangle, of_point = None, None
            if shown.quantity is not None and not shown.is_of_lines and name not in ghosts:
                values = shown.quantity.at_points(coloured, surface, name in mesh.rigid)
                if shown.is_by_face:
                    of_triangle = values[surface.face_of_triangle]
                else:
                    of_point = values
            triangles, source = split(surface.triangles, surface.of_nodes(mesh.coordinates), of_triangle)
            if of_triangle is not None:
                of_vertex = np.empty(len(source))
                of_vertex[triangles.ravel()] = np.repeat(of_triangle, 3)
            else:
                of_vertex = None if of_point is None else of_point[source]
            part = Part(name, triangles, np.empty((len(frames), len(source), 3), np.float32), None if of_vertex is None else shown.colours(of_vertex),
                        PLAIN_BODY, TRANSPARENT if name in (*options.transparent, *ghosts) else 1.0)
            bodies.append((part, surface, source))
        for i, frame in enumerate(frames):
            displacement = frame.displacement()
            if not np.isfinite(displacement).all():
                raise PliantError(f"the displacement at t = {frame.time:g} s is not finite")
            positions = mesh.coordinates + options.scale * displacement
            for part, surface, source in bodies:
                part.positions[i] = y_up(surface.of_nodes(positions)[source])
        return [part for part, _, _ in bodies]

    def _obstacles(self, frames):
        obstacles = self._shown.obstacles(frames[0])
        if obstacles is None:
            return []
        points = np.stack([y_up(self._shown.obstacle_points(frame)) for frame in frames])
        parts = []
        for number in np.unique(obstacles.obstacle):
            own = obstacles.triangles[obstacles.obstacle == number]
            triangles, source = split(own, points[0])
            name = obstacles.names[number]
            parts.append(Part(name, triangles, points[:, source], None, OBSTACLE, TRANSPARENT if name in self._options.transparent else 1.0,
                              is_open=len(own) == 2))
        return parts

    def _mechanisms(self, frames, coloured):
        shown = [self._shown.mechanisms(frame) for frame in frames]
        if shown[0] is None:
            return []
        now = shown[frames.index(coloured)]
        # Two vertices for each segment, which has a colour.
        positions = np.stack([y_up(one.points[one.segments.ravel()]) for one in shown])
        lines = np.arange(now.segments.size).reshape(-1, 2)
        return [Part("mechanisms", lines, positions, np.repeat(now.colours, 2, axis=0), PLAIN_BODY)]

    # -------------------------------------------------------------------------------------------------------- in the file

    def _add(self, part, group, times, is_one_of_several):
        """A node for a part, with its animation. In runs that were resumed it is there only during the frames of its mesh."""
        base = part.positions[group.index(self._resting(group))]
        motion = motion_of(part.positions, base, self._tolerance)
        attributes = {"POSITION": self._document.add_array(base, VERTICES, with_range=True)}
        targets = [{"POSITION": self._document.add_array(shape, VERTICES, with_range=True)} for shape in motion.shapes]
        if part.is_surface:
            at_base = normals(part.cells, base).astype(np.float32)
            attributes["NORMAL"] = self._document.add_array(at_base, VERTICES)
            if targets:
                of_frames = np.stack([normals(part.cells, x).astype(np.float32) for x in part.positions])
                for target, shape in zip(targets, along(motion, of_frames, at_base)):
                    target["NORMAL"] = self._document.add_array(shape, VERTICES)
        if part.colours is not None:
            attributes["COLOR_0"] = self._document.add_array(linear(part.colours), VERTICES, normalized=True)
        primitive = {"attributes": attributes, "indices": self._document.add_indices(part.cells), "material": self._material(part),
                     "mode": TRIANGLES if part.is_surface else LINES}
        mesh = {"name": part.name, "primitives": [primitive]}
        if targets:
            primitive["targets"] = targets
            mesh["weights"] = [0.0] * len(targets)
            mesh["extras"] = {"targetNames": [f"shape {k + 1}" for k in range(len(targets))]}
        node = {"name": part.name, "mesh": self._document.add("meshes", mesh)}
        if is_one_of_several and self._at not in group:
            node["scale"] = [0.0] * 3
        number = self._document.add_node(node)
        if targets:
            self._animate(number, "weights", times[group], motion.weights.ravel(), "LINEAR")
        if is_one_of_several:
            self._show_during(number, group, times)

    def _show_during(self, node, group, times):
        starts = [(0, group[0] == 0), (group[0], True), (group[-1] + 1, False)]
        kept = {frame: is_there for frame, is_there in starts if frame < len(times)}
        scales = np.array([[float(is_there)] * 3 for is_there in kept.values()], np.float32)
        self._animate(node, "scale", times[list(kept)], scales, "STEP")

    def _animate(self, node, path, times, values, interpolation):
        sampler = {"input": self._document.add_array(times.astype(np.float32), with_range=True), "output": self._document.add_array(values),
                   "interpolation": interpolation}
        self._samplers.append(sampler)
        self._channels.append({"sampler": len(self._samplers) - 1, "target": {"node": node, "path": path}})

    def _material(self, part):
        plain = [1.0, 1.0, 1.0]
        if part.colours is None:
            plain = (linear(255 * np.array([part.plain]))[0, :3] / 65535).tolist()
        material = {"name": part.name, "pbrMetallicRoughness": {"baseColorFactor": [*plain, part.opacity], "metallicFactor": 0.0,
                                                                "roughnessFactor": 0.6}}
        if part.opacity < 1:
            material["alphaMode"] = "BLEND"
        if part.is_open:
            material["doubleSided"] = True
        return self._document.add("materials", material)
