#!/usr/bin/python3
"""Opens the obstacles of a result that tests/io/test_obstacle_writer.cpp wrote, as a reader of XDMF and as the tools do.

usage: check_obstacles.py DIRECTORY NUM_FRAMES moves|rests
"""
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from check_xdmf import array_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools"))
sys.dont_write_bytecode = True
from package import Result  # noqa: E402


def main():
    directory, num_frames, motion = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    grids = ElementTree.parse(os.path.join(directory, "result_obstacles.xdmf")).findall("Domain/Grid/Grid")
    result = Result(directory)
    assert len(grids) == len(result.frames) == num_frames, (len(grids), len(result.frames))
    for i, (grid, frame) in enumerate(zip(grids, result.frames)):
        height = i if motion == "moves" else 0  # a tenth of the step, which is 10 i
        assert frame.step == 10 * i and float(grid.find("Time").get("Value")) == frame.time
        assert grid.find("Topology").get("TopologyType") == "Triangle"
        obstacles = frame.obstacles
        for ours, item in ((obstacles.triangles, "Topology/DataItem"), (obstacles.points, "Geometry/DataItem"),
                           (obstacles.obstacle, "Attribute/DataItem")):
            assert np.array_equal(ours, array_of(grid.find(item), directory)), item
        assert obstacles.names == ["floor", "tip"]
        assert list(obstacles.obstacle) == [0, 0, 1, 1, 1, 1]
        sheet, = obstacles.planes()
        assert np.array_equal(obstacles.points[sheet], [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        tip = obstacles.points_of_others()
        assert tip.shape == (4, 3) and abs(tip[:, 2].min() - 1 - height) < 1e-14, tip
        a, b, c = (tip[obstacles.triangles[2:, k] - 4] for k in range(3))
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3 - tip.mean(axis=0)) > 0).all()


if __name__ == "__main__":
    main()
