"""What a report of Pliant carries, unpacked: the reverse of src/io/packed.cpp, written on its own."""
import base64
import json
import math
import re
import zlib

import numpy as np


class ReportFile:
    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            self.text = file.read()
        self.json = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', self.text, re.S)[1])
        self._blocks = dict(re.findall(r'<script type="text/plain" id="block-(\d+)">(.*?)</script>', self.text))
        self.result = self.json["result"]

    def bytes_of(self, block):
        return zlib.decompress(base64.b64decode(self._blocks[str(block)], validate=True))

    def array(self, block, kind):
        return np.frombuffer(self.bytes_of(block), dtype=kind)

    def rows(self, block, triangles, size, scale):
        """Quantised rows, each from the rows before and the neighbours before."""
        low, high, levels = scale
        content = self.bytes_of(block)
        halves = np.frombuffer(content, dtype="u1", offset=1).reshape(2, -1, size).astype(np.int64)
        coded = halves[0] + 256 * halves[1]
        residual = np.where(coded % 2 == 1, -(coded + 1) // 2, coded // 2)
        sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        sides = sides[sides[:, 0] < sides[:, 1]]
        earlier = [sides[sides[:, 1] == v, 0] for v in range(size)]
        numbers = np.zeros((len(residual) + 2, size), dtype=np.int64)  # two rows of nothing first
        for f, of_row in enumerate(residual, start=2):
            predicted = 2 * numbers[f - 1] - numbers[f - 2] if content[0] == 2 and f > 3 else numbers[f - 1]
            for v in range(size):
                near = earlier[v] if len(earlier[v]) else np.arange(max(v - 1, 0), v)
                change = numbers[f, near] - predicted[near]
                mean = math.floor(change.mean() + 0.5) if len(change) else 0
                numbers[f, v] = (predicted[v] + mean + of_row[v]) % 65536
        return low + (high - low) * numbers[2:] / levels

    def triangles(self, mesh):
        return self.index_of(self.result["meshes"][mesh])

    def index_of(self, given):
        return np.cumsum(self.array(given["index"], "i4")).reshape(-1, 3)

    def positions(self, mesh):
        given = self.result["meshes"][mesh]
        triangles = self.triangles(mesh)
        return np.stack([self.rows(block, triangles, given["vertices"], scale)[0] for block, scale in zip(given["positions"], given["scales"])], axis=1)

    def field(self, name, mesh=0):
        """Frames x vertices x components; of the displacement without the shifts."""
        field = next(f for f in self.result["fields"] if f["name"] == name)
        size, triangles = self.result["meshes"][mesh]["vertices"], self.triangles(mesh)
        return np.stack([self.rows(block, triangles, size, scale) for block, scale in zip(field["values"][mesh], field["scales"])], axis=2)

    def history(self):
        given = self.json["history"]
        table = self.array(given["values"], "f8").reshape(len(given["columns"]), -1)
        return dict(zip(given["columns"], table))

    def blocks_of_fields(self):
        return [self._blocks[str(block)] for field in self.result["fields"] for of_mesh in field["values"] for block in of_mesh]
