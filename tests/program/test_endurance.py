#!/usr/bin/python3
"""Many steps of a small body: memory and open files do not grow with them."""
import pathlib
import time
import unittest

import numpy as np

from program import ProgramTest, finish, read_history, start, write_box

BODY = """
mesh: {file: box.msh}
bodies:
  - density: 1000
    elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}
    viscosity: [{model: prony, ratio: 0.5, relaxation_time: 50 ms}]
constraints: [{surface: left, displacement: [0, 0, "0.002*sin(20*t)"]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 1 ms, end: 0.05}
probes: [{name: tip, point: [0.1, 0.1, 0.1]}]
"""


class Endurance(ProgramTest):
    STEPS = 4000

    def test_memory_and_files(self):
        write_box(self.directory / "box.msh", (1, 1, 1), (0.1, 0.1, 0.1))
        settings = [f"time.end={self.STEPS * 1e-3}", "output.every=0.02", "checkpoint={every: 50}"]
        arguments = ["run", self.write("in.yaml", BODY), "--quiet", "--output", "out"]
        arguments += [a for setting in settings for a in ("--set", setting)]
        process = start(arguments, self.directory)
        of_process = pathlib.Path("/proc") / str(process.pid)
        samples = []
        while process.poll() is None:
            try:
                status = (of_process / "status").read_text()
                memory = next(line for line in status.splitlines() if line.startswith("VmRSS"))
                files = len(list((of_process / "fd").iterdir()))
                rows = (self.directory / "out/history.csv").read_text().count("\n")
                samples.append((rows, int(memory.split()[1]), files))
            except (OSError, StopIteration):
                pass  # not yet, or over
            time.sleep(0.05)
        done = finish(process, 60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(read_history(self.directory / "out")["step"]), self.STEPS + 1)
        rows, memory, files = np.array([sample for sample in samples if 1000 < sample[0] < self.STEPS]).T
        self.assertGreater(len(rows), 4)
        # A leak of 64 bytes a step would be 256 kB; the list of the frames in result.xdmf, kept as text, takes 0.4 MB.
        self.assertLess(memory[-1] - memory[0], 1500, memory)
        # A file that is being written may be open beside those that always are; one lost per frame would be hundreds.
        self.assertLess(files.max() - files.min(), 8, files)


if __name__ == "__main__":
    unittest.main()
