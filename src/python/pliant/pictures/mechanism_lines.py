"""Tendons, springs, rods and joints in a picture: tubes, prisms and spheres that VTK draws."""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from .rods import HAIRLINE, prisms
from .shown import JOINT

THICKNESS, DOT = 0.004, 0.014  # radius of lines and of the spheres at joints, as fractions of the scene's size


class DrawnMechanisms:
    """Lines in a renderer, in whose scene something is `size` long; `set` places and colours them."""

    def __init__(self, renderer, size):
        self._lines, self._places, self._rods = vtkPolyData(), vtkPolyData(), vtkPolyData()
        self._hairline = HAIRLINE * size
        tubes = vtkTubeFilter()
        tubes.SetInputData(self._lines)
        tubes.SetRadius(THICKNESS * size)
        tubes.SetNumberOfSides(16)
        tubes.CappingOn()
        ball = vtkSphereSource()
        ball.SetRadius(DOT * size)
        ball.SetThetaResolution(24)
        ball.SetPhiResolution(24)
        balls = vtkGlyph3D()
        balls.SetInputData(self._places)
        balls.SetSourceConnection(ball.GetOutputPort())
        balls.ScalingOff()
        rods = vtkPolyDataNormals()
        rods.SetInputData(self._rods)
        rods.SetFeatureAngle(35)
        rods.ConsistencyOff()
        self.actors = [self._actor(renderer, part.GetOutputPort()) for part in (tubes, balls, rods)]
        self.actors[1].GetMapper().ScalarVisibilityOff()
        self.actors[1].GetProperty().SetColor(*(c / 255 for c in JOINT))

    @staticmethod
    def _actor(renderer, port):
        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputConnection(port)
        mapper.SetScalarModeToUseCellData()
        actor.SetMapper(mapper)
        actor.GetProperty().SetAmbient(0.5)
        actor.GetProperty().SetDiffuse(0.6)
        renderer.AddActor(actor)
        return actor

    def set(self, shown):
        """`shown`: a ShownMechanisms."""
        lines = ~shown.is_rod
        self._fill(self._lines, shown.points, shown.segments[lines])
        self._lines.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(shown.colours[lines]), deep=True))
        if len(shown.rods) > 0:
            points, triangles, segment = prisms(shown.rods, shown.has_rectangle, self._hairline)
            self._fill(self._rods, points, triangles)
            self._rods.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(shown.rod_colours[segment]), deep=True))
        self._fill(self._places, shown.points[shown.joints])

    @staticmethod
    def _fill(data, positions, lines_or_triangles=None):
        points, cells = vtkPoints(), vtkCellArray()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=True))
        data.SetPoints(points)
        if lines_or_triangles is not None:
            count, width = lines_or_triangles.shape
            cells.SetData(numpy_to_vtkIdTypeArray(width * np.arange(count + 1, dtype=np.int64), deep=True),
                          numpy_to_vtkIdTypeArray(np.ascontiguousarray(lines_or_triangles, dtype=np.int64).ravel(), deep=True))
            (data.SetLines if width == 2 else data.SetPolys)(cells)
        data.Modified()
