"""What a report of Pliant carries, unpacked: the reverse of src/io/packed.cpp, written on its own."""
import base64
import json
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

    def rows(self, block, size, scale):
        """Quantised rows, each from the row before and the number before."""
        low, high, levels = scale
        halves = np.frombuffer(self.bytes_of(block), dtype="u1").reshape(2, -1, size).astype(np.int64)
        coded = halves[0] + 256 * halves[1]
        residual = np.where(coded % 2 == 1, -(coded + 1) // 2, coded // 2)
        numbers = np.cumsum(np.cumsum(residual, axis=0), axis=1) % 65536
        return low + (high - low) * numbers / levels

    def triangles(self, mesh):
        return np.cumsum(self.array(self.result["meshes"][mesh]["index"], "i4")).reshape(-1, 3)

    def positions(self, mesh):
        given = self.result["meshes"][mesh]
        return np.stack([self.rows(block, given["vertices"], scale)[0] for block, scale in zip(given["positions"], given["scales"])], axis=1)

    def field(self, name, mesh=0):
        """Frames x vertices x components; of the displacement without the shifts."""
        field = next(f for f in self.result["fields"] if f["name"] == name)
        size = self.result["meshes"][mesh]["vertices"]
        return np.stack([self.rows(block, size, scale) for block, scale in zip(field["values"][mesh], field["scales"])], axis=2)

    def history(self):
        given = self.json["history"]
        table = self.array(given["values"], "f8").reshape(len(given["columns"]), -1)
        return dict(zip(given["columns"], table))
