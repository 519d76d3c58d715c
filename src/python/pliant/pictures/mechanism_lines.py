"""Tendons, springs, rods and joints in a picture: tubes and spheres that VTK draws."""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from .shown import JOINT

THICKNESS, DOT = 0.004, 0.014  # radius of lines, at least, and of the spheres at joints, as fractions of the scene's size


class DrawnMechanisms:
    """Lines in a renderer, in whose scene something is `size` long; `set` places and colours them."""

    def __init__(self, renderer, size):
        self._lines, self._places = vtkPolyData(), vtkPolyData()
        tubes = vtkTubeFilter()
        tubes.SetInputData(self._lines)
        tubes.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
        self._least_radius = THICKNESS * size
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
        self.actors = [self._actor(renderer, part.GetOutputPort()) for part in (tubes, balls)]
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
        self._fill(self._lines, shown.points, shown.segments)
        radii = np.maximum(shown.radii, self._least_radius)
        self._lines.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(radii), deep=True))
        self._lines.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(shown.colours), deep=True))
        self._fill(self._places, shown.points[shown.joints])

    @staticmethod
    def _fill(data, positions, segments=None):
        points, cells = vtkPoints(), vtkCellArray()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=True))
        data.SetPoints(points)
        if segments is not None:
            offsets = 2 * np.arange(len(segments) + 1, dtype=np.int64)
            cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True),
                          numpy_to_vtkIdTypeArray(np.ascontiguousarray(segments, dtype=np.int64).ravel(), deep=True))
            data.SetLines(cells)
        data.Modified()
