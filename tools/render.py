#!/usr/bin/python3
"""Turns a result of Pliant into a picture, a series of pictures or a movie.

Needs no screen: VTK draws into a virtual one, which this program starts and ends.
"""
import argparse
import atexit
import ctypes
import dataclasses
import os
import re
import shutil
import subprocess
import sys

try:
    import numpy as np
    from PIL import Image
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkPolyDataNormals
    from vtkmodules.vtkRenderingCore import (
        vtkActor,
        vtkLight,
        vtkPolyDataMapper,
        vtkRenderer,
        vtkRenderWindow,
        vtkWindowToImageFilter,
    )
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  the implementation behind vtkRenderWindow
    from mechanism_lines import DrawnMechanisms, ShownMechanisms, tensions_of
    from page import BACKGROUND, Colours, NamedColours, Page, times_as_text
    from package import PliantError as UserError, Result, Surface
except ImportError as missing:
    print(f"render.py: {missing}; run it with /usr/bin/python3, and with the packages of tools/setup.sh", file=sys.stderr)
    sys.exit(2)

from command_line import Parser, exit_code

PLAIN_BODY = (0.62, 0.70, 0.79)
OBSTACLE = (0.93, 0.91, 0.88)
OBSTACLE_OVER_BODY = 0.5  # opacity of obstacles where they hide a body
MECHANISM_IN_BODY = 0.6  # opacity of tendons, springs and joints where a body hides them
TRANSPARENT = 0.25  # opacity of what is chosen to be transparent
VIEW_ANGLE = 24.0  # [degrees], of the picture's height
SUPERSAMPLING = 2  # drawn this much larger and scaled down: smooth edges on any graphics library
VIEWS = {"iso": (0.62, -1.0, 0.48), "front": (0, -1, 0), "back": (0, 1, 0), "right": (1, 0, 0), "left": (-1, 0, 0),
         "top": (0, 0, 1), "bottom": (0, 0, -1)}
COMPONENTS = {3: "x y z".split(), 6: "xx yy zz xy yz xz".split(),
              9: "xx xy xz yx yy yz zx zy zz".split()}
PRINCIPAL = "principal_"  # fields of three values in descending order


# ---------------------------------------------------------------------------------------------- a screen to draw on


def start_screen():
    """A virtual X server of our own; one that is there already serves only if Xvfb is missing."""
    program = shutil.which("Xvfb")
    if program is None:
        if os.environ.get("DISPLAY"):
            return
        raise UserError("pictures need a screen or a virtual one: install the package 'xvfb'")
    read, write = os.pipe()
    display = f":{1000 + os.getpid()}"  # servers that look for a free number take each other's
    server = subprocess.Popen(
        [program, display, "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp", "+extension", "GLX"],
        pass_fds=[write], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True, preexec_fn=_die_with_parent)
    os.close(write)
    atexit.register(_end, server)
    with os.fdopen(read) as pipe:
        number = pipe.readline().strip()
    if not number:
        raise UserError("the virtual screen (Xvfb) did not start")
    os.environ["DISPLAY"] = f":{number}"
    os.environ.pop("XAUTHORITY", None)
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"


def _die_with_parent():
    death_signal, terminate = 1, 15  # PR_SET_PDEATHSIG, SIGTERM
    ctypes.CDLL(None).prctl(death_signal, terminate)


def _end(server):
    server.terminate()
    server.wait()


# ------------------------------------------------------------------------------------------------ what is displayed


@dataclasses.dataclass(frozen=True)
class Quantity:
    """What colours the body: a field of the result, or a component or the length of it."""

    field: str
    component: int  # -1: the length of a vector
    label: str
    unit: str
    names: list  # of a quantity that counts bodies or ranks; else empty

    def at_points(self, frame, surface):
        """Values at the points of the surface; of counted things, at its faces."""
        field = frame.field(self.field)
        if self.names:
            return field.values[surface.cell_of_face, 0]
        values = _of_nodes(surface, field.values) if field.on_nodes else surface.of_cells(field.values)
        return np.linalg.norm(values, axis=1) if self.component < 0 else values[:, self.component]


def _of_nodes(surface, values):
    """Nodal values at the points of the surface: infinite ones, such as gaps where nothing is near, stay so."""
    infinite = np.isposinf(values)
    if not infinite.any():
        return surface.of_nodes(values)
    finite = values[np.isfinite(values)]
    at_points = surface.of_nodes(np.where(infinite, finite.max() if len(finite) > 0 else 0.0, values))
    return np.where(surface.of_nodes(infinite.astype(float)) != 0, np.inf, at_points)


def quantity_of(result, name):
    """`displacement`, `displacement_z`, `cauchy_stress_xx`, ... as a Quantity."""
    frame = result.frames[0]
    known = frame.field_names
    base, _, suffix = name.rpartition("_")
    if name not in known and base in known:
        field = frame.field(base)
        components = components_of(base, field)
        if suffix not in components:
            raise UserError(f"the field '{base}' has no component '{suffix}'; it has {', '.join(components) or 'only one'}")
        return Quantity(base, components.index(suffix), f"{_words(base)} {suffix}", field.unit, [])
    field = frame.field(name)
    if name == "body":
        return Quantity(name, 0, "body", "", frame.mesh.body_names)
    if name == "rank":
        return Quantity(name, 0, "rank", "", [str(i) for i in range(int(field.values.max()) + 1)])
    components = field.values.shape[1]
    if components > 3:
        example = COMPONENTS[components][0]
        raise UserError(f"'{name}' is a tensor: choose a component such as {name}_{example}, or von_mises_stress")
    if name.startswith(PRINCIPAL):
        raise UserError(f"'{name}' has three values: choose {name}_1 (the largest), {name}_2 or {name}_3")
    return Quantity(name, -1 if components == 3 else 0, _words(name), field.unit, [])


def components_of(name, field):
    """Their names; none of a number."""
    return ["1", "2", "3"] if name.startswith(PRINCIPAL) else COMPONENTS.get(field.values.shape[1], [])


def _words(name):
    return name.replace("_", " ").replace("von mises", "von Mises").replace("cauchy", "Cauchy")


# ----------------------------------------------------------------------------------------------------- the 3D scene


@dataclasses.dataclass(frozen=True)
class Shell:
    """A surface that is drawn as one, and how."""

    surface: Surface
    opacity: float


class DrawnShell:
    """A shell in VTK: its points move, its triangles have colours."""

    def __init__(self):
        self.points, self.body, self.edges = vtkPoints(), vtkPolyData(), vtkPolyData()

    def set(self, positions, colours, by_face):
        self.points.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=True))
        self.points.Modified()
        if colours is not None:
            (self.body.GetCellData() if by_face else self.body.GetPointData()).SetScalars(
                numpy_to_vtk(np.ascontiguousarray(colours), deep=True))
        self.body.Modified()
        self.edges.Modified()


class Scene:
    """The shells in VTK; `draw` moves and colours them and returns the pixels."""

    def __init__(self, shells, size, options):
        self._size = tuple(SUPERSAMPLING * n for n in size)
        self._renderer = vtkRenderer()
        self._renderer.SetBackground(*(c / 255 for c in BACKGROUND))
        self._renderer.UseFXAAOn()
        self._shells = []
        for shell in shells:
            drawn = DrawnShell()
            self._add_surface(drawn.body, drawn.points, shell.surface.triangles, PLAIN_BODY).GetProperty().SetOpacity(shell.opacity)
            if options.mesh_edges:
                drawn.edges.SetPoints(drawn.points)
                self._add_lines(drawn.edges, shell.surface.element_edges, (0.12, 0.14, 0.18), 1.1, 0.55 * shell.opacity)
            self._shells.append(drawn)
        self._obstacles = []
        self._mechanisms = None
        self._add_lights()
        self._window = vtkRenderWindow()
        if any(shell.opacity < 1 for shell in shells) or options.transparent:
            self._peel()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self._window.SetSize(*self._size)
        self._window.AddRenderer(self._renderer)

    def _peel(self):
        """Draws transparent triangles from the farthest to the nearest, pixel by pixel."""
        self._window.SetAlphaBitPlanes(1)
        self._renderer.SetUseDepthPeeling(1)
        self._renderer.SetMaximumNumberOfPeels(24)
        self._renderer.SetOcclusionRatio(0.0)

    def _add_surface(self, data, points, triangles, colour):
        data.SetPoints(points)
        data.SetPolys(_cell_array(triangles))
        normals = vtkPolyDataNormals()
        normals.SetInputData(data)
        normals.SetFeatureAngle(35)
        normals.ConsistencyOff()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(normals.GetOutputPort())
        actor = vtkActor()
        actor.SetMapper(mapper)
        material = actor.GetProperty()
        material.SetColor(*colour)
        material.SetAmbient(0.42)
        material.SetDiffuse(0.66)
        material.SetSpecular(0.10)
        material.SetSpecularPower(25)
        self._renderer.AddActor(actor)
        return actor

    def add_obstacles(self, triangles, opacity=1.0):
        """Obstacles, which `draw` places."""
        points, data = vtkPoints(), vtkPolyData()
        actor = self._add_surface(data, points, triangles, OBSTACLE)
        actor.GetProperty().SetAmbient(0.62)
        actor.GetProperty().SetDiffuse(0.38)
        actor.GetProperty().SetOpacity(opacity)
        self._obstacles.append((points, data, actor))

    def add_mechanisms(self, size):
        """Tendons, springs and joints, which `draw` places, in a scene of this size."""
        self._mechanisms = DrawnMechanisms(self._renderer, size)

    def _add_lines(self, data, lines, colour, width, opacity):
        data.SetLines(_cell_array(lines))
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.ScalarVisibilityOff()
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-1, -4)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*colour)
        actor.GetProperty().SetLineWidth(width * SUPERSAMPLING)
        actor.GetProperty().SetOpacity(opacity)
        actor.GetProperty().LightingOff()
        self._renderer.AddActor(actor)

    def _add_lights(self):
        """A key light over the viewer's left shoulder, a weak one from the right, a rim from behind."""
        self._renderer.RemoveAllLights()
        self._renderer.AutomaticLightCreationOff()
        for position, intensity in (((-0.5, 0.8, 1.0), 0.80), ((1.0, -0.2, 0.8), 0.36), ((0.2, 0.5, -1.0), 0.25)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*position)
            light.SetFocalPoint(0, 0, 0)
            light.SetIntensity(intensity)
            self._renderer.AddLight(light)

    def add_outline(self, positions, triangles):
        """The reference shape as thin lines: its sharp edges."""
        shape = vtkPolyData()
        points = vtkPoints()
        points.SetData(numpy_to_vtk(positions, deep=True))
        shape.SetPoints(points)
        shape.SetPolys(_cell_array(triangles))
        edges = vtkFeatureEdges()
        edges.SetInputData(shape)
        edges.SetFeatureAngle(30)
        edges.ColoringOff()
        edges.Update()
        found = edges.GetOutput()
        if found.GetNumberOfCells() > 0:
            lines = vtk_to_numpy(found.GetLines().GetConnectivityArray()).reshape(-1, 2)
            outline = vtkPolyData()
            outline.SetPoints(found.GetPoints())
            self._add_lines(outline, lines, (0.45, 0.48, 0.53), 1.0, 0.8)

    def aim(self, camera):
        view = self._renderer.GetActiveCamera()
        view.SetViewAngle(VIEW_ANGLE)
        view.SetFocalPoint(*camera.target)
        view.SetPosition(*camera.position)
        view.SetViewUp(*camera.up)

    def draw(self, positions, colours, by_face, obstacle_points, mechanisms):
        """`positions`, `colours`: of each shell; 8-bit RGB of each point (or triangle), or None for plain bodies. Returns
        height x width x 3 pixels.

        Obstacles are half transparent where they hide a body, and mechanisms are seen through what hides them.
        """
        for shell, x, colour in zip(self._shells, positions, colours):
            shell.set(x, colour, by_face)
        for points, data, _ in self._obstacles:
            points.SetData(numpy_to_vtk(np.ascontiguousarray(obstacle_points), deep=True))
            points.Modified()
            data.Modified()
        if self._mechanisms is not None:
            self._mechanisms.set(mechanisms)
        whole = drawn = self._pixels()
        if self._obstacles:
            bodies = self._without([actor for _, _, actor in self._obstacles])
            hidden = (bodies != BACKGROUND).any(axis=2, keepdims=True) & (bodies != whole).any(axis=2, keepdims=True)
            drawn = np.where(hidden, OBSTACLE_OVER_BODY * whole + (1 - OBSTACLE_OVER_BODY) * bodies, whole)
        if self._mechanisms is not None:
            lines = self._without([actor for actor in self._actors() if actor not in self._mechanisms.actors])
            share = np.where((lines == whole).all(axis=2, keepdims=True), 1.0, MECHANISM_IN_BODY)
            drawn = np.where((lines != BACKGROUND).any(axis=2, keepdims=True), share * lines + (1 - share) * drawn, drawn)
        return drawn.round().astype(np.uint8)

    def _actors(self):
        actors = self._renderer.GetActors()
        return [actors.GetItemAsObject(i) for i in range(actors.GetNumberOfItems())]

    def _without(self, actors):
        """The picture without some of the actors."""
        for actor in actors:
            actor.VisibilityOff()
        pixels = self._pixels()
        for actor in actors:
            actor.VisibilityOn()
        return pixels

    def _pixels(self):
        self._renderer.ResetCameraClippingRange()
        self._window.Render()
        grab = vtkWindowToImageFilter()
        grab.SetInput(self._window)
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1]
        return pixels[..., :3].copy()


def _cell_array(cells):
    array = vtkCellArray()
    offsets = np.arange(0, cells.size + 1, cells.shape[1])
    array.SetData(numpy_to_vtkIdTypeArray(offsets.astype(np.int64), deep=True),
                  numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, dtype=np.int64).ravel(), deep=True))
    return array


@dataclasses.dataclass(frozen=True)
class Camera:
    position: np.ndarray
    target: np.ndarray
    up: np.ndarray


def fitted_camera(direction, clouds, size):
    """The camera that looks against `direction` and just sees all points of all clouds."""
    back = np.asarray(direction, dtype=float)
    back /= np.linalg.norm(back)
    up = np.array([0, 0, 1.0]) if abs(back[2]) < 0.99 else np.array([0, 1.0, 0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    axes = np.stack([right, up, back])
    half_height = np.tan(np.radians(VIEW_ANGLE / 2)) * 0.93  # a margin of 7 %
    slopes = np.array([half_height * size[0] / size[1], half_height])
    local = np.concatenate([_extreme(points @ axes.T) for points in clouds])
    # A point is seen from distance d over the shift s if |p - s| <= slope (d - depth); both bounds together give the least d.
    planes = [(local[:, k, None] * [1, -1] + slopes[k] * local[:, 2, None]).max(axis=0) for k in (0, 1)]
    distance = max(sum(planes[k]) / (2 * slopes[k]) for k in (0, 1))
    shift = np.array([(planes[0][0] - planes[0][1]) / 2, (planes[1][0] - planes[1][1]) / 2, 0])
    deepest = local[:, 2].max()
    distance = max(distance, deepest + 1e-3 * (np.ptp(local) or 1))
    target = (shift + [0, 0, local[:, 2].mean()]) @ axes
    return Camera((shift + [0, 0, distance]) @ axes, target, up)


def _extreme(points):
    """Some points of a cloud that bound it: those farthest in 200 directions."""
    directions = np.random.default_rng(1).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return points[np.unique((points @ directions.T).argmax(axis=0))]


def _sheet(corners, points):
    """The rectangle in the plane of a square's corners, with the same sides, that has the points over it, and a margin."""
    along = [corners[1] - corners[0], corners[3] - corners[0]]
    axes = np.array([side / np.linalg.norm(side) for side in along])
    local = (points - corners[0]) @ axes.T
    margin = 0.15 * np.ptp(points, axis=0).max()
    low, high = local.min(axis=0) - margin, local.max(axis=0) + margin
    return corners[0] + np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]) @ axes


# --------------------------------------------------------------------------------------------------------- the work


class Renderer:
    """Draws frames of a result, all with the same camera and colour scale."""

    def __init__(self, result, chosen, options):
        self._result, self._options = result, options
        self._frames = chosen
        self._shells_of_mesh = {}
        self._scenes = {}
        self._require_names(chosen[0])
        self._by_tension = options.field == "tension"
        self._quantity = self._chosen_quantity()
        self._colours = self._colour_scale()
        title = options.title if options.title is not None else result.title
        self._page = Page(options.size, title, self._quantity, self._colours)
        self._times = dict(zip((frame.name for frame in result.frames), times_as_text(result.frames)))
        clouds = [x for frame in self._sample() for x in self._positions(frame)]
        if options.outline:
            clouds += [self._reference(shell, chosen[0]) for shell in self._shells(chosen[0])]
        self._bodies = np.concatenate([_extreme(points) for points in clouds])
        clouds += self._near_obstacles()
        clouds += [shown.cloud() for shown in map(self._mechanisms, self._sample()) if shown is not None]
        self._camera = fitted_camera(options.view, clouds, self._page.scene_size)

    def _chosen_quantity(self):
        if self._options.field == "none":
            return None
        if not self._by_tension:
            return quantity_of(self._result, self._options.field)
        if self._frames[0].mechanisms is None:
            raise UserError("--field tension: the result has no tendons and no springs")
        return Quantity("tension", 0, "tension", "N", [])

    def _sample(self, at_most=60):
        """Frames from which the camera and the colour scale are taken."""
        picked = np.unique(np.linspace(0, len(self._frames) - 1, at_most).round().astype(int))
        return [self._frames[i] for i in picked]

    def _require_names(self, frame):
        known = [*frame.mesh.body_names, *(frame.obstacles.names if frame.obstacles else [])]
        lines = frame.mechanisms.names if frame.mechanisms else []
        for option, names in (("hide", [*known, *lines]), ("transparent", known)):
            for name in getattr(self._options, option):
                if name not in names:
                    raise UserError(f"--{option} {name}: there is no body or obstacle of this name; there are {', '.join(names)}")

    def _shells(self, frame):
        """The outside of the bodies that are neither hidden nor transparent, as one; then each transparent body."""
        if frame.mesh_group not in self._shells_of_mesh:
            mesh, options = frame.mesh, self._options
            hidden, transparent = (np.array([name in names for name in mesh.body_names]) for names in (options.hide, options.transparent))
            parts = [(~hidden & ~transparent, 1.0)]
            parts += [(np.arange(len(hidden)) == k, TRANSPARENT) for k in np.nonzero(transparent & ~hidden)[0]]
            cells = [(np.nonzero(of_body[mesh.body])[0], opacity) for of_body, opacity in parts]
            shells = [Shell(Surface(mesh, cells=numbers), opacity) for numbers, opacity in cells if len(numbers) > 0]
            if not shells:
                raise UserError("--hide: every body is hidden")
            self._shells_of_mesh[frame.mesh_group] = shells
        return self._shells_of_mesh[frame.mesh_group]

    @staticmethod
    def _reference(shell, frame):
        return shell.surface.of_nodes(frame.mesh.coordinates)

    def _positions(self, frame):
        """Of each shell."""
        displacement = frame.displacement()
        found = []
        for shell in self._shells(frame):
            positions = self._reference(shell, frame) + self._options.scale * shell.surface.of_nodes(displacement)
            if not np.isfinite(positions).all():
                raise UserError(f"the displacement at t = {frame.time:g} s is not finite")
            found.append(positions)
        return found

    def _obstacles(self, frame):
        """Those that are not hidden; None where displacements are not drawn as they are: then nothing touches."""
        obstacles = frame.obstacles if self._options.scale == 1 else None
        if obstacles is None:
            return None
        shown = ~np.isin(np.array(obstacles.names)[obstacles.obstacle], self._options.hide)
        if not shown.any():
            return None
        return dataclasses.replace(obstacles, triangles=obstacles.triangles[shown], obstacle=obstacles.obstacle[shown])

    def _mechanisms(self, frame):
        """Those that are not hidden; None where displacements are not drawn as they are."""
        given = frame.mechanisms if self._options.scale == 1 else None
        if given is None:
            return None
        shown = ShownMechanisms(given, self._options.hide, self._colours if self._by_tension else None)
        return shown if len(shown.segments) > 0 else None

    def _near_obstacles(self):
        """Points of obstacles that belong into the picture: those next to the bodies, and the sheets of planes."""
        middle = (self._bodies.min(axis=0) + self._bodies.max(axis=0)) / 2
        reach = 1.5 * np.linalg.norm(self._bodies - middle, axis=1).max()
        found = []
        for obstacles in map(self._obstacles, self._sample()):
            if obstacles is None:
                continue
            points = obstacles.points_of_others()
            near = points[np.linalg.norm(points - middle, axis=1) < reach]
            found += [near] if len(near) > 0 else []
            found += [_sheet(obstacles.points[corners], self._bodies) for corners in obstacles.planes()]
        return found

    def _obstacle_points(self, frame):
        """Where the points of obstacles are drawn: planes as sheets along the bodies."""
        obstacles = self._obstacles(frame)
        if obstacles is None:
            return None
        points = obstacles.points.copy()
        for corners in obstacles.planes():
            points[corners] = _sheet(points[corners], self._bodies)
        return points

    def _values(self, frame):
        """Of each shell."""
        return [self._quantity.at_points(frame, shell.surface) for shell in self._shells(frame)]

    def _colour_scale(self):
        if self._quantity is None:
            return None
        if self._quantity.names:
            return NamedColours(len(self._quantity.names))
        if self._options.range is not None:
            return Colours(*self._options.range)
        # A magnitude starts at zero. Cell stresses at a sharp corner are far larger than elsewhere: the uppermost and
        # lowermost thousandth get the colour of the ends.
        of_lines = [tensions_of(frame.mechanisms) for frame in self._sample()] if self._by_tension else []
        values = np.concatenate(of_lines or [_extent(np.concatenate(self._values(frame))) for frame in self._sample()])
        low, high = values.min(), values.max()
        return Colours(0.0 if 0 <= low < 0.5 * high else low, high)

    def _scene(self, frame):
        if frame.mesh_group not in self._scenes:
            shells = self._shells(frame)
            scene = Scene(shells, self._page.scene_size, self._options)
            obstacles = self._obstacles(frame)
            if obstacles is not None:
                clear = np.isin(np.array(obstacles.names)[obstacles.obstacle], self._options.transparent)
                for chosen, opacity in ((~clear, 1.0), (clear, TRANSPARENT)):
                    if chosen.any():
                        scene.add_obstacles(obstacles.triangles[chosen], opacity)
            if self._mechanisms(frame) is not None:
                scene.add_mechanisms(np.linalg.norm(np.ptp(self._bodies, axis=0)))
            if self._options.outline:
                for shell in shells:
                    scene.add_outline(self._reference(shell, frame), shell.surface.triangles)
            scene.aim(self._camera)
            self._scenes[frame.mesh_group] = scene
        return self._scenes[frame.mesh_group]

    def picture(self, frame):
        shells = self._shells(frame)
        colours, by_face = [None] * len(shells), False
        if self._quantity is not None and not self._by_tension:
            colours, by_face = [self._colours(values) for values in self._values(frame)], bool(self._quantity.names)
            if by_face:
                colours = [of_faces[shell.surface.face_of_triangle] for of_faces, shell in zip(colours, shells)]
        pixels = self._scene(frame).draw(self._positions(frame), colours, by_face, self._obstacle_points(frame), self._mechanisms(frame))
        return self._page.compose(pixels, self._times[frame.name])


def _extent(values):
    """The range of colours: of values that are not 0, as contact has few of them, all but a thousandth at either end, and 0 if it
    occurs. Infinite ones, such as gaps where nothing is near, have the colour of the end."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return np.zeros(2)
    others = finite[finite != 0]
    ends = np.quantile(others, [0.001, 0.999]) if len(others) > 0 else np.zeros(2)
    return ends if len(others) == len(finite) else np.append(ends, 0.0)


def write_movie(pictures, file, frames_per_second):
    if file.endswith(".gif"):
        pictures = [picture.quantize(128, dither=Image.NONE) for picture in pictures]
        pictures[0].save(file, save_all=True, append_images=pictures[1:], duration=round(1000 / frames_per_second), loop=0)
        return
    program = shutil.which("ffmpeg")
    if program is None:
        raise UserError("a movie needs the package 'ffmpeg' (an animated GIF does not: --movie gif)")
    encoder = None
    for picture in pictures:
        if encoder is None:
            command = [program, "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                       f"{picture.width}x{picture.height}", "-r", f"{frames_per_second:g}", "-i", "-", "-vf",
                       "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags",
                       "+faststart", file]
            encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            encoder.stdin.write(picture.tobytes())
        except BrokenPipeError:
            break
    _, errors = encoder.communicate()
    if encoder.returncode != 0:
        raise UserError(f"ffmpeg could not write {file}: {errors.decode(errors='replace').strip().splitlines()[-1]}")


def chosen_frames(result, options):
    series = options.frames or options.movie
    if options.frame is None:
        return result.frames if series else result.frames[-1:]
    if options.frame == "last":
        return result.frames[-1:]
    count = len(result.frames)
    if not -count <= options.frame < count:
        raise UserError(f"there is no frame {options.frame}: the result has the frames 0 to {count - 1}")
    return [result.frames[options.frame]]


def run(options):
    result = Result(options.result)
    if options.field is None:
        options.field = "displacement" if "displacement" in result[0].field_names else "none"
    frames = chosen_frames(result, options)
    renderer = Renderer(result, frames, options)
    start_screen()
    if options.movie:
        file = options.output or os.path.join(result.directory, f"movie.{options.movie}")
        write_movie((renderer.picture(frame) for frame in frames), file, options.fps)
        print(file)
    elif options.frames:
        folder = options.output or os.path.join(result.directory, "frames")
        os.makedirs(folder, exist_ok=True)
        for i, frame in enumerate(frames):
            renderer.picture(frame).save(os.path.join(folder, f"frame_{i:04}.png"))
        print(f"{folder}/frame_0000.png to frame_{len(frames) - 1:04}.png")
    else:
        file = options.output or os.path.join(result.directory, "picture.png")
        renderer.picture(frames[0]).save(file)
        print(file)


def _view(text):
    if text in VIEWS:
        return VIEWS[text]
    numbers = [float(part) for part in text.split(",")]
    if len(numbers) != 3 or not np.linalg.norm(numbers) > 0:
        raise ValueError
    return numbers


def _size(text):
    width, height = (int(part) for part in text.lower().split("x"))
    if not (160 <= width <= 8192 and 120 <= height <= 8192):
        raise argparse.ArgumentTypeError(f"{text}: sizes go from 160x120 to 8192x8192")
    return width, height


def _frame(text):
    return "last" if text == "last" else int(text)


def _range(text):
    low, high = (float(part) for part in text.split(","))
    if not low < high:
        raise ValueError
    return low, high


def _positive(text):
    number = float(text)
    if not 0 < number < np.inf:
        raise ValueError
    return number


def _finite(text):
    number = float(text)
    if not np.isfinite(number):
        raise ValueError
    return number


# argparse puts these names into its message: "invalid WIDTHxHEIGHT value: '3'".
_view.__name__, _size.__name__, _frame.__name__ = "view", "WIDTHxHEIGHT", "frame"
_range.__name__, _positive.__name__, _finite.__name__ = "LOW,HIGH", "positive", "number"


def _with_negative_values(arguments):
    """`--view -1,0,0` as `--view=-1,0,0`: argparse takes what begins with a minus sign for another option."""
    joined = []
    for word in arguments:
        if joined and joined[-1] in ("--view", "--range") and re.match(r"-[\d.]", word):
            joined[-1] += "=" + word
        else:
            joined.append(word)
    return joined


def parsed(arguments):
    parser = Parser(prog="render.py", description=__doc__.split("\n")[0])
    parser.add_argument("result", help="the output directory of a run, its result.xdmf or its result.h5")
    parser.add_argument("-o", "--output", help="file to write (with --frames: directory); default: in the output directory")
    parser.add_argument("--field", help="what colours the body: displacement (default), velocity, von_mises_stress, "
                        "velocity_z, cauchy_stress_xx, body, rank, ..., tension (colours tendons and springs), or none")
    parser.add_argument("--range", type=_range, metavar="LOW,HIGH", help="of the colours, in SI units; default: that of all frames")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--frames", action="store_true", help="write every frame as a PNG")
    what.add_argument("--movie", choices=("mp4", "gif"), help="write a movie of all frames")
    parser.add_argument("--fps", type=_positive, default=25, help="frames per second of the movie (25)")
    parser.add_argument("--frame", type=_frame, metavar="N|last", help="which frame to draw, from 0; -1 is the last (default: last)")
    parser.add_argument("--view", type=_view, default=VIEWS["iso"], metavar="X,Y,Z|NAME",
                        help=f"where the viewer stands, seen from the body: a direction or one of {', '.join(VIEWS)} (iso)")
    parser.add_argument("--size", type=_size, default=(1280, 800), metavar="WxH", help="in pixels (1280x800)")
    parser.add_argument("--scale", type=_finite, default=1.0, help="displacements are multiplied by it (1); obstacles, tendons, "
                        "springs and joints are drawn at 1 only")
    parser.add_argument("--mesh-edges", action="store_true", help="draw the edges of the elements")
    parser.add_argument("--outline", action="store_true", help="draw the edges of the undeformed shape")
    parser.add_argument("--hide", action="append", default=[], metavar="NAME", help="leave out a body, an obstacle, a tendon, a spring or a joint; may be repeated")
    parser.add_argument("--transparent", action="append", default=[], metavar="NAME",
                        help="draw a body or an obstacle transparent; may be repeated")
    parser.add_argument("--title", help="instead of the run's title")
    return parser.parse_args(_with_negative_values(arguments))


def main():
    options = parsed(sys.argv[1:])
    return exit_code("render.py", lambda: run(options), UserError, options.output, ".png, .jpg, .tif")


if __name__ == "__main__":
    sys.exit(main())
