// Another run next to the first one: the same camera, time, colours and cut.
import { Bodies } from "./bodies.js";
import { readHistory } from "./data.js";
import { element } from "./elements.js";
import { Mechanisms } from "./mechanisms.js";
import { Obstacles } from "./obstacles.js";
import { Points } from "./points.js";
import { View } from "./scene.js";

const place = (id) => document.getElementById(id);
const NOWHERE = -1;
const STILL = 1e-9;  // moves of the camera that are none, in sizes of the bodies

/// Names that distinguish the runs: the ends of their directories, from where these differ.
export function namesOf(report) {
  const parts = [report, report.other].map(({ directory }) => directory.split("/").filter(Boolean));
  let k = 1;
  while (k < Math.min(...parts.map((p) => p.length)) && parts[0].slice(-k).join("/") === parts[1].slice(-k).join("/")) ++k;
  return parts.map((p) => p.slice(-k).join("/") || "run");
}

/// Bodies of both runs as the panel asks for them: it needs fields of both, and one range of colours.
function coverBoth(bodies, others) {
  const own = { need: bodies.need.bind(bodies), extremes: bodies.extremes.bind(bodies) };
  const fieldOfOther = (field) => others.fields.findIndex(({ name }) => name === bodies.fields[field].name);
  bodies.need = async (field) => {
    await own.need(field);
    if (fieldOfOther(field) >= 0) await others.need(fieldOfOther(field));
  };
  bodies.extremes = (field, component) => {
    const found = [own.extremes(field, component)], other = fieldOfOther(field);
    if (other >= 0) found.push(others.extremes(other, component));
    return [Math.min(...found.map(([low]) => low)), Math.max(...found.map(([, high]) => high))];
  };
  return fieldOfOther;
}

export class Second {
  /// `bodies`: of the first run, which are asked for both from now on.
  static async load(run, bodies) {
    const second = new Second(), others = await Bodies.load(run.result);
    Object.assign(second, { run, bodies: others, history: await readHistory(run), fieldOfOther: coverBoth(bodies, others) });
    return second;
  }

  /// Frames of both runs by their times; the modes of the first one.
  frames(first) {
    if (first.some(({ label }) => label)) return first;
    const times = [...new Set([...first, ...this.bodies.frames].map(({ time }) => time))].sort((a, b) => a - b);
    return times.map((time) => ({ time }));
  }

  /// Draws what the first view is set to from now on; either view moves the camera of both.
  async show(view) {
    this.view = new View(place("view-2"), this.bodies, await Obstacles.load(this.bodies), await Mechanisms.load(this.bodies));
    this.first = view;
    this.offset = view.origin.map((x, k) => x - this.view.origin[k]);  // from places in the first drawing to those in this one
    this.followSettings();
    this.followCut();
    this.followArrows();
    this.followCamera();
  }

  /// After a method of the first view, `then` with its arguments.
  after(object, method, then) {
    const own = object[method].bind(object);
    object[method] = (...given) => {
      const result = own(...given);
      then(...given);
      return result;
    };
  }

  followSettings() {
    const { first, view } = this;
    this.after(first, "set", (options) => {
      const field = options.field >= 0 ? this.fieldOfOther(options.field) : options.field;
      view.arrows.scale = first.arrows.scale;
      view.set(field === undefined ? options : { ...options, field });
    });
    this.after(first, "paint", (kind) => view.paint(first.options.field >= 0 && this.fieldOfOther(first.options.field) < 0 ? "none" : kind));
    this.after(first, "show", (looks) => {
      const bodies = this.bodies.names.map((name, i) => looks.bodies[first.bodies.names.indexOf(name)] ?? this.bodies.looks[i]);
      view.show({ ...looks, bodies });
    });
    // All of both is seen.
    const cloud = first.cloud.bind(first);
    first.cloud = () => [...cloud(), ...view.cloud().map((p) => p.set(p.x - this.offset[0], p.y - this.offset[1], p.z - this.offset[2]))];
  }

  followCut() {
    const { first, view } = this, [from, to] = [first.clip, view.clip];
    const place = () => {
      if (!from.normal) return;
      const shift = from.normal.toArray().reduce((sum, n, k) => sum + n * this.offset[k], 0);
      to.move({ low: from.low + shift, high: from.high + shift, share: from.share, isFlipped: from.isFlipped });
    };
    this.after(from, "aim", (normal) => (to.aim(normal), place()));
    this.after(from, "move", () => to.normal && place());
  }

  followArrows() {
    const { arrows } = this.first, own = arrows.show.bind(arrows);
    arrows.show = async (field) => {
      await own(field);
      const other = field >= 0 ? this.fieldOfOther(field) : NOWHERE;
      await this.view.arrows.show(other);
      if (other < 0) return;
      const longest = Math.max(arrows.longest.get(field), this.view.arrows.longest.get(other));
      arrows.longest.set(field, longest);
      this.view.arrows.longest.set(other, longest);
      this.first.set({});
    };
  }

  /// After each drawing of the first view its camera is copied; after each of this one it is copied back if it has moved since, by hand or gliding.
  followCamera() {
    const { first, view, offset } = this;
    const copy = (from, to, sign) => {
      for (const [a, b] of [[from.camera.position, to.camera.position], [from.controls.target, to.controls.target]]) {
        b.set(a.x + sign * offset[0], a.y + sign * offset[1], a.z + sign * offset[2]);
      }
      to.camera.quaternion.copy(from.camera.quaternion);
    };
    const placeOf = ({ camera, controls }) => [...camera.position.toArray(), ...controls.target.toArray()];
    let copied = placeOf(view);
    const push = () => {
      const before = placeOf(view);
      copy(first, view, 1);
      copied = placeOf(view);
      if (before.some((x, k) => x !== copied[k])) view.touch();
    };
    this.after(first, "draw", push);
    this.after(first, "aim", () => (view.settle(), push()));
    this.after(view, "draw", () => {
      if (placeOf(view).every((x, k) => Math.abs(x - copied[k]) < STILL * view.bodySize)) return;
      first.aimed = null;
      copy(view, first, -1);
      first.touch();
    });
  }

  /// Points that are clicked here; `plots` of both.
  addPoints(panel, plots, name) {
    const named = { add: (plot, times) => plots.add({ ...plot, title: `${name}: ${plot.title}` }, times), remove: (made) => plots.remove(made) };
    const painted = panel.painted;
    this.points = new Points(this.view, panel, named, { marks: place("marks-2"), table: place("points-2") });
    const ownPainted = panel.painted;
    panel.painted = () => (painted(), ownPainted());
    this.view.look = () => this.points.draw();
  }
}

/// What differs between the inputs of two runs, line by line; the place of their results does not count.
export function showDifferences(to, report, names) {
  const lines = [report, report.other].map(({ input }) => input.split("\n").filter((line) => !/^\s*(#|directory:|$)/.test(line)));
  const only = lines.map((own, i) => own.filter((line) => !lines[1 - i].includes(line)));
  const article = element("article", { className: "wide", id: "differences" }, element("h2", { textContent: "What differs in the inputs" }));
  if (only.every((list) => list.length === 0)) article.append(element("p", { textContent: "Nothing." }));
  else {
    article.append(element("div", { className: "columns" }, ...only.map((list, i) =>
      element("div", {}, element("b", { textContent: names[i] }), element("pre", { textContent: list.join("\n") || "–" })))));
  }
  to.append(article);
}
