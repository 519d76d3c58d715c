#!/usr/bin/python3
"""What changes with the number of ranks and does not depend on the machine: iterations, load, communication, memory.

Two steps of bodies under their weight, on more and more ranks, which may be more than the machine has cores: only counts
are reported, no times. `--write` puts the table into docs/scaling.md.

  tools/scaling.py --bodies M --solvers amg --ranks 1 4
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

import bench

TOOLS = os.path.dirname(os.path.abspath(__file__))
PAGE = os.path.join(bench.ROOT, "docs", "scaling.md")
STEPS = 2
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}

# Bricks of six tetrahedra along the axes, and the size [m].
BODIES = {"S": ((30, 6, 6), (1.0, 0.2, 0.2)), "M": ((55, 11, 11), (1.0, 0.2, 0.2)),
          "L": ((85, 17, 17), (1.0, 0.2, 0.2)), "cube": ((24, 24, 24), (0.3, 0.3, 0.3))}
COLUMNS = ("body", "tetrahedra", "solver", "ranks", "largest part / mean", "ghosts / own nodes", "neighbours",
           "Newton per step", "linear per Newton", "MB on the fullest rank", "MB in all")


def prepare(directory, body):
    """The input of a body and its mesh; returns the input's path."""
    n, box = BODIES[body]
    mesh, file = os.path.join(directory, f"{body}.msh"), os.path.join(directory, f"{body}.yaml")
    subprocess.run([sys.executable, os.path.join(TOOLS, "beam_mesh.py"), "--n", *map(str, n), "--box", *map(str, box),
                    "--binary", "-o", mesh], check=True)
    with open(file, "w", encoding="utf-8") as text:
        text.write(f"""mesh: {{file: {mesh}}}
element: P1
bodies:
  - {{volume: beam, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}}}
constraints: [{{surface: clamp, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, 0, -9.81]}}]
time: {{method: backward-euler, step: 0.01, end: {0.01 * STEPS}}}
output: {{directory: {directory}/out, every: {0.01 * STEPS}, fields: [displacement]}}
""")
    return file


def run(ranks, command):
    """Output, and the peak memory of each rank [MB]."""
    measured = [sys.executable, os.path.join(TOOLS, "bench.py"), "--measure", bench.PLIANT, *command]
    done = subprocess.run(["mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), *measured],
                          env=ENVIRONMENT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise bench.Failure(f"{' '.join(command)} on {ranks} ranks\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout, [float(m) for m in re.findall(r"^peak ([\d.]+) MB$", done.stdout, re.MULTILINE)]


def numbers(pattern, text):
    match = re.search(pattern, text, re.MULTILINE)
    if match is None:
        raise bench.Failure(f"'{pattern}' is not in the output:\n{text}")
    return [int(number) for number in match.groups()]


def spread(text, ranks):
    """Largest part over the mean one, ghosts per own node, neighbours of the rank that has most."""
    if ranks == 1:
        return "1", "0", "0"
    [cells] = numbers(r"^ +size +(\d+) tetrahedra", text)
    [most] = numbers(r"^ +ranks +\d+, with \d+ to (\d+) cells", text)
    [unknowns] = numbers(r"^unknowns\n +(\d+) ", text)
    ghosts, neighbours = numbers(r"^ +ghosts: \d+ to \d+ nodes per rank, (\d+) in all; from \d+ to (\d+) other ranks$", text)
    return f"{most * ranks / cells:.2f}", f"{3 * ghosts / unknowns:.2f}", str(neighbours)


def row(file, body, solver, ranks):
    n, _ = BODIES[body]
    chosen = ["--set", f"solver.linear={solver}"]
    checked, _ = run(ranks, ["check", file, *chosen])
    output, peaks = run(ranks, ["run", file, *chosen])
    newton, linear = numbers(r"^newton: (\d+) iterations .*, (\d+) linear iterations", output)
    return [body, f"{6 * n[0] * n[1] * n[2]:,}", solver, str(ranks), *spread(checked, ranks), f"{newton / STEPS:.1f}",
            f"{linear / newton:.1f}", f"{max(peaks):.0f}", f"{sum(peaks):.0f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=["M", "L", "cube"])
    parser.add_argument("--solvers", nargs="+", default=["auto", "amg"])
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2, 4, 8, 16])
    parser.add_argument("--write", action="store_true", help="put the table into docs/scaling.md")
    options = parser.parse_args()
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    print("\n".join(lines), flush=True)
    try:
        with tempfile.TemporaryDirectory() as directory:
            for body in options.bodies:
                file = prepare(directory, body)
                for solver in options.solvers:
                    for ranks in options.ranks:
                        lines.append("| " + " | ".join(row(file, body, solver, ranks)) + " |")
                        print(lines[-1], flush=True)
    except (bench.Failure, FileNotFoundError, subprocess.CalledProcessError) as error:
        print(f"scaling.py: {error}", file=sys.stderr)
        return 1
    if options.write:
        bench.write(PAGE, "tools/scaling.py", "\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
