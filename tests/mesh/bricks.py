"""Mesh files by hand, in every format that is read, so that tests can break them."""
import pathlib
import struct
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "program"))

from program import SIDES, TETRAHEDRON, TRIANGLE, box  # noqa: E402

NAMES = [(2, k + 1, name) for k, name in enumerate(SIDES)] + [(3, 7, "body")]


class Brick:
    """A cube of 48 tetrahedra. Parts may be changed before it is written; nodes of `blocks` count from 1."""

    def __init__(self):
        points, triangles, cells = box((2, 2, 2))
        self.names = list(NAMES)
        self.tags = list(range(1, len(points) + 1))
        self.points = [tuple(map(float, p)) for p in points]
        # (dimension, entity, type, physical group or 0, nodes of each element)
        self.blocks = [(2, k + 1, TRIANGLE, k + 1, (t + 1).tolist()) for k, t in enumerate(triangles)]
        self.blocks.append((3, 7, TETRAHEDRON, 7, (cells + 1).tolist()))

    def cells(self):
        return self.blocks[-1][4]

    def num_elements(self):
        return sum(len(block[4]) for block in self.blocks)

    def names_section(self):
        lines = [f'{dimension} {tag} "{name}"' for dimension, tag, name in self.names]
        return "\n".join(["$PhysicalNames", str(len(lines)), *lines, "$EndPhysicalNames", ""]).encode()

    def msh2(self, binary=False, order="<"):
        """Version 2.2, as bytes; `order`: "<" or ">", of binary numbers."""
        if not binary:
            nodes = [f"{tag} {x!r} {y!r} {z!r}" for tag, (x, y, z) in zip(self.tags, self.points)]
            elements = []
            for _, entity, kind, physical, members in self.blocks:
                for member in members:
                    elements.append(f"{len(elements) + 1} {kind} 2 {physical} {entity} {' '.join(map(str, member))}")
            body = "\n".join(["$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements", str(len(elements)), *elements,
                              "$EndElements", ""]).encode()
            return b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + self.names_section() + body
        nodes = b"".join(struct.pack(order + "i3d", tag, *x) for tag, x in zip(self.tags, self.points))
        elements, number = b"", 0
        for _, entity, kind, physical, members in self.blocks:
            elements += struct.pack(order + "3i", kind, len(members), 2)
            for member in members:
                number += 1
                elements += struct.pack(f"{order}{3 + len(member)}i", number, physical, entity, *member)
        return (b"$MeshFormat\n2.2 1 8\n" + struct.pack(order + "i", 1) + b"\n$EndMeshFormat\n" + self.names_section() +
                b"$Nodes\n%d\n" % len(self.tags) + nodes + b"\n$EndNodes\n$Elements\n%d\n" % number + elements + b"\n$EndElements\n")

    def msh4(self, binary=False, order="<"):
        """Version 4.1, as bytes."""
        def words(kinds, *values):
            """`kinds`: i, Q or d per value."""
            if binary:
                return struct.pack(order + kinds, *values)
            return (" ".join(repr(v) if k == "d" else str(v) for k, v in zip(kinds, values)) + "\n").encode()

        entities = words("QQQQ", *(sum(block[0] == dimension for block in self.blocks) for dimension in range(4)))
        for dimension, entity, _, physical, _ in self.blocks:
            physicals = [physical] if physical else []
            values = [entity, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, len(physicals), *physicals, 0]
            entities += words("idddddd" + "Q" + "i" * len(physicals) + "Q", *values)
            assert dimension >= 1
        nodes = words("QQQQ", 1, len(self.tags), min(self.tags), max(self.tags)) + words("iiiQ", 3, 7, 0, len(self.tags))
        nodes += b"".join(words("Q", tag) for tag in self.tags) + b"".join(words("ddd", *x) for x in self.points)
        elements, number = words("QQQQ", len(self.blocks), self.num_elements(), 1, self.num_elements()), 0
        for dimension, entity, kind, _, members in self.blocks:
            elements += words("iiiQ", dimension, entity, kind, len(members))
            for member in members:
                number += 1
                elements += words("Q" * (1 + len(member)), number, *member)
        head = b"$MeshFormat\n4.1 %d 8\n" % binary + (struct.pack(order + "i", 1) + b"\n" if binary else b"") + b"$EndMeshFormat\n"
        end = b"\n" if binary else b""
        return (head + self.names_section() + b"$Entities\n" + entities + end + b"$EndEntities\n$Nodes\n" + nodes + end +
                b"$EndNodes\n$Elements\n" + elements + end + b"$EndElements\n")


def write_parts(path, change=None):
    """Pliant's own format (HDF5) with three tetrahedra; `change` alters the open file before it is closed."""
    with h5py.File(path, "w") as file:
        file.attrs["format"] = np.bytes_("pliant-mesh")
        file.attrs["version"] = 1
        file["nodes"] = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, 0.0]])
        file["cells"] = np.array([[0, 1, 2, 3], [1, 2, 3, 4], [1, 5, 2, 4]], dtype=np.int32)
        for number, (dimension, tag, name, members) in enumerate([(2, 1, "left", [[0, 1]]), (3, 7, "body", [0, 1, 2])]):
            file[f"groups/{number}"] = np.array(members, dtype=np.int64)
            file[f"groups/{number}"].attrs.update({"dimension": dimension, "tag": tag, "name": np.bytes_(name)})
        file.create_group("cell_data")
        if change is not None:
            change(file)
