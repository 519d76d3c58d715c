// Points of the bodies that are marked on the drawing: the extremes of the colour field, and those that were clicked, with
// their values and a plot of their history.
import { Vector3 } from "three";
import { element } from "./elements.js";
import { handyUnit, short, spelt, typeset } from "./numbers.js";

const COLOURS = ["#d9693f", "#4a80c9", "#43a874", "#9670c6"];  // of clicked points; there are at most so many
const REACH = 12;  // [pixels] of a click around a mark
const AXES = [0, 1, 2];

/// The vertex next to where a ray meets triangles first, or -1. `hides(x, y, z)`: what is not met.
export function vertexOnRay(from, along, x, index, hides) {
  let nearest = Infinity, found = -1;
  const a = new Vector3(), b = new Vector3(), c = new Vector3(), hit = new Vector3(), normal = new Vector3(), side = new Vector3();
  for (let t = 0; t < index.length; t += 3) {
    a.fromArray(x, 3 * index[t]);
    b.fromArray(x, 3 * index[t + 1]).sub(a);
    c.fromArray(x, 3 * index[t + 2]).sub(a);
    // from + s along = a + p b + q c (Moeller & Trumbore 1997)
    normal.crossVectors(along, c);
    const det = b.dot(normal);
    if (det === 0) continue;
    hit.subVectors(from, a);
    const p = hit.dot(normal) / det;
    if (p < 0 || p > 1) continue;
    side.crossVectors(hit, b);
    const q = along.dot(side) / det, s = c.dot(side) / det;
    if (q < 0 || p + q > 1 || s <= 0 || s >= nearest) continue;
    hit.copy(from).addScaledVector(along, s);
    if (hides(hit.x, hit.y, hit.z)) continue;
    nearest = s;
    found = index[t + (1 - p - q >= p && 1 - p - q >= q ? 0 : p >= q ? 1 : 2)];
  }
  return found;
}

export class Points {
  /// `marks`, `table`: elements of the page; `plots`: where the history is drawn.
  constructor(view, panel, plots, { marks, table }) {
    Object.assign(this, { view, panel, plots, place: marks, table, picked: [], extremes: [] });
    view.moved = (at) => this.move(at);
    panel.painted = () => this.plot();
    let down = null;
    view.canvas.addEventListener("pointerdown", (event) => (down = event.button === 0 && event.isPrimary ? [event.clientX, event.clientY] : null));
    view.canvas.addEventListener("pointerup", (event) => {
      const still = event.pointerType === "touch" ? 10 : 4;  // [pixels]
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < still) this.click(event.clientX, event.clientY);
      down = null;
    });
  }

  /// A click picks the vertex below it, or drops the picked one there.
  async click(clientX, clientY) {
    const { view } = this, box = view.canvas.getBoundingClientRect(), [x, y] = [clientX - box.left, clientY - box.top];
    const near = this.picked.find((point) => point.mark && Math.hypot(point.mark.x - x, point.mark.y - y) < REACH);
    if (near) return this.drop(near);
    const from = view.camera.position.clone();
    const along = new Vector3((2 * x) / box.width - 1, 1 - (2 * y) / box.height, 0.5).unproject(view.camera).sub(from).normalize();
    const { body, clear } = view.drawn[view.at.surface.number], hides = (...p) => view.clip.hides(...p);
    const [solid, seen] = [body, clear].map((mesh) => vertexOnRay(from, along, view.positions.array, mesh.geometry.index.array, hides));
    const vertex = solid >= 0 ? solid : seen;
    if (vertex < 0) return;
    // Its row shows every field: these are unpacked before a drawing of the point can ask for them.
    const { bodies } = view, { surface } = view.at;
    await Promise.all(bodies.fields.map((_, i) => bodies.need(i)));
    if (view.bodies !== bodies) return;  // a page that watches its run has others now
    const same = this.picked.find((point) => point.vertex === vertex && point.surface === surface);
    if (same) return this.drop(same);
    if (this.picked.length === COLOURS.length) this.picked.shift();
    const colour = COLOURS.find((c) => !this.picked.some((point) => point.colour === c));
    this.picked.push({ vertex, surface, colour });
    this.change();
  }

  drop(point) {
    this.picked = this.picked.filter((other) => other !== point);
    this.change();
  }

  change() {
    this.plot();
    this.view.set({});
  }

  /// Everything that depends on the time.
  move(at) {
    this.findExtremes(at);
    this.marks = [];
    for (const { vertex, text } of this.extremes) this.marks.push({ vertex, text, className: "mark extreme" });
    this.picked.forEach((point, i) => {
      point.mark = null;
      if (point.surface !== at.surface || !this.view.isShown(at.surface, point.vertex)) return;
      point.mark = { vertex: point.vertex, text: String(i + 1), className: "mark picked", colour: point.colour };
      this.marks.push(point.mark);
    });
    this.place.replaceChildren(...this.marks.map((mark) => {
      mark.element = element("div", { className: mark.className }, element("i"), element("span", { textContent: mark.text }));
      if (mark.colour) mark.element.style.setProperty("--mark", mark.colour);
      return mark.element;
    }));
    this.fill(at);
  }

  /// Lowest and highest value of the colours now, of the bodies that are shown and have the field.
  findExtremes(at) {
    this.extremes = [];
    const { values } = this.view, { shown } = this.panel;
    if (!this.panel.marksExtremes || !values || !shown.kind) return;
    const { absent } = (this.panel.byField && this.panel.bodies.fields[this.panel.now.field]) || {}, isWithout = (v) => absent?.includes(at.surface.bodies[v]);
    let low = -1, high = -1;
    for (let v = 0; v < values.length; ++v) {
      if (isWithout(v)) continue;
      if (!(low < 0 || values[v] < values[low] || values[v] > values[high]) || !this.view.isShown(at.surface, v)) continue;
      if (low < 0 || values[v] < values[low]) low = v;
      if (high < 0 || values[v] > values[high]) high = v;
    }
    if (low < 0) return;
    const [factor, unit] = handyUnit(shown.unit, Math.max(Math.abs(shown.low), Math.abs(shown.high)));
    const text = (word, v) => `${word} ${short(values[v] / factor, 3)}${unit ? ` ${typeset(unit)}` : ""}`;
    this.extremes = values[low] === values[high] ? [] : [{ vertex: low, text: text("min", low) }, { vertex: high, text: text("max", high) }];
  }

  /// Marks to where their vertices are on the screen.
  draw() {
    const { view } = this, { clientWidth: width, clientHeight: height } = view.canvas, p = new Vector3();
    for (const mark of this.marks ?? []) {
      p.fromArray(view.positions.array, 3 * mark.vertex).project(view.camera);
      mark.x = ((p.x + 1) / 2) * width;
      mark.y = ((1 - p.y) / 2) * height;
      mark.element.style.transform = `translate(${mark.x.toFixed(1)}px, ${mark.y.toFixed(1)}px)`;
      mark.element.classList.toggle("left", mark.x > width - 110);
    }
  }

  /// Quantities with the unit of their rows, and the value of each component at a point.
  quantities() {
    const { bodies } = this.view, size = this.view.bodySize;
    const place = { label: "Position", unit: "m", largest: size, names: ["x", "y", "z"], at: (at, v) => {
      const moved = bodies.moves ? bodies.valuesAt(at, 0, v) : [0, 0, 0];
      return AXES.map((k) => at.surface.rest[3 * v + k] + moved[k]);
    } };
    return [place, ...bodies.fields.map(({ name, unit, scales }, i) => ({
      label: spelt(name), unit, largest: Math.max(...scales.flatMap(([low, high]) => [Math.abs(low), Math.abs(high)])), field: i,
      names: scales.length === 3 ? ["x", "y", "z"] : [""], at: (at, v) => bodies.valuesAt(at, i, v) }))];
  }

  fill(at) {
    this.table.hidden = !this.picked.length;
    if (!this.picked.length) return;
    const rows = [element("tr", {}, element("th", { textContent: "Point" }), ...this.picked.map((point, i) => {
      const button = element("button", { textContent: `${i + 1} ×`, title: `drop point ${i + 1}`, onclick: () => this.drop(point) });
      button.style.color = point.colour;
      return element("td", {}, button);
    }))];
    for (const { label, unit, largest, names, at: valueAt } of this.quantities()) {
      const values = this.picked.map(({ vertex, surface }) => (surface === at.surface ? valueAt(at, vertex) : null));
      const [factor, handy] = handyUnit(unit, largest);
      names.forEach((name, k) => rows.push(element("tr", {},
        element("th", { textContent: `${label} ${name}`.trim() }),
        ...values.map((value) => element("td", { textContent: value ? short(value[k] / factor) : "–" })),
        element("td", { className: "unit", textContent: typeset(handy) }))));
    }
    this.table.replaceChildren(element("table", {}, ...rows));
  }

  /// The history of the colour field at the picked points; of the displacement where there is no such field.
  plot() {
    if (this.plotted) this.plots.remove(this.plotted);
    this.plotted = null;
    const { bodies, options } = this.view, field = options.field >= 0 ? options.field : 0, component = options.field >= 0 ? options.component : -1;
    if (!this.picked.length || !bodies.fields.length || bodies.frames.length < 2) return;
    const { name, unit, scales } = bodies.fields[field];
    const lines = this.picked.map(({ vertex, surface, colour }, i) => [`point ${i + 1}`, bodies.frames.map((frame) => {
      const at = bodies.at(frame.time);
      if (at.surface !== surface) return NaN;
      const values = bodies.valuesAt(at, field, vertex);
      return scales.length === 1 ? values[0] : component < 0 ? Math.hypot(...values) : values[component];
    }), 0, colour]);
    const part = scales.length === 1 ? "" : component < 0 ? ", magnitude" : ` ${"xyz"[component]}`;
    const times = Float64Array.from(bodies.frames, (frame) => frame.time);
    this.plotted = this.plots.add({ title: `${spelt(name)}${part}`, note: "at the points", unit, lines, first: true }, times);
  }
}
