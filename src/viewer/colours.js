// Values to colours: perceptually uniform maps; a diverging one about zero for values of both signs.
import { DataTexture, LinearFilter, NearestFilter, SRGBColorSpace } from "three";

// Stops of matplotlib's viridis and cividis (the one for every colour vision) and of ColorBrewer's RdBu, without the darkest
// ends: shading needs colours that can become darker.
const VIRIDIS = ["46307e", "3f4788", "365d8d", "2c728e", "23888e", "1f9d8a", "2db27d", "54c568", "86d549", "bddf26", "fde725"];
const CIVIDIS = ["0f3570", "2f4670", "45566f", "57656f", "6a7470", "7b8376", "8e9377", "a3a474", "b9b66c", "d0c860", "e8dc4d", "fde737"];
const RED_BLUE = ["2166ac", "4393c3", "92c5de", "d1e5f0", "f7f7f7", "fddbc7", "f4a582", "d6604d", "b2182b"];
const NAMES = ["5b8fd6", "e08a5c", "5fb88a", "a283cf", "d8b04c", "63b9c7", "cf7198", "8f98a6", "9bbf5a", "c08f72"];

const parts = (hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16));

/// The colour at 0 <= s <= 1 between stops.
function between(stops, s) {
  const at = s * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2);
  const [a, b] = [parts(stops[i]), parts(stops[i + 1])];
  return a.map((x, k) => Math.round(x + (at - i) * (b[k] - x)));
}

const STOPS = { viridis: VIRIDIS, cividis: CIVIDIS, diverging: RED_BLUE };
const stopsOf = (kind) => STOPS[kind];

/// Names of maps for people. The diverging one has its middle at zero.
export const MAPS = { auto: "automatic", viridis: "viridis", cividis: "cividis", diverging: "blue to red about 0" };

/// Whether a range has values of both signs, not just by rounding.
export const straddles = (low, high) => low < -0.02 * (high - low) && high > 0.02 * (high - low);

/// The range of colours for values from `low` to `high`; `only`: the value of all, where it is the same.
export function rangeOf(low, high) {
  if (!(high > low)) return { only: low, low: low === 0 ? 0 : low - Math.abs(low) / 2, high: low === 0 ? 1 : low + Math.abs(low) / 2 };
  if (straddles(low, high)) return { low: -Math.max(-low, high), high: Math.max(-low, high) };
  return { low: low >= 0 && low < 0.5 * high ? 0 : low, high };
}

/// The map of a range that has not been given one.
export const mapOf = (chosen, low, high) => (chosen !== "auto" ? chosen : straddles(low, high) ? "diverging" : "viridis");

/// Where a value of a range is on a map: 0 to 1.
export function shareOf(kind, value, low, high) {
  const within = Math.min(high, Math.max(low, value)), most = Math.max(Math.abs(low), Math.abs(high));
  return kind === "diverging" ? (within / most + 1) / 2 : (within - low) / (high - low);
}

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

/// One of the names of MAPS, but not "auto".
export function colourMap(kind) {
  if (!textures.has(kind)) textures.set(kind, texture(map(stopsOf(kind)), LinearFilter));
  return textures.get(kind);
}

/// The colours from `bottom` to `top` in the part of a map that a range takes.
export function gradient(kind, low, high, bottom, top) {
  const stops = Array.from({ length: 17 }, (_, i) => colourAt(kind, shareOf(kind, bottom + (i / 16) * (top - bottom), low, high)));
  return `linear-gradient(to top, ${stops.map((c) => `rgb(${c})`).join(", ")})`;
}

export const nameColour = (i) => "#" + NAMES[i % NAMES.length];

export const nameColours = (count) =>
  texture(Array.from({ length: count }, (_, i) => parts(NAMES[i % NAMES.length])), NearestFilter);
