#!/usr/bin/python3
"""ParaView's own readers find in the files what the run wrote: times, places, fields. Needs `pvpython` on PATH."""
import json
import shutil
import subprocess
import time
import unittest

import numpy as np

from program import ENVIRONMENT, ProgramTest, finish, start, write_box
from package import Result

INPUT = """
mesh: {file: bar.msh}
element: P2
bodies:
  - {volume: body, density: 1200 kg/m^3, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
contact:
  obstacles:
    - {name: floor, shape: plane, point: [0, 0, -0.5], normal: [0, 0, 1]}
    - {name: ball, shape: sphere, point: [0.9, 0.1, -0.105], radius: 0.1, motion: {translate: [0, 0, "0.2*t"]}}
time: {method: bdf2, end: 0.05, adaptive: {relative: 0.01}}
output: {fields: [displacement, velocity, acceleration, cauchy_stress, contact_pressure, contact_gap, contact_slip,
                  von_mises_stress, volume_ratio, energy_density]}
"""
# Prints per reader, file and frame what is there, as JSON.
READ = """
import json, sys
from paraview import servermanager
from paraview.simple import XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT
from vtkmodules.util.numpy_support import vtk_to_numpy

def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).tolist() for i in range(data.GetNumberOfArrays())}

def read(reader, file):
    source = reader(FileNames=[file]) if reader is XDMFReader else reader(FileName=[file])
    source.UpdatePipelineInformation()
    frames = []
    for time in source.TimestepValues:
        source.UpdatePipeline(time)
        grid = servermanager.Fetch(source)
        frames.append({"time": time, "points": vtk_to_numpy(grid.GetPoints().GetData()).tolist(),
                       "types": sorted({grid.GetCellType(c) for c in range(grid.GetNumberOfCells())}),
                       "cells": vtk_to_numpy(grid.GetCells().GetConnectivityArray()).tolist(),
                       "nodal": arrays(grid.GetPointData()), "of cells": arrays(grid.GetCellData())})
    return frames

json.dump({r.__name__: [read(r, f) for f in sys.argv[2:]] for r in (XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT)}, open(sys.argv[1], "w"))
"""
TRIANGLE, QUADRATIC_TETRAHEDRON = 5, 24  # VTK's cell types


@unittest.skipUnless(shutil.which("pvpython"), "pvpython is not installed; Debian's package python3-paraview has it")
class ParaView(ProgramTest):
    def read(self, *names):
        script, answer = self.write("read.py", READ), self.directory / "answer.json"
        done = subprocess.run(["pvpython", "--force-offscreen-rendering", script, answer, *(self.directory / name for name in names)],
                              env=ENVIRONMENT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        answers = json.loads(answer.read_text())
        self.assertEqual(len(answers), 3)
        return answers.values()

    def test_every_reader_finds_what_was_written(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2), order=2)
        self.run_input(self.write("bar.yaml", INPUT))
        result = Result(self.directory / "out")
        self.assertGreater(result.frames[-1].field("contact_pressure").values.max(), 0)
        for bodies, obstacles in self.read("out/result.xdmf", "out/result_obstacles.xdmf"):
            self.assertEqual([f["time"] for f in bodies], [f.time for f in result.frames])
            self.assertEqual([f["time"] for f in obstacles], [f.time for f in result.frames])
            for read, written in zip(bodies, result.frames):
                self.assertEqual(read["types"], [QUADRATIC_TETRAHEDRON])
                np.testing.assert_array_equal(read["points"], written.mesh.coordinates)
                np.testing.assert_array_equal(read["cells"], np.ravel(written.mesh.cells))
                self.assertEqual({*read["nodal"], *read["of cells"]}, set(written.field_names))
                for name in written.field_names:
                    field = written.field(name)
                    values = read["nodal" if field.on_nodes else "of cells"][name]
                    np.testing.assert_array_equal(np.reshape(values, field.values.shape), field.values, name)
            for read, written in zip(obstacles, result.frames):
                self.assertEqual(read["types"], [TRIANGLE])
                np.testing.assert_array_equal(read["points"], written.obstacles.points)
                np.testing.assert_array_equal(read["of cells"]["obstacle"], written.obstacles.obstacle)

    def test_a_run_that_goes_on_is_read_and_goes_on(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2), order=2)
        endless = INPUT[:INPUT.index("output:")].replace("end: 0.05, adaptive: {relative: 0.01}", "step: 1 ms, end: 1e3").replace('"0.2*t"', "0")
        endless += "output: {every: 0.2, fields: [displacement]}\n"
        run = start(["run", self.write("bar.yaml", endless), "--quiet", "--output", "out"], self.directory)
        self.addCleanup(run.kill)
        while run.poll() is None and not (self.directory / "out/result_obstacles.xdmf").exists():
            time.sleep(0.1)
        for bodies, obstacles in self.read("out/result.xdmf", "out/result_obstacles.xdmf"):
            self.assertTrue(bodies and obstacles)
        self.assertIsNone(run.poll())
        run.terminate()
        self.assertEqual(finish(run, 60).stderr.count("error"), 0)


if __name__ == "__main__":
    unittest.main()
