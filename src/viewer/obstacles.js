// Rigid obstacles of contact, where the result has them.
import { BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, Group, Mesh, MeshStandardMaterial } from "three";
import { report, accumulated, rows, EarlierNeighbours } from "./data.js";

const AXES = [0, 1, 2];
const REACH = 1.6;  // of a plane that is drawn, in sizes of the scene

/// White in the middle, black at the rim.
function fading() {
  const canvas = document.createElement("canvas"), size = (canvas.width = canvas.height = 256);
  const pen = canvas.getContext("2d"), shade = pen.createRadialGradient(size / 2, size / 2, 0, size / 2, size / 2, size / 2);
  for (const [at, grey] of [[0, 255], [0.35, 235], [0.7, 110], [0.97, 0], [1, 0]]) shade.addColorStop(at, `rgb(${grey} ${grey} ${grey})`);
  pen.fillStyle = shade;
  pen.fillRect(0, 0, size, size);
  return new CanvasTexture(canvas);
}

/// Triangles that hang together, as lists of vertices, three each.
function pieces(index, size) {
  const parent = Int32Array.from({ length: size }, (_, i) => i);
  const root = (i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (let t = 0; t < index.length; ++t) parent[root(index[t])] = root(index[t - (t % 3)]);
  const found = new Map();
  for (let t = 0; t < index.length; t += 3) {
    const key = root(index[t]);
    if (!found.has(key)) found.set(key, []);
    found.get(key).push(...index.subarray(t, t + 3));
  }
  return [...found.values()];
}

/// Obstacles of one part of the run (they are written anew where it was resumed).
class Part {
  static async load(given, materials) {
    const part = new Part();
    const index = await accumulated(given.index), neighbours = new EarlierNeighbours(index, given.vertices);
    part.moves = await Promise.all(given.moves.map((block, k) => rows(block, neighbours, given.moveScales[k])));
    part.rest = new Float32Array(3 * given.vertices);
    for (const k of AXES) (await rows(given.positions[k], neighbours, given.scales[k])).addTo(part.rest, k, 3, 0, 1);
    part.position = new BufferAttribute(new Float32Array(3 * given.vertices), 3);
    part.group = new Group();
    part.planes = [];
    const closed = [];
    for (const piece of pieces(index, given.vertices)) {
      // Two triangles are a plane, cut out around the bodies; what is closed has more.
      if (piece.length !== 6) closed.push(...piece);
      else part.planes.push({ piece, mesh: part.add(piece, materials.plane, new BufferAttribute(new Float32Array(2 * given.vertices), 2)) });
    }
    if (closed.length) part.add(closed, materials.solid);
    return part;
  }

  add(index, material, uv) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.position);
    if (uv) geometry.setAttribute("uv", uv);
    geometry.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = 1;
    this.group.add(mesh);
    return mesh;
  }

  /// Planes fade out around the middle of the scene, which is the origin of the drawing.
  fade(reach) {
    const x = this.position.array;
    for (const { piece, mesh } of this.planes) {
      const [a, b, c] = piece.map((v) => [...x.subarray(3 * v, 3 * v + 3)]);
      const minus = (p, q) => p.map((value, k) => value - q[k]), dot = (p, q) => p.reduce((sum, value, k) => sum + value * q[k], 0);
      const unit = (p) => p.map((value) => value / Math.sqrt(dot(p, p)));
      const first = unit(minus(b, a)), other = minus(c, a);
      const second = unit(minus(other, first.map((value) => value * dot(other, first))));
      const uv = mesh.geometry.attributes.uv;
      for (const v of new Set(piece)) {
        const p = x.subarray(3 * v, 3 * v + 3);
        [first, second].forEach((axis, k) => (uv.array[2 * v + k] = 0.5 + dot([...p], axis) / (2 * reach)));
      }
      uv.needsUpdate = true;
    }
  }
}

export class Obstacles {
  static async load(bodies) {
    const given = report.result.obstacles;
    if (!given?.some(Boolean)) return null;
    const obstacles = new Obstacles();
    obstacles.bodies = bodies;
    obstacles.group = new Group();
    const look = { color: 0x98a2b0, roughness: 0.9, transparent: true, side: DoubleSide, depthWrite: false };
    const materials = { plane: new MeshStandardMaterial({ ...look, opacity: 0.6, alphaMap: fading() }),
                        solid: new MeshStandardMaterial({ ...look, opacity: 0.5, flatShading: true }) };
    obstacles.parts = await Promise.all(given.map((part) => part && Part.load(part, materials)));
    for (const part of obstacles.parts) if (part) obstacles.group.add(part.group);
    return obstacles;
  }

  /// Where they are at that time, relative to `origin`.
  place(at, origin, sceneSize) {
    for (const part of this.parts) if (part) part.group.visible = false;
    const part = this.parts[at.surface.number];
    if (!part) return;
    part.group.visible = true;
    const x = part.position.array;
    for (let i = 0; i < x.length; ++i) x[i] = part.rest[i] - origin[i % 3];
    for (const [frame, weight] of at.parts) {
      part.moves.forEach((u, k) => u.addTo(x, k, 3, this.bodies.rowOfFrame[frame], weight));
    }
    part.position.needsUpdate = true;
    part.fade(REACH * sceneSize);
  }
}
