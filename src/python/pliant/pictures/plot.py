"""Draws the history of a run: energies and their balance, probes, forces, cavities, joints and tendons, and what each step cost."""
import os
import re

import matplotlib
import numpy as np
import yaml
from matplotlib import pyplot as plt

from pliant import History, PliantError, Result
from pliant.error import did_you_mean
from pliant.notebook import EFFORTS, unit_of

from ..command_line import Parser, exit_code
from .analysis import counted
from .axes import column_in_words, use_handy_units
from .columns import title_of_entry, unit_of_entry

COLOURS = ["#3b6fb6", "#d1603d", "#3f9c6b", "#8a63b8", "#c79a2b", "#4aa5b5", "#b5507c", "#6d7580"]
STYLE = {
    "font.size": 9, "axes.titlesize": 10.5, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#8b919b", "axes.labelcolor": "#2d3139",
    "axes.grid": True, "grid.color": "#e3e6ea", "grid.linewidth": 0.8, "axes.axisbelow": True,
    "xtick.color": "#5a606b", "ytick.color": "#5a606b", "text.color": "#2d3139", "lines.linewidth": 1.6,
    "legend.frameon": False, "legend.fontsize": 8.5, "figure.facecolor": "white",
    "axes.prop_cycle": matplotlib.cycler(linestyle=["-", "--", ":"]) * matplotlib.cycler(color=COLOURS), "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True,
}
ENERGIES = ("kinetic_energy", "elastic_energy", "load_potential", "dissipated_energy", "numerical_dissipation", "load_work")

TOLERANCE = 1e-7  # of the largest energy per metre: forces below it are 0
MOST_FORCES = 3  # in a drawing, with three lines each
ROUNDING, SEEN = 1e-12, 1e-6  # of the largest value of a unit: what counts as constant, and half of the axis that it is drawn on


def changes(values):
    """Does it vary by more than rounding?"""
    return np.ptp(values) > 1e-12 * max(np.abs(values).max(), 1e-300)


def scales(history, taken):
    """The largest magnitude of all columns of a unit, by unit; angles are compared with 1 rad. `taken`: as of columns_from_fields."""
    found = {"rad": 1.0}
    for name in history:
        unit, values = unit_of_column(name, taken, history), history[name][np.isfinite(history[name])]
        if unit and len(values):
            found[unit] = max(found.get(unit, 0.0), float(np.abs(values).max()))
    return found


def flatten_noise(axes, largest):
    """Lines that vary by no more than rounding, next to all columns of their unit, are drawn flat: the axis is as wide as what can be seen of these. `largest`: as of scales."""
    unit = re.search(r"\[([^\]]+)\]$", axes.get_ylabel())
    values = np.concatenate([np.zeros(0), *(np.asarray(line.get_ydata(), float) for line in axes.lines)])
    values = values[np.isfinite(values)]
    if not len(values) or axes.get_yscale() != "linear" or not axes.get_autoscaley_on():
        return
    scale = max(largest.get(unit[1], 0.0) if unit else 0.0, np.abs(values).max())
    if 0 < np.ptp(values) <= ROUNDING * scale:
        middle = (values.min() + values.max()) / 2
        axes.set_ylim(middle - SEEN * scale, middle + SEEN * scale)
        axes.dataLim.intervaly = axes.get_ylim()  # which handy units follow


def triples(history, suffixes):
    """Names of which the history has all three columns, e.g. `tip` for tip_x, tip_y, tip_z."""
    first = [name[: -len(suffixes[0])] for name in history if name.endswith(suffixes[0])]
    return [name for name in first if all(name + suffix in history for suffix in suffixes)]


def show_legend(axes):
    """Next to the curves, never over them."""
    if axes.lines:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def draw_energies(axes, time, history):
    axes.set_title("Energies")
    for name in ENERGIES:
        if name in history and np.any(history[name] != 0):
            # At slow motion the work of loads is the elastic energy, which is seen under dashes.
            style = {"linestyle": "--"} if name == "load_work" else {}
            axes.plot(time, history[name], label=name.replace("_", " "), **style)
    axes.set_ylabel("energy [J]")
    show_legend(axes)


def draw_balance(axes, time, history):
    axes.set_title("Energy balance")
    error = history["energy_balance_error"]
    turnover = max(np.ptp(history[name]) for name in ENERGIES if name in history)
    relative = turnover > 0
    axes.plot(time, error / turnover if relative else error, color=COLOURS[1])
    axes.axhline(0, color="#8b919b", linewidth=0.8)
    axes.set_ylabel("error / largest energy change" if relative else "error [J]")
    if relative and np.abs(error).max() <= ROUNDING * turnover:
        axes.set_ylim(-SEEN, SEEN)


def draw_lines(axes, time, title, label, lines):
    """Those of the lines, by name, whose changes are seen next to those of the others."""
    axes.set_title(title)
    most = max((max(np.ptp(values), 1e-6 * np.abs(values).max()) for values in lines.values()), default=0.0)
    for name, values in lines.items():
        if np.ptp(values) > 1e-3 * most:
            axes.plot(time, values, label=name)
    axes.set_ylabel(label)
    show_legend(axes)


def draw_probes(axes, time, history, probes):
    positions = {f"{probe} {axis}": history[f"{probe}_{axis}"] for probe in probes for axis in "xyz"}
    title = "Probes and centers of rigid bodies" if any(f"{probe}_qw" in history for probe in probes) else "Probes"
    draw_lines(axes, time, title, "moved from the start by [m]", {name: x - x[0] for name, x in positions.items()})


def ways(history):
    """What a path moves, by name: of each probe the component of its displacement that changes most, with the sign that it
    has at the end; of cavities the volume."""
    found = {}
    for probe in triples(history, ("_ux", "_uy", "_uz")):
        axis = max("xyz", key=lambda k: np.ptp(history[f"{probe}_u{k}"]))
        moved = history[f"{probe}_u{axis}"]
        sign = "-" if moved[-1] < 0 else ""
        found[f"{sign}u{axis} of {probe} [m]"] = -moved if sign else moved
    found |= {f"volume of {name.removesuffix('_volume')} [m³]": history[name] for name in history
              if name.endswith("_volume") and name.replace("_volume", "_pressure") in history}
    return {name: values for name, values in found.items() if changes(values)}


def draw_path(axes, history, name, values):
    """The load factor over what it moves; parts that are unstable are dashed."""
    load = history["load_factor"]
    axes.set_title("Load")
    unstable = np.nan_to_num(history["unstable_modes"]) > 0 if "unstable_modes" in history else np.zeros(len(load), bool)
    # A step belongs to the state that it leads to.
    for state, style in ((False, "-"), (True, "--")):
        for k in np.flatnonzero(unstable[1:] == state):
            axes.plot(values[k:k + 2], load[k:k + 2], style, color=COLOURS[0], dash_capstyle="round")
    axes.plot(values, load, ".", color=COLOURS[0], markersize=4)
    if unstable.any():
        axes.plot([], [], "-", color=COLOURS[0], label="stable")
        axes.plot([], [], "--", color=COLOURS[0], label="unstable")
        show_legend(axes)
    axes.axhline(0, color="#8b919b", linewidth=0.8)
    axes.set_ylabel("load factor")
    axes.set_xlabel(name)


def of_forces(history):
    """Drawings of the forces of obstacles and constraints, of few of them each: a force of an obstacle on its only body is not drawn twice."""
    components = {name: [history[f"{name}_f{axis}"] for axis in "xyz"] for name in triples(history, ("_fx", "_fy", "_fz"))}
    change = {name: max(np.ptp(values) for values in of_name) for name, of_name in components.items()}
    # What a solver's tolerance leaves where forces balance, as on a closed chamber: they do no such work over a metre.
    work = max((np.abs(history[name]).max() for name in ("elastic_energy", "load_work", "support_work") if name in history), default=0.0)
    if change and 0 < max(change.values()) <= TOLERANCE * work:
        return
    seen = [name for name in components if change[name] > 1e-3 * max(change.values())] or list(components)[:MOST_FORCES]
    for whole in list(seen):
        seen = [name for name in seen if not (name.startswith(f"{whole}_") and np.array_equal(components[name], components[whole], equal_nan=True))]
    parts = [seen[first:first + MOST_FORCES] for first in range(0, len(seen), MOST_FORCES)]
    for names in parts:
        title = "Forces of obstacles and constraints" if len(parts) == 1 else "Forces of " + ", ".join(names)
        lines = {f"{name} {axis}": values for name in names for axis, values in zip("xyz", components[name])}
        yield lambda axes, time, h, parts=(title, "force [N]", lines): draw_lines(axes, time, *parts)


# Columns of cavities, tendons, springs and joints: their ending, the title over them, and what they are.
MECHANISMS = (("_pressure", "Pressure in cavities", "gauge pressure [Pa]"), ("_volume", "Volume of cavities", "volume [m³]"),
              ("_tension", "Tension of tendons", "tension [N]"), ("_force", "Force of springs", "force [N]"),
              ("_length", "Length of tendons and springs", "length [m]"), ("_angle", "Angles of joints", "angle [rad]"),
              ("_travel", "Travel of joints", "travel [m]"),
              *((ending, f"{quantity.capitalize()}s of {of}", f"{quantity} [{unit}]")
                for ending, of in zip(EFFORTS, ("motors", "springs of joints", "dampers of joints", "friction in joints", "friction in bearings", "stops of joints"))
                for quantity, unit in (("torque", "N m"), ("force", "N"))))


def of_mechanisms(history, taken):
    """Drawings of these columns, of those that vary."""
    for ending, title, label in MECHANISMS:
        lines = {name.removesuffix(ending): history[name] for name in history if name.endswith(ending) and name not in taken
                 and (ending not in EFFORTS or label.endswith(f"[{unit_of(name, history)}]"))}
        if any(changes(values) for values in lines.values()):
            yield lambda axes, time, h, parts=(title, label, lines): draw_lines(axes, time, *parts)


def draw_column(axes, time, history, name, title):
    what, unit = title
    axes.set_title(what[0].upper() + what[1:])
    axes.plot(time, history[name], color=COLOURS[3])
    axes.set_ylabel(f"{name} [{unit}]" if unit else name)


def labelled(name, unit):
    return f"{column_in_words(name, unit)} [{unit}]" if unit else name


def draw_mesh_error(axes, time, history):
    axes.set_title("Discretization error")
    axes.plot(time, 100 * history["discretization_error"], color=COLOURS[4])
    axes.set_ylim(bottom=0)
    axes.set_ylabel("% of the elastic energy")


def draw_iterations(axes, time, history):
    axes.set_title("Newton iterations per step")
    iterations = history["newton_iterations"][1:]
    axes.step(time[1:], iterations, where="mid", color=COLOURS[0])
    axes.fill_between(time[1:], iterations, step="mid", color=COLOURS[0], alpha=0.15, linewidth=0)
    axes.set_ylim(0, max(1, iterations.max(initial=1)) * 1.15)
    axes.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(integer=True))
    axes.set_ylabel(f"iterations (mean {iterations.mean():.1f})" if len(iterations) else "iterations")


def draw_time_step(axes, time, history):
    axes.set_title("Step" if "load_factor" in history else "Time step")
    step = history["dt"][1:]
    axes.step(time[1:], step, where="mid", color=COLOURS[2])
    if np.all(step > 0) and step.max(initial=0) > 20 * step.min(initial=np.inf):
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, step.max(initial=1e-300) * 1.15)
    axes.set_ylabel("dt [s]" if "load_factor" not in history else "dt")


def columns_from_fields(directory):
    """Names of the columns of `output.history`; of each what it is, and its unit."""
    try:
        with open(os.path.join(directory, "run.yaml"), encoding="utf-8") as file:
            given = yaml.safe_load(file)
        return {entry["name"]: (title_of_entry(entry), unit_of_entry(given, entry)) for entry in given["output"]["history"]}
    except (OSError, KeyError, TypeError, yaml.YAMLError):  # a history alone, or a run without such columns
        return {}


def panels(history, taken):
    """The drawings this history has the columns for. `taken`: as of columns_from_fields."""
    chosen = []
    if any(name in history for name in ENERGIES):
        chosen.append(draw_energies)
        if "energy_balance_error" in history:
            chosen.append(draw_balance)
    probes = triples(history, ("_x", "_y", "_z"))
    if probes:
        chosen.append(lambda axes, time, h: draw_probes(axes, time, h, probes))
    chosen += of_forces(history)
    chosen += of_mechanisms(history, taken)
    for name, title in taken.items():
        if name in history:
            chosen.append(lambda axes, time, h, name=name, title=title: draw_column(axes, time, h, name, title))
    if "discretization_error" in history:
        chosen.append(draw_mesh_error)
    if "newton_iterations" in history:
        chosen.append(draw_iterations)
    if "dt" in history:
        chosen.append(draw_time_step)
    return chosen


def unit_of_column(name, taken, history):
    return taken[name][1] if name in taken else unit_of(name, history)


def chosen_columns(history, names, taken, x):
    """Drawings of the columns that are named: those of one unit in one, over the column `x` or over time."""
    by_unit = {}
    for name in names:
        by_unit.setdefault(unit_of_column(name, taken, history) or name, []).append(name)
    for unit, columns in by_unit.items():
        def draw_them(axes, time, h, unit=unit, columns=columns):
            for name in columns:
                axes.plot(h[x] if x else time, h[name], label=column_in_words(name, unit_of_column(name, taken, h)))
            axes.set_ylabel(labelled(columns[0], unit_of_column(columns[0], taken, h)) if len(columns) == 1 else f"[{unit}]")
            if len(columns) > 1:
                show_legend(axes)
            if x:
                axes.set_xlabel(labelled(x, unit_of_column(x, taken, h)))
        yield draw_them


def require(history, option, name):
    if name not in history:
        raise PliantError(f"--{option} {name}: the history has no such column; {did_you_mean(name, history) or 'it has ' + ', '.join(history)}".strip())


LABELS = {"path": "length of the path", "load": "load factor", "": "time [s]"}


def draw(history, title, taken, counts="", columns=(), x=None):
    along = list(ways(history).items()) if "load_factor" in history else []
    drawings = [lambda axes, time, h, way=way: draw_path(axes, h, *way) for way in along[:4]] + panels(history, taken)
    if columns:
        drawings = list(chosen_columns(history, columns, taken, x))
    num_columns = min(2, max(1, len(drawings)))
    num_rows = max(1, -(-len(drawings) // num_columns))
    size = (12, 0.5 + 2.9 * num_rows) if num_columns == 2 else (8, 4.5)
    figure, grid = plt.subplots(num_rows, num_columns, figsize=size, squeeze=False, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12)
    figure.suptitle(title, x=0.012, ha="left", fontsize=13, fontweight="bold")
    largest = scales(history, taken)
    for axes, drawing in zip(grid.flat, drawings):
        drawing(axes, history["time"], history)
        flatten_noise(axes, largest)
        if not axes.get_xlabel():
            axes.margins(x=0.01)
            axes.set_xlabel(LABELS[counts])
        use_handy_units(axes)
    for axes in grid.flat[len(drawings):]:
        axes.remove()
    return figure


def title_of(directory):
    """The run's title, if its result is there and readable."""
    try:
        return Result(directory).title
    except (PliantError, OSError, KeyError):  # a plot without a title is better than none
        return os.path.basename(directory)


def parser_of(program):
    parser = Parser(prog=program, description=__doc__)
    parser.add_argument("result", help="the output directory of a run, or its history.csv")
    parser.add_argument("-o", "--output", help="file to write (.png, .pdf, .svg); default: history.png in the output directory")
    parser.add_argument("--of", metavar="COLUMN,...", action="append", help="columns of the history to draw instead; those of one unit together")
    parser.add_argument("--x", metavar="COLUMN", help="the column to draw those over, instead of time: pressure over volume, force over displacement")
    return parser


def main(arguments, program):
    options = parser_of(program).parse_args(arguments)
    plt.switch_backend("Agg")

    def work():
        history = History(options.result)
        directory = os.path.dirname(os.path.abspath(history.file))
        file = options.output or os.path.join(directory, "history.png")
        of = None if options.of is None else ",".join(options.of)
        columns = [] if of is None else [name.strip() for name in of.split(",")]
        if not all(columns):
            raise PliantError(f"--of '{of}': a name is missing; columns are separated by commas, as in --of tip_z,kinetic_energy")
        for option, names in (("of", columns), ("x", [options.x] if options.x else [])):
            for name in names:
                require(history, option, name)
        if options.x and not columns:
            raise PliantError("--x needs the columns to draw over it: --of COLUMN,...")
        with plt.rc_context(STYLE):
            figure = draw(history, title_of(directory), columns_from_fields(directory), counted(directory), columns, options.x)
            figure.savefig(file, dpi=150)
        print(file)

    return exit_code(program, work, PliantError, options.output, ".png, .pdf or .svg")
