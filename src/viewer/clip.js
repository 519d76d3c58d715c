// A plane that cuts the bodies open. The page has their surfaces only, so the cut itself is plain: it is drawn where an odd
// number of surfaces lies behind the plane or before it, which is inside of closed surfaces.
import {
  AlwaysStencilFunc, DoubleSide, InvertStencilOp, Mesh, MeshBasicMaterial, MeshLambertMaterial, NotEqualStencilFunc, Plane,
  PlaneGeometry, Vector3, ZeroStencilOp,
} from "three";
import { element } from "./elements.js";
import { handyUnit, short, span } from "./numbers.js";

const NORMALS = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const CUT = 0xc3c9d2;

export class Clip {
  /// `drawn`: the surfaces of the view, `materials`: those to be cut.
  constructor(view, drawn, materials) {
    Object.assign(this, { view, materials, plane: new Plane(), normal: null, share: 0.5, isFlipped: false, cuts: true });
    const planes = [this.plane];
    const counting = new MeshBasicMaterial({
      colorWrite: false, depthWrite: false, depthTest: false, side: DoubleSide, clippingPlanes: planes, stencilWrite: true,
      stencilFunc: AlwaysStencilFunc, stencilFail: InvertStencilOp, stencilZFail: InvertStencilOp, stencilZPass: InvertStencilOp,
    });
    this.counts = drawn.map((one) => {
      const count = new Mesh(one.body.geometry, counting);
      Object.assign(count, { frustumCulled: false, renderOrder: 0.3, visible: false });
      one.all.add(count);
      return count;
    });
    this.cap = new Mesh(new PlaneGeometry(), new MeshLambertMaterial({
      color: CUT, side: DoubleSide, stencilWrite: true, stencilRef: 0, stencilFunc: NotEqualStencilFunc,
      stencilFail: ZeroStencilOp, stencilZFail: ZeroStencilOp, stencilZPass: ZeroStencilOp,
    }));
    Object.assign(this.cap, { frustumCulled: false, renderOrder: 0.6, visible: false });
    view.scene.add(this.cap);
  }

  /// `normal`: three numbers, or null for the whole bodies.
  aim(normal) {
    this.normal = normal && new Vector3(...normal).normalize();
    for (const material of this.materials) material.clippingPlanes = normal ? [this.plane] : null;
    for (const object of [...this.counts, this.cap]) object.visible = Boolean(normal);
    if (!normal) return this.view.set({});
    const depths = this.view.cloud().map((p) => p.dot(this.normal));
    [this.low, this.high] = span(depths);
    this.isFlipped = this.normal.dot(new Vector3(...this.view.direction())) < 0;  // the cut is seen
    this.move();
  }

  /// The plane to `share` of the bodies' extent in all frames; kept is what is behind it, or before it if flipped.
  move(changes = {}) {
    Object.assign(this, changes);
    if (!this.normal) return;
    this.depth = this.low + this.share * (this.high - this.low);
    this.plane.set(this.normal, -this.depth);
    this.cap.position.copy(this.normal).multiplyScalar(this.depth);
    this.cap.lookAt(this.cap.position.clone().add(this.normal));
    this.cap.scale.setScalar(8 * this.view.sceneSize);
    if (!this.isFlipped) this.plane.negate();
    this.view.set({});
  }

  /// Whether a point of the drawing is cut away.
  hides(x, y, z) {
    if (!this.normal) return false;
    const { normal, constant } = this.plane;
    return normal.x * x + normal.y * y + normal.z * z + constant < 0;
  }
}

/// Rows of the panel: the direction, the place, the side.
export function clipControls(view) {
  const { clip } = view;
  const choice = element("select", { id: "clip", title: "plane that cuts the bodies" });
  choice.setAttribute("aria-label", choice.title);
  for (const [value, text] of [["none", "No cut"], ["x", "Cut across x"], ["y", "Cut across y"], ["z", "Cut across z"], ["view", "Cut along the screen"]]) {
    choice.append(new Option(text, value));
  }
  const slider = element("input", { type: "range", id: "clip-place", className: "slider", min: 0, max: 1, step: 0.005, value: 0.5 });
  slider.setAttribute("aria-label", "Place of the cut");
  const where = element("output", { id: "clip-where" });
  const again = element("button", { id: "clip-again", textContent: "as seen now", title: "cut along the screen as it is now" });
  const flip = element("button", { id: "clip-flip", textContent: "flip", title: "keep the other side" });
  const place = element("div", { className: "row" }, slider, where), sides = element("div", { className: "row views" }, flip, again);
  const note = element("p", { className: "note", textContent: "The cut is grey: the page has the values of surfaces only." });
  const say = () => {
    const axis = Object.keys(NORMALS).indexOf(choice.value);
    const size = Math.max(Math.abs(clip.low), Math.abs(clip.high)), [factor, unit] = handyUnit("m", size || 1);
    const step = 10 ** Math.floor(Math.log10((clip.high - clip.low) / factor || 1) - 2);
    where.textContent = axis < 0 ? `${Math.round(100 * clip.share)} %`
      : `${short((Math.round((clip.depth + view.origin[axis]) / factor / step) * step), 3)} ${unit}`;
  };
  const aim = () => {
    const { value } = choice;
    for (const row of [place, sides, note]) row.hidden = value === "none";
    again.hidden = value !== "view";
    clip.aim(value === "none" ? null : NORMALS[value] ?? view.direction());
    if (value !== "none") say();
  };
  choice.onchange = again.onclick = aim;
  slider.oninput = () => (clip.move({ share: slider.valueAsNumber }), say());
  flip.onclick = () => clip.move({ isFlipped: !clip.isFlipped });
  for (const row of [place, sides, note]) row.hidden = true;
  return [element("div", { className: "row" }, choice), place, sides, note];
}
