// `pliant report`: puts the page together.
import { report, readHistory } from "./data.js";
import { Bodies } from "./bodies.js";
import { Items, showFindings } from "./items.js";
import { Mechanisms } from "./mechanisms.js";
import { Obstacles } from "./obstacles.js";
import { Panel } from "./panel.js";
import { Picture, pictureControls } from "./picture.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Points } from "./points.js";
import { View, VIEWS } from "./scene.js";
import { Second, namesOf, showDifferences } from "./second.js";
import { addFacts, showFacts, showModelFacts, showRun, showTexts } from "./texts.js";
import { watch } from "./watch.js";
import "./style.css";  // after that of the plots, which it changes

/// The time of a static analysis is a load factor, or the length of its path; otherwise empty.
const isStatic = !/^time:\n(?: .*\n)*?  method: static$/m.test(report.input) ? ""
  : /^time:\n(?: .*\n)*?  path:/m.test(report.input) ? "path" : "load";
const place = (id) => document.getElementById(id);

/// The axes of space, seen as the bodies are.
function drawTriad(camera) {
  const colours = ["#d1504a", "#3f9c6b", "#4a80c9"];
  const m = camera.matrixWorldInverse.elements;
  const axes = [0, 1, 2].map((k) => ({ k, x: 26 * m[4 * k], y: -26 * m[4 * k + 1], depth: m[4 * k + 2] }));
  axes.sort((a, b) => a.depth - b.depth);
  place("triad").innerHTML = axes.map(({ k, x, y }) =>
    `<line x2="${x.toFixed(1)}" y2="${y.toFixed(1)}" stroke="${colours[k]}"/>` +
    `<text x="${(1.33 * x).toFixed(1)}" y="${(1.33 * y).toFixed(1)}" fill="${colours[k]}">${"xyz"[k]}</text>`).join("");
}

/// What there is of the second run besides its drawing; for the plots its history and its name.
function surroundSecond(second) {
  const names = namesOf(report);
  [second.firstName, second.name] = names;
  ["name", "name-2"].forEach((id, i) => {
    place(id).textContent = place(id).title = names[i];
    place(id).hidden = false;
  });
  place("stage-2").hidden = false;
  place("title").textContent = document.title = report.title === report.other.title ? report.title : `${report.title} | ${report.other.title}`;
  addFacts(report.other, second.history, isStatic, names);
  showRun(place("run"), report.other, names);
  showDifferences(place("run"), report, names);
  return { history: second.history, names };
}

/// Past the end of the shorter run its name says where it has ended: its drawing stays as it was there.
function markEnds(player, second, bodies) {
  const ends = [bodies, second.bodies].map(({ frames }) => frames.at(-1).time), names = [second.firstName, second.name];
  const texts = ends.map((end) => player.text(end).join(" ").trim());
  player.listen((time) => ["name", "name-2"].forEach((id, i) => {
    place(id).textContent = names[i] + (time > ends[i] ? ` · ended at ${texts[i]}` : "");
  }));
}

/// What surrounds the drawing of a run: its history in plots.
async function surroundRun(player, second) {
  const history = await readHistory(report);
  showFacts(report, history, isStatic);
  showRun(place("run"), report);
  const others = second && surroundSecond(second);
  const plots = new Plots(place("plots"), history, { isStatic, taken: report.taken ?? [], others, seek: (time) => player.seek(time) });
  player.listen((time) => plots.mark(time));
  return { history, plots };
}

/// What surrounds that of a model before its run: what the check found. Nothing plays.
function surroundModel() {
  for (const part of document.querySelectorAll(".transport, #plots")) part.hidden = true;
  showModelFacts(report);
  showFindings(place("run"), report.model);
  return {};
}

/// The number of the field that the page opens with: stresses of bodies, or else forces of shells, or else the first one, which is the
/// displacement. Rods and shells have no stress.
function openingField(fields, { tetrahedra, triangles }) {
  const number = (name) => fields.findIndex((field) => field.name === name);
  const wanted = [...(tetrahedra ? ["von_mises_stress"] : []), ...(triangles ? ["principal_membrane_force_1"] : [])];
  const found = wanted.map(number).find((k) => k >= 0);
  return String(found ?? (fields.length ? 0 : "none"));
}

async function start() {
  const bodies = await Bodies.load(report.result);
  const second = report.other ? await Second.load(report.other, bodies) : null;
  const player = new Player(second ? second.frames(bodies.frames) : bodies.frames, isStatic);
  const { history, plots } = report.model ? surroundModel() : await surroundRun(player, second);
  if (second && !player.hasLabels) markEnds(player, second, bodies);
  showTexts(place("texts"), report);
  let view;
  try {
    view = new View(place("view"), bodies, await Obstacles.load(bodies), await Mechanisms.load(bodies));
  } catch (error) {
    // Without WebGL there are still the plots.
    place("trouble").hidden = false;
    place("trouble").textContent = `This browser draws no 3D here: ${error.message}`;
    document.documentElement.dataset.ready = "without 3D";
    return;
  }
  await second?.show(view);
  const panel = new Panel(place("panel"), view, bodies, place("legend"));
  const points = new Points(view, panel, plots, { marks: place("marks"), table: place("points") });
  view.look = (camera) => {
    drawTriad(camera);
    points.draw();
  };
  second?.addPoints(panel, plots, second.name);
  const picture = new Picture({ report, view, panel, player, points, second });
  place("panel").append(...pictureControls(picture));
  let items;
  if (report.model) {
    items = await Items.load(view);
    place("panel").prepend(...items.list());
    panel.colour.value = bodies.areSeveral ? "bodies" : "none";
  } else {
    panel.colour.value = openingField(bodies.fields, report.result.elements);
  }
  await panel.paint();
  player.listen((time) => view.set({ time }));
  view.aim(VIEWS.iso);
  player.seek(player.hasLabels ? player.start : player.end);
  await watch({ player, view, panel, points, picture });
  // For those who drive the page from outside.
  window.pliant = { player, view, panel, bodies, history, points, picture, items, second };
  requestAnimationFrame(() => requestAnimationFrame(() => (document.documentElement.dataset.ready = "yes")));
}

start().catch((error) => {
  place("trouble").hidden = false;
  place("trouble").textContent = `This page cannot be shown: ${error.message}`;
  throw error;
});
