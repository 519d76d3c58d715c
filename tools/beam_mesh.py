#!/usr/bin/python3
"""Writes a box of tetrahedra as a gmsh 2.2 file: the beam of the benchmarks and of the reference solutions.

Every brick of the grid is cut into six tetrahedra around its diagonal from the lowest to the highest corner (Kuhn),
all positively oriented. Groups: volume `beam`, surface `clamp` (x = 0). Vertex (i, j, k) has the number
1 + i + (nx + 1) (j + (ny + 1) k).

  tools/beam_mesh.py --n 55 11 11 -o beam.msh
  tools/beam_mesh.py --n 19 19 19 --box 0.3 0.3 0.3 --binary -o cube.msh
"""
import argparse
import itertools
import sys

import numpy as np

CLAMP, BEAM = 1, 2  # physical tags
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh element types


def vertices(n, box):
    """Coordinates [m], shape (vertices, 3)."""
    x, y, z = (np.linspace(0.0, length, count + 1) for length, count in zip(box, n))
    grid = np.meshgrid(z, y, x, indexing="ij")
    return np.stack([grid[2].ravel(), grid[1].ravel(), grid[0].ravel()], axis=1)


def tetrahedra(n):
    """Vertices from 0, shape (tetrahedra, 4): per brick one path along its edges for each order of the three axes."""
    stride = np.array([1, n[0] + 1, (n[0] + 1) * (n[1] + 1)])
    corner = lowest_corners(n)
    cells = np.empty((len(corner), 6, 4), dtype=np.int32)
    for row, axes in enumerate(itertools.permutations(range(3))):
        path = np.concatenate([[0], np.cumsum(stride[list(axes)])])
        odd = axes in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        cells[:, row] = corner[:, None] + path[[0, 2, 1, 3] if odd else [0, 1, 2, 3]]
    return cells.reshape(-1, 4)


def clamp_triangles(n):
    """Vertices from 0 of the facets at x = 0, shape (triangles, 3), normals outward."""
    stride_y, stride_z = n[0] + 1, (n[0] + 1) * (n[1] + 1)
    corner = (np.arange(n[1])[None, :] * stride_y + np.arange(n[2])[:, None] * stride_z).ravel()[:, None]
    lower = corner + [0, stride_y + stride_z, stride_y]
    upper = corner + [0, stride_z, stride_y + stride_z]
    return np.stack([lower, upper], axis=1).reshape(-1, 3).astype(np.int32)


def lowest_corners(n):
    i, j, k = (np.arange(count) for count in n)
    return (i[None, None, :] + (n[0] + 1) * (j[None, :, None] + (n[1] + 1) * k[:, None, None])).ravel()


def write(path, points, triangles, cells, binary):
    with open(path, "wb") as out:
        out.write(b"$MeshFormat\n2.2 %d 8\n" % (1 if binary else 0))
        if binary:
            out.write(np.int32(1).tobytes() + b"\n")
        out.write(b'$EndMeshFormat\n$PhysicalNames\n2\n2 %d "clamp"\n3 %d "beam"\n$EndPhysicalNames\n' % (CLAMP, BEAM))
        out.write(b"$Nodes\n%d\n" % len(points))
        (write_points_binary if binary else write_points_text)(out, points)
        out.write(b"$EndNodes\n$Elements\n%d\n" % (len(triangles) + len(cells)))
        blocks = [(TRIANGLE, CLAMP, triangles, 1), (TETRAHEDRON, BEAM, cells, 1 + len(triangles))]
        for kind, tag, elements, first in blocks:
            # Columns: number, physical tag, tag of the geometric entity (the same here), vertices from 1.
            tags = np.full((len(elements), 2), tag)
            rows = np.hstack([np.arange(first, first + len(elements))[:, None], tags, elements + 1]).astype(np.int32)
            if binary:
                out.write(np.array([kind, len(rows), 2], dtype=np.int32).tobytes() + rows.tobytes())
            else:
                line = f"%d {kind} 2" + " %d" * (rows.shape[1] - 1) + "\n"
                out.write((line * len(rows) % tuple(rows.ravel().tolist())).encode())
        out.write(b"$EndElements\n")


def write_points_text(out, points):
    numbers = (str(k) for k in range(1, len(points) + 1))
    out.write("".join(f"{k} {x!r} {y!r} {z!r}\n" for k, (x, y, z) in zip(numbers, points.tolist())).encode())


def write_points_binary(out, points):
    rows = np.empty(len(points), dtype=[("number", "<i4"), ("point", "<f8", 3)])
    rows["number"] = np.arange(1, len(points) + 1)
    rows["point"] = points
    out.write(rows.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, nargs=3, default=[30, 6, 6], metavar=("NX", "NY", "NZ"), help="bricks along x, y, z")
    parser.add_argument("--box", type=float, nargs=3, default=[1.0, 0.2, 0.2], metavar=("LX", "LY", "LZ"), help="size [m]")
    parser.add_argument("--binary", action="store_true", help="write numbers as bytes rather than as text")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.msh")
    arguments = parser.parse_args()
    if min(arguments.n) < 1 or min(arguments.box) <= 0:
        parser.error("the numbers of bricks and the sizes must be positive")
    try:
        write(arguments.output, vertices(arguments.n, arguments.box), clamp_triangles(arguments.n),
              tetrahedra(arguments.n), arguments.binary)
    except OSError as error:
        sys.exit(f"{arguments.output}: {error.strerror}")


if __name__ == "__main__":
    main()
