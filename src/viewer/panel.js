// The controls next to the drawing: colours, scale of the displacement, what is shown.
import { gradient, nameColour } from "./colours.js";
import { handyUnit, short, spelt, ticks, typeset } from "./numbers.js";
import { LOOKS, VIEWS } from "./scene.js";

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/// The colour bar, or the bodies' names.
export function showLegend(place, { label, unit, low, high, kind }) {
  place.replaceChildren();
  if (!kind) return;
  const [factor, handy] = handyUnit(unit, Math.max(Math.abs(low), Math.abs(high)));
  const bar = element("div", { className: "bar" });
  bar.style.background = gradient(kind);
  const marks = element("div", { className: "marks" });
  for (const value of ticks(low / factor, high / factor)) {
    const share = (value * factor - low) / (high - low);
    const mark = element("span", { textContent: short(Math.abs(value) < 1e-12 * Math.abs(high / factor) ? 0 : value) });
    mark.style.bottom = `${100 * share}%`;
    marks.append(mark);
  }
  place.append(element("div", { className: "label" }, element("b", { textContent: label }), element("span", { textContent: handy ? ` ${typeset(handy)}` : "" })),
               element("div", { className: "scale" }, bar, marks));
}

export class Panel {
  constructor(place, view, bodies, legend) {
    Object.assign(this, { view, bodies, legend, ranges: new Map() });
    this.colour = element("select", { id: "colour" });
    this.colour.append(new Option("plain", "none"));
    if (bodies.names.length > 1) this.colour.append(new Option("Body", "bodies"));
    if (view.mechanisms?.hasTension) this.colour.append(new Option("Tension of lines", "tension"));
    bodies.fields.forEach((field, i) => this.colour.append(new Option(spelt(field.name), i)));
    this.component = element("select", { id: "component" });
    [["magnitude", -1], ["x", 0], ["y", 1], ["z", 2]].forEach(([name, value]) => this.component.append(new Option(name, value)));
    this.low = element("input", { type: "number", step: "any", title: "lowest value of the colours" });
    this.high = element("input", { type: "number", step: "any", title: "highest value of the colours" });
    this.scale = element("input", { type: "number", step: "any", value: 1, id: "scale" });
    place.append(
      element("h2", { textContent: "Colour" }), element("div", { className: "row" }, this.colour),
      (this.componentRow = element("div", { className: "row" }, this.component)),
      (this.rangeRow = element("div", { className: "row range" }, this.low, element("span", { textContent: "to" }), this.high,
        element("button", { textContent: "auto", title: "the range over all frames", onclick: () => this.paint() }))),
      element("h2", { textContent: "Shape" }));
    if (bodies.moves) {
      place.append(element("label", { className: "row" }, element("span", { textContent: "Displacements ×" }), this.scale));
    }
    place.append(this.check("Edges of elements", "edges"), this.check("Outline at the start", "outline"));
    if (this.flies()) place.append(this.check("Follow the bodies", "follow", () => view.aim(this.direction())));
    this.looks = { bodies: bodies.names.map(() => "solid"), obstacles: {}, mechanisms: {} };
    const obstacles = view.obstacles?.names ?? [];
    for (const name of obstacles) this.looks.obstacles[name] = "transparent";
    if (bodies.names.length > 1) {
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
      ...Object.entries(VIEWS).map(([name, direction]) => element("button", {
        textContent: name, title: name === "iso" ? "from the front, above" : `along ${name}`, onclick: () => view.aim(direction) })),
      element("button", { textContent: "PNG", title: "save the picture", onclick: () => this.save() })));
    this.colour.onchange = this.component.onchange = () => this.paint();
    this.low.onchange = this.high.onchange = () =>
      this.setRange(Number(this.low.value) * this.factor, Number(this.high.value) * this.factor);
    this.scale.onchange = () => Number.isFinite(this.scale.valueAsNumber) && view.set({ scale: this.scale.valueAsNumber });
  }

  direction() {
    return this.view.camera.position.clone().sub(this.view.controls.target).toArray();
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

  /// Colours by what is chosen.
  async paint() {
    const chosen = this.colour.value, byField = !["none", "bodies", "tension"].includes(chosen);
    this.rangeRow.hidden = !byField;
    this.componentRow.hidden = !byField || this.bodies.fields[chosen].scales.length === 1;
    const tension = chosen === "tension" ? this.view.mechanisms.range() : null;
    this.view.set({ tension });
    if (!byField) {
      this.view.set({ field: -1 });
      this.view.paint(tension ? "none" : chosen);
      showLegend(this.legend, tension ? { label: "Tension", unit: "N", ...tension } : {});
      return;
    }
    const field = Number(chosen), component = this.componentRow.hidden ? 0 : Number(this.component.value);
    await this.bodies.need(field);
    const key = `${field} ${component}`;
    if (!this.ranges.has(key)) this.ranges.set(key, this.bodies.range(field, component));
    const { low, high, kind } = this.ranges.get(key);
    this.now = { field, component, kind };
    this.setRange(low, high);
  }

  setRange(low, high) {
    if (!(high > low)) return this.paint();
    const { field, component, kind } = this.now, { name, unit, scales } = this.bodies.fields[field];
    [this.factor] = handyUnit(unit, Math.max(Math.abs(low), Math.abs(high)));  // as the colour bar has it
    this.low.value = Number((low / this.factor).toPrecision(3));
    this.high.value = Number((high / this.factor).toPrecision(3));
    this.view.set({ field, component, low, high });
    this.view.paint(kind);
    const part = scales.length === 1 || component < 0 ? "" : ` ${"xyz"[component]}`;
    showLegend(this.legend, { label: spelt(name) + part, unit, low, high, kind });
  }

  save() {
    const link = element("a", { download: "pliant.png", href: this.view.canvas.toDataURL("image/png") });
    link.click();
  }
}
