// Numbers and units as people read them.

const PREFIXES = [["n", 1e-9], ["µ", 1e-6], ["m", 1e-3], ["", 1], ["k", 1e3], ["M", 1e6], ["G", 1e9]];
const PREFIXED = new Set(["m", "Pa", "m/s", "N", "J", "W", "m/s^2", "J/m^3", "s", "N m", "N s"]);

/// The factor and the unit that give handy numbers: 2.3e5 Pa as 230 kPa, 2e-9 m^3 as 2 mm^3.
export function handyUnit(unit, largest) {
  const power = unit.match(/^m\^([23])$/)?.[1];
  if (power && largest > 0) {
    const [prefix, factor] = [["µ", 1e-6], ["m", 1e-3], ["c", 1e-2]].find(([, f]) => largest < 1000 * f ** power) ?? ["", 1];
    return [factor ** power, prefix + unit];
  }
  if (!PREFIXED.has(unit) || !(largest > 0)) return [1, unit];
  let [prefix, factor] = PREFIXES.find(([, f]) => largest < 1000 * f) ?? PREFIXES.at(-1);
  if ((unit.startsWith("m") || unit === "s") && factor > 1) [prefix, factor] = ["", 1];
  return [factor, prefix + unit];
}

/// That of an axis of times, as `pliant plot` has it: tenths of seconds remain seconds.
export const unitOfTimes = (last) => (last >= 0.1 ? [1, "s"] : handyUnit("s", last));

/// Lowest and highest of the finite ones among numbers, however many: a function does not take more than about 10^5 arguments.
export function span(values) {
  let low = Infinity, high = -Infinity;
  for (const x of values) if (Number.isFinite(x)) (low = Math.min(low, x)), (high = Math.max(high, x));
  return high >= low ? [low, high] : [0, 0];
}

export const largest = (values) => Math.max(...span(values).map(Math.abs));
export const extent = (values) => { const [low, high] = span(values); return high - low; };

export const typeset = (unit) =>
  unit.replace(/\^(-?\d+)/g, (_, n) => [...n].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("")).replaceAll("*", "·");

/// About `count` round numbers from low to high.
export function ticks(low, high, count = 5) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const near = [1, 2, 2.5, 5, 10].reduce((a, b) => (Math.abs(b - rough / power) < Math.abs(a - rough / power) ? b : a));
  const step = near * power, values = [];
  for (let i = Math.ceil(low / step - 1e-9); i <= high / step + 1e-9; ++i) values.push(i * step);
  return values;
}

const minus = (text) => text.replaceAll("-", "\u2212");

/// With so many significant digits, no zeros at the end.
export function short(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return minus(String(Number(value.toPrecision(digits))));
  return minus(value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e"));
}

export const grouped = (n) => n.toLocaleString("en").replaceAll(",", "\u2009");

/// A time, or a load, which has no unit, with as many decimals as distinguish the frames.
export function timeText(times, unitOfTime) {
  const last = largest(times), [factor, unit] = handyUnit(unitOfTime, last);
  const gap = times.length > 1 ? (last / factor) / (times.length - 1) : 1;
  const enough = Math.max(0, Math.ceil(-Math.log10(gap || 1) + 0.3)), scaled = gap * 10 ** enough;
  const decimals = Math.min(6, enough + (Math.abs(scaled - Math.round(scaled)) > 0.01 * scaled ? 1 : 0));  // 0.75, not 0.8
  return (t) => [(t / factor).toFixed(decimals), unit];
}

/// How fast it is shown: 0.17 s in a second as "1/6 of real time".
export function paceText(pace) {
  if (Math.abs(pace - 1) < 0.01) return "real time";
  const rounded = (x) => grouped(Number(x.toPrecision(x < 3 ? 2 : x < 10 ? 1 : 2)));
  return pace < 1 ? `1/${rounded(1 / pace)} of real time` : `${rounded(pace)} × real time`;
}

const NAMES = { "von mises": "von Mises", "cauchy": "Cauchy", "first piola kirchhoff": "first Piola-Kirchhoff", "green lagrange": "Green-Lagrange" };

/// von_mises_stress as "von Mises stress"
export const inWords = (name) => name.replaceAll("_", " ").replace(/\b(von mises|cauchy|first piola kirchhoff|green lagrange)\b/, (found) => NAMES[found]);

/// The same as a title: "Von Mises stress"
export function spelt(name) {
  const text = inWords(name);
  return text[0].toUpperCase() + text.slice(1);
}
