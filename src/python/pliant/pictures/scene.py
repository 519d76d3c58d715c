"""Bodies, obstacles and mechanisms as VTK draws them."""
import enum

import numpy as np
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

from .camera import VIEW_ANGLE
from .mechanism_lines import DrawnMechanisms
from .page import BACKGROUND
from .shown import OBSTACLE, PLAIN_BODY

OBSTACLE_OVER_BODY = 0.5  # opacity of obstacles where they hide a body
MECHANISM_IN_BODY = 0.6  # opacity of tendons, springs and joints where a body hides them
SUPERSAMPLING = 2  # drawn this much larger and scaled down: smooth edges on any graphics library


class Sides(enum.Enum):
    """From which side triangles are seen."""

    BOTH, FACING = range(2)  # FACING: from that from where they are counterclockwise


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
            self._add_surface(drawn.body, drawn.points, shell.triangles, PLAIN_BODY).GetProperty().SetOpacity(shell.opacity)
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

    def add_obstacles(self, triangles, opacity=1.0, sides=Sides.BOTH):
        """Obstacles, which `draw` places."""
        points, data = vtkPoints(), vtkPolyData()
        actor = self._add_surface(data, points, triangles, OBSTACLE)
        actor.GetProperty().SetAmbient(0.62)
        actor.GetProperty().SetDiffuse(0.38)
        actor.GetProperty().SetOpacity(opacity)
        actor.GetProperty().SetBackfaceCulling(sides is Sides.FACING)
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
        whole = self._pixels()
        drawn = whole.copy()
        if self._obstacles:
            bodies = self._without([actor for _, _, actor in self._obstacles])
            _blend(drawn, bodies, _differ(bodies, BACKGROUND) & _differ(bodies, whole), 1 - OBSTACLE_OVER_BODY)
        if self._mechanisms is not None:
            # Without smoothing, which would give their rims the colour of the background.
            self._renderer.UseFXAAOff()
            lines = self._without([actor for actor in self._actors() if actor not in self._mechanisms.actors])
            self._renderer.UseFXAAOn()
            is_there, is_hidden = _differ(lines, BACKGROUND), _differ(lines, whole)
            _blend(drawn, lines, is_there & ~is_hidden, 1.0)
            _blend(drawn, lines, is_there & is_hidden, MECHANISM_IN_BODY)
        return drawn

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
        grab.ShouldRerenderOff()
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1]
        return pixels[..., :3].copy()


def _differ(pixels, others):
    """Which of them, height x width; `others`: pixels, too, or one colour."""
    others = np.broadcast_to(np.asarray(others, dtype=np.uint8), pixels.shape)
    return (pixels[..., 0] != others[..., 0]) | (pixels[..., 1] != others[..., 1]) | (pixels[..., 2] != others[..., 2])


def _blend(pixels, others, chosen, share):
    """Some of the pixels with a share of others, in place."""
    pixels[chosen] = (share * others[chosen] + (1 - share) * pixels[chosen]).round()


def _cell_array(cells):
    array = vtkCellArray()
    offsets = np.arange(0, cells.size + 1, cells.shape[1])
    array.SetData(numpy_to_vtkIdTypeArray(offsets.astype(np.int64), deep=True),
                  numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, dtype=np.int64).ravel(), deep=True))
    return array
