// The time that is shown, and what moves it.
import { timeText } from "./numbers.js";

const place = (id) => document.getElementById(id);
const ICONS = { play: "M3 1.5v13l11-6.5z", pause: "M3 1.5h3.5v13H3zM9.5 1.5H13v13H9.5z" };

export class Player {
  constructor(frames) {
    this.frames = frames;
    this.start = frames[0].time;
    this.end = frames.at(-1).time;
    this.listeners = [];
    this.playing = false;
    // All of it in 3 to 12 seconds, 25 frames in one; where that is near the pace of life, at that.
    const span = this.end - this.start || 1;
    const seconds = Math.min(12, Math.max(3, frames.length / 25));
    this.pace = span / seconds;
    if (this.pace > 0.6 && this.pace < 1.7) this.pace = 1;
    this.text = timeText(frames.map((f) => f.time));
    place("scrub").min = this.start;
    place("scrub").max = this.end > this.start ? this.end : this.start + 1;
    for (const factor of [0.1, 0.25, 0.5, 1, 2, 4]) {
      place("speed").append(new Option(`${factor}×`, factor, factor === 1, factor === 1));
    }
    place("speed").title = `1× shows ${Number(this.pace.toPrecision(2))} s in a second`;
    place("scrub").oninput = () => this.seek(Number(place("scrub").value));
    place("play").onclick = () => (this.playing ? this.pause() : this.play());
    addEventListener("keydown", (event) => this.key(event));
    this.icon();
  }

  listen(listener) {
    this.listeners.push(listener);
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
    place("time").innerHTML = `<b>${number}</b> ${unit}`;
    for (const listener of this.listeners) listener(this.time);
  }

  play() {
    if (this.time >= this.end) this.seek(this.start);
    this.playing = true;
    this.icon();
    let last = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      const step = Math.max(0, Math.min(0.25, (now - last) / 1000)) * this.pace * Number(place("speed").value);
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

  key(event) {
    if (/^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(event.target.tagName) && event.target.type !== "range") return;
    const action = { " ": () => (this.playing ? this.pause() : this.play()), ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1),
                     Home: () => this.seek(this.start), End: () => this.seek(this.end) }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
