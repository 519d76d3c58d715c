"""What notebooks show of runs and their results: tables and small pictures as HTML."""
import base64
import html
import io
import json
import os
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from .error import PliantError

if TYPE_CHECKING:
    from .history import History
    from .result import Frame, Mesh, Result
    from .runs import Run

ENERGIES = ("kinetic_energy", "elastic_energy", "load_potential", "dissipated_energy", "load_work")
COUNTED = ("step", "newton_iterations", "linear_iterations", "contact_points")
MOST_CELLS, MOST_TRIANGLES = 500_000, 60_000  # of a small picture; more take longer than a second
VIEW = np.array([0.62, -1.0, 0.48])  # from where it looks

# A run is shown although its files were moved or removed since.
UNREADABLE = (PliantError, OSError, KeyError, ValueError, RuntimeError)

Rows = Iterable["tuple[str, str]"]


# -------------------------------------------------------------------------------------------------------- in one line


def instants(file: str) -> str:
    """What the times in a history.csv or result.h5 are called: "t", of a static run "load factor" or "length of the path"."""
    try:
        from .pictures.analysis import counted  # which needs PyYAML

        return {"load": "load factor", "path": "length of the path"}.get(counted(os.path.dirname(file)), "t")
    except ImportError:
        return "t"


def at_time(time: float, file: str) -> str:
    return f"t = {time:g}" if (name := instants(file)) == "t" else f"{name} {time:g}"


def of_times(times: np.ndarray, file: str) -> str:
    """Without a unit."""
    return f"{at_time(times[0], file)} to {times[-1]:g}" if len(times) > 1 else at_time(times[0], file)


def plural(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def elements_of(mesh: "Mesh", order: str = "") -> str:
    """How many there are of each kind; `order`: of the tetrahedra. Cells stand for segments of rods, triangles of shells and rigid bodies."""
    of_body = np.bincount(mesh.body, minlength=len(mesh.body_names))
    count = {name: int(of_body[np.isin(mesh.body_names, names)].sum()) for name, names in
             (("triangle", mesh.shells), ("segment", mesh.rods), ("", [*mesh.sections, *mesh.masses]))}
    tetrahedra = len(mesh.cells) - sum(count.values())
    found = [plural(tetrahedra, f"{order} tetrahedron".strip()).replace("tetrahedrons", "tetrahedra")] if tetrahedra else []
    found += [plural(count[kind], kind) + of for kind, of in (("triangle", " of shells"), ("segment", " of rods")) if count[kind]]
    return ", ".join(found) or "rigid bodies alone"


def result_in_a_line(result: "Result") -> str:
    parts = [plural(len(result), "frame"), of_times(result.times, result.file)]
    if result.h5:  # it is open
        parts.append(elements_of(result[-1].mesh))
    return f"Result({result.file!r}: {', '.join(parts)})"


def history_in_a_line(history: "History") -> str:
    return f"History({history.file!r}: {plural(len(history.time), 'row')}, {of_times(history.time, history.file)}, {plural(len(history), 'column')})"


def run_in_a_line(run: "Run") -> str:
    try:
        summary, end = run.summary, run.history.time[-1]
    except UNREADABLE:
        return f"Run({run.directory!r})"
    steps = plural(summary["steps"]["accepted"], "step")
    return f"Run({run.directory!r}: {summary['outcome']}, {steps} to {at_time(end, run.history.file)} in {summary['seconds']['total']:.3g} s)"


# ------------------------------------------------------------------------------------------------------------ as HTML


# Columns of joints: what motors, springs, dampers, friction, bearings and stops exert.
EFFORTS = ("_effort", "_spring", "_damping", "_friction", "_bearing", "_stops")


def unit_of(column: str, history: "Iterable[str]" = ()) -> str:
    """The unit of a column of the history, as docs/output.md has it; empty if it is a number or unknown. `history`: all of its columns, which
    say whether a joint is a hinge or a slider."""
    for ending, of_angle, of_travel in (*((ending, "N m", "N") for ending in EFFORTS), ("_rate", "rad/s", "m/s")):
        if column.endswith(ending):
            joint = column[: -len(ending)]
            if f"{joint}_angle" in history or f"{joint}_travel" in history:
                return of_angle if f"{joint}_angle" in history else of_travel
    if column.endswith(("_energy", "_work", "_dissipation")) or column.startswith("dissipated_") or column in (
            "load_potential", "energy_balance_error"):
        return "J"
    if column in ("time", "dt"):
        return "s"
    if column in ("px", "py", "pz"):
        return "kg m/s"
    if column in ("Lx", "Ly", "Lz"):
        return "kg m²/s"
    for endings, unit in ((("_x", "_y", "_z", "gap_min"), "m"), (("_vx", "_vy", "_vz"), "m/s"), (("_wx", "_wy", "_wz"), "rad/s"), (("_fx", "_fy", "_fz"), "N"),
                          (("_tx", "_ty", "_tz"), "N m"), (("_jx", "_jy", "_jz"), "N s"), (("_pressure",), "Pa"), (("_volume",), "m³"),
                          (("_ux", "_uy", "_uz", "_length", "_travel"), "m"), (("_tension", "_force"), "N"), (("_angle",), "rad")):
        if column.endswith(endings):
            return unit
    return ""


def number(value: float, unit: str = "") -> str:
    return f"{value:.6g} {unit}".strip()


def card(title: str, rows: Rows, picture: "Optional[str]" = None, more: str = "") -> str:
    """A heading, a table of names and values, and next to it a picture."""
    cells = "".join(f'<tr><th style="text-align:left;font-weight:600;vertical-align:top">{html.escape(name)}</th>'
                    f'<td style="text-align:left">{html.escape(value)}</td></tr>' for name, value in rows)
    drawn = "" if picture is None else f'<div style="flex:none">{picture}</div>'
    return (f'<div class="pliant"><p style="font-weight:600;margin:0 0 4px">{html.escape(title)}</p>'
            f'<div style="display:flex;flex-wrap:wrap;gap:16px;align-items:flex-start"><table>{cells}</table>{drawn}</div>{more}</div>')


def folded(title: str, content: str) -> str:
    return f"<details><summary>{html.escape(title)}</summary>{content}</details>"


def table(header: "Sequence[str]", rows: "Iterable[Sequence[str]]") -> str:
    """A table whose first column is left-aligned, and the others, which hold numbers, right-aligned."""
    def line(tag: str, texts: "Sequence[str]") -> str:
        side = ("left",) + ("right",) * (len(texts) - 1)
        return "<tr>" + "".join(f'<{tag} style="text-align:{s}">{html.escape(t)}</{tag}>' for s, t in zip(side, texts)) + "</tr>"
    return "<table>" + line("th", header) + "".join(line("td", row) for row in rows) + "</table>"


def files_of(directory: str) -> str:
    """The names of what is there, and how large it is."""
    if not os.path.isdir(directory):
        return "they were moved or removed since"
    found = []
    for name in sorted(os.listdir(directory)):
        path = os.path.join(directory, name)
        if os.path.isfile(path):
            size = os.path.getsize(path)
            found.append(f"{name} ({size / 1e3:.3g} kB)" if size < 1e6 else f"{name} ({size / 1e6:.3g} MB)")
    return ", ".join(found[:12]) + (f" and {len(found) - 12} more" if len(found) > 12 else "")


def history_rows(history: "History") -> "list[tuple[str, str]]":
    """Energies and the last values of probes."""
    rows = []
    for name in (*ENERGIES, "numerical_dissipation"):
        if name in history and np.any(history[name] != 0):
            rows.append((name.replace("_", " "), number(history[name][-1], "J")))
    if "energy_balance_error" in history:
        rows.append(("energy balance error", number(history["energy_balance_error"][-1], "J")))
    for name in history:
        stem = name[:-1]
        if name.endswith("_x") and all(stem + axis in history for axis in ("y", "z", "vx")):
            rows.append((stem[:-1], "(" + ", ".join(number(history[stem + axis][-1]) for axis in "xyz") + ") m at the end"))
    return rows


def history_as_html(history: "History") -> str:
    rows = [("file", history.file), ("rows", f"{len(history.time):,}, {of_times(history.time, history.file)}"), *history_rows(history)]
    counts = instants(history.file) != "t"
    columns = [(name, "" if counts and name in ("time", "dt") else unit_of(name, history), *(number(f(history[name])) for f in (lambda v: v[0], lambda v: v[-1], np.min, np.max)))
               for name in history if name not in COUNTED]
    every = table(("column", "unit", "first", "last", "smallest", "largest"), columns)
    return card("History", rows, picture_of_history(history), folded(f"all {len(columns)} columns", every))


def result_as_html(result: "Result") -> str:
    if not result.h5:
        return card(result.title or "Result", [("file", result.file), ("frames", f"{len(result)}, {of_times(result.times, result.file)}"), ("state", "closed")])
    last, mesh = result[-1], result[-1].mesh
    kind = "quadratic" if mesh.cells.shape[1] == 10 else "linear"
    rows = [("file", result.file), ("frames", f"{len(result)}, {of_times(result.times, result.file)}"),
            ("mesh", f"{elements_of(mesh, kind)}, {len(mesh.coordinates):,} nodes"), ("bodies", ", ".join(mesh.bodies_with_surface) or "-")]
    if last.obstacles is not None:
        rows.append(("obstacles", ", ".join(last.obstacles.names)))
    if last.mechanisms is not None:
        rows.append(("mechanisms", ", ".join(last.mechanisms.names)))
    for name in last.field_names:
        if name not in ("body", "rank"):
            field = last.field(name)
            rows.append((name.replace("_", " "), f"{extent(field.values)} {field.unit} at the end".replace("  ", " ")))
    return card(result.title or "Result", [*rows, *told_by(result.directory)], picture_of_frame(last))


def told_by(directory: str) -> "list[tuple[str, str]]":
    """Warnings and notes of the run whose result is in this directory; none while it is active."""
    try:
        with open(os.path.join(directory, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        return [(kind, str(text)) for kind in ("warning", "note") for text in summary.get(f"{kind}s", [])]
    except (OSError, ValueError, AttributeError, TypeError):
        return []


def extent(values: np.ndarray) -> str:
    """From the smallest to the largest value or component; the largest length of vectors."""
    finite = values[np.isfinite(values).all(axis=1)]
    if len(finite) == 0:
        return "not finite"
    if values.shape[1] == 3:
        return f"up to {np.linalg.norm(finite, axis=1).max():.4g}"
    return f"{'components ' if values.shape[1] > 1 else ''}{finite.min():.4g} to {finite.max():.4g}"


def run_as_html(run: "Run") -> str:
    rows = [("directory", run.directory)]
    try:
        summary, history = run.summary, run.history
    except UNREADABLE:
        return card("Run", [*rows, ("state", "its files cannot be read")])
    seconds = summary["seconds"]["total"]
    rows += [("input", os.path.join(run.directory, "run.yaml")),
             ("outcome", f"{summary['outcome']} after {seconds:.3g} s on {plural(summary['ranks'], 'rank')}"),
             ("steps", f"{summary['steps']['accepted']:,} to {at_time(history.time[-1], history.file)}, {summary['solver']['newton_iterations']:,} Newton iterations"),
             *told_by(run.directory),
             *history_rows(history), ("files", files_of(run.directory))]
    picture = picture_of_history(history)
    title = "Run"
    try:
        title = run.result.title or title
        body = picture_of_frame(run.result[-1])
        picture = body if picture is None else picture + (body or "")
    except UNREADABLE:
        pass
    log = folded("what the program printed", f"<pre>{html.escape(run.log)}</pre>") if run.log else ""
    return card(title, rows, picture, log)


# ----------------------------------------------------------------------------------------------------------- pictures


def _figure(width: float, height: float) -> "Optional[Any]":
    """A figure of matplotlib, apart from those of the user; None where matplotlib is not installed. Sizes in inches."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        return None
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _image(figure: Any, words: str) -> str:
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=100)
    return f'<img alt="{html.escape(words)}" src="data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}"/>'


def picture_of_history(history: "History") -> "Optional[str]":
    """Energies over time."""
    shown = [name for name in ENERGIES if name in history and np.ptp(history[name]) > 0]
    figure = _figure(3.6, 2.4) if shown and len(history.time) > 1 else None
    if figure is None:
        return None
    axes = figure.add_subplot()
    for name in shown:
        axes.plot(history.time, history[name], label=name.replace("_", " "), linewidth=1.4)
    axes.set_xlabel("time [s]" if (name := instants(history.file)) == "t" else name, fontsize=8)
    axes.set_ylabel("energy [J]", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return _image(figure, "energies over time")


def picture_of_frame(frame: "Frame") -> "Optional[str]":
    """The bodies in their current shape, coloured by the length of the displacement; None where that would take long."""
    from .surface import Surface  # which needs results

    if len(frame.mesh.cells) > MOST_CELLS:
        return None
    surface = Surface(frame.mesh, divisions=1)
    figure = _figure(3.2, 2.4) if 0 < len(surface.triangles) <= MOST_TRIANGLES else None
    if figure is None:
        return None
    import matplotlib
    from matplotlib.collections import PolyCollection

    u = frame.displacement()
    x = surface.of_nodes(frame.mesh.coordinates + u)
    back = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    axes_of_view = np.stack([right, np.cross(back, right), back])
    corners = (x @ axes_of_view.T)[surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    length = np.linalg.norm(surface.of_nodes(u), axis=1)
    share = length[surface.triangles].mean(axis=1) / (length.max() or 1)
    light = np.clip(0.45 + 0.55 * normals @ np.array([-0.35, 0.55, 0.76]), 0.25, 1)
    colours = matplotlib.colormaps["viridis"](0.15 + 0.85 * share)[:, :3] * light[:, None]
    order = np.nonzero(normals[:, 2] > 0)[0]
    order = order[np.argsort(corners[order, :, 2].mean(axis=1))]  # those nearest to the viewer last
    axes = figure.add_subplot(aspect="equal")
    axes.set_axis_off()
    now = at_time(frame.time, frame.result.file)
    axes.add_collection(PolyCollection(corners[order, :, :2], facecolors=colours[order], edgecolors=colours[order], linewidths=0.3))
    axes.autoscale_view()
    axes.set_title(f"{now}, displacement up to {length.max():.3g} m", fontsize=8)
    return _image(figure, f"the bodies at {now}, coloured by displacement")


# --------------------------------------------------------------------------------------------------------- the report


def is_notebook() -> bool:
    """Does a notebook run this? Its shell has a kernel; that of a terminal has none."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None else None
    return hasattr(shell, "kernel")


def show_page(file: "Union[str, os.PathLike[str]]", height: int) -> None:
    """The page in a frame of the notebook, which then holds all of it."""
    from IPython.display import HTML, display

    with open(file, encoding="utf-8") as page:
        content = html.escape(page.read(), quote=True)
    display(HTML(f'<div><iframe title="report" srcdoc="{content}" style="width:100%;height:{height}px;border:1px solid #8884"></iframe></div>'))
