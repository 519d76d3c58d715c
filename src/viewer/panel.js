// The controls next to the drawing: colours, scale of the displacement, what is shown.
import { arrowControls } from "./arrows.js";
import { clipControls } from "./clip.js";
import { MAPS, mapOf, nameColour } from "./colours.js";
import { element, NumberField, refuseFactor } from "./elements.js";
import { showLegend } from "./legend.js";
import { handyUnit, short, spelt, typeset } from "./numbers.js";
import { LOOKS, VIEWS } from "./scene.js";

const SEEN = { iso: "from the front, above", front: "towards +y", back: "towards -y", left: "towards +x", right: "towards -x", top: "towards -z", bottom: "towards +z" };

export class Panel {
  constructor(place, view, bodies, legend) {
    Object.assign(this, { view, bodies, legend, ranges: new Map(), shown: {}, note: "", marksExtremes: false });
    this.painted = () => {};  // called when other colours are shown
    this.colour = element("select", { id: "colour" });
    this.colour.append(new Option("plain", "none"));
    if (bodies.areSeveral) this.colour.append(new Option("Body", "bodies"));
    if (view.mechanisms?.hasTension) this.colour.append(new Option("Tension of lines", "tension"));
    // Fields of rods are 0 where there are only fibres, which have a tension.
    const hasField = ({ name }) => !name.startsWith("rod_") || bodies.result.elements.segments > 0;
    bodies.fields.forEach((field, i) => hasField(field) && this.colour.append(new Option(spelt(field.name), i)));
    this.component = element("select", { id: "component" });
    [["magnitude", -1], ["x", 0], ["y", 1], ["z", 2]].forEach(([name, value]) => this.component.append(new Option(name, value)));
    const low = (this.low = new NumberField({ id: "low", title: "lowest value of the colours",
      refuse: (value) => (Math.abs(value) > 1e30 ? "too large" : value >= high.value ? "not below the highest" : ""),
      apply: (value) => this.setRange(value * this.factor, this.shown.high) }));
    const high = (this.high = new NumberField({ id: "high", title: "highest value of the colours",
      refuse: (value) => (Math.abs(value) > 1e30 ? "too large" : value <= low.value ? "not above the lowest" : ""),
      apply: (value) => this.setRange(this.shown.low, value * this.factor) }));
    this.map = element("select", { id: "map", title: "colour map" });
    this.map.setAttribute("aria-label", this.map.title);
    for (const [value, text] of Object.entries(MAPS)) this.map.append(new Option(`Map: ${text}`, value));
    const scale = new NumberField({ id: "scale", title: "factor of the displacements", value: 1, refuse: refuseFactor, apply: (value) => view.set({ scale: value }) });
    const extremes = element("input", { type: "checkbox", id: "show-extremes" });
    extremes.onchange = () => {
      this.marksExtremes = extremes.checked;
      view.set({});
    };
    place.append(
      element("h2", { textContent: "Colour" }), element("div", { className: "row" }, this.colour),
      (this.componentRow = element("div", { className: "row" }, this.component)),
      (this.rangeRow = element("div", { className: "row range" }, low.input, element("span", { textContent: "to" }), high.input,
        element("button", { textContent: "auto", title: "the range over all frames", onclick: () => this.paint() }))),
      low.word, high.word,
      (this.mapRow = element("div", { className: "row" }, this.map)),
      (this.extremesRow = element("label", { className: "row check" }, extremes, element("span", { textContent: "Mark minimum and maximum" }))),
      element("h2", { textContent: "Shape" }));
    if (bodies.moves) {
      place.append(element("label", { className: "row" }, element("span", { textContent: "Displacements ×" }), scale.input), scale.word);
    }
    place.append(this.check("Edges of elements", "edges"), this.check("Outline at the start", "outline"));
    if (this.flies()) place.append(this.check("Follow the bodies", "follow", () => view.aim(view.direction())));
    place.append(...arrowControls(view, () => this.legendAnew()), ...clipControls(view));
    this.looks = { bodies: bodies.looks, obstacles: {}, mechanisms: {} };
    const obstacles = view.obstacles?.names ?? [];
    for (const name of obstacles) this.looks.obstacles[name] = "transparent";
    if (bodies.areSeveral) {
      place.append(element("h2", { textContent: "Bodies" }), this.choices("body", bodies.names, this.looks.bodies, (i) => i, nameColour));
    }
    if (obstacles.length > 0) {
      place.append(element("h2", { textContent: "Obstacles" }), this.choices("obstacle", obstacles, this.looks.obstacles, (i) => obstacles[i], () => "#98a2b0"));
    }
    if (view.mechanisms) {
      const { names, kinds, colours } = view.mechanisms;
      for (const name of names) this.looks.mechanisms[name] = "shown";
      place.append(element("h2", { textContent: "Mechanism" }),
        this.choices("part", names, this.looks.mechanisms, (i) => names[i], (i) => colours[i], { looks: ["shown", "hidden"], kinds }));
    }
    place.append(element("h2", { textContent: "View" }), element("div", { className: "row views" },
      ...Object.entries(VIEWS).map(([name, direction]) => element("button", { textContent: name, title: SEEN[name], onclick: () => view.aim(direction) }))));
    this.colour.onchange = this.component.onchange = () => this.paint();
    this.map.onchange = () => (this.byField ? this.setRange(this.shown.low, this.shown.high) : this.paint());
  }

  flies() {
    const { frames } = this.bodies, first = frames[0].shift;
    return this.bodies.moves && frames.some((f) => Math.hypot(...f.shift.map((s, k) => s - first[k])) > 0.75 * this.view.bodySize);
  }

  check(text, option, then) {
    const box = element("input", { type: "checkbox", id: `show-${option}` });
    box.onchange = () => {
      this.view.set({ [option]: box.checked });
      then?.();
    };
    return element("label", { className: "row check" }, box, element("span", { textContent: text }));
  }

  /// A row for each name that chooses how it is drawn: of native controls, so that the keyboard reaches them.
  choices(kind, names, looks, keyOf, colourOf, { looks: allowed = LOOKS, kinds } = {}) {
    const list = element("div", { className: "bodies" });
    names.forEach((name, i) => {
      if (kind === "body" && !this.bodies.isDrawn[i]) return;
      const choice = element("select", { id: `${kind}-${i}`, title: `how to draw ${name}` });
      for (const look of allowed) choice.append(new Option(look, look));
      choice.value = looks[keyOf(i)];
      choice.setAttribute("aria-label", `${name}: how to draw it`);
      choice.onchange = () => {
        looks[keyOf(i)] = choice.value;
        row.dataset.look = choice.value;
        this.view.show(this.looks);
      };
      const chip = element("i");
      chip.style.background = colourOf(i);
      const row = element("div", { className: "row look" }, chip, element("span", { textContent: kinds ? `${name}, ${kinds[i]}` : name, title: name }), choice);
      row.dataset.look = choice.value;
      list.append(row);
    });
    return list;
  }

  /// Colours by what is chosen, over the range of all frames.
  async paint() {
    const chosen = this.colour.value, byField = !["none", "bodies", "tension"].includes(chosen);
    const isTension = chosen === "tension";
    this.byField = byField;
    this.rangeRow.hidden = this.extremesRow.hidden = !byField;
    this.mapRow.hidden = !byField && !isTension;
    this.componentRow.hidden = !byField || this.bodies.fields[chosen].scales.length === 1;
    if (!byField) {
      const range = isTension ? this.view.mechanisms.range() : null;
      if (range) range.kind = mapOf(this.map.value, range.low, range.high);
      this.view.set({ tension: range, field: -1 });
      this.view.paint(isTension ? "none" : chosen);
      this.shown = range ? { label: "Tension", unit: "N", ...range } : {};
      this.legendAnew();
      this.painted();
      return;
    }
    const field = Number(chosen), component = this.componentRow.hidden ? 0 : Number(this.component.value);
    await this.bodies.need(field);
    const key = `${field} ${component}`;
    if (!this.ranges.has(key)) this.ranges.set(key, this.bodies.range(field, component));
    const { low, high, only } = this.ranges.get(key);
    this.now = { field, component };
    this.setRange(low, high, only);
    this.painted();
  }

  /// `only`: the value of all, where it is the same in all frames.
  setRange(low, high, only) {
    const { field, component } = this.now, { name, unit, scales } = this.bodies.fields[field], kind = mapOf(this.map.value, low, high);
    [this.factor] = handyUnit(unit, Math.max(Math.abs(low), Math.abs(high)));  // as the colour bar has it
    this.low.value = Number((low / this.factor).toPrecision(3));
    this.high.value = Number((high / this.factor).toPrecision(3));
    const part = scales.length === 1 || component < 0 ? "" : ` ${"xyz"[component]}`;
    this.shown = { label: spelt(name) + part, unit, low, high, only, kind };
    this.view.set({ field, component, low, high, tension: null });
    this.view.paint(kind);
    this.legendAnew();
  }

  legendAnew() {
    const { arrows } = this.view, { name, unit } = this.bodies.fields[arrows.field] ?? {};
    this.note = "";
    if (name) {
      const longest = arrows.longest.get(arrows.field), [factor, handy] = handyUnit(unit, longest);
      this.note = `arrows: ${spelt(name).toLowerCase()} up to ${short(longest / factor, 3)} ${typeset(handy)}`;
    }
    showLegend(this.legend, this.shown, this.note);
  }
}
