#!/usr/bin/python3
"""Opens the mechanisms of a result that tests/io/test_mechanism_writer.cpp wrote, as a reader of XDMF and as the tools do.

usage: check_mechanisms.py DIRECTORY NUM_FRAMES
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
    directory, num_frames = sys.argv[1], int(sys.argv[2])
    grids = ElementTree.parse(os.path.join(directory, "result_mechanisms.xdmf")).findall("Domain/Grid/Grid")
    result = Result(directory)
    assert len(grids) == len(result.frames) == num_frames, (len(grids), len(result.frames))
    for i, (grid, frame) in enumerate(zip(grids, result.frames)):
        assert frame.step == 10 * i and float(grid.find("Time").get("Value")) == frame.time
        topology, (tension, part) = grid.find("Topology"), grid.findall("Attribute")
        assert (topology.get("TopologyType"), topology.get("NodesPerElement")) == ("Polyline", "2")
        assert [field.get("Name") for field in (tension, part)] == ["tension", "part"]
        mechanisms = frame.mechanisms
        for ours, item in ((mechanisms.segments, topology.find("DataItem")), (mechanisms.points, grid.find("Geometry/DataItem")),
                           (mechanisms.tension, tension.find("DataItem")), (mechanisms.part, part.find("DataItem"))):
            assert np.array_equal(ours, array_of(item, directory)), item.text
        assert mechanisms.names == ["flexor", "coil", "knuckle", "wrist"]
        assert mechanisms.kinds == ["tendon", "spring", "hinge", "ball"]
    count = np.arange(num_frames)
    assert list(result.tendons) == ["flexor"] and list(result.springs) == ["coil"] and list(result.joints) == ["knuckle", "wrist"]
    flexor, coil, knuckle, wrist = *result.tendons.values(), *result.springs.values(), *result.joints.values()
    at_rest = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 1]])
    assert np.allclose(flexor.points, at_rest + np.multiply.outer(count, [[0, 0, 1]]), atol=1e-14, rtol=0)
    assert np.array_equal(flexor.tension, np.outer(10 * count, [1, 0.5]))
    assert coil.points.shape == (num_frames, 2, 3) and np.array_equal(coil.tension[:, 0], -10 * count)
    assert (knuckle.type, wrist.type) == ("hinge", "ball")
    assert np.allclose(knuckle.point, np.array([5, 5, 5]) + np.multiply.outer(count, [0, 0, 1]), atol=1e-14, rtol=0)
    assert np.allclose(knuckle.axis, np.multiply.outer(1 - count / 2, [0, 1, 0]), atol=1e-14, rtol=0)
    assert not wrist.axis.any() and np.array_equal(wrist.point[0], [7, 7, 7])


if __name__ == "__main__":
    main()
