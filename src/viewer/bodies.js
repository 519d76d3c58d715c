// The surfaces of the bodies at any time, between frames too.
import { rangeOf } from "./colours.js";
import { accumulated, int32, rows, EarlierNeighbours } from "./data.js";
import { span } from "./numbers.js";

const AXES = [0, 1, 2];

/// One surface with what is known of it in each frame.
class Surface {
  /// `mesh`: of the report; `number`: which it is there.
  static async load(mesh, number) {
    const surface = new Surface();
    surface.number = number;
    surface.size = mesh.vertices;
    surface.index = await accumulated(mesh.index);
    surface.bodies = await int32(mesh.bodies);
    surface.perFacet = mesh.perFacet;
    surface.neighbours = new EarlierNeighbours(surface.index, mesh.vertices);
    surface.rest = new Float32Array(3 * mesh.vertices);
    for (const i of AXES) (await rows(mesh.positions[i], surface.neighbours, mesh.scales[i])).addTo(surface.rest, i, 3, 0, 1);
    return surface;
  }

  /// Pairs of vertices: the edges of the elements.
  elementEdges() {
    const pairs = [];
    for (let t = 0; t < this.index.length; t += 3) {
      const [a, b, c] = this.index.subarray(t, t + 3);
      if (this.perFacet === 1) pairs.push(a, b, b, c, c, a);
      else if ((t / 3) % 4 < 3) pairs.push(a, b, c, a);  // corner first; the fourth triangle is in the middle
    }
    return pairs;
  }

  /// Pairs of vertices: sides of one triangle only, which are the sharp edges.
  sharpEdges() {
    const seen = new Map();
    for (let t = 0; t < this.index.length; t += 3) {
      for (const i of AXES) {
        const a = this.index[t + i], b = this.index[t + ((i + 1) % 3)];
        const key = Math.min(a, b) * this.size + Math.max(a, b);
        if (!seen.delete(key)) seen.set(key, [a, b]);
      }
    }
    return [...seen.values()].flat();
  }
}

/// Frame numbers around a time, and how far it is from the first to the second; nothing lies between frames with labels, such as modes.
function around(frames, time) {
  let i = 0;
  while (i + 1 < frames.length && frames[i + 1].time <= time) ++i;
  const next = frames[i + 1];
  if (!next || next.label || next.mesh !== frames[i].mesh || !(next.time > frames[i].time)) return [i, i, 0];
  return [i, i + 1, Math.min(1, Math.max(0, (time - frames[i].time) / (next.time - frames[i].time)))];
}

export class Bodies {
  /// `result`: of a run on the page.
  static async load(result) {
    const bodies = new Bodies();
    const { meshes, frames, fields } = result;
    bodies.frames = frames;
    bodies.fields = fields;
    bodies.names = result.bodies;
    bodies.result = result;
    bodies.surfaces = await Promise.all(meshes.map((mesh, i) => Surface.load(mesh, i)));
    // Fibres are bodies without facets: the mechanisms show them.
    const seen = new Set(bodies.surfaces.flatMap((surface) => [...new Set(surface.bodies)]));
    bodies.isDrawn = bodies.names.map((name, i) => seen.has(i) && !result.unseen?.includes(name));
    // Ellipsoids of inertia stand for no surface: next to bodies that have one, they are seen through and have no field.
    bodies.isGhost = bodies.names.map((name) => Boolean(result.masses?.includes(name)));
    if (bodies.isDrawn.every((isDrawn, i) => !isDrawn || bodies.isGhost[i])) bodies.isGhost.fill(false);
    const count = meshes.map(() => 0);
    bodies.rowOfFrame = frames.map((frame) => count[frame.mesh]++);
    bodies.values = new Map();
    bodies.moves = fields[0]?.name === "displacement";
    if (bodies.moves) await bodies.need(0);
    return bodies;
  }

  /// Unpacks a field.
  async need(field) {
    if (this.values.has(field)) return;
    const { scales, values } = this.fields[field];
    this.values.set(field, await Promise.all(values.map((blocks, m) =>
      Promise.all(blocks.map((block, c) => rows(block, this.surfaces[m].neighbours, scales[c]))))));
  }

  /// What there is at a time: the surface, and rows with weights that give its values.
  at(time) {
    const [i, j, share] = around(this.frames, time);
    const surface = this.surfaces[this.frames[i].mesh];
    const parts = [[i, 1 - share]];
    if (share > 0) parts.push([j, share]);
    const shift = AXES.map((k) => parts.reduce((sum, [f, w]) => sum + w * this.frames[f].shift[k], 0));
    return { surface, parts, shift, step: this.frames[share < 0.5 ? i : j].step, frame: share < 0.5 ? i : j };
  }

  /// Current positions, with displacements times `scale`, relative to `origin`.
  positions(at, scale, origin, target) {
    const { surface, parts, shift } = at;
    const x = surface.rest;
    const offset = AXES.map((k) => (this.moves ? scale * shift[k] : 0) - origin[k]);
    for (let i = 0; i < x.length; i += 3) {
      target[i] = x[i] + offset[0];
      target[i + 1] = x[i + 1] + offset[1];
      target[i + 2] = x[i + 2] + offset[2];
    }
    if (!this.moves) return;
    const u = this.values.get(0)[surface.number];
    for (const [frame, weight] of parts) {
      for (const k of AXES) u[k].addTo(target, k, 3, this.rowOfFrame[frame], weight * scale);
    }
  }

  /// Values of a needed field: a component, or the magnitude (component -1).
  scalars(at, field, component, target) {
    const { surface, parts, shift } = at;
    const of = this.values.get(field)[surface.number];
    const isDisplacement = this.moves && field === 0;
    const add = (c, into, first, stride) => {
      for (const [frame, weight] of parts) of[c].addTo(into, first, stride, this.rowOfFrame[frame], weight);
    };
    if (component >= 0) {
      target.fill(isDisplacement ? shift[component] : 0);
      add(component, target, 0, 1);
      return;
    }
    const vectors = this.vectors(at, field);
    for (let v = 0; v < surface.size; ++v) target[v] = Math.hypot(vectors[3 * v], vectors[3 * v + 1], vectors[3 * v + 2]);
  }

  /// Values of a needed field with three components.
  vectors(at, field) {
    const { surface, parts, shift } = at, vectors = new Float32Array(3 * surface.size);
    const of = this.values.get(field)[surface.number];
    if (this.moves && field === 0) for (let i = 0; i < vectors.length; ++i) vectors[i] = shift[i % 3];
    for (const k of AXES) for (const [frame, weight] of parts) of[k].addTo(vectors, k, 3, this.rowOfFrame[frame], weight);
    return vectors;
  }

  /// Values of a needed field at a vertex: its components.
  valuesAt(at, field, vertex) {
    const { surface, parts, shift } = at;
    return this.values.get(field)[surface.number].map((rows, k) =>
      parts.reduce((sum, [frame, weight]) => sum + weight * rows.value(this.rowOfFrame[frame], vertex), this.moves && field === 0 ? shift[k] : 0));
  }

  /// How each is drawn at first.
  get looks() {
    return this.isGhost.map((isGhost) => (isGhost ? "transparent" : "solid"));
  }

  /// Whether there are several bodies to choose from.
  get areSeveral() {
    return this.isDrawn.filter(Boolean).length > 1;
  }

  /// The range of the colours of a field.
  range(field, component) {
    return rangeOf(...this.extremes(field, component));
  }

  /// Lowest and highest value over all frames; of peaks the uppermost and lowermost thousandth are left out, for at sharp
  /// corners stresses have no bound. Zeros do not count among these: contact acts on few places, and its peaks are those.
  extremes(field, component) {
    const samples = [], frames = this.frames.length, some = Math.min(frames, 40);
    for (let k = 0; k < some; ++k) {
      const at = this.at(this.frames[some > 1 ? Math.round((k * (frames - 1)) / (some - 1)) : 0].time);
      let values = new Float32Array(at.surface.size);
      this.scalars(at, field, component, values);
      if (this.isGhost.includes(true)) values = values.filter((_, v) => !this.isGhost[at.surface.bodies[v]]);
      const sorted = values.filter((value) => value !== 0).sort(), cut = Math.floor(sorted.length / 1000);
      if (sorted.length > 0) samples.push(sorted[cut], sorted[sorted.length - 1 - cut]);
      if (sorted.length < values.length) samples.push(0);
    }
    return span(samples);
  }
}
