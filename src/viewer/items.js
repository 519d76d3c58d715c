// What a model consists of besides its bodies (`pliant check --html`): dots where it is, arrows for forces, a list to switch
// each on and off. What is inside a body is seen through it, fainter.
import {
  BufferAttribute, BufferGeometry, Group, InstancedMesh, LatheGeometry, Matrix4, MeshStandardMaterial, Points, PointsMaterial,
  Quaternion, Vector2, Vector3,
} from "three";
import { OUTLINE } from "./arrows.js";
import { report, float64 } from "./data.js";
import { element } from "./elements.js";
import { disc } from "./mechanisms.js";

/// Kinds in the order of the list.
const KINDS = {
  constraint: { title: "Constraints", colour: "#2f74d0", isShown: true },
  load: { title: "Loads", colour: "#d8433a", isShown: true },
  shell: { title: "Shells", colour: "#0b8f6a", isShown: false },
  cavity: { title: "Cavities", colour: "#18a0a8", isShown: false },
  contact: { title: "Contact, where it is nearest", colour: "#e8981c", isShown: true },
  probe: { title: "Probes", colour: "#8b4fc9", isShown: true },
  cells: { title: "Mesh", colour: "#c2255c", isShown: false },
  group: { title: "Groups of the mesh", colour: "#5c9a2f", isShown: false },
};
const DOTS = { many: 5, few: 12 }, FEW = 20, FAINT = 0.35;  // [pixels]; opacity behind a body
const LONGEST = 0.16, SHORTEST = 0.3;  // arrow relative to the bodies, and to the longest of its load

let dot = null;  // one for all items

class Item {
  constructor(given, points, vectors) {
    Object.assign(this, given, { points, vectors, group: new Group() });
    this.kindOf = KINDS[given.kind];
    this.group.visible = this.kindOf.isShown;
  }

  static async load(given) {
    return new Item(given, await float64(given.points), given.vectors === undefined ? null : await float64(given.vectors));
  }

  /// Objects to draw, twice: in front of the bodies and, fainter, behind them.
  make(view) {
    const count = this.points.length / 3;
    this.size = count > FEW ? DOTS.many : DOTS.few;
    const at = Float32Array.from(this.points, (x, i) => x - view.origin[i % 3]);
    for (const faint of [false, true]) {
      const look = faint ? { transparent: true, opacity: FAINT, depthTest: false, depthWrite: false } : {};
      const object = this.vectors ? this.arrows(view, at, look) : this.dots(at, look, faint);
      Object.assign(object, { frustumCulled: false, renderOrder: faint ? 3 : 0 });
      this.group.add(object);
    }
  }

  dots(at, look, faint) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(at, 3));
    return new Points(geometry, new PointsMaterial({ ...look, size: this.size, sizeAttenuation: false, map: (dot ??= disc()), alphaTest: faint ? FAINT / 2 : 0.5, color: this.kindOf.colour }));
  }

  /// Forces: those that point outward begin at their places, the others end there.
  arrows(view, at, look) {
    const count = at.length / 3, up = new Vector3(0, 1, 0), matrix = new Matrix4(), turn = new Quaternion();
    const made = new InstancedMesh(new LatheGeometry(OUTLINE.map(([r, h]) => new Vector2(r, h)), 10),
      new MeshStandardMaterial({ ...look, color: this.kindOf.colour, roughness: 0.6 }), count);
    const vector = (i) => new Vector3().fromArray(this.vectors, 3 * i);
    let longest = 0;
    for (let i = 0; i < count; ++i) longest = Math.max(longest, vector(i).length());
    for (let i = 0; i < count; ++i) {
      const place = new Vector3().fromArray(at, 3 * i), force = vector(i), size = force.length();
      const length = size > 0 ? LONGEST * view.bodySize * Math.max(SHORTEST, size / longest) : 0;
      if (size > 0) force.divideScalar(size);
      if (count > 1 && force.dot(place) < 0) place.addScaledVector(force, -length);
      turn.setFromUnitVectors(up, size > 0 ? force : up);
      made.setMatrixAt(i, matrix.compose(place, turn, new Vector3(length, length, length)));
    }
    return made;
  }

  /// Larger while the pointer is on its row.
  emphasise(isOn) {
    for (const { material } of this.group.children) {
      if (material.isPointsMaterial) material.size = this.size * (isOn ? 1.8 : 1);
      else material.emissive.set(isOn ? 0x553311 : 0);
    }
  }
}

export class Items {
  static async load(view) {
    const made = Object.assign(new Items(), { view, all: await Promise.all(report.model.items.map((item) => Item.load(item))) });
    for (const item of made.all) {
      item.make(view);
      view.scene.add(item.group);
    }
    return made;
  }

  row(item, number) {
    const box = element("input", { type: "checkbox", id: `item-${number}`, checked: item.group.visible });
    box.onchange = () => {
      item.group.visible = box.checked;
      this.view.touch();
    };
    const chip = element("i");
    chip.style.background = item.kindOf.colour;
    const row = element("label", { className: "row check item", title: item.text }, box, chip,
      element("span", {}, item.name, element("small", { textContent: item.text })));
    for (const [event, isOn] of [["pointerenter", true], ["pointerleave", false]]) {
      row.addEventListener(event, () => {
        item.emphasise(isOn);
        this.view.touch();
      });
    }
    return row;
  }

  /// Headings and rows for the panel.
  list() {
    const numbered = this.all.map((item, number) => ({ item, number }));
    return Object.entries(KINDS).flatMap(([kind, { title }]) => {
      const some = numbered.filter(({ item }) => item.kind === kind);
      return some.length ? [element("h2", { textContent: title }), ...some.map(({ item, number }) => this.row(item, number))] : [];
    });
  }
}

/// What the check found, below the picture.
export function showFindings(to, { lines, diagnostics }) {
  for (const [severity, title] of [["warning", "Warnings"], ["note", "Notes"]]) {
    const some = diagnostics.filter((d) => d.severity === severity);
    if (some.length) to.append(element("article", { className: "wide" }, element("h2", { textContent: title }), ...some.map(({ text }) => element("p", { className: severity, textContent: text }))));
  }
  to.append(element("article", { className: "wide" }, element("h2", { textContent: "What the check found" }), element("pre", { textContent: lines.join("\n") })));
}
