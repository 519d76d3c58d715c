// The history as plots that follow the player: a click on one sets its time.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { extent, handyUnit, inWords, largest, short, spelt, typeset, unitOfTimes } from "./numbers.js";
import { PathPlot, waysOf } from "./path.js";

const COLOURS = ["#4a80c9", "#d9693f", "#43a874", "#9670c6", "#c79a2b", "#4aa5b5", "#bd5a86", "#7d8693"];
const ENERGIES = ["kinetic_energy", "elastic_energy", "load_potential", "dissipated_energy", "numerical_dissipation", "load_work"];
const LAST_LABEL = 24;  // half of what is below the end of the axis of times [pixels]

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
/// Those of the lines that vary by more than rounding, relative to the others.
function varying(lines) {
  const most = Math.max(0, ...lines.map(([, values]) => Math.max(extent(values), 1e-6 * largest(values))));
  return lines.filter(([, values]) => extent(values) > 1e-6 * most);
}

/// Where in ascending numbers.
function nearest(values, x) {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle;
    else high = middle;
  }
  return x - values[low] < values[high] - x ? low : high;
}

/// Names of which the history has all three columns, e.g. `tip` for tip_x, tip_y, tip_z.
function triples(history, suffixes) {
  return [...history.keys()].filter((name) => name.endsWith(suffixes[0])).map((name) => name.slice(0, -suffixes[0].length))
    .filter((stem) => stem && suffixes.every((s) => history.has(stem + s)));
}

/// Whether an obstacle's force on its only body is that of the obstacle, which is among the names.
function isRepeated(history, name, names, suffixes) {
  return names.some((whole) => name.startsWith(`${whole}_`) &&
    suffixes.every((s) => history.get(name + s).every((value, k) => value === history.get(whole + s)[k])));
}

/// Columns of tendons, springs, joints and motors: their ending, the title over them, their unit; `with`: the ending of another column
/// that their joint has.
const MECHANISMS = [
  { ending: "_tension", title: "Tension of tendons", unit: "N" }, { ending: "_force", title: "Force of springs", unit: "N" },
  { ending: "_length", title: "Length of tendons and springs", unit: "m" }, { ending: "_angle", title: "Angles of joints", unit: "rad" },
  { ending: "_travel", title: "Travel of joints", unit: "m" },
  ...[["_effort", "motors"], ["_spring", "springs of joints"], ["_damping", "dampers of joints"], ["_friction", "friction in joints"],
    ["_bearing", "friction in bearings"], ["_stops", "stops of joints"]].flatMap(
    ([ending, of]) => [{ ending, title: `Torques of ${of}`, unit: "N m", with: "_angle" }, { ending, title: `Forces of ${of}`, unit: "N", with: "_travel" }]),
];

function* plotsOfMechanisms(history, taken) {
  for (const { ending, title, unit, with: other } of MECHANISMS) {
    const stems = [...history.keys()].filter((name) => name.endsWith(ending) && !taken.some(({ column }) => column === name))
      .map((name) => name.slice(0, -ending.length)).filter((stem) => stem && (!other || history.has(stem + other)));
    const lines = varying(stems.map((stem) => [stem, history.get(stem + ending)]));
    if (lines.length) yield { title, unit, lines };
  }
}

/// Dashed is a second run, dotted what has the colour of an earlier line.
const dashes = (isDashed, i) => (isDashed ? { dash: [6, 4] } : i >= COLOURS.length ? { dash: [2, 3] } : {});

/// What is to be plotted: title, unit, lines of name and values.
function* plotsOf(history, { isStatic, taken }) {
  const energies = ENERGIES.filter((n) => history.has(n) && largest(history.get(n)) > 0);
  if (energies.length) {
    yield { title: "Energies", unit: "J", lines: energies.map((n) => [spelt(n).replace(/ energy$/, ""), history.get(n)]) };
    const turnover = Math.max(...energies.map((n) => extent(history.get(n))));
    const error = history.get("energy_balance_error");
    if (error && turnover > 0) {
      yield { title: "Energy balance", unit: "", note: "error / largest energy change",
              lines: [["error", error.map((e) => e / turnover)]], colour: 1 };
    }
  }
  for (const probe of triples(history, ["_x", "_y", "_z", "_vx"])) {
    const lines = varying([..."xyz"].map((k, i) => [k, history.get(`${probe}_${k}`).map((x, _, all) => x - all[0]), i]));
    const isBody = history.has(`${probe}_qw`);  // a rigid body has a rotation, too
    if (lines.length) yield { title: `${isBody ? "Body" : "Probe"} ${probe}`, note: `${isBody ? "center " : ""}moved from the start`, unit: "m", lines };
  }
  // What a solver's tolerance leaves where forces balance, as on a closed chamber: they do no such work over a metre.
  const least = 1e-7 * Math.max(0, ...["elastic_energy", "load_work", "support_work"].filter((n) => history.has(n)).map((n) => largest(history.get(n))));
  for (const [suffixes, what, unit] of [[["_fx", "_fy", "_fz"], "Force at", "N"], [["_tx", "_ty", "_tz"], "Torque at", "N m"]]) {
    const names = triples(history, suffixes);
    for (const name of names) {
      const lines = varying(suffixes.map((s, i) => ["xyz"[i], history.get(name + s), i]));
      if (isRepeated(history, name, names, suffixes) || !lines.some(([, values]) => extent(values) > least)) continue;
      yield { title: `${what} ${name}`, unit, lines };
    }
  }
  for (const name of [...history.keys()].filter((n) => n.endsWith("_pressure") && history.has(n.replace(/_pressure$/, "_volume")))) {
    const cavity = name.replace(/_pressure$/, "");
    yield { title: `Pressure in ${cavity}`, unit: "Pa", lines: [["gauge pressure", history.get(name)]] };
    yield { title: `Volume of ${cavity}`, unit: "m^3", lines: [["volume", history.get(`${cavity}_volume`)]], colour: 2 };
  }
  yield* plotsOfMechanisms(history, taken);
  if (history.has("load_factor")) yield { title: "Load factor", unit: "", lines: [["load", history.get("load_factor")]] };
  const linear = history.has("px") ? varying([..."xyz"].map((k, i) => [k, history.get(`p${k}`), i])) : [];
  if (linear.length) yield { title: "Momentum", unit: "N s", lines: linear };
  for (const { column, title, unit } of taken) {
    if (history.has(column)) yield { title: column, note: inWords(title), unit, lines: [[column, history.get(column)]], colour: 3 };
  }
  const coarse = history.get("discretization_error");
  if (coarse) yield { title: "Discretization error", note: "share of the elastic energy", unit: "", lines: [["error", coarse]], zero: true, colour: 1 };
  const newton = history.get("newton_iterations");
  if (newton?.length > 1) yield { title: "Newton iterations", note: "per step", unit: "", lines: [["iterations", newton]], steps: true, zero: true };
  const dt = history.get("dt");
  if (dt?.length > 2 && !isStatic) yield { title: "Time step", unit: "s", lines: [["dt", dt]], steps: true, zero: true, colour: 2 };
}

/// Values at other times: linear between, those of the next row in steps; none outside.
function at(times, values, wanted, isStepped) {
  let i = 0;
  return wanted.map((t) => {
    while (i < times.length && times[i] < t) ++i;
    if (i === times.length || (i === 0 && times[0] > t)) return NaN;
    if (isStepped || times[i] === t) return values[i];
    const share = (t - times[i - 1]) / (times[i] - times[i - 1]);
    return values[i - 1] + share * (values[i] - values[i - 1]);
  });
}

/// Plots of two histories: those of the same title in one, the second run dashed. `names`: of the runs.
function* plotsOfBoth(history, others, options) {
  const [time, otherTime] = [history, others.history].map((h) => h.get("time"));
  const both = Float64Array.from(new Set([...time, ...otherTime])).sort();
  const of = (plots) => new Map([...plots].map((plot) => [plot.title, plot]));
  const [own, other] = [of(plotsOf(history, options)), of(plotsOf(others.history, options))];
  for (const title of new Set([...own.keys(), ...other.keys()])) {
    const plot = own.get(title) ?? other.get(title), lines = [];
    [[own, time], [other, otherTime]].forEach(([plots, times], run) => plots.get(title)?.lines.forEach(([name, values, colour], i) =>
      lines.push([`${name} · ${others.names[run]}`, at(times, values, both, plot.steps), colour ?? (plot.lines.length > 1 ? i : plot.colour ?? i), undefined, run === 1])));
    yield [{ ...plot, lines }, both];
  }
}

/// `seek(time)` is called when a plot is clicked.
export class Plots {
  constructor(place, history, { isStatic, taken, others, seek }) {
    const time = history.get("time"), last = Math.max(...[history, others?.history].map((h) => h?.get("time")?.at(-1) ?? 0));
    const [timeFactor, unit] = isStatic ? [1, ""] : unitOfTimes(last);
    Object.assign(this, { place, seek, made: [], timeFactor, timeLabel: { load: "load factor", path: "length of the path" }[isStatic] ?? `time [${unit}]`, paths: [] });
    this.sync = uPlot.sync("history");
    if (others && time?.length && others.history.get("time")?.length) {
      for (const [plot, times] of [...plotsOfBoth(history, others, { isStatic, taken })].slice(0, 40)) this.add(plot, times);
    } else if (time?.length) {
      if (time.length > 1 && history.has("load_factor")) this.paths = waysOf(history).map((way) => new PathPlot(place, history, way, seek));
      for (const plot of [...plotsOf(history, { isStatic, taken })].slice(0, 40)) this.add(plot, time);
    }
    new ResizeObserver(() => this.resize()).observe(place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.made.forEach(({ chart }) => chart.redraw(false, true)));
  }

  /// `plot`: as of plotsOf; `first`: before the others. What `remove` takes.
  add(plot, time) {
    const card = document.createElement("figure");
    // In steps the first row is the initial state, which took none.
    const from = plot.steps ? 1 : 0;
    const values = plot.lines.map(([, v]) => v.subarray ? v.subarray(from) : v.slice(from));
    const [factor, unit] = handyUnit(plot.unit, Math.max(...values.map(largest)));
    const caption = document.createElement("figcaption");
    const label = [plot.note, unit && `[${typeset(unit)}]`].filter(Boolean).join(" ");
    caption.innerHTML = "<b></b> <span></span>";
    caption.children[0].textContent = plot.title;
    caption.children[1].textContent = label;
    const box = document.createElement("div");
    card.append(caption, box);
    this.place[plot.first ? "prepend" : "append"](card);
    const axis = (more) => ({
      stroke: () => styleOf("--faint"), grid: { stroke: () => styleOf("--rule"), width: 1 }, ticks: { show: false },
      font: "11px " + styleOf("--font"), ...more,
    });
    const show = (u, v) => (v == null ? "" : short(v));
    const strokes = [null, ...plot.lines.map(([, , colour, own], i) => own ?? COLOURS[(colour ?? plot.colour ?? i) % COLOURS.length])];
    const chart = new uPlot({
      width: this.width(), height: 210, padding: [8, LAST_LABEL, 0, 0],
      cursor: { sync: { key: "history", setSeries: false }, points: { size: 6 }, drag: { x: true, y: false } },
      legend: { live: true, markers: { fill: (u, i) => strokes[i] } },
      scales: { x: { time: false }, y: plot.zero ? { range: (u, low, high) => [0, (high || 1) * 1.15] } : {} },
      axes: [axis({ size: 30, values: (u, v) => v.map((x) => short(x / this.timeFactor)) }),
             axis({ size: 58, values: (u, v) => v.map((x) => short(x)) })],
      series: [{ label: this.timeLabel, value: (u, v) => (v == null ? "" : short(v / this.timeFactor)) },
               ...plot.lines.map(([name, , , , isDashed], i) => ({
                 label: name, value: show, stroke: strokes[i + 1], width: 1.7, points: { show: false }, ...dashes(isDashed, i),
                 ...(plot.steps && { paths: uPlot.paths.stepped({ align: -1 }) }),
               }))],
      hooks: { ready: [(u) => this.watch(u, this.seek), () => queueMicrotask(() => this.time !== undefined && this.mark(this.time))] },
    }, [time.subarray(from), ...values.map((v) => Array.from(v, (x) => (Number.isFinite(x) ? x / factor : null)))], box);
    const marker = document.createElement("div");
    marker.className = "now";
    chart.over.append(marker);
    const made = { chart, marker, card };
    this.made.push(made);
    return made;
  }

  remove(made) {
    this.made = this.made.filter((other) => other !== made);
    this.sync.unsub(made.chart);
    made.chart.destroy();
    made.card.remove();
  }

  /// A click without a drag sets the time; a drag zooms, a double click takes it back.
  watch(chart, seek) {
    let down = 0;
    chart.over.addEventListener("mousedown", (event) => (down = event.clientX));
    chart.over.addEventListener("mouseup", (event) => {
      if (Math.abs(event.clientX - down) < 3) seek(chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, "x"));
    });
  }

  width() {
    const style = getComputedStyle(this.place), columns = style.gridTemplateColumns.split(" ").length;
    const gap = parseFloat(style.columnGap) || 0;
    return Math.max(220, Math.floor((this.place.clientWidth - gap * (columns - 1)) / columns) - 26);
  }

  resize() {
    const width = this.width();
    for (const { chart } of this.made) if (chart.width !== width) chart.setSize({ width, height: 210 });
    if (this.time !== undefined) this.mark(this.time);
  }

  /// A line at that time, and its values below, unless the pointer asks for others.
  mark(time) {
    this.time = time;
    for (const path of this.paths) path.mark(time);
    for (const { chart, marker } of this.made) {
      marker.style.transform = `translateX(${chart.valToPos(time, "x")}px)`;
      if (!(chart.cursor.left >= 0)) chart.setLegend({ idx: nearest(chart.data[0], time) });
    }
  }
}
