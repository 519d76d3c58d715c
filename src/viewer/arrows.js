// A vector field as arrows, from points that are spread evenly over the bodies.
import { InstancedMesh, LatheGeometry, Matrix4, MeshStandardMaterial, Quaternion, Vector2, Vector3 } from "three";
import { element, NumberField, refuseFactor } from "./elements.js";
import { spelt } from "./numbers.js";

const SPACING = 1 / 24, LONGEST = 0.18;  // between arrows, and of the longest in all frames, relative to the bodies' size
export const OUTLINE = [[0, 0], [0.022, 0], [0.022, 0.7], [0.075, 0.7], [0, 1]];  // radius and height of an arrow
const COLOUR = 0xd8433a;
const UP = new Vector3(0, 1, 0);

/// One vertex of each cell of a grid that has one: of each body its own.
function spread(surface, size) {
  const found = new Map();
  for (let v = 0; v < surface.size; ++v) {
    const cell = [0, 1, 2].map((k) => Math.floor(surface.rest[3 * v + k] / size));
    const key = `${surface.bodies[v]} ${cell}`;
    if (!found.has(key)) found.set(key, v);
  }
  return [...found.values()];
}

export class Arrows {
  constructor(view) {
    Object.assign(this, { view, field: -1, scale: 1, vertices: new Map(), longest: new Map() });
    this.material = new MeshStandardMaterial({ color: COLOUR, roughness: 0.6 });
    this.geometry = new LatheGeometry(OUTLINE.map(([r, h]) => new Vector2(r, h)), 10);
  }

  /// Fields with three components.
  static fieldsOf(bodies) {
    return bodies.fields.map((field, i) => ({ name: spelt(field.name), i })).filter(({ i }) => bodies.fields[i].scales.length === 3);
  }

  /// `field`: its number, or -1.
  async show(field) {
    if (field >= 0) await this.view.bodies.need(field);
    this.field = field;
    if (field >= 0 && !this.longest.has(field)) this.longest.set(field, this.view.bodies.range(field, -1).high);
    this.view.set({});
  }

  /// `positions`: of the vertices in the drawing.
  place(at, positions) {
    const { view, field } = this, { surface } = at;
    if (this.mesh) this.mesh.visible = field >= 0;
    if (field < 0) return;
    if (!this.vertices.has(surface)) this.vertices.set(surface, spread(surface, SPACING * view.bodySize));
    const vertices = this.vertices.get(surface), length = (LONGEST * view.bodySize * this.scale) / this.longest.get(field);
    if (!this.mesh || this.mesh.instanceMatrix.count < vertices.length) {
      if (this.mesh) view.scene.remove(this.mesh);
      this.mesh = Object.assign(new InstancedMesh(this.geometry, this.material, vertices.length), { frustumCulled: false });
      view.scene.add(this.mesh);
    }
    const vectors = view.bodies.vectors(at, field), matrix = new Matrix4(), turn = new Quaternion();
    let count = 0;
    for (const v of vertices) {
      const from = new Vector3().fromArray(positions, 3 * v), vector = new Vector3().fromArray(vectors, 3 * v).multiplyScalar(length);
      const size = vector.length();
      if (size < 1e-3 * view.bodySize || !view.isShown(surface, v)) continue;
      turn.setFromUnitVectors(UP, vector.divideScalar(size));
      this.mesh.setMatrixAt(count++, matrix.compose(from, turn, new Vector3(size, size, size)));
    }
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}

/// Rows of the panel: the field and the scale of its arrows.
export function arrowControls(view, changed) {
  const { arrows } = view, fields = Arrows.fieldsOf(view.bodies);
  if (!fields.length) return [];
  const choice = element("select", { id: "arrows", title: "vectors as arrows" });
  choice.setAttribute("aria-label", choice.title);
  choice.append(new Option("No arrows", -1), ...fields.map(({ name, i }) => new Option(`Arrows: ${name.toLowerCase()}`, i)));
  const scale = new NumberField({ id: "arrow-scale", title: "length of the arrows", value: 1, refuse: refuseFactor,
    apply: (value) => { arrows.scale = value; view.set({}); } });
  const row = element("label", { className: "row", hidden: true }, element("span", { textContent: "Length ×" }), scale.input);
  choice.onchange = async () => {
    row.hidden = Number(choice.value) < 0;
    await arrows.show(Number(choice.value));
    changed();
  };
  return [element("div", { className: "row" }, choice), row, scale.word];
}
