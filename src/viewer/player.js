// The time that is shown, and what moves it.
import { paceText, timeText } from "./numbers.js";

const place = (id) => document.getElementById(id);
const ICONS = { play: "M3 1.5v13l11-6.5z", pause: "M3 1.5h3.5v13H3zM9.5 1.5H13v13H9.5z" };

export class Player {
  /// `isStatic`: "load" or "path" if the time is that of a static analysis, which has no pace.
  constructor(frames, isStatic) {
    Object.assign(this, { frames, isStatic });
    this.start = frames[0].time;
    this.end = frames.at(-1).time;
    this.listeners = [];
    this.playing = false;
    // All of it in 3 to 12 seconds, 25 frames in one; where that is near the pace of life, at that.
    const span = this.end - this.start || 1;
    const seconds = Math.min(12, Math.max(3, frames.length / 25));
    this.pace = span / seconds;
    if (this.pace > 0.6 && this.pace < 1.7) this.pace = 1;
    this.text = timeText(frames.map((f) => f.time), isStatic ? "" : "s");
    this.hasLabels = frames.some((f) => f.label);
    place("scrub").min = this.start;
    place("scrub").max = this.end > this.start ? this.end : this.start + 1;
    for (const factor of [0.1, 0.25, 0.5, 1, 2, 4]) {
      place("speed").append(new Option(`${factor}×`, factor, factor === 1, factor === 1));
    }
    place("speed").onchange = () => (place("pace").textContent = isStatic || this.hasLabels ? "" : paceText(this.speed()));
    place("speed").onchange();
    place("scrub").oninput = () => this.seek(Number(place("scrub").value));
    place("play").onclick = () => (this.playing ? this.pause() : this.play());
    addEventListener("keydown", (event) => this.key(event));
    this.releaseKeys();
    this.icon();
  }

  listen(listener) {
    this.listeners.push(listener);
  }

  /// What is shown in place of the time: of the last frame that has begun.
  label() {
    return this.frames.findLast((f) => f.time <= this.time)?.label ?? "";
  }

  /// Seconds of the run that are shown in one.
  speed() {
    return this.pace * Number(place("speed").value);
  }

  icon() {
    place("play").innerHTML = `<svg viewBox="0 0 16 16" width="16" height="16"><path d="${ICONS[this.playing ? "pause" : "play"]}"/></svg>`;
    place("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  seek(time) {
    this.time = Math.min(this.end, Math.max(this.start, time));
    place("scrub").value = this.time;
    place("scrub").style.setProperty("--done", `${(100 * (this.time - this.start)) / (this.end - this.start || 1)}%`);
    const [number, unit] = this.text(this.time);
    if (this.hasLabels) place("time").textContent = this.label();
    else place("time").innerHTML = this.isStatic ? `${this.isStatic} <b>${number}</b>` : `<b>${number}</b> ${unit}`;
    for (const listener of this.listeners) listener(this.time);
  }

  play() {
    if (this.time >= this.end) this.seek(this.start);
    this.playing = true;
    this.icon();
    let last = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      const step = Math.max(0, Math.min(0.25, (now - last) / 1000)) * this.speed();
      last = now;
      this.seek(this.time + step);
      if (this.time >= this.end) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.icon();
  }

  /// To the next frame, or back.
  step(by) {
    this.pause();
    const now = this.frames.reduce((best, f, i) => (Math.abs(f.time - this.time) < Math.abs(this.frames[best].time - this.time) ? i : best), 0);
    this.seek(this.frames[Math.min(this.frames.length - 1, Math.max(0, now + by))].time);
  }

  /// The keyboard belongs to the player again after a click on a control: only what is typed into, and what the keyboard
  /// itself has reached, keeps it. The Tab key continues where the click was.
  releaseKeys() {
    const release = () => setTimeout(() => {
      const { activeElement: active } = document;
      if (active === this.clicked && !isTypedInto(active)) active.blur();
    });
    addEventListener("pointerdown", ({ target }) => {
      const control = target.closest("label")?.control ?? target.closest("button, select, input, summary");
      this.clicked = control ?? null;
    }, true);
    addEventListener("focusin", ({ target }) => target !== this.clicked && (this.clicked = null));
    addEventListener("click", ({ target }) => target.tagName !== "SELECT" && release());
    addEventListener("change", release);
  }

  key(event) {
    const { target, key } = event;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (isTypedInto(target)) {
      if (key === "Enter") target.blur();  // which is a change
      return;
    }
    const isOwn = /^(INPUT|SELECT|BUTTON|SUMMARY)$/.test(target.tagName) && target.id !== "scrub";
    if (isOwn && (target !== this.clicked || isOpen(target))) return;
    const action = { " ": () => (this.playing ? this.pause() : this.play()), ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1),
                     Home: () => this.seek(this.start), End: () => this.seek(this.end) }[key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}

const isTypedInto = (target) => target.tagName === "TEXTAREA" || (target.tagName === "INPUT" && /^(number|text)$/.test(target.type));

/// Whether a list of choices has its menu open; older browsers do not say, and the keys are then the list's.
function isOpen(target) {
  if (target.tagName !== "SELECT") return false;
  return !CSS.supports("selector(:open)") || target.matches(":open");
}
