// Tendons, springs, rods and joints, where the result has them: lines, and a dot where a joint is. What is inside a body is
// seen through it, fainter.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, Group, NotEqualStencilFunc, Points, PointsMaterial, ReplaceStencilOp, SRGBColorSpace,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { colourAt, rangeOf, shareOf } from "./colours.js";
import { int32, rows, EarlierNeighbours } from "./data.js";

const AXES = [0, 1, 2];
const COLOURS = { tendon: "#d63a50", spring: "#2f9e78", rod: "#5b6f8f", joint: "#e8981c" };
const WIDTH = 3, DOT = 13, FAINT = 0.5;  // [pixels]; opacity behind a body

const colourOf = (kind) => COLOURS[kind] ?? COLOURS.joint;

/// A round dot.
export function disc() {
  const canvas = document.createElement("canvas"), size = (canvas.width = canvas.height = 64);
  const pen = canvas.getContext("2d");
  pen.fillStyle = "#ffffff";
  pen.arc(size / 2, size / 2, size / 2 - 2, 0, 2 * Math.PI);
  pen.fill();
  return new CanvasTexture(canvas);
}

/// Segments overlap where they meet: each pixel is drawn once, or transparent ones would be spotted.
function drawOnce(lines) {
  Object.assign(lines.material, { stencilWrite: true, stencilRef: 1, stencilFunc: NotEqualStencilFunc, stencilZPass: ReplaceStencilOp });
  const own = lines.onBeforeRender;
  lines.onBeforeRender = (renderer) => {
    own.call(lines, renderer);
    renderer.clearStencil();
  };
}

/// What belongs to one part of the run (it is written anew where it was resumed).
class Part {
  static async load(given) {
    const part = Object.assign(new Part(), { names: given.names, kinds: given.kinds });
    const points = new EarlierNeighbours([], given.vertices);
    part.rest = new Float32Array(3 * given.vertices);
    for (const k of AXES) (await rows(given.positions[k], points, given.scales[k])).addTo(part.rest, k, 3, 0, 1);
    part.moves = await Promise.all(given.moves.map((block, k) => rows(block, points, given.moveScales[k])));
    part.segments = await int32(given.segments);
    part.parts = await int32(given.parts);
    part.joints = await int32(given.joints);
    part.tensions = await rows(given.tensions, new EarlierNeighbours([], part.parts.length), given.tensionScale);
    return part;
  }

  /// Positions relative to `origin` and tensions; `weights`: of rows.
  at(weights, scale, origin) {
    const x = new Float32Array(this.rest.length), tension = new Float32Array(this.parts.length);
    for (let i = 0; i < x.length; ++i) x[i] = this.rest[i] - origin[i % 3];
    for (const [row, weight] of weights) {
      this.moves.forEach((u, k) => u.addTo(x, k, 3, row, weight * scale));
      this.tensions.addTo(tension, 0, 1, row, weight);
    }
    return { x, tension };
  }
}

export class Mechanisms {
  static async load(bodies) {
    const given = bodies.result.mechanisms;
    if (!given?.some(Boolean)) return null;
    const made = new Mechanisms();
    made.bodies = bodies;
    made.parts = await Promise.all(given.map((part) => part && Part.load(part)));
    const last = made.parts.filter(Boolean).at(-1);
    Object.assign(made, { names: last.names, kinds: last.kinds, looks: {}, group: new Group() });
    made.colours = made.kinds.map(colourOf);
    made.lines = new LineSegmentsGeometry();
    made.dots = new BufferGeometry();
    const map = disc();
    for (const faint of [false, true]) {
      const look = faint ? { transparent: true, opacity: FAINT, depthTest: false, depthWrite: false } : {};
      const lines = new LineSegments2(made.lines, new LineMaterial({ ...look, linewidth: WIDTH, vertexColors: true }));
      const dots = new Points(made.dots, new PointsMaterial({ ...look, size: DOT, sizeAttenuation: false, map, alphaTest: faint ? FAINT / 2 : 0.5, color: COLOURS.joint }));
      for (const object of [lines, dots]) Object.assign(object, { frustumCulled: false, renderOrder: faint ? 3 : 0 });
      if (faint) drawOnce(lines);
      made.group.add(lines, dots);
    }
    return made;
  }

  get hasTension() {
    return this.kinds.some((kind) => ["tendon", "spring", "rod"].includes(kind));
  }

  /// The range of the tensions of tendons, springs and rods over all frames.
  range() {
    let low = 0, high = 0;
    this.bodies.frames.forEach((frame, f) => {
      const part = this.parts[frame.mesh];
      if (!part) return;
      for (const value of part.at([[this.bodies.rowOfFrame[f], 1]], 1, [0, 0, 0]).tension) [low, high] = [Math.min(low, value), Math.max(high, value)];
    });
    return rangeOf(low, high);
  }

  /// `looks`: by name, "hidden" or not.
  show(looks) {
    this.looks = looks;
  }

  /// Numbers for the graphics card, in the place of others where there are as many.
  set(place, numbers, anew) {
    if (place?.array.length !== numbers.length) return anew();
    place.array.set(numbers);
    place.needsUpdate = true;
  }

  current(at, scale, origin) {
    const part = this.parts[at.surface.number];
    return part && { part, ...part.at(at.parts.map(([frame, weight]) => [this.bodies.rowOfFrame[frame], weight]), scale, origin) };
  }

  /// Where they are at that time, relative to `origin`, displacements times `scale`. `range`: of the colours of tensions,
  /// or nothing.
  place(at, origin, scale, range) {
    const now = this.current(at, scale, origin);
    this.group.visible = Boolean(now);
    if (!now) return;
    const { part, x, tension } = now, positions = [], colours = [], dots = [], colour = new Color();
    const isShown = (p) => this.looks[part.names[p]] !== "hidden";
    for (let s = 0; s < part.parts.length; ++s) {
      const p = part.parts[s];
      if (!isShown(p)) continue;
      for (const end of [0, 1]) {
        const v = 3 * part.segments[2 * s + end];
        positions.push(x[v], x[v + 1], x[v + 2]);
      }
      if (range && p < part.names.length - part.joints.length) {
        const [r, g, b] = colourAt(range.kind, shareOf(range.kind, tension[s], range.low, range.high));
        colour.setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
      } else {
        colour.set(colourOf(part.kinds[p]));
      }
      for (let end = 0; end < 2; ++end) colours.push(colour.r, colour.g, colour.b);
    }
    part.joints.forEach((v, j) => {
      if (isShown(part.names.length - part.joints.length + j)) dots.push(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
    });
    this.group.children.forEach((object) => (object.visible = (object.isPoints ? dots : positions).length > 0));
    if (positions.length > 0) {
      this.set(this.lines.attributes.instanceStart?.data, positions, () => this.lines.setPositions(positions));
      this.set(this.lines.attributes.instanceColorStart?.data, colours, () => this.lines.setColors(colours));
      this.lines.instanceCount = positions.length / 6;
    }
    this.set(this.dots.attributes.position, dots, () => this.dots.setAttribute("position", new BufferAttribute(new Float32Array(dots), 3)));
  }
}
