// The colour bar, on the page and in pictures of it.
import { colourAt, gradient, shareOf } from "./colours.js";
import { element } from "./elements.js";
import { handyUnit, short, ticks, typeset } from "./numbers.js";

/// Where which numbers stand on the bar, from 0 to 1.
function marksOf({ low, high, only }, factor) {
  if (only !== undefined) return [{ share: (only - low) / (high - low), text: short(only / factor) }];
  return ticks(low / factor, high / factor).map((value) => ({
    share: (value * factor - low) / (high - low),
    text: short(Math.abs(value) < 1e-12 * Math.max(Math.abs(low), Math.abs(high)) / factor ? 0 : value),
  }));
}

const unitOf = ({ unit, low, high, only }) => handyUnit(unit, Math.abs(only ?? Math.max(Math.abs(low), Math.abs(high))));

/// The range of the bar: of a value that is the same everywhere, that alone.
const barOf = ({ low, high, only }) => (only === undefined ? [low, high] : [only, only]);

/// `shown`: label, unit, low, high, kind of the colours; without a kind there is no bar. `note`: a line below.
export function showLegend(place, shown, note) {
  place.replaceChildren();
  if (shown.kind) {
    const [factor, unit] = unitOf(shown);
    const bar = element("div", { className: "bar" }), marks = element("div", { className: "marks" });
    bar.style.background = gradient(shown.kind, shown.low, shown.high, ...barOf(shown));
    for (const { share, text } of marksOf(shown, factor)) {
      const mark = element("span", { textContent: text });
      mark.style.bottom = `${100 * share}%`;
      marks.append(mark);
    }
    marks.style.width = `${Math.max(1, ...[...marks.children].map((mark) => mark.textContent.length))}ch`;
    place.append(element("div", { className: "label" }, element("b", { textContent: shown.label }), element("span", { textContent: unit ? ` ${typeset(unit)}` : "" })),
                 element("div", { className: "scale" }, bar, marks));
  }
  if (note) place.append(element("div", { className: "note", textContent: note }));
  place.hidden = !place.children.length;
}

/// The same with a pen of a picture, its right upper corner at `right`, `top`.
export function drawLegend(pen, shown, note, { right, top, font, ink, card }) {
  const box = (y, width, height) => {
    pen.fillStyle = card;
    pen.fillRect(right - width, y, width, height);
    pen.fillStyle = ink;
  };
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  let y = top;
  if (shown.kind) {
    const [factor, unit] = unitOf(shown), label = shown.label + (unit ? ` ${typeset(unit)}` : ""), height = 200, marks = marksOf(shown, factor);
    pen.font = `600 14px ${font}`;
    box(y, pen.measureText(label).width + 16, 26);
    pen.fillText(label, right - 8, y + 14);
    pen.font = `12px ${font}`;
    box(y + 30, Math.max(...marks.map(({ text }) => pen.measureText(text).width)) + 36, height + 20);
    for (const { share, text } of marks) pen.fillText(text, right - 28, y + 40 + height * (1 - share));
    const [bottom, upper] = barOf(shown);
    for (let i = 0; i < height; ++i) {
      const value = upper - (i / height) * (upper - bottom);
      pen.fillStyle = `rgb(${colourAt(shown.kind, shareOf(shown.kind, value, shown.low, shown.high))})`;
      pen.fillRect(right - 20, y + 40 + i, 12, 1);
    }
    y += height + 54;
  }
  if (!note) return;
  pen.font = `12px ${font}`;
  box(y, pen.measureText(note).width + 16, 22);
  pen.fillText(note, right - 8, y + 12);
}
