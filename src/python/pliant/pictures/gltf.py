"""Binary glTF 2.0 (.glb): a small writer. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html

glTF has metres, seconds, y upwards, and triangles that are counterclockwise seen from outside.
"""
import json
import struct

import numpy as np

TRIANGLES, LINES = 4, 1  # modes of primitives
VERTICES, INDICES = 34962, 34963  # what a view of the buffer is for
COMPONENTS = {np.dtype(np.uint16): 5123, np.dtype(np.uint32): 5125, np.dtype(np.float32): 5126}
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


def y_up(vectors):
    """Points or directions, rows x 3, from z upwards to y upwards, as float32."""
    return np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1).astype(np.float32)


def linear(colours):
    """8-bit sRGB colours, rows x 3, as linear ones with 16 bits and an opacity of 1, which glTF's vertices have."""
    s = colours / 255
    values = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
    return (np.column_stack([values, np.ones(len(values))]) * 65535).round().astype(np.uint16)


class Document:
    """The parts of a .glb, added one by one; `write` writes them. Methods return indices of what they added."""

    def __init__(self, generator):
        self._json = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}]}
        self._binary = bytearray()

    def add(self, kind, entry):
        """Appends to one of glTF's lists, such as "materials"."""
        entries = self._json.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def add_node(self, node):
        """A node of the scene."""
        self._json["scenes"][0]["nodes"].append(self.add("nodes", node))
        return self._json["scenes"][0]["nodes"][-1]

    def describe(self, name, extras):
        """The scene's name, and what else a program may want to know about it."""
        self._json["scenes"][0].update({"name": name, "extras": extras})

    def add_array(self, values, target=None, *, normalized=False, with_range=False):
        """An accessor of an array: rows of 1, 3 or 4 numbers."""
        values = np.ascontiguousarray(values)
        rows = values.reshape(len(values), -1)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": values.nbytes}
        if target is not None:
            view["target"] = target
        self._binary += values.tobytes() + bytes(-values.nbytes % 4)
        accessor = {"bufferView": self.add("bufferViews", view), "componentType": COMPONENTS[values.dtype], "count": len(rows),
                    "type": TYPES[rows.shape[1]]}
        if normalized:
            accessor["normalized"] = True
        if with_range:
            accessor.update({"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()})
        return self.add("accessors", accessor)

    def add_indices(self, cells):
        """Vertices of triangles or lines, in as few bytes as they fit into; 65535 is reserved."""
        small = cells.max() < 65535
        return self.add_array(cells.ravel().astype(np.uint16 if small else np.uint32), INDICES)

    def write(self, file):
        self._json["buffers"] = [{"byteLength": len(self._binary)}]
        text = json.dumps(self._json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self._binary)
        with open(file, "wb") as glb:
            glb.write(struct.pack("<4sII", b"glTF", 2, length))
            glb.write(struct.pack("<I4s", len(text), b"JSON") + text)
            glb.write(struct.pack("<I4s", len(self._binary), b"BIN\0"))
            glb.write(self._binary)
