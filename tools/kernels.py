#!/usr/bin/python3
"""The hot loops on one core against what it can do at best: the table of docs/performance.md, "Kernels".

  tools/kernels.py                        neo-Hookean
  tools/kernels.py --filter 'P1/'         any of Google Benchmark's names, for example P2/ogden/hessian
  tools/kernels.py --write                the table goes to docs/performance.md too
"""
import argparse
import json
import os
import subprocess
import sys

import bench

PROGRAM = os.path.join(bench.ROOT, "build", "bin", "benchmark_kernels")
COLUMNS = ["element", "law", "kernel", "ns per tetrahedron", "million/s", "operations", "bytes", "GFlop/s", "GB/s", "roofline"]


def row(result):
    """A projected Hessian has no roofline: its eigenproblems are not counted."""
    element, law, kernel = result["name"].split("/")
    rate = result["tetrahedra"]
    cells = [element, law, kernel.replace("-", " "), f"{1e9 / rate:.1f}", f"{rate / 1e6:.3g}"]
    if kernel == "projected-hessian":
        return [*cells, *["-"] * 5]
    part, bound = max((result["of_peak"], "operations"), (result["of_bandwidth"], "bandwidth"))
    return [*cells, f"{result['operations'] / rate:.0f}", f"{result['bytes'] / rate:.0f}", f"{result['operations'] / 1e9:.1f}",
            f"{result['bytes'] / 1e9:.1f}", f"{100 * part:.0f} % of the {bound}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--filter", default="/neo-hookean/", help="a regular expression; default: %(default)s")
    parser.add_argument("--program", default=PROGRAM, help="default: %(default)s (cmake -DPLIANT_BENCHMARKS=ON)")
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    options = parser.parse_args()
    try:
        output = subprocess.run([options.program, f"--benchmark_filter={options.filter}", "--benchmark_format=json"], check=True,
                              capture_output=True, text=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        print(f"kernels.py: {error}", file=sys.stderr)
        return 1
    results = json.loads(output)
    best = ", ".join(f"{name} {results['context'][name]}" for name in ("multiply-adds [GFlop/s]", "triad [GB/s]"))
    lines = [f"One core, at best: {best}", "", "| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(row(result)) + " |" for result in results["benchmarks"]]
    print("\n".join(lines))
    if options.write:
        bench.write(bench.PAGE, "tools/kernels.py", "\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
