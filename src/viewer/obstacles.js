// Rigid obstacles of contact, where the result has them.
import { BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, FrontSide, Group, Mesh, MeshStandardMaterial } from "three";
import { accumulated, int32, rows, EarlierNeighbours } from "./data.js";

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

/// Vertices of the triangles of each obstacle, three each.
function pieces(index, owners) {
  const found = [];
  owners.forEach((owner, t) => (found[owner] ??= []).push(...index.subarray(3 * t, 3 * t + 3)));
  return found;
}

/// Whether triangles enclose the side that they face, as those of obstacles do that bodies are inside of: their mean distance from their
/// middle along their normals, which is 0 of a plane, is negative, by more than a hundredth of their extent.
function facesItsMiddle(piece, x) {
  let area = 0;
  const middle = [0, 0, 0], low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], found = [];
  for (let i = 0; i < piece.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((j) => x.subarray(3 * piece[i + j], 3 * piece[i + j] + 3));
    const u = AXES.map((k) => b[k] - a[k]), v = AXES.map((k) => c[k] - a[k]);
    const normal = AXES.map((k) => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    const center = AXES.map((k) => (a[k] + b[k] + c[k]) / 3), size = Math.hypot(...normal);
    area += size;
    for (const k of AXES) {
      middle[k] += size * center[k];
      low[k] = Math.min(low[k], a[k], b[k], c[k]);
      high[k] = Math.max(high[k], a[k], b[k], c[k]);
    }
    found.push([normal, center]);
  }
  const distance = found.reduce((sum, [normal, center]) => sum + AXES.reduce((s, k) => s + normal[k] * (center[k] - middle[k] / area), 0), 0);
  return distance < -0.01 * area * Math.hypot(...AXES.map((k) => high[k] - low[k]));
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
    part.materials = materials;
    part.planes = [];
    part.shapes = [];  // by name
    pieces(index, await int32(given.owners)).forEach((piece, owner) => {
      // Two triangles are a plane, cut out around the bodies; what is closed has more. The walls of a vessel are seen behind the bodies.
      const isPlane = piece.length === 6, kind = isPlane ? "plane" : facesItsMiddle(piece, part.rest) ? "vessel" : "closed";
      const mesh = part.add(piece, materials.transparent.closed, isPlane && new BufferAttribute(new Float32Array(2 * given.vertices), 2));
      if (isPlane) part.planes.push({ piece, mesh });
      part.shapes.push({ name: given.names[owner], mesh, kind });
    });
    part.show({});
    return part;
  }

  /// `looks`: by name, one of "solid", "transparent", "hidden"; transparent where there is none.
  show(looks) {
    for (const { name, mesh, kind } of this.shapes) {
      const look = looks[name] ?? "transparent";
      mesh.visible = look !== "hidden";
      if (mesh.visible) mesh.material = this.materials[look][kind];
    }
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
    const given = bodies.result.obstacles;
    if (!given?.some(Boolean)) return null;
    const obstacles = new Obstacles();
    obstacles.bodies = bodies;
    obstacles.group = new Group();
    const look = { color: 0x98a2b0, roughness: 0.9, side: DoubleSide };
    const plane = { ...look, transparent: true, depthWrite: false, alphaMap: fading() };  // fades out, however solid
    const closed = { ...look, flatShading: true }, vessel = { ...closed, side: FrontSide };
    const clear = { transparent: true, depthWrite: false, opacity: 0.5 };
    const materials = {
      transparent: { plane: new MeshStandardMaterial({ ...plane, opacity: 0.6 }), closed: new MeshStandardMaterial({ ...closed, ...clear }),
                     vessel: new MeshStandardMaterial({ ...vessel, ...clear }) },
      solid: { plane: new MeshStandardMaterial(plane), closed: new MeshStandardMaterial(closed), vessel: new MeshStandardMaterial(vessel) } };
    obstacles.names = [...new Set(given.flatMap((part) => part?.names ?? []))];
    obstacles.parts = await Promise.all(given.map((part) => part && Part.load(part, materials)));
    for (const part of obstacles.parts) if (part) obstacles.group.add(part.group);
    return obstacles;
  }

  /// As Part.show.
  show(looks) {
    for (const part of this.parts) part?.show(looks);
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
