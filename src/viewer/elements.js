// What the controls of the page are made of.

export function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/// A field for a number. `refuse(value)` returns what is wrong with it, or nothing; then `apply(value)` is called. A number
/// that is refused is replaced by the one before, with a word next to the field until the next input.
export class NumberField {
  constructor({ id, title, value, refuse, apply }) {
    this.input = element("input", { type: "number", step: "any", id: id ?? "", title });
    this.input.setAttribute("aria-label", title);
    this.word = element("span", { className: "refused", hidden: true });
    this.word.setAttribute("role", "alert");
    this.value = value;
    this.input.oninput = () => (this.word.hidden = true);
    this.input.onchange = () => {
      const typed = this.input.valueAsNumber, wrong = Number.isFinite(typed) ? refuse(typed) : "not a number";
      if (!wrong) this.kept = typed;
      this.input.value = this.kept ?? "";
      this.word.hidden = !wrong;
      this.word.textContent = wrong ? `${wrong}; ${this.kept} is kept` : "";
      if (!wrong) apply(typed);
    };
  }

  get value() {
    return this.kept;
  }

  set value(value) {
    this.kept = value;
    this.input.value = value ?? "";
    this.word.hidden = true;
  }
}

/// A factor that can be drawn with.
export const refuseFactor = (value) =>
  value <= 0 ? "must be above 0" : value < 1e-6 || value > 1e6 ? "must be from 1e-6 to 1e6" : "";
