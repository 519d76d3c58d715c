// The drawing: bodies, their edges, obstacles, light and camera. Draws when something has changed.
import {
  AmbientLight, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshStandardMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Arrows } from "./arrows.js";
import { Clip } from "./clip.js";
import { colourMap, nameColours, shareOf } from "./colours.js";
import { span } from "./numbers.js";

const VIEW_ANGLE = 24;  // [degrees], of the picture's height
/// From where the bodies are seen: z is up, the front is at low y.
export const VIEWS = { iso: [0.62, -1, 0.48], front: [0, -1, 0], back: [0, 1, 0], left: [-1, 0, 0], right: [1, 0, 0], top: [0, 0, 1], bottom: [0, 0, -1] };
const PLAIN = 0x9db2c9;
const TRANSPARENT = 0.22;  // opacity of bodies that are drawn so
/// How a body or an obstacle may be drawn.
export const LOOKS = ["solid", "transparent", "hidden"];

/// Unit normals at vertices, from the triangles around each, by their areas.
function setNormals(normals, x, index) {
  normals.fill(0);
  for (let t = 0; t < index.length; t += 3) {
    const a = 3 * index[t], b = 3 * index[t + 1], c = 3 * index[t + 2];
    const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    normals[i] /= size;
    normals[i + 1] /= size;
    normals[i + 2] /= size;
  }
}

/// A surface as the graphics card has it.
class Drawn {
  constructor(surface, materials, isGhost) {
    this.surface = surface;
    this.isGhost = isGhost;
    const position = new BufferAttribute(new Float32Array(3 * surface.size), 3);
    const geometry = (index) => {
      const made = new BufferGeometry();
      made.setAttribute("position", position);
      made.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
      made.boundingSphere = null;
      return made;
    };
    this.body = new Mesh(geometry(surface.index), materials.body);
    this.body.geometry.setAttribute("normal", new BufferAttribute(new Float32Array(3 * surface.size), 3));
    this.body.geometry.setAttribute("uv", new BufferAttribute(new Float32Array(2 * surface.size).fill(0.5), 2));
    this.clear = new Mesh(geometry([]), materials.clear);  // the transparent bodies, after all that is solid
    this.ghosts = new Mesh(geometry([]), materials.ghost);
    for (const object of [this.clear, this.ghosts]) {
      for (const name of ["normal", "uv"]) object.geometry.setAttribute(name, this.body.geometry.attributes[name]);
      object.renderOrder = 2;
    }
    this.edges = new LineSegments(geometry(surface.elementEdges()), materials.edges);
    this.sharp = new LineSegments(geometry(surface.sharpEdges()), materials.sharp);
    const rest = new BufferGeometry();
    rest.setAttribute("position", new BufferAttribute(new Float32Array(3 * surface.size), 3));
    rest.setIndex(this.sharp.geometry.index);
    this.outline = new LineSegments(rest, materials.outline);
    this.all = new Group().add(this.body, this.clear, this.ghosts, this.edges, this.sharp, this.outline);
    for (const object of this.all.children) object.frustumCulled = false;  // it moves
  }

  /// `looks`: of each body, one of LOOKS; those of `isGhost` are plain where they are transparent. Transparent bodies have no edges of elements, only sharp ones.
  show(looks) {
    const { surface } = this;
    const lookOf = (body) => (this.isGhost[body] && looks[body] === "transparent" ? "ghost" : looks[body]);
    const draw = (object, whole, size, drawn) => {
      const kept = [];
      for (let i = 0; i < whole.length; i += size) {
        if (drawn.includes(lookOf(surface.bodies[whole[i]]))) for (let j = 0; j < size; ++j) kept.push(whole[i + j]);
      }
      object.geometry.setIndex(new BufferAttribute(Uint32Array.from(kept), 1));
    };
    draw(this.body, surface.index, 3, ["solid"]);
    draw(this.clear, surface.index, 3, ["transparent"]);
    draw(this.ghosts, surface.index, 3, ["ghost"]);
    draw(this.edges, surface.elementEdges(), 2, ["solid"]);
    draw(this.sharp, surface.sharpEdges(), 2, ["solid", "transparent"]);
    this.outline.geometry.setIndex(this.sharp.geometry.index);
  }
}

export class View {
  /// `obstacles`: of obstacles.js, `mechanisms`: of mechanisms.js, or null.
  constructor(canvas, bodies, obstacles, mechanisms) {
    this.bodies = bodies;
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true });
    this.renderer.localClippingEnabled = true;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(VIEW_ANGLE, 1, 0.01, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    // Once it is moved by hand, the view is the viewer's own.
    let isHeld = false;
    for (const [name, held] of [["start", true], ["end", false]]) this.controls.addEventListener(name, () => (isHeld = held));
    this.controls.addEventListener("change", () => {
      if (isHeld) this.aimed = null;
      this.touch();
    });
    this.light();
    const surface = { roughness: 0.78, metalness: 0, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.materials = {
      body: new MeshStandardMaterial(surface),
      clear: new MeshStandardMaterial({ ...surface, transparent: true, opacity: TRANSPARENT, depthWrite: false }),
      ghost: new MeshStandardMaterial({ ...surface, color: PLAIN, transparent: true, opacity: TRANSPARENT, depthWrite: false }),
      edges: new LineBasicMaterial({ transparent: true, opacity: 0.32 }),
      sharp: new LineBasicMaterial({ transparent: true, opacity: 0.35 }),
      outline: new LineBasicMaterial({ transparent: true, opacity: 0.5 }),
    };
    this.origin = this.centre();
    this.drawn = bodies.surfaces.map((surface) => new Drawn(surface, this.materials, bodies.isGhost));
    for (const one of this.drawn) this.scene.add(one.all);
    if (bodies.isGhost.includes(true)) for (const one of this.drawn) one.show(bodies.looks);
    const { body, clear, ghost, edges, sharp } = this.materials;
    this.clip = new Clip(this, this.drawn, [body, clear, ghost, edges, sharp]);
    this.arrows = new Arrows(this);
    this.obstacles = obstacles;
    if (obstacles) this.scene.add(obstacles.group);
    this.mechanisms = mechanisms;
    if (mechanisms) this.scene.add(mechanisms.group);
    this.bodyColours = nameColours(Math.max(1, bodies.names.length));
    this.options = { time: 0, scale: 1, field: -1, component: -1, low: 0, high: 1, edges: false, outline: false,
                     follow: false, tension: null };
    this.shown = bodies.names.map(() => true);
    this.moved = this.look = () => {};  // called with new positions, and after each drawing
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.ink());
    this.ink();
    this.resize();
  }

  /// A key light over the viewer's left shoulder, a weak one from the right, a rim from behind: they go with the camera.
  light() {
    this.scene.add(new AmbientLight(0xffffff, 0.75), this.camera);
    for (const [place, strength] of [[[-0.5, 0.8, 1], 2.0], [[1, -0.2, 0.8], 0.75], [[0.2, 0.5, -1], 0.6]]) {
      const light = new DirectionalLight(0xffffff, strength);
      light.position.set(...place);
      this.camera.add(light, light.target);
    }
  }

  /// Lines in the colour of the page's text.
  ink() {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.materials.edges.color.set(dark ? 0x05070a : 0x10141b);
    this.materials.sharp.color.set(dark ? 0x05070a : 0x10141b);
    this.materials.outline.color.set(dark ? 0xaab4c2 : 0x5a6472);
    this.touch();
  }

  /// In the middle of the bodies at the start, so that the graphics card's short numbers do.
  centre() {
    const x = this.bodies.surfaces[0].rest, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < x.length; ++i) {
      low[i % 3] = Math.min(low[i % 3], x[i]);
      high[i % 3] = Math.max(high[i % 3], x[i]);
    }
    this.bodySize = Math.hypot(...low.map((l, k) => high[k] - l)) || 1;
    this.sceneSize = this.bodySize;
    return low.map((l, k) => (l + high[k]) / 2 || 0);
  }

  set(options) {
    Object.assign(this.options, options);
    this.stale = true;
    this.touch();
  }

  /// `looks`: of each body and of each obstacle's name, one of LOOKS; of what is hidden of mechanisms, "hidden".
  show(looks) {
    this.shown = looks.bodies.map((look) => look !== "hidden");
    for (const one of this.drawn) one.show(looks.bodies);
    this.obstacles?.show(looks.obstacles);
    this.mechanisms?.show(looks.mechanisms);
    this.set({});
  }

  /// Whether a vertex of a surface is neither hidden with its body nor cut away.
  isShown(surface, v) {
    const x = this.positions.array;
    return this.shown[surface.bodies[v]] && !this.clip.hides(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
  }

  /// From where the bodies are seen now.
  direction() {
    return this.camera.position.clone().sub(this.controls.target).toArray();
  }

  /// Colours from a map, from the bodies' names, or none.
  paint(kind) {
    for (const material of [this.materials.body, this.materials.clear]) {
      material.map = kind === "bodies" ? this.bodyColours : kind === "none" ? null : colourMap(kind);
      material.color.set(kind === "none" ? PLAIN : 0xffffff);
      material.needsUpdate = true;
    }
    this.kind = kind;
    this.set({});
  }

  /// Positions over all frames, some of them: what the camera must see.
  cloud() {
    const { frames } = this.bodies, some = Math.min(frames.length, 24), points = [];
    for (let k = 0; k < some; ++k) {
      const at = this.bodies.at(frames[some > 1 ? Math.round((k * (frames.length - 1)) / (some - 1)) : 0].time);
      const x = new Float32Array(3 * at.surface.size);
      this.bodies.positions(at, this.options.scale, this.origin, x);
      if (this.options.follow) for (let i = 0; i < x.length; ++i) x[i] -= this.flown(at)[i % 3];
      const every = Math.max(1, Math.floor(at.surface.size / 1500));
      for (let v = 0; v < at.surface.size; v += every) points.push(new Vector3(x[3 * v], x[3 * v + 1], x[3 * v + 2]));
      const lines = this.mechanisms?.current(at, this.options.scale, this.originAt(at));
      for (let v = 0; lines && v < lines.x.length; v += 3) points.push(new Vector3(...lines.x.subarray(v, v + 3)));
    }
    return points;
  }

  /// Ends the gliding after a drag.
  settle() {
    this.controls.enableDamping = false;
    this.controls.update();
    this.controls.enableDamping = true;
  }

  /// Looks from a direction so that all is just seen. A point is seen from distance d over the shift s if
  /// |p - s| <= slope (d - depth); both bounds together give the least d.
  aim(direction) {
    this.settle();
    this.aimed = direction;
    const points = this.cloud(), back = new Vector3(...direction).normalize();
    this.camera.up.set(0, 0, 1);
    if (Math.abs(back.z) > 0.99) back.set(0, -0.012, Math.sign(back.z)).normalize();
    const right = new Vector3().crossVectors(this.camera.up, back).normalize();
    const up = new Vector3().crossVectors(back, right);
    const half = Math.tan((VIEW_ANGLE / 2) * (Math.PI / 180)) * 0.9;
    const slopes = [half * this.camera.aspect * (1 - this.legendShare()), half];
    const bounds = [right, up].map((axis, k) => {
      let plus = -Infinity, minus = -Infinity;
      for (const p of points) {
        plus = Math.max(plus, p.dot(axis) + slopes[k] * p.dot(back));
        minus = Math.max(minus, -p.dot(axis) + slopes[k] * p.dot(back));
      }
      return { shift: (plus - minus) / 2, distance: (plus + minus) / (2 * slopes[k]) };
    });
    this.sceneSize = Math.max(this.bodySize, span(points.map((p) => p.distanceTo(points[0])))[1]);
    const [shallowest, deepest] = span(points.map((p) => p.dot(back))), middle = (shallowest + deepest) / 2;
    const distance = Math.max(bounds[0].distance, bounds[1].distance, deepest + 0.1 * this.bodySize);
    const place = (depth) => right.clone().multiplyScalar(bounds[0].shift).addScaledVector(up, bounds[1].shift).addScaledVector(back, depth);
    this.controls.target.copy(place(middle));
    this.camera.position.copy(place(distance));
    this.controls.update();
    this.touch();
  }

  /// Width of the colour bar, as a fraction of the view's.
  legendShare() {
    const { clientWidth: width } = this.canvas.parentElement;
    return width > 0 ? Math.min(110 / width, 0.2) : 0;
  }

  flown(at) {
    const first = this.bodies.frames[0].shift;
    return at.shift.map((s, k) => this.options.scale * (s - first[k]));
  }

  /// Where the origin of the drawing is: it flies with the bodies if it follows them.
  originAt(at) {
    return this.options.follow ? this.origin.map((x, k) => x + this.flown(at)[k]) : this.origin;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.setViewOffset(width, height, (this.legendShare() * width) / 2, 0, width, height);
    this.camera.updateProjectionMatrix();
    if (this.aimed) this.aim(this.aimed);
    this.touch();
  }

  touch() {
    this.waiting ||= requestAnimationFrame(() => this.render());
  }

  /// Now, with what has been set.
  render() {
    cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    this.controls.update();
    if (this.stale) this.move();
    this.draw();
  }

  /// Positions and colours of the time that is set.
  move() {
    this.stale = false;
    const { options, bodies } = this, at = bodies.at(options.time);
    for (const one of this.drawn) one.all.visible = one.surface === at.surface;
    const { body, outline, edges } = this.drawn[at.surface.number];
    const attributes = body.geometry.attributes;
    this.at = at;
    this.positions = attributes.position;
    const origin = this.originAt(at);
    bodies.positions(at, options.scale, origin, attributes.position.array);
    attributes.position.needsUpdate = true;
    setNormals(attributes.normal.array, attributes.position.array, at.surface.index);
    attributes.normal.needsUpdate = true;
    edges.visible = options.edges;
    outline.visible = options.outline;
    if (options.outline) {
      const x = outline.geometry.attributes.position;
      for (let i = 0; i < x.array.length; ++i) x.array[i] = at.surface.rest[i] - origin[i % 3];
      x.needsUpdate = true;
    }
    this.obstacles?.place(at, origin, this.sceneSize);
    this.mechanisms?.place(at, origin, options.scale, options.tension);
    this.arrows.place(at, attributes.position.array);
    this.colour(at, attributes.uv);
    this.moved(at);
  }

  colour(at, uv) {
    const { field, component, low, high } = this.options;
    this.values = null;
    if (this.kind === "bodies") {
      const count = this.bodies.names.length;
      for (let v = 0; v < at.surface.size; ++v) uv.array[2 * v] = (at.surface.bodies[v] + 0.5) / count;
    } else if (field >= 0) {
      const values = (this.values = new Float32Array(at.surface.size));
      this.bodies.scalars(at, field, component, values);
      const [first, last] = [low, high].map((value) => shareOf(this.kind, value, low, high)), scale = (last - first) / (high - low);
      for (let v = 0; v < values.length; ++v) {
        // Half a texel at each end keeps the ends of the map apart.
        uv.array[2 * v] = 0.5 / 256 + (255 / 256) * Math.min(last, Math.max(first, first + (values[v] - low) * scale));
      }
    }
    uv.needsUpdate = true;
  }

  draw() {
    const far = this.camera.position.distanceTo(this.controls.target) + 50 * this.bodySize;
    this.camera.near = far / 5000;
    this.camera.far = far * 4;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.look(this.camera);
  }
}
