// What is saved from the page: the picture with its legend, title and time, and a video of it.
import { element } from "./elements.js";
import { drawLegend } from "./legend.js";

const FORMATS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const RATE = 12e6;  // [bit/s]

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function save(blob, name) {
  const link = element("a", { download: name, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export class Picture {
  /// `report`: of the page; `points`: whose marks are drawn.
  constructor({ report, view, panel, player, points }) {
    Object.assign(this, { view, panel, player, points, title: document.title });
    this.run = report.directory.split("/").filter(Boolean).at(-1) || "pliant";
    this.canvas = document.createElement("canvas");
    this.pen = this.canvas.getContext("2d");
  }

  /// The picture as it is on the screen, in pixels of the screen.
  compose() {
    const { pen, canvas, view } = this, { width, height } = view.canvas, font = styleOf("--font");
    // Encoders of videos need even sizes.
    const [evenWidth, evenHeight] = [width - (width % 2), height - (height % 2)];
    if (canvas.width !== evenWidth || canvas.height !== evenHeight) Object.assign(canvas, { width: evenWidth, height: evenHeight });
    const ratio = width / view.canvas.clientWidth;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    const shade = pen.createLinearGradient(0, 0, 0, height);
    shade.addColorStop(0, styleOf("--stage-top"));
    shade.addColorStop(1, styleOf("--stage-end"));
    pen.fillStyle = shade;
    pen.fillRect(0, 0, width, height);
    pen.drawImage(view.canvas, 0, 0);
    pen.scale(ratio, ratio);
    const ink = styleOf("--ink"), card = styleOf("--veil"), wide = view.canvas.clientWidth;
    for (const mark of this.points.marks ?? []) this.drawMark(mark, { font, ink, card, wide });
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    pen.fillStyle = ink;
    pen.font = `600 18px ${font}`;
    pen.fillText(this.title, 16, 32, wide - 200);
    pen.font = `14px ${font}`;
    pen.fillText(this.timeLine(), 16, 54);
    drawLegend(pen, this.panel.shown, this.panel.note, { right: wide - 12, top: 12, font, ink, card });
    return canvas;
  }

  timeLine() {
    const [number, unit] = this.player.text(this.player.time);
    return this.player.isStatic ? `load ${number}` : `t = ${number} ${unit}`;
  }

  drawMark({ x, y, text, colour }, { font, ink, card, wide }) {
    const { pen } = this, isLeft = x > wide - 110;
    pen.fillStyle = colour ?? ink;
    pen.strokeStyle = "#ffffff";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(x, y, 4.5, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
    pen.font = `600 12px ${font}`;
    pen.textAlign = isLeft ? "right" : "left";
    pen.textBaseline = "middle";
    const width = pen.measureText(text).width + 10, left = isLeft ? x - 9 - width : x + 9;
    pen.fillStyle = card;
    pen.fillRect(left, y - 9, width, 18);
    pen.fillStyle = colour ?? ink;
    pen.fillText(text, isLeft ? left + width - 5 : left + 5, y + 1);
  }

  savePicture() {
    this.view.render();  // with what was set since the last drawing
    const [number, unit] = this.player.text(this.player.time);
    const name = `${this.run}_${this.player.isStatic ? "load" : "t"}${number}${this.player.isStatic ? "" : unit.replace("µ", "u")}.png`;
    this.compose().toBlob((blob) => save(blob, name), "image/png");
  }

  static format() {
    if (!globalThis.MediaRecorder || !HTMLCanvasElement.prototype.captureStream) return null;
    return FORMATS.find((format) => MediaRecorder.isTypeSupported(format)) ?? null;
  }

  /// Plays from the start to the end and saves that as a video; a second call ends it early. `told(isRecording)`.
  record(told) {
    const { player, view } = this;
    if (this.recorder) return player.pause();
    this.compose();
    const type = Picture.format(), parts = [];
    const recorder = (this.recorder = new MediaRecorder(this.canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: RATE }));
    recorder.ondataavailable = ({ data }) => data.size && parts.push(data);
    recorder.onstop = () => {
      this.recorder = view.recorded = player.paused = null;
      told(false);
      save(new Blob(parts, { type: type.split(";")[0] }), `${this.run}.${type.includes("mp4") ? "mp4" : "webm"}`);
    };
    view.recorded = () => this.compose();
    player.seek(player.start);
    recorder.start(500);
    told(true);
    player.play();
    // The last picture stays for a moment.
    player.paused = () => setTimeout(() => recorder.state === "recording" && recorder.stop(), 400);
  }
}

/// The row of the panel.
export function pictureControls(picture) {
  const type = Picture.format();
  const video = element("button", { id: "save-video", textContent: "Video", disabled: !type,
    title: type ? "play all and save it as a video, at the speed of the player" : "this browser does not record videos",
    onclick: () => picture.record((isRecording) => (video.textContent = isRecording ? "Stop" : "Video")) });
  return element("div", { className: "row views" },
    element("button", { id: "save-picture", textContent: "PNG", title: "save the picture with its legend and time", onclick: () => picture.savePicture() }), video);
}
