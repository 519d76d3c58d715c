#!/usr/bin/python3
"""What rods in a body add to a step: the same body with and without them, in turns; seconds of processor time, and their ratio.

  tools/bench_rods.py                           10,064 segments in 99,900 tetrahedra, one rank
  tools/bench_rods.py --ranks 2 --repeat 5      the median of five turns on two ranks
  tools/bench_rods.py --youngs-modulus 1e9      stiffer fibres
  tools/bench_rods.py --bending true            rods that resist bending and twist, whatever their size

The body is the beam of tools/bench.py under its weight, and the rods are fibres along it on lines of its mesh. Time without
set-up and output.
"""
import os
import re
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import beam_mesh
import package  # noqa: F401  finds the package pliant
from pliant.command_line import Parser, report

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLIANT = os.environ.get("PLIANT", os.path.join(ROOT, "build", "bin", "pliant"))
BRICKS, BOX = (74, 15, 15), (1.0, 0.2, 0.2)
NUM_RODS = 136  # of 196 lines of the mesh inside the body
STEPS = 6
LINE, TRIANGLE, TETRAHEDRON = 1, 2, 4


class Failure(Exception):
    """A run that did not do what it should."""


def write_mesh(path):
    """The beam with volume `beam`, surface `clamp`, and a curve for each rod."""
    nx, ny, nz = BRICKS
    points, cells = beam_mesh.vertices(BRICKS, BOX), beam_mesh.tetrahedra(BRICKS)
    lines = [(j, k) for k in range(1, nz) for j in range(1, ny)][:NUM_RODS]
    elements = [(TRIANGLE, 1, t) for t in beam_mesh.clamp_triangles(BRICKS)] + [(TETRAHEDRON, 2, c) for c in cells]
    for number, (j, k) in enumerate(lines):
        first = (nx + 1) * (j + (ny + 1) * k)
        elements += [(LINE, 3 + number, (first + i, first + i + 1)) for i in range(nx)]
    with open(path, "w", encoding="ascii") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{2 + NUM_RODS}\n2 1 \"clamp\"\n3 2 \"beam\"\n")
        out.write("".join(f"1 {3 + n} \"fibre{n}\"\n" for n in range(NUM_RODS)) + f"$EndPhysicalNames\n$Nodes\n{len(points)}\n")
        out.write("".join("{} {:.17g} {:.17g} {:.17g}\n".format(n, *x) for n, x in enumerate(points, 1)))
        out.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        for n, (kind, tag, members) in enumerate(elements, 1):
            out.write(f"{n} {kind} 2 {tag} {tag} {' '.join(str(m + 1) for m in members)}\n")
        out.write("$EndElements\n")
    return NUM_RODS * nx, len(cells)


def write_inputs(directory, modulus, bending):
    text = """mesh: {file: beam.msh}
bodies: [{volume: beam, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: clamp, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81], volume: beam}]
"""
    text += f"time: {{method: backward-euler, step: 10 ms, end: {10 * STEPS} ms}}\noutput: {{every: 10}}\n"
    rods = "rods:\n" + "".join(f"  - {{name: fibre{n}, curve: fibre{n}, radius: 0.5 mm, density: 1000, youngs_modulus: {modulus}, "
                               f"poissons_ratio: 0.3{bending}}}\n" for n in range(NUM_RODS))
    for name, contents in (("without", text), ("with", text + rods)):
        with open(os.path.join(directory, f"{name}.yaml"), "w", encoding="ascii") as out:
            out.write(contents)


def run(name, ranks, directory, options):
    """Seconds of processor time of a step, by what they are spent on, and Newton's iterations."""
    command = ["mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), PLIANT, "run", f"{name}.yaml", *options]
    before = os.times()
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0:
        raise Failure(f"{' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    line = re.search(r"^time: .*", done.stdout, re.M)[0]
    part = lambda key: float(re.search(rf"{key} ?([\d.e-]+)", line)[1])
    wall, parts = part("time:"), {key: part(key) for key in ("assembly", "factorization", "solve")}
    processor = after.children_user - before.children_user
    share = processor / wall / STEPS  # the machine may be busy: walls are scaled to the time of the processor
    return {key: seconds * share for key, seconds in parts.items()}, int(re.search(r"^newton: (\d+)", done.stdout, re.M)[1])


def main():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--repeat", type=int, default=3, help="turns (3)")
    parser.add_argument("--youngs-modulus", type=float, default=1e8, metavar="E", help="of the rods [Pa] (1e8)")
    parser.add_argument("--bending", choices=("true", "false"), help="the rods' key of this name (none)")
    options, more = parser.parse_known_args()
    try:
        with tempfile.TemporaryDirectory() as directory:
            segments, cells = write_mesh(os.path.join(directory, "beam.msh"))
            write_inputs(directory, options.youngs_modulus, f", bending: {options.bending}" if options.bending else "")
            print(f"{segments} segments in {cells} tetrahedra, {options.ranks} rank{'s' if options.ranks > 1 else ''}", flush=True)
            ratios = []
            for _ in range(options.repeat):
                plain, with_rods = (run(name, options.ranks, directory, more) for name in ("without", "with"))
                ratios.append(sum(with_rods[0].values()) / sum(plain[0].values()))
                for name, (parts, newton) in (("without", plain), ("with", with_rods)):
                    listed = ", ".join(f"{key} {seconds:.3f}" for key, seconds in parts.items())
                    print(f"  {name:8} {sum(parts.values()):.3f} s a step: {listed}; {newton} iterations", flush=True)
            print(f"with rods a step takes {np.round(statistics.median(ratios), 3)} times as long (median of {options.repeat})")
    except (Failure, FileNotFoundError) as error:
        return report("bench_rods.py", error)
    return 0


if __name__ == "__main__":
    sys.exit(main())
