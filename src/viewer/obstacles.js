// Rigid obstacles of contact, where the result has them.
import { BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshStandardMaterial } from "three";
import { report, accumulated, rows } from "./data.js";

const AXES = [0, 1, 2];

/// Obstacles of one part of the run (they are written anew where it was resumed).
class Part {
  static async load(given) {
    const part = new Part();
    part.size = given.vertices;
    part.moves = await Promise.all((given.moves ?? []).map((block, k) => rows(block, given.vertices, given.moveScales[k])));
    part.rest = new Float32Array(3 * given.vertices);
    for (const k of AXES) (await rows(given.positions[k], given.vertices, given.scales[k])).addTo(part.rest, k, 3, 0, 1);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * given.vertices), 3));
    geometry.setIndex(new BufferAttribute(Uint32Array.from(await accumulated(given.index)), 1));
    part.mesh = new Mesh(geometry, new MeshStandardMaterial({ color: 0x98a2b0, roughness: 0.85, transparent: true, opacity: 0.42,
                                                              side: DoubleSide, flatShading: true, depthWrite: false }));
    part.mesh.frustumCulled = false;
    part.mesh.renderOrder = 1;
    return part;
  }
}

export class Obstacles {
  static async load(bodies) {
    const given = report.result.obstacles;
    if (!given?.some(Boolean)) return null;
    const obstacles = new Obstacles();
    obstacles.bodies = bodies;
    obstacles.group = new Group();
    obstacles.parts = await Promise.all(given.map((part) => part && Part.load(part)));
    for (const part of obstacles.parts) if (part) obstacles.group.add(part.mesh);
    return obstacles;
  }

  /// Where they are at that time, relative to `origin`.
  place(at, origin) {
    for (const part of this.parts) if (part) part.mesh.visible = false;
    const part = this.parts[at.surface.number];
    if (!part) return;
    part.mesh.visible = true;
    const x = part.mesh.geometry.attributes.position;
    for (let i = 0; i < x.array.length; ++i) x.array[i] = part.rest[i] - origin[i % 3];
    for (const [frame, weight] of at.parts) {
      part.moves.forEach((u, k) => u.addTo(x.array, k, 3, this.bodies.rowOfFrame[frame], weight));
    }
    x.needsUpdate = true;
  }
}
