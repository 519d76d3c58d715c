// What is saved from the page: the picture with its legend, title and time, and a video of it.
import { element } from "./elements.js";
import { drawLegend } from "./legend.js";
import { runName } from "./texts.js";
import { webm } from "./webm.js";

const CODECS = { "vp09.00.51.08": "V_VP9", vp8: "V_VP8" };
const RATE = 30, BITS = 12e6, KEYS = 30;  // pictures and bits in a second, pictures from key to key
const REST = 0.3;  // [s] for which the last picture stays

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function save(blob, name) {
  const link = element("a", { download: name, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export class Picture {
  /// `report`: of the page; `points`: whose marks are drawn.
  /// `second`: the other run on the page, or null.
  constructor({ report, view, panel, player, points, second }) {
    Object.assign(this, { view, panel, player, points, second, title: document.title });
    this.run = second ? "comparison" : runName(report);
    this.canvas = document.createElement("canvas");
    this.pen = this.canvas.getContext("2d", { willReadFrequently: true });  // by the encoder
  }

  /// The picture as it is on the screen, in pixels of the screen.
  compose() {
    const { pen, canvas, view, second } = this, { height } = view.canvas, font = styleOf("--font");
    const half = view.canvas.width, width = half + (second ? second.view.canvas.width : 0);
    // Encoders of videos need even sizes.
    const [evenWidth, evenHeight] = [width - (width % 2), height - (height % 2)];
    if (canvas.width !== evenWidth || canvas.height !== evenHeight) Object.assign(canvas, { width: evenWidth, height: evenHeight });
    const ratio = half / view.canvas.clientWidth;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    const shade = pen.createLinearGradient(0, 0, 0, height);
    shade.addColorStop(0, styleOf("--stage-top"));
    shade.addColorStop(1, styleOf("--stage-end"));
    pen.fillStyle = shade;
    pen.fillRect(0, 0, width, height);
    pen.drawImage(view.canvas, 0, 0);
    if (second) pen.drawImage(second.view.canvas, half, 0);
    pen.scale(ratio, ratio);
    const ink = styleOf("--ink"), card = styleOf("--veil"), wide = view.canvas.clientWidth;
    for (const mark of this.points.marks ?? []) this.drawMark(mark, { font, ink, card, wide });
    if (second) this.drawSecond({ font, ink, card, wide });
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    for (const [text, size, bottom] of [[this.title, "600 18px", 32], [this.timeLine(), "14px", 56]]) {
      pen.font = `${size} ${font}`;
      pen.fillStyle = card;
      pen.fillRect(10, bottom - 20, Math.min(pen.measureText(text).width, wide - 200) + 12, 26);
      pen.fillStyle = ink;
      pen.fillText(text, 16, bottom, wide - 200);
    }
    drawLegend(pen, this.panel.shown, this.panel.note, { right: wide - 12, top: 12, font, ink, card });
    return canvas;
  }

  /// The marks of the second run, and the names of both.
  drawSecond(style) {
    const { pen, second } = this, { wide, font, ink } = style;
    pen.save();
    pen.translate(wide, 0);
    for (const mark of second.points.marks ?? []) this.drawMark(mark, style);
    pen.restore();
    pen.font = `600 14px ${font}`;
    pen.fillStyle = ink;
    pen.textAlign = "center";
    pen.textBaseline = "alphabetic";
    [second.firstName, second.name].forEach((name, i) => pen.fillText(name, (i + 0.5) * wide, this.view.canvas.clientHeight - 16, wide - 100));
  }

  timeLine() {
    if (this.player.hasLabels) return this.player.label();
    const [number, unit] = this.player.text(this.player.time);
    return this.player.isStatic ? `${this.player.isStatic} ${number}` : `t = ${number} ${unit}`;
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

  renderAll() {
    this.view.render();
    this.second?.view.render();
  }

  savePicture() {
    this.renderAll();  // with what was set since the last drawing
    const [number, unit] = this.player.text(this.player.time);
    const kind = this.player.hasLabels ? "mode" : this.player.isStatic || "t";
    const name = `${this.run}_${kind}${number}${kind === "t" ? unit.replace("µ", "u") : ""}.png`;
    this.compose().toBlob((blob) => save(blob, name), "image/png");
  }

  /// A video of all from the start to the end, at the speed of the player, with every picture however slow this browser
  /// draws; a second call ends it early. `changed(share)`: how much is done, null at the end.
  async record(changed) {
    if (this.isRecording) return (this.isRecording = false);
    this.isRecording = true;
    this.player.pause();
    try {
      await this.encode(changed);
    } finally {
      this.isRecording = false;
      changed(null);
    }
  }

  async encode(changed) {
    const { player } = this, { width, height } = this.compose();
    const size = { width, height, bitrate: BITS, framerate: RATE, latencyMode: "realtime" };
    let codec = null;
    for (const name of Object.keys(CODECS)) {
      if (!codec && (await VideoEncoder.isConfigSupported({ codec: name, ...size })).supported) codec = name;
    }
    if (!codec) throw new Error("this browser encodes no video of this size");
    const pictures = [];
    let failure = null;
    const encoder = new VideoEncoder({ error: (error) => (failure = error), output: (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      pictures.push({ time: Math.round(chunk.timestamp / 1000), isKey: chunk.type === "key", data });
    } });
    encoder.configure({ codec, ...size });
    const moving = Math.ceil(((player.end - player.start) / player.speed()) * RATE), count = moving + 1 + Math.round(REST * RATE);
    for (let i = 0; i < count && this.isRecording && !failure; ++i) {
      player.seek(i < moving ? player.start + (i * player.speed()) / RATE : player.end);
      this.renderAll();
      const frame = new VideoFrame(this.compose(), { timestamp: (1e6 * i) / RATE, duration: 1e6 / RATE });
      encoder.encode(frame, { keyFrame: i % KEYS === 0 });
      frame.close();
      changed(i / count);
      do await new Promise((done) => setTimeout(done)); while (encoder.encodeQueueSize > 4);
    }
    if (!failure) await encoder.flush();
    if (failure) throw failure;
    encoder.close();
    save(webm(pictures, { codec: CODECS[codec], width, height, length: (1000 * pictures.length) / RATE }), `${this.run}.webm`);
  }
}

/// The row of the panel.
export function pictureControls(picture) {
  const isAble = Boolean(globalThis.VideoEncoder);
  const word = element("span", { className: "refused", hidden: true });
  const video = element("button", { id: "save-video", textContent: "Video", disabled: !isAble,
    title: isAble ? "save all of it as a video, at the speed of the player" : "this browser does not encode videos",
    onclick: () => {
      word.hidden = true;
      picture.record((share) => (video.textContent = share === null ? "Video" : `Stop at ${Math.floor(100 * share)} %`)).catch((error) => {
        word.hidden = false;
        word.textContent = error.message;
      });
    } });
  return [element("div", { className: "row views" },
    element("button", { id: "save-picture", textContent: "PNG", title: "save the picture with its legend and time", onclick: () => picture.savePicture() }), video), word];
}
