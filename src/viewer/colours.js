// Values to colours: perceptually uniform maps; a diverging one about zero for values of both signs.
import { DataTexture, LinearFilter, NearestFilter, SRGBColorSpace } from "three";

// Stops of matplotlib's viridis and of ColorBrewer's RdBu, without the darkest ends: shading needs colours that can
// become darker.
const VIRIDIS = ["46307e", "3f4788", "365d8d", "2c728e", "23888e", "1f9d8a", "2db27d", "54c568", "86d549", "bddf26", "fde725"];
const RED_BLUE = ["2166ac", "4393c3", "92c5de", "d1e5f0", "f7f7f7", "fddbc7", "f4a582", "d6604d", "b2182b"];
const NAMES = ["5b8fd6", "e08a5c", "5fb88a", "a283cf", "d8b04c", "63b9c7", "cf7198", "8f98a6", "9bbf5a", "c08f72"];

const parts = (hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16));

/// The colour at 0 <= s <= 1 between stops.
function between(stops, s) {
  const at = s * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2);
  const [a, b] = [parts(stops[i]), parts(stops[i + 1])];
  return a.map((x, k) => Math.round(x + (at - i) * (b[k] - x)));
}

const stopsOf = (kind) => (kind === "diverging" ? RED_BLUE : VIRIDIS);

/// The colour of a map at 0 <= s <= 1, or at the nearer end: red, green, blue up to 255.
export const colourAt = (kind, s) => between(stopsOf(kind), Math.min(1, Math.max(0, s)));

function texture(colours, filter) {
  const data = new Uint8Array(colours.flatMap((c) => [...c, 255]));
  const made = new DataTexture(data, colours.length, 1);
  made.colorSpace = SRGBColorSpace;
  made.magFilter = made.minFilter = filter;
  made.needsUpdate = true;
  return made;
}

const map = (stops) => Array.from({ length: 256 }, (_, i) => between(stops, i / 255));
const textures = new Map();

/// One of "sequential", "diverging".
export function colourMap(kind) {
  if (!textures.has(kind)) textures.set(kind, texture(map(stopsOf(kind)), LinearFilter));
  return textures.get(kind);
}

export const gradient = (kind) =>
  `linear-gradient(to top, ${stopsOf(kind).map((c) => "#" + c).join(", ")})`;

export const nameColour = (i) => "#" + NAMES[i % NAMES.length];

export const nameColours = (count) =>
  texture(Array.from({ length: count }, (_, i) => parts(NAMES[i % NAMES.length])), NearestFilter);
