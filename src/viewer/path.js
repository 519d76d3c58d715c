// The path of a static analysis: the load factor over what it moves, unstable parts dashed, with a mark that follows the player.
import { extent, handyUnit, largest, short, span, ticks, typeset } from "./numbers.js";

const WIDTH = 420, HEIGHT = 236, LEFT = 52, RIGHT = 12, TOP = 8, BOTTOM = 34;

/// What a path moves: title, unit, values; of each probe the component of its displacement that changes most, with the sign
/// that it has at the end, and the volumes of cavities.
export function waysOf(history) {
  const ways = [];
  for (const name of history.keys()) {
    const probe = name.endsWith("_ux") && name.slice(0, -3);
    if (probe) {
      const axis = [..."xyz"].sort((a, b) => extent(history.get(`${probe}_u${b}`)) - extent(history.get(`${probe}_u${a}`)))[0];
      const values = history.get(`${probe}_u${axis}`), sign = values.at(-1) < 0 ? -1 : 1;
      ways.push({ title: `${sign < 0 ? "\u2212" : ""}u${axis} of ${probe}`, unit: "m", values: Array.from(values, (x) => sign * x) });
    } else if (name.endsWith("_volume") && history.has(name.replace(/_volume$/, "_pressure"))) {
      ways.push({ title: `volume of ${name.replace(/_volume$/, "")}`, unit: "m^3", values: Array.from(history.get(name)) });
    }
  }
  return ways.filter(({ values }) => extent(values) > 0).slice(0, 4);
}

export class PathPlot {
  /// `way`: as of waysOf; a click seeks the nearest state.
  constructor(place, history, way, seek) {
    this.time = history.get("time");
    const load = history.get("load_factor"), unstable = history.get("unstable_modes");
    const [factor, unit] = handyUnit(way.unit, largest(way.values));
    const x = way.values.map((v) => v / factor), [left, right] = span(x), [low, high] = span(load);
    const column = (v) => LEFT + ((v - left) / (right - left)) * (WIDTH - LEFT - RIGHT);
    const row = (v) => HEIGHT - BOTTOM - ((v - low) / (high - low || 1)) * (HEIGHT - TOP - BOTTOM);
    this.points = x.map((v, k) => [column(v), row(load[k])]);
    const text = (at, anchor, words) => `<text x="${at[0].toFixed(1)}" y="${at[1].toFixed(1)}" text-anchor="${anchor}">${words}</text>`;
    const rule = (a, b) => `<path d="M${a[0].toFixed(1)} ${a[1].toFixed(1)}L${b[0].toFixed(1)} ${b[1].toFixed(1)}" class="rule"/>`;
    const across = ticks(low, high || 1).map((v) => rule([LEFT, row(v)], [WIDTH - RIGHT, row(v)]) + text([LEFT - 6, row(v) + 4], "end", short(v)));
    const down = ticks(left, right).map((v) => rule([column(v), TOP], [column(v), HEIGHT - BOTTOM]) + text([column(v), HEIGHT - BOTTOM + 14], "middle", short(v)));
    const pieces = this.points.slice(1).map(([a, b], k) => {
      const [c, d] = this.points[k];
      return `<path d="M${c.toFixed(1)} ${d.toFixed(1)}L${a.toFixed(1)} ${b.toFixed(1)}" class="${unstable?.[k + 1] > 0 ? "unstable" : "stable"}"/>`;
    });
    const card = document.createElement("figure");
    card.innerHTML = `<figcaption><b>Load factor</b> <span></span></figcaption><svg class="path" viewBox="0 0 ${WIDTH} ${HEIGHT}">` +
      `${across.join("")}${down.join("")}${pieces.join("")}<circle r="4.5"/></svg>`;
    card.querySelector("span").textContent = `over ${way.title} [${typeset(unit)}]${unstable?.some((n) => n > 0) ? ", dashed where unstable" : ""}`;
    place.append(card);
    const svg = card.querySelector("svg");
    this.dot = card.querySelector("circle");
    svg.addEventListener("click", (event) => {
      const box = svg.getBoundingClientRect(), scale = WIDTH / box.width;
      const far = ([a, b]) => Math.hypot(a - scale * (event.clientX - box.left), b - scale * (event.clientY - box.top));
      const nearest = this.points.reduce((best, p, k) => (far(p) < far(this.points[best]) ? k : best), 0);
      seek(this.time[nearest]);
    });
  }

  mark(time) {
    let k = this.time.findLastIndex((t) => t <= time);
    if (k < 0) k = 0;
    const [a, b] = this.points[k], [c, d] = this.points[k + 1] ?? this.points[k];
    const part = k + 1 < this.points.length ? (time - this.time[k]) / (this.time[k + 1] - this.time[k]) : 0;
    this.dot.setAttribute("cx", a + part * (c - a));
    this.dot.setAttribute("cy", b + part * (d - b));
  }
}
