#!/usr/bin/python3
"""Whole runs of a beam in Pliant and in dolfinx, side by side: seconds per step, ratios, memory. See tools/bench.sh."""
import argparse
import csv
import itertools
import math
import os
import platform
import re
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLIANT = os.environ.get("PLIANT", os.path.join(ROOT, "build", "bin", "pliant"))
PAGE = os.path.join(ROOT, "docs", "performance.md")
FIGURE = os.path.join(ROOT, "docs", "images", "performance.svg")
DOLFINX = os.path.join(ROOT, "tests", "benchmarks", "dolfinx_beam.py")

# Bricks of the beam, order of the element, steps.
SIZES = {"S": ((30, 6, 6), 1, 10), "M": ((55, 11, 11), 1, 10), "L": ((85, 17, 17), 1, 10), "XL": ((160, 32, 32), 1, 3),
         "M2": ((55, 11, 11), 2, 3)}
# Young's modulus [Pa], Poisson's ratio, step [s], the relative tolerance that dolfinx still reaches, box [m] if another.
VARIANTS = {
    "beam": (1e6, 0.4, 0.01, 1e-8, (1.0, 0.2, 0.2)),
    "stiff": (1e9, 0.45, 0.025, 1e-5, (1.0, 0.2, 0.2)),
    "bulky": (1e6, 0.4, 0.01, 1e-8, (0.3, 0.3, 0.3)),
    "stiff and bulky": (1e9, 0.45, 0.025, 1e-4, (0.3, 0.3, 0.3)),
}
BULKY = {"S": (10, 10, 10), "M": (19, 19, 19), "L": (29, 29, 29), "XL": (55, 55, 55), "M2": (19, 19, 19)}
PEERS = {"MUMPS": "mumps_chol", "GAMG": "gamg", "ICC": "icc"}
# Sizes that do not fit, or take minutes for a run.
TOO_LARGE = {"MUMPS": {"L", "M2", "XL"}}
# What is asked of the ratio to the fastest configuration of dolfinx.
TARGETS = {"S": 0.15, "M": 0.12, "L": 0.12, "XL": 0.15, "M2": 0.06, "bulky": 0.15, "stiff": 0.05}
# Final positions of two programs that solve the same equations to these tolerances.
AGREEMENT = {1e-8: 1e-6, 1e-5: 1e-3, 1e-4: 1e-2}


class Failure(Exception):
    """A run that did not do what it should."""


def measure(arguments):
    """Runs a program as a child and reports its peak memory: the role this script plays on each rank."""
    code = subprocess.call(arguments)
    print(f"peak {resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.1f} MB", flush=True)
    return code


def run(ranks, command):
    """Output, and peak memory [MB] summed over the ranks."""
    full = ["mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), sys.executable, __file__,
            "--measure", *command]
    done = subprocess.run(full, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failure(f"{' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout, sum(float(m) for m in re.findall(r"peak ([\d.]+) MB", done.stdout))


def case(size, variant):
    """The parameters of a case, for both programs."""
    n, order, steps = SIZES[size]
    youngs, poisson, dt, tolerance, box = VARIANTS[variant]
    return {"n": BULKY[size] if "bulky" in variant else n, "order": order, "steps": steps, "youngs": youngs,
            "poisson": poisson, "dt": dt, "tolerance": tolerance, "box": box}


def of_dolfinx(problem, ranks, solver):
    command = [sys.executable, DOLFINX, "--n", *map(str, problem["n"]), "--p", str(problem["order"]), "--steps",
               str(problem["steps"]), "--solver", solver, "--E", str(problem["youngs"]), "--nu", str(problem["poisson"]),
               "--dt", str(problem["dt"]), "--rtol", str(problem["tolerance"]), "--box", *map(str, problem["box"])]
    text, memory = run(ranks, command)
    number = {name: float(value) for name, value in re.findall(r"(step|newton|cg)=([\d.]+)", text)}
    tip = float(re.search(r"uz\(lx,0,0\)=(\S+)", text).group(1))
    return {"step": number["step"] / 1e3, "newton": number["newton"], "memory": memory, "tip": tip}


def of_pliant(problem, ranks, directory):
    """Seconds per step: the mean over all steps, output and the first factorization included (of dolfinx the median)."""
    mesh = os.path.join(directory, f"{problem['n'][0]}_{problem['box'][0]}.msh")
    if not os.path.exists(mesh):
        subprocess.run([sys.executable, os.path.join(ROOT, "tools", "beam_mesh.py"), "--n", *map(str, problem["n"]), "--box",
                        *map(str, problem["box"]), "--binary", "-o", mesh], check=True, stdout=subprocess.DEVNULL)
    end = problem["steps"] * problem["dt"]
    with open(os.path.join(directory, "beam.yaml"), "w", encoding="utf-8") as text:
        text.write(f"""mesh: {{file: {mesh}}}
element: P{problem['order']}
bodies:
  - volume: beam
    density: 1000
    elasticity: {{model: neo-hookean, youngs_modulus: {problem['youngs']}, poissons_ratio: {problem['poisson']}}}
constraints: [{{surface: clamp, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, 0, -9.81]}}]
time: {{method: backward-euler, step: {problem['dt']}, end: {end}}}
output: {{every: {end}, fields: [displacement]}}
probes: [{{name: tip, point: [{problem['box'][0]}, 0, 0]}}]
""")
    out = os.path.join(directory, "out")
    text, memory = run(ranks, [PLIANT, "run", os.path.join(directory, "beam.yaml"), "--output", out])
    spent = re.search(r"time: ([\d.]+) s = set-up ([\d.]+)", text, re.MULTILINE)
    newton = re.search(r"^newton: (\d+) iterations in (\d+) stages", text, re.MULTILINE)
    with open(os.path.join(out, "history.csv"), newline="", encoding="utf-8") as table:
        tip = float(list(csv.DictReader(table))[-1]["tip_z"])
    return {"step": (float(spent.group(1)) - float(spent.group(2))) / problem["steps"], "memory": memory, "tip": tip,
            "newton": int(newton.group(1)) / int(newton.group(2)), "multigrid": "multigrid" in text}


def compare(size, variant, ranks, options, directory):
    """Medians of each program; they take turns, so that a machine that warms up or slows down does so for all."""
    problem = case(size, variant)
    runs = {"Pliant": lambda: of_pliant(problem, ranks, directory)}
    for name in options.peers:
        if size not in TOO_LARGE.get(name, ()):
            runs[name] = lambda solver=PEERS[name]: of_dolfinx(problem, ranks, solver)
    results = {name: [] for name in runs}
    for _ in range(options.repeats):
        for name, start in runs.items():
            results[name].append(start())
    return {name: {key: statistics.median(r[key] for r in several) for key in several[0]}
            for name, several in results.items()}


def target(size, variant):
    """The ratio that a case should reach: that of its variant, or that of its size."""
    return TARGETS[variant.split()[0]] if variant != "beam" else TARGETS[size]


def in_bold_above(limit, ratio):
    """A ratio with two digits, in bold where these are above the limit."""
    text = f"{ratio:.2f}"
    return f"**{text}**" if float(text) > limit else text


def row(size, variant, ranks, options, median):
    problem = case(size, variant)
    ours = median["Pliant"]
    cells = 6 * problem["n"][0] * problem["n"][1] * problem["n"][2]
    start = [variant, size, f"{cells:,} P{problem['order']}", str(ranks), f"{ours['step']:.3g}"]
    peers = [name for name in options.peers if name in median]
    if not peers:
        return [*start, f"{ours['newton']:.1f}", f"{ours['memory']:.0f}"]
    best = min(peers, key=lambda name: median[name]["step"])
    theirs = median[best]
    if abs(ours["tip"] - theirs["tip"]) > AGREEMENT[problem["tolerance"]] * abs(theirs["tip"]):
        raise Failure(f"{variant}, {size}: the tip of Pliant is at {ours['tip']}, that of dolfinx at {theirs['tip']}")
    alike = median.get("GAMG" if ours["multigrid"] else "MUMPS")
    return [*start, *(f"{median[name]['step']:.3g}" if name in median else "-" for name in options.peers),
            in_bold_above(target(size, variant), ours["step"] / theirs["step"]), f"{target(size, variant):.2f}", f"{ours['newton']:.1f}", f"{theirs['newton']:.1f}",
            f"{ours['memory']:.0f}", f"{theirs['memory']:.0f}", f"{alike['memory']:.0f}" if alike else "-"]


def draw(measured, file):
    """Seconds per step of the beam with linear elements against its tetrahedra."""
    import matplotlib.pyplot as plt  # pylint: disable=import-outside-toplevel
    from plot import COLOURS, STYLE  # pylint: disable=import-outside-toplevel
    plt.rcParams.update(STYLE)
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    programs = list(dict.fromkeys(name for median in measured.values() for name in median))
    for colour, program in zip(COLOURS, programs):
        for ranks, line in ((1, "o-"), (2, "s--")):
            points = [(6 * math.prod(case(size, "beam")["n"]), median[program]["step"])
                      for (variant, size, on), median in measured.items()
                      if variant == "beam" and SIZES[size][1] == 1 and on == ranks and program in median]
            if points:
                name = program if program == "Pliant" else f"dolfinx, {program}"
                axes.loglog(*zip(*sorted(points)), line, color=colour, label=f"{name}, {ranks} rank{'s' * (ranks > 1)}")
    axes.set(xlabel="tetrahedra", ylabel="seconds per step", title="Beam, linear elements")
    axes.legend()
    figure.savefig(file)


def heading(options):
    columns = ["variant", "size", "tetrahedra", "ranks", "Pliant [s]"]
    if options.peers:
        columns += [*(f"dolfinx, {name} [s]" for name in options.peers), "ratio to the best", "target", "Newton", "of the best", "MB",
                    "of the best", "of the same kind of solver"]
    else:
        columns += ["Newton", "MB"]
    return "| " + " | ".join(columns) + " |\n|" + "---|" * len(columns)


def write(page, program, table):
    """Replaces the table that `program` has written to a page before."""
    begin, end = f"<!-- {program} --write writes this table. -->", "<!-- Its end. -->"
    with open(page, encoding="utf-8") as file:
        before, rest = file.read().split(begin)
    _, after = rest.split(end, 1)
    with open(page, "w", encoding="utf-8") as file:
        file.write(f"{before}{begin}\n{table}\n{end}{after}")


def give_all_the_same_blas_kernels():
    """Where OpenBLAS does not know the processor, Pliant chooses its kernels itself; the peers get the same."""
    if not os.path.exists(PLIANT):
        return
    done = subprocess.run([PLIANT, "--version"], env=os.environ | {"OPENBLAS_VERBOSE": "2"}, capture_output=True, text=True,
                          check=False)
    kernels = re.findall(r"^Core: (\w+)$", done.stderr, re.MULTILINE)
    if kernels:
        os.environ["OPENBLAS_CORETYPE"] = kernels[-1]


def main():
    if sys.argv[1:2] == ["--measure"]:
        return measure(sys.argv[2:])
    parser = argparse.ArgumentParser(prog="bench.sh", description=__doc__)
    parser.add_argument("--sizes", nargs="+", choices=SIZES, default=["S", "M"])
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=["beam"])
    parser.add_argument("--cases", nargs="+", metavar="VARIANT/SIZE", default=[],
                        help="these alone, e.g. beam/S 'stiff and bulky/M'")
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=list(PEERS),
                        help="configurations of dolfinx; none: Pliant alone")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="put table and figure into docs/performance.md")
    options = parser.parse_args()
    cases = [tuple(name.split("/")) for name in options.cases] or list(itertools.product(options.variants, options.sizes))
    if not all(variant in VARIANTS and size in SIZES for variant, size, *_ in cases):
        parser.error("a case is VARIANT/SIZE: one of " + ", ".join(VARIANTS) + " and one of " + ", ".join(SIZES))
    if options.peers and subprocess.call([sys.executable, "-c", "import dolfinx"], stderr=subprocess.DEVNULL) != 0:
        print("bench.sh: dolfinx is missing: install python3-dolfinx and python3-petsc4py-real, or measure Pliant alone "
              "with --peers", file=sys.stderr)
        return 2
    give_all_the_same_blas_kernels()
    command = shlex.join(["tools/bench.sh", *sys.argv[1:]])
    lines = [f"{os.cpu_count()} cores, {platform.machine()}; medians of {options.repeats}; `{command}`", "", heading(options)]
    print("\n".join(lines), flush=True)
    measured = {}
    try:
        with tempfile.TemporaryDirectory() as directory:
            for (variant, size), ranks in itertools.product(cases, options.ranks):
                median = measured[variant, size, ranks] = compare(size, variant, ranks, options, directory)
                lines.append("| " + " | ".join(row(size, variant, ranks, options, median)) + " |")
                print(lines[-1], flush=True)
    except (Failure, FileNotFoundError, subprocess.CalledProcessError) as error:
        print(f"bench.sh: {error}", file=sys.stderr)
        return 1
    if options.write:
        write(PAGE, "tools/bench.sh", "\n".join(lines))
        draw(measured, FIGURE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
