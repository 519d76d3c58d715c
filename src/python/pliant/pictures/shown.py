"""What is shown of a result: which bodies, obstacles and mechanisms, where they are in a frame, and their colours."""
import dataclasses

import numpy as np

from pliant import PliantError, Surface

from .camera import extreme, sheet
from .colours import Colours, NamedColours
from .cut import CutSurface, Plane
from .quantity import OF_RODS, Quantity, quantity_of
from .rods import RodShapes

PLAIN_BODY = (0.62, 0.70, 0.79)
OBSTACLE = (0.93, 0.91, 0.88)
TRANSPARENT = 0.25  # opacity of what is chosen to be transparent
COLOURS = {"tendon": (214, 58, 80), "spring": (47, 158, 120), "rod": (91, 111, 143)}
JOINT = (232, 152, 28)


@dataclasses.dataclass(frozen=True)
class Shell:
    """A surface that is drawn as one, and how."""

    surface: "Surface | CutSurface"
    opacity: float
    names: "list[str]"  # of the bodies
    is_ghost: bool = False  # of ellipsoids of inertia, which have no colours of a field
    is_rigid: bool = False  # of rigid bodies alone
    mirrors: "tuple[Plane, ...]" = ()  # at which it is reflected, one after another

    @property
    def triangles(self):
        """Counterclockwise seen from outside."""
        return self.surface.triangles[:, ::-1] if len(self.mirrors) % 2 else self.surface.triangles

    def reflected(self, points):
        for plane in self.mirrors:
            points = plane.reflected(points)
        return points

    def sign(self, axes):
        """Whether a component of a field, such as "x" or "xy", has the other sign in the image: -1, or 1."""
        return np.prod([(-1) ** axes.count("xyz"[int(plane.normal.argmax())]) for plane in self.mirrors])


class ShownMechanisms:
    """Those of a frame whose names are not in `hidden`; `colour_of`: colours of tensions, None for plain lines. `rods`: RodShapes of
    the mesh; `of_rods`: colours of their segments, or None for those of their lines; `positions`: of the mesh's nodes."""

    def __init__(self, mechanisms, hidden, colour_of, rods, of_rods, positions):
        names, first_joint = np.array(mechanisms.names), len(mechanisms.names) - len(mechanisms.joints)
        kept = ~np.isin(names[mechanisms.part], hidden)
        part = mechanisms.part[kept]
        self.points, self.segments = mechanisms.points, mechanisms.segments[kept]
        self.joints = mechanisms.joints[~np.isin(names[first_joint:], hidden)]
        self.colours = np.array([COLOURS.get(mechanisms.kinds[p], JOINT) for p in part], dtype=np.uint8).reshape(-1, 3)
        is_line = part < first_joint
        if colour_of is not None and is_line.any():
            self.colours[is_line] = colour_of(mechanisms.tension[kept][is_line])
        self.is_rod = np.isin(names[part], rods.names)  # fibres have no cells, and are lines
        self._add_rods(rods, of_rods, positions, names[part])

    def _add_rods(self, rods, of_rods, positions, name_of_segment):
        """The bodies of the rods, with the colours of their axes; or with their own, which then are those of their axes, too."""
        kept = np.isin(rods.names, name_of_segment)
        self.rods, self.has_rectangle = rods.at(positions)[kept], rods.is_rectangular[kept]
        self.rod_colours = np.empty((len(self.rods), 3), dtype=np.uint8) if of_rods is None else of_rods[kept]
        middles, of_axes = self.rods[:, :2].mean(axis=1), self.points[self.segments].mean(axis=1)
        for name in np.unique(rods.names[kept]):
            bodies, axis = np.nonzero(rods.names[kept] == name)[0], np.nonzero(name_of_segment == name)[0]
            distance = np.linalg.norm(middles[bodies, None] - of_axes[None, axis], axis=2)
            if of_rods is None:
                self.rod_colours[bodies] = self.colours[axis[distance.argmin(axis=1)]]
            else:
                self.colours[axis] = self.rod_colours[bodies[distance.argmin(axis=0)]]

    def add_image(self, plane):
        """The image of everything at a plane, too."""
        first = len(self.points)
        self.points = np.concatenate([self.points, plane.reflected(self.points)])
        self.segments, self.joints = (np.concatenate([numbers, first + numbers]) for numbers in (self.segments, self.joints))
        ends, directors = plane.reflected(self.rods[:, :2]), plane.reflected(self.rods[:, 2:]) - plane.reflected(np.zeros(3))
        self.rods = np.concatenate([self.rods, np.concatenate([ends, directors], axis=1)])
        self.colours, self.is_rod, self.has_rectangle, self.rod_colours = (
            np.concatenate([values, values]) for values in (self.colours, self.is_rod, self.has_rectangle, self.rod_colours))

    def cloud(self):
        """Where they are."""
        ends, directors = self.rods[:, :2], self.rods[:, 2:]
        around = np.concatenate([ends + directors[:, [k]] * sign for k in (0, 1) for sign in (-1, 1)], axis=1)
        return np.concatenate([self.points[np.append(self.segments.ravel(), self.joints)], around.reshape(-1, 3)])


def tensions_of(mechanisms):
    """Of tendons and springs [N]."""
    return mechanisms.tension[mechanisms.part < len(mechanisms.names) - len(mechanisms.joints)]


class Shown:
    """What `options` choose of the frames `chosen`: the same colours and parts in all of them.

    `options`: field, range, colour_map, scale, hide, transparent, outline, cut, mirror, view, as `pliant render` has them.
    """

    def __init__(self, result, chosen, options):
        self._result, self._options, self.frames = result, options, chosen
        self._shells_of_mesh, self._rods_of_mesh = {}, {}
        self._cut = None
        self._require_names(chosen[0])
        self.by_tension = options.field == "tension"
        self.by_rods = options.field.startswith(OF_RODS)
        self.quantity = self._chosen_quantity()
        self.colours = self._colour_scale()
        clouds = self.clouds() or self.mechanism_clouds()
        if not clouds and options.scale == 1:
            raise PliantError("--hide: every body is hidden")
        if not clouds:
            raise PliantError("nothing is left to draw: rods, tendons, springs and joints are drawn with --scale 1 only")
        if not self.clouds() and not self.is_of_lines:
            self.quantity = self.colours = None  # rods alone have colours of their own
        self.bodies = np.concatenate([extreme(points) for points in clouds])  # points that bound them

    def clouds(self):
        """The points of the bodies in some frames, and those of the outline; none of a model of rods alone."""
        clouds = [positions for frame in self.sample() for positions in self.positions(frame)]
        if self._options.outline:
            clouds += [self.reference(shell, self.frames[0]) for shell in self.shells(self.frames[0])]
        return [points for points in clouds if len(points) > 0]

    def mechanism_clouds(self):
        return [shown.cloud() for shown in map(self.mechanisms, self.sample()) if shown is not None]

    def _chosen_quantity(self):
        if self._options.field == "none":
            return None
        if self.by_rods:
            self._require_rods()
        if not self.by_tension:
            return quantity_of(self._result, self._options.field, self.frames[0])
        if self.frames[0].mechanisms is None:
            raise PliantError("--field tension: the result has no tendons and no springs")
        return Quantity("tension", 0, "tension", "N", [])

    @property
    def is_of_lines(self):
        """Do lines and rods have the colours, and bodies none?"""
        return self.by_tension or self.by_rods

    def _require_rods(self):
        frame = self.frames[0]
        if frame.mechanisms is not None and "rod" in frame.mechanisms.kinds and not np.isin(frame.mesh.rods, self._rods(frame).names).any():
            raise PliantError(f"--field {self._options.field}: fibres, which only stretch, have no such field; their axial force is --field tension")

    def _rods(self, frame):
        """RodShapes of the frame's mesh."""
        if frame.mesh_group not in self._rods_of_mesh:
            self._rods_of_mesh[frame.mesh_group] = RodShapes(frame.mesh)
        return self._rods_of_mesh[frame.mesh_group]

    def sample(self, at_most=60):
        """Frames from which the camera is taken."""
        return _some(self.frames, at_most)

    def _require_names(self, frame):
        known = [*frame.mesh.bodies_with_surface, *(frame.obstacles.names if frame.obstacles else [])]
        lines = frame.mechanisms.names if frame.mechanisms else []
        for option, names in (("hide", [*known, *lines]), ("transparent", known)):
            for name in getattr(self._options, option):
                if name not in names:
                    raise PliantError(f"--{option} {name}: nothing that {'can be transparent' if option == 'transparent' else 'is drawn'} has this name; names are {', '.join(names) or 'none'}")

    def shells(self, frame):
        """The outside of the bodies that are neither hidden nor transparent, as one, or as one of those that are rigid and one of the others; then each transparent body, and all ghosts."""
        if frame.mesh_group not in self._shells_of_mesh:
            mesh, options = frame.mesh, self._options
            hidden, transparent = (np.array([name in names for name in mesh.body_names]) for names in (options.hide, options.transparent))
            hidden |= ~np.isin(mesh.body_names, mesh.bodies_with_surface)
            ghost = np.isin(mesh.body_names, self.ghosts(mesh))
            opaque = ~hidden & ~transparent & ~ghost
            rigid = np.isin(mesh.body_names, mesh.rigid)
            is_apart = self.quantity is not None and not self.is_of_lines and self.quantity.is_of_deformable_bodies
            parts = [(opaque & ~rigid, 1.0, False), (opaque & rigid, 1.0, False)] if is_apart else [(opaque, 1.0, False)]
            parts += [(np.arange(len(hidden)) == k, TRANSPARENT, False) for k in np.nonzero(transparent & ~hidden & ~ghost)[0]]
            parts.append((ghost & ~hidden, TRANSPARENT, True))
            shells, gone = [], []
            for of_body, opacity, is_ghost in parts:
                cells = np.nonzero(of_body[mesh.body])[0]
                names = [name for name, is_in in zip(mesh.body_names, of_body) if is_in]
                if len(cells) > 0:
                    surface = Surface(mesh, cells=cells)
                    kept = surface if options.cut is None else self._cut_open(surface, mesh, cells)
                    if len(kept.triangles) > 0:
                        shells.append(Shell(kept, opacity, names, is_ghost, bool(rigid[of_body].all())))
                    elif not is_ghost:
                        gone.append(opacity)
            if TRANSPARENT in gone or (gone and all(shell.opacity < 1 for shell in shells)):
                raise PliantError("--cut: nothing of a body is left; its plane lies behind all of it, seen by the viewer")
            for plane in options.mirror:
                shells += [dataclasses.replace(shell, mirrors=(*shell.mirrors, plane)) for shell in shells]
            self._shells_of_mesh[frame.mesh_group] = shells
        return self._shells_of_mesh[frame.mesh_group]

    def _cut_open(self, surface, mesh, cells):
        """What is left when the viewer's side of the plane is taken away; the plane is the same for all bodies and frames."""
        if self._cut is None:
            plane, toward_viewer = self._options.cut, np.asarray(self._options.view, dtype=float)
            offset = plane.offset
            if offset is None:
                along = mesh.coordinates[np.unique(mesh.cells)] @ plane.normal
                offset = (along.min() + along.max()) / 2
            sign = -1.0 if plane.normal @ toward_viewer < 0 else 1.0
            self._cut = Plane(sign * plane.normal, sign * offset)
        return CutSurface(surface, mesh, cells, self._cut)

    def ghosts(self, mesh):
        """Names of bodies without a surface: the ellipsoids of their inertia are seen through, unless nothing else is shown."""
        others = set(mesh.bodies_with_surface) - {*mesh.masses, *self._options.hide}
        return mesh.masses if others else []

    @staticmethod
    def reference(shell, frame):
        return shell.reflected(shell.surface.of_nodes(frame.mesh.coordinates))

    def positions(self, frame):
        """Of each shell."""
        displacement = frame.displacement()
        found = []
        for shell in self.shells(frame):
            at_rest, moved = (shell.surface.of_nodes(values) for values in (frame.mesh.coordinates, displacement))
            positions = shell.reflected(at_rest + self._options.scale * moved)
            if not np.isfinite(positions).all():
                raise PliantError(f"the displacement at t = {frame.time:g} s is not finite")
            found.append(positions)
        return found

    def obstacles(self, frame):
        """Those that are not hidden; None where displacements are not drawn as they are: then nothing touches."""
        obstacles = frame.obstacles if self._options.scale == 1 else None
        if obstacles is None:
            return None
        shown = ~np.isin(np.array(obstacles.names)[obstacles.obstacle], self._options.hide)
        if not shown.any():
            return None
        return dataclasses.replace(obstacles, triangles=obstacles.triangles[shown], obstacle=obstacles.obstacle[shown])

    def mechanisms(self, frame):
        """Those that are not hidden; None where displacements are not drawn as they are."""
        given = frame.mechanisms if self._options.scale == 1 else None
        if given is None:
            return None
        rods = self._rods(frame)
        of_rods = self.colours(self._rod_values(frame)) if self.by_rods else None
        shown = ShownMechanisms(given, self._options.hide, self.colours if self.by_tension else None, rods, of_rods, frame.positions())
        for plane in self._options.mirror:
            shown.add_image(plane)
        return shown if len(shown.segments) > 0 else None

    def _rod_values(self, frame):
        """Of each segment of rods with cells."""
        return frame.field(self.quantity.field).values[self._rods(frame).cells, 0]

    def near_obstacles(self):
        """Points of obstacles that belong into the picture: those next to the bodies, and the sheets of planes. Vessels are around the
        bodies, however large."""
        middle = (self.bodies.min(axis=0) + self.bodies.max(axis=0)) / 2
        reach = 1.5 * np.linalg.norm(self.bodies - middle, axis=1).max()
        found = []
        for obstacles in map(self.obstacles, self.sample()):
            if obstacles is None:
                continue
            others = ~np.isin(obstacles.obstacle, obstacles.vessels())
            points = dataclasses.replace(obstacles, triangles=obstacles.triangles[others], obstacle=obstacles.obstacle[others]).points_of_others()
            near = points[np.linalg.norm(points - middle, axis=1) < reach]
            found += [near] if len(near) > 0 else []
            found += [sheet(obstacles.points[corners], self.bodies) for corners in obstacles.planes()]
        return found

    def obstacle_points(self, frame):
        """Where the points of obstacles are drawn: planes as sheets along the bodies."""
        obstacles = self.obstacles(frame)
        if obstacles is None:
            return None
        points = obstacles.points.copy()
        for corners in obstacles.planes():
            points[corners] = sheet(points[corners], self.bodies)
        return points

    def _values(self, frame):
        """Of each shell; None for ghosts."""
        return [None if shell.is_ghost else shell.sign(self.quantity.axes) * self.quantity.at_points(frame, shell.surface, shell.is_rigid) for shell in self.shells(frame)]

    @property
    def is_by_face(self):
        """Do faces have colours, instead of points?"""
        return self.quantity is not None and not self.is_of_lines and bool(self.quantity.names)

    def colours_of(self, frame):
        """Of each shell, 8-bit RGB of each point, or of each triangle (`is_by_face`); None for plain bodies."""
        shells = self.shells(frame)
        if self.quantity is None or self.is_of_lines:
            return [None] * len(shells)
        colours = [None if values is None else self.colours(values) for values in self._values(frame)]
        if self.is_by_face:
            colours = [None if of_faces is None else of_faces[shell.surface.face_of_triangle] for of_faces, shell in zip(colours, shells)]
        return colours

    def _colour_scale(self):
        if self.quantity is None:
            return None
        if self.quantity.names:
            return NamedColours(len(self.quantity.names))
        if self._options.range is not None:
            return Colours(*self._options.range, self._options.colour_map)
        # A magnitude starts at zero. Cell stresses at a sharp corner are far larger than elsewhere: the uppermost and
        # lowermost thousandth get the colour of the ends. Pictures of one result have the same scale, whichever frame they show.
        having = [frame for frame in self._result.frames if self.is_of_lines or self.quantity.field in frame.field_names]
        values = np.concatenate([self._extent_of(frame) for frame in _some(having, 60)])
        low, high = values.min(initial=np.inf), values.max(initial=-np.inf)
        if len(values) == 0:
            low = high = 0.0
        return Colours(0.0 if 0 <= low < 0.5 * high else low, high, self._options.colour_map)


    def _extent_of(self, frame):
        """Values of a frame that the colours must have room for."""
        if self.by_tension:
            return tensions_of(frame.mechanisms)
        if self.by_rods:
            return self._rod_values(frame)
        return _extent(np.concatenate([np.zeros(0), *(values for values in self._values(frame) if values is not None)]))


def _some(frames, at_most):
    """Evenly chosen ones, with the first and the last."""
    picked = np.unique(np.linspace(0, len(frames) - 1, at_most).round().astype(int))
    return [frames[i] for i in picked]


def _extent(values):
    """The range of colours: of values that are not 0, as contact has few of them, all but a thousandth at either end, and 0 if it
    occurs. Infinite ones, such as gaps where nothing is near, have the colour of the end."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return np.zeros(2)
    others = finite[finite != 0]
    ends = np.quantile(others, [0.001, 0.999]) if len(others) > 0 else np.zeros(2)
    return ends if len(others) == len(finite) else np.append(ends, 0.0)
