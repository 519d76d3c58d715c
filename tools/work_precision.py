#!/usr/bin/python3
"""Draws what a study of `pliant converge` found: the error of each method over its Newton iterations and over wall time."""
import csv
import os
import sys

try:
    import matplotlib
    import matplotlib.pyplot as plt
    import package  # noqa: F401  finds the package pliant
    from pliant.command_line import Parser, exit_code
    from pliant.pictures.plot import COLOURS, STYLE, PliantError
except ImportError as missing:
    print(f"work_precision.py: {missing}; run it with /usr/bin/python3, and with the packages of tools/setup.sh",
          file=sys.stderr)
    sys.exit(2)

MARKERS = "osD^v<>PX*"
WORK = {"newton_iterations": "Newton iterations", "seconds": "wall time [s]"}
ERRORS = {"error_displacement": "error of the displacement [m]", "error_velocity": "error of the velocity [m/s]"}


def read_study(path):
    """The rows of each method, in the order of the table."""
    file = os.path.join(path, "convergence.csv") if os.path.isdir(path) else path
    if not os.path.isfile(file):
        raise PliantError(f"there is not a study: {file} does not exist")
    with open(file, newline="", encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    methods = {}
    try:
        for row in rows:
            numbers = {name: float(row[name]) for name in (*WORK, *ERRORS)}
            methods.setdefault(row["method"], []).append(numbers)
    except (KeyError, TypeError, ValueError) as error:
        raise PliantError(f"{file} is not a study of `pliant converge`: {error}") from error
    if not methods:
        raise PliantError(f"{file} holds no level yet")
    return os.path.dirname(os.path.abspath(file)), methods


def draw(methods, title, works):
    """A row of panels for each measure of work: displacement and velocity."""
    figure, grid = plt.subplots(len(works), 2, figsize=(11, 0.6 + 3.9 * len(works)), squeeze=False, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
    figure.suptitle(title, x=0.012, ha="left", fontsize=13, fontweight="bold")
    for axes_row, work in zip(grid, works):
        for axes, error in zip(axes_row, ERRORS):
            for k, (method, rows) in enumerate(methods.items()):
                # Levels that were not solved have no error: nan, which is not drawn.
                axes.loglog([row[work] for row in rows], [row[error] for row in rows], label=method,
                            color=COLOURS[k % len(COLOURS)], marker=MARKERS[k % len(MARKERS)], markersize=5,
                            linestyle="-" if k < len(COLOURS) else "--")
            axes.set_xlabel(WORK[work])
            axes.set_ylabel(ERRORS[error])
        axes_row[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def main():
    parser = Parser(prog="work_precision.py", description=__doc__)
    parser.add_argument("study", help="the output directory of `pliant converge`, or its convergence.csv")
    parser.add_argument("-o", "--output", help="file to write (.png, .pdf, .svg); default: work_precision.png next to the table")
    parser.add_argument("--title", default="Work and precision")
    parser.add_argument("--work", choices=[*WORK, "both"], default="both", help="what counts as work")
    options = parser.parse_args()
    plt.switch_backend("Agg")

    def work():
        directory, methods = read_study(options.study)
        file = options.output or os.path.join(directory, "work_precision.png")
        with plt.rc_context({**STYLE, "axes.formatter.limits": matplotlib.rcParams["axes.formatter.limits"]}):
            draw(methods, options.title, list(WORK) if options.work == "both" else [options.work]).savefig(file, dpi=110)
        print(file)

    return exit_code(parser.prog, work, PliantError, options.output, ".png, .pdf or .svg")


if __name__ == "__main__":
    sys.exit(main())
