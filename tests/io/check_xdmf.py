#!/usr/bin/python3
"""Opens a result that tests/io/sample.cpp wrote and compares it with what that file describes.

usage: check_xdmf.py RESULT.xdmf NODES_PER_CELL NUM_FRAMES

Read twice: by following the XDMF with an XML parser and h5py into a VTK grid, always; and by ParaView's own XDMF readers, where
they are installed (package python3-paraview; Debian's python3-vtk9 comes without them).
"""
import os
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np
import vtkmodules.vtkCommonExecutionModel
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_QUADRATIC_TETRA, VTK_TETRA, vtkCellArray, vtkUnstructuredGrid

CUBES, SIDE = (3, 2, 2), 0.5
VOLUME = CUBES[0] * CUBES[1] * CUBES[2] * SIDE**3
TIME_STEP = 0.1
CELL_TYPES = {"Tetrahedron": VTK_TETRA, "Tetrahedron_10": VTK_QUADRATIC_TETRA}


def array_of(item, directory):
    """The numbers of a <DataItem>, whose declared shape and type must be those of the dataset."""
    file, place = item.text.strip().split(":")
    with h5py.File(os.path.join(directory, file), "r") as h5:
        dataset = h5[place]
        assert list(dataset.shape) == [int(n) for n in item.get("Dimensions").split()], place
        assert dataset.dtype.itemsize == int(item.get("Precision")), place
        assert dataset.dtype.kind == {"Float": "f", "Int": "i"}[item.get("NumberType")], place
        return dataset[()]


def grids_by_hand(file):
    """(time, vtkUnstructuredGrid) of each frame."""
    directory = os.path.dirname(os.path.abspath(file))
    series = ElementTree.parse(file).find("Domain/Grid")
    assert series.get("CollectionType") == "Temporal"
    for frame in series.findall("Grid"):
        topology = frame.find("Topology")
        cells = array_of(topology.find("DataItem"), directory)
        grid = vtkUnstructuredGrid()
        points = vtkPoints()
        points.SetData(numpy_to_vtk(array_of(frame.find("Geometry/DataItem"), directory), deep=True))
        grid.SetPoints(points)
        cell_array = vtkCellArray()
        for cell in cells:
            cell_array.InsertNextCell(len(cell), [int(n) for n in cell])
        grid.SetCells(CELL_TYPES[topology.get("TopologyType")], cell_array)
        for attribute in frame.findall("Attribute"):
            values = numpy_to_vtk(array_of(attribute.find("DataItem"), directory), deep=True)
            values.SetName(attribute.get("Name"))
            data = {"Node": grid.GetPointData(), "Cell": grid.GetCellData()}[attribute.get("Center")]
            data.AddArray(values)
        yield float(frame.find("Time").get("Value")), grid


def grids_by_paraview(file, reader):
    """The same through one of ParaView's XDMF readers."""
    reader.SetFileName(file)
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    key = vtkmodules.vtkCommonExecutionModel.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    for i in range(information.Length(key)):
        time = information.Get(key, i)
        reader.UpdateTimeStep(time)
        data = reader.GetOutputDataObject(0)
        while not data.IsA("vtkUnstructuredGrid"):
            data = data.GetBlock(0)
        grid = vtkUnstructuredGrid()
        grid.DeepCopy(data)
        yield time, grid


def signed_volume(x, cells):
    a, b, c, d = (x[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def check(frames, nodes_per_cell, num_frames):
    frames = list(frames)
    assert len(frames) == num_frames, f"{len(frames)} frames instead of {num_frames}"
    for i, (time, grid) in enumerate(frames):
        t = TIME_STEP * i
        assert abs(time - t) < 1e-15, (time, t)
        x = vtk_to_numpy(grid.GetPoints().GetData())
        cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, nodes_per_cell)
        num_cells = 6 * CUBES[0] * CUBES[1] * CUBES[2]
        assert cells.shape[0] == grid.GetNumberOfCells() == num_cells
        assert grid.GetCellType(0) == {4: VTK_TETRA, 10: VTK_QUADRATIC_TETRA}[nodes_per_cell]
        assert np.allclose(x.max(axis=0), SIDE * np.array(CUBES)) and np.allclose(x.min(axis=0), 0)
        volumes = signed_volume(x, cells)
        assert (volumes > 0).all() and abs(volumes.sum() - VOLUME) < 1e-12
        if nodes_per_cell == 10:
            # VTK's own numbering decides: the third node of each edge of the cell lies midway between the other two.
            for c in range(num_cells):
                cell = grid.GetCell(c)
                for e in range(6):
                    end, other, middle = (cell.GetEdge(e).GetPointId(k) for k in range(3))
                    assert np.allclose(x[middle], (x[end] + x[other]) / 2)
        node, by_cell = grid.GetPointData(), grid.GetCellData()
        u = vtk_to_numpy(node.GetArray("displacement"))
        zero = np.zeros(len(x))
        assert np.allclose(u, np.stack([0.1 * t * x[:, 0] * x[:, 1], zero, -t * x[:, 2] ** 2], axis=1), atol=1e-15)
        body = vtk_to_numpy(by_cell.GetArray("body"))
        assert body.shape == (num_cells,) and set(body) == {0, 1}
        assert (vtk_to_numpy(by_cell.GetArray("rank")) >= 0).all()
        stress = vtk_to_numpy(by_cell.GetArray("cauchy_stress"))
        assert stress.shape == (num_cells, 6)
        assert np.allclose(stress, t * np.arange(1, 7) + body[:, None])
        assert np.allclose(vtk_to_numpy(by_cell.GetArray("density")), 1000)


def main():
    file, nodes_per_cell, num_frames = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    check(grids_by_hand(file), nodes_per_cell, num_frames)
    try:
        from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
        from vtkmodules.vtkIOXdmf3 import vtkXdmf3Reader
    except ImportError:
        return
    for reader in (vtkXdmfReader(), vtkXdmf3Reader()):
        check(grids_by_paraview(file, reader), nodes_per_cell, num_frames)
        print(f"{reader.GetClassName()}: as expected")


if __name__ == "__main__":
    main()
