// The words of the page: what ran, how it ended, what it took, its input.
import { element } from "./elements.js";
import { grouped, short } from "./numbers.js";

const place = (id) => document.getElementById(id);

/// Value of a key of run.yaml, whose lines are plain.
const given = (input, key) => input.match(new RegExp(`^ *${key}: *"?([^"\\n{]+)"?$`, "m"))?.[1];

/// How many elements of each kind; nodes too where all are those of tetrahedra.
function sizeOf({ elements: { tetrahedra, triangles, segments }, nodes, order }) {
  const kinds = [[tetrahedra, `tetrahedra (P${order})`], [triangles, "triangles of shells"], [segments, "segments of rods"]];
  const sizes = kinds.filter(([count]) => count > 0).map(([count, what]) => `${grouped(count)} ${what}`);
  if (tetrahedra > 0 && sizes.length === 1) sizes.push(`${grouped(nodes)} nodes`);
  return sizes.length ? sizes : ["rigid bodies alone"];
}

const countOf = (warnings) => `${warnings} ${warnings === 1 ? "warning" : "warnings"}`;

/// The same for a model that has not run.
export function showModelFacts({ title, result, model, program, written, directory }) {
  place("title").textContent = document.title = title;
  place("outcome").textContent = "model";
  const warnings = model.diagnostics.filter((d) => d.severity === "warning").length;
  place("facts").textContent = [...sizeOf(result), "before the start",
    ...(warnings ? [countOf(warnings)] : [])].join("  ·  ");
  place("made").textContent = `Made with ${program.split("\n")[0]} on ${written} from ${directory}`;
}

/// The name of the directory of a result.
export const runName = ({ directory }) => directory.split("/").filter(Boolean).at(-1) || "pliant";

/// Whether the frames are modes, whose label says which.
const hasModes = ({ frames }) => frames.some((frame) => frame.label);

const OUTCOMES = { done: "done", interrupted: "interrupted", failed: "failed", unfinished: "no end yet", running: "running" };

export function showFacts(report, history, isStatic) {
  const { title, result, summary } = report;
  place("title").textContent = document.title = title || runName(report);
  const outcome = report.watch ? "running" : hasModes(result) ? "modes" : (summary?.outcome ?? "unfinished");
  const badge = place("outcome");
  badge.textContent = OUTCOMES[outcome] ?? outcome;
  badge.dataset.outcome = outcome;
  badge.title = outcome === "running" ? `the page is renewed every ${short(report.watch)} s` : outcome === "unfinished" ? "the run continues, or was killed" : summary?.message || "";
  place("facts").textContent = factsOf(report, history, isStatic);
  place("made").textContent = `Made with ${report.program.split("\n")[0]} on ${report.written} from ${report.directory}`;
}

/// The same for the second run of a page: its facts below those of the first, and how it ended if the first one ended otherwise.
export function addFacts(run, history, isStatic, names) {
  const facts = place("facts"), badge = place("outcome"), outcome = run.summary?.outcome ?? "unfinished";
  facts.textContent = `${names[0]}:  ${facts.textContent}\n${names[1]}:  ${factsOf(run, history, isStatic)}`;
  if (outcome !== badge.dataset.outcome && badge.dataset.outcome in OUTCOMES) {
    badge.textContent += ` | ${OUTCOMES[outcome] ?? outcome}`;
    if (badge.dataset.outcome === "done") badge.dataset.outcome = outcome;
  }
  place("made").textContent += ` and ${run.directory}`;
}

function factsOf({ result, summary, input, history: { steps } }, history, isStatic) {
  const frames = result.frames.length < result.framesInResult
    ? `${grouped(result.frames.length)} of ${grouped(result.framesInResult)} frames` : `${grouped(result.frames.length)} frames`;
  const facts = sizeOf(result);
  const method = given(input, "method");
  if (method) facts.push(method);
  if (steps > 0) facts.push(`${grouped(steps)} steps`);
  const times = history.get("time");
  if (times?.length > 1 && !isStatic) facts.push(`to t = ${short(times.at(-1))} s`);
  if (summary?.ranks > 1) facts.push(`${summary.ranks} ranks`);
  const warnings = summary?.warnings?.length;
  return [...facts, frames, ...(warnings ? [countOf(warnings)] : [])].join("  ·  ");
}

const PARTS = [["set_up", "set-up"], ["assembly", "assembly"], ["factorization", "factorization"], ["solve", "solve"], ["output", "output"], ["rest", "rest"]];

function timings(seconds) {
  const bar = element("div", { className: "stack" }), list = element("ul", { className: "key" });
  PARTS.forEach(([key, name], i) => {
    const part = element("i", { title: `${name} ${short(seconds[key], 3)} s` });
    part.style.flexGrow = seconds[key] / seconds.total;
    part.style.background = `var(--part-${i})`;
    bar.append(part);
    const chip = element("i");
    chip.style.background = `var(--part-${i})`;
    list.append(element("li", {}, chip, element("span", { textContent: name }), element("b", { textContent: `${short(seconds[key], 3)} s` })));
  });
  return element("article", {}, element("h2", { textContent: "Where the time went" }),
    element("p", { className: "big", textContent: `${short(seconds.total, 3)} s` }), bar, list);
}

function table(title, rows) {
  const made = element("table");
  for (const [name, value] of rows) made.append(element("tr", {}, element("th", { textContent: name }), element("td", { textContent: value })));
  return element("article", {}, element("h2", { textContent: title }), made);
}

/// `names`: of two runs, of which this is the second; then the cards of the first get its name too.
export function showRun(to, { summary, result }, names) {
  if (names) {
    for (const title of to.querySelectorAll("h2")) title.textContent += ` · ${names[0]}`;
    const before = to.children.length;
    showRun(to, { summary, result });
    for (const card of [...to.children].slice(before)) card.querySelector("h2").textContent += ` · ${names[1]}`;
    return;
  }
  if (hasModes(result)) to.append(table("Modes", result.frames.map((frame) => frame.label.split(", "))));
  if (!summary) return;
  const { seconds, steps, solver, worst_step: worst, message, warnings, notes } = summary;
  if (message) to.append(element("article", { className: "wide" }, element("h2", { textContent: "Why it ended" }), element("p", { textContent: message })));
  if (warnings?.length) {
    to.append(element("article", { className: "wide" }, element("h2", { textContent: "Warnings" }),
      ...warnings.map((text) => element("p", { className: "warning", textContent: text }))));
  }
  if (notes?.length) {
    to.append(element("article", { className: "wide" }, element("h2", { textContent: "Notes" }), ...notes.map((text) => element("p", { textContent: text }))));
  }
  to.append(timings(seconds));
  to.append(table("Steps", [
    ["accepted", grouped(steps.accepted)], ["shortest", `${short(steps.shortest)} s`], ["longest", `${short(steps.longest)} s`],
    ["repeated after a failed solve", grouped(steps.failed)], ["repeated for accuracy", grouped(steps.inaccurate)],
    ...(worst ? [["hardest", `step ${grouped(worst.step)}, ${worst.newton_iterations} iterations`]] : [])]));
  const mesh = summary.discretization_error;
  if (mesh) {
    to.append(table("Mesh", [
      ["discretization error", `${short(100 * mesh.share, 2)} % of the elastic energy`],
      ["most around", `${mesh.place.map((x) => short(x)).join(", ")} m`]]));
  }
  to.append(table("Newton", [
    ["iterations", grouped(solver.newton_iterations)], ["stages", grouped(solver.stages)], ["factorizations", grouped(solver.factorizations)],
    ["linear iterations", grouped(solver.linear_iterations)], ["step lengths rejected", grouped(solver.backtracks)],
    ["Hessians projected", grouped(solver.projections)]]));
}

export function showTexts(to, { input, program }) {
  const fold = (title, text) => element("details", {}, element("summary", { textContent: title }), element("pre", { textContent: text }));
  if (input) to.append(fold("The input as understood (run.yaml)", input));
  to.append(fold("Versions", program));
}
