// The page: takes the events, draws at most ten times a second, sends commands.

import { Curve, Reference, Spectrum, WarmUp } from "./charts.js";
import { command, latest, study } from "./commands.js";
import { Diagnosis } from "./diagnosis.js";
import { $, make } from "./dom.js";
import { acceptDrops } from "./dropped.js";
import { Grid, isShown } from "./grid.js";
import { InMotion } from "./in-motion.js";
import { Polar } from "./polar.js";
import { Results } from "./results.js";
import { Sensor } from "./sensor.js";
import { Simulation } from "./simulation.js";
import { Start, tiles } from "./start.js";
import { STATES, add, begin, empty } from "./state.js";
import { subscribe } from "./stream.js";
import { Warming } from "./warmup.js";
import { clock, clockSeconds, degrees, duration, percent, significant, withU } from "./words.js";

const model = empty();
let status = null;
let connected = false;
let answered = null;

// Themes.
const THEMES = ["light", "dark", "red"];
function theme(name) {
  const chosen = THEMES.includes(name) ? name : "light";
  document.documentElement.dataset.theme = chosen;
  $("theme").value = chosen;
  localStorage.setItem("isolux-theme", chosen);
  for (const figure of [grid, curve, warming, warmUp, reference, spectrum, sensor, inMotion, ...Object.values(views)]) figure.refresh();
  changed();
}

const polar = new Polar($("polar"), $("polar-text"));
const grid = new Grid($("grid"), $("grid-text"));
const curve = new Curve($("curve"), $("curve-text"), 272);
const warming = new Warming();
const warmUp = new WarmUp($("warm-up"), $("warm-up-text"), 136);
const reference = new Reference($("reference"), $("reference-text"), 136);
const spectrum = new Spectrum($("spectrum"), $("spectrum-text"), 272);

const sensor = new Sensor($("sensor"), $("sensor-text"));
const inMotion = new InMotion();

// Views: what the run says is worked out when its view is opened.
const views = { results: new Results(), simulation: new Simulation(), diagnosis: new Diagnosis() };
const VIEWS = ["start", "live", "results", "simulation", "diagnosis", "inspect"];
const view = () => VIEWS.find((name) => location.hash === `#/${name}`);
const busy = () => Boolean(status?.running || status?.elsewhere);
const start = new Start((body) => ask(body));
let worked = null;

/** The page begins where something happens, and follows a scan that begins while it shows the start. */
function follow(wasBusy) {
  if (!status) return;
  if (!view()) history.replaceState(null, "", busy() || (status.jobs.length === 0 && status.runs.length === 0) ? "#/live" : "#/start");
  else if (busy() && !wasBusy && view() === "start") location.hash = "#/live";
}

function open() {
  const now = view();
  for (const section of document.querySelectorAll("[data-view]")) section.hidden = section.dataset.view !== now;
  for (const link of $("views").querySelectorAll("a")) {
    // Nothing can be worked out where no run is shown.
    link.hidden = !status?.run && ["#/results", "#/simulation", "#/diagnosis"].includes(link.hash);
    if (link.hash === `#/${now}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  // Another run, other results of it, or another model: what was worked out is of the old one.
  const key = JSON.stringify([status?.run, status?.running, status?.results, status?.changes]);
  if (worked !== key) {
    worked = key;
    for (const one of Object.values(views)) one.stale();
  }
  if (views[now] && status?.run && !status.running) views[now].open();
  if (now === "start" && status) start.draw(status);
}

// Drawing, ten times a second at most.
let due = false;
function changed() {
  if (due) return;
  due = true;
  setTimeout(() => requestAnimationFrame(() => { due = false; draw(); }), 90);
}

function text(id, words) {
  const element = $(id);
  if (element.textContent !== words) element.textContent = words;
}

function draw() {
  header();
  open();
  const live = view() === "live";
  $("scan").hidden = !live || !model.outline;
  $("none").hidden = !live || Boolean(model.outline);
  if (!model.outline || !live) return;
  cards();
  readings();
  checks();
  polar.draw(model);
  curve.draw(model);
  grid.draw(model);
  if (status?.in_motion) inMotion.draw(model);
  if (!$("warm-panel").hidden) warming.draw(model, status?.times);
  warmUp.draw(model);
  reference.draw(model);
  spectrum.draw(model);
  dark();
  journal();
  finished();
  if ($("table-details").open) table();
}

/** A card is shown from when it has something to show. */
function cards() {
  const warms = ["homing", "warming_up"].includes(model.state) && model.planes.size === 0;
  for (const [id, shown] of [
    ["warm-panel", warms], ["lamp-panel", !warms && (model.warmUps.length > 0 || model.references.length > 0)],
    ["polar-panel", model.planes.size > 0], ["curve-panel", model.planes.size > 0],
    ["grid-panel", [...model.points.values()].some(isShown)], ["in-motion-panel", Boolean(status?.in_motion)],
    ["sensor-panel", Boolean(status?.sensor)], ["spectrum-panel", Boolean(model.spectrum)], ["rows-panel", model.rows.length > 0],
  ]) $(id).hidden = !shown;
  for (const id of ["reference", "reference-text"]) $(id).hidden = model.references.length === 0;
  $("scan").classList.toggle("warms", warms);
}

/** The main numbers of a run that is done, and where more of it is. */
const headline = latest(async (run) => {
  const card = await study({ study: "card", run }).catch(() => null);
  $("finished-numbers").replaceChildren(...tiles(card?.numbers ?? []));
});

function finished() {
  const done = model.state === "completed" && Boolean(status?.report) && !status.running;
  $("finished").hidden = !done;
  const run = done ? status.runs.find((name) => status.run.endsWith(`/${name}`) || status.run === name) : null;
  const key = JSON.stringify([run, status?.results]);
  if (!run || finished.key === key) return;
  finished.key = key;
  headline(run);
}

function header() {
  let [word, shape] = STATES[model.state] ?? ["No scan", "none"];
  if (status?.pause_asked && status.running && model.state !== "paused") [word, shape] = ["Pausing", "wait"];
  const before = $("state-word").textContent;
  text("state-word", word);
  $("state").dataset.shape = shape;
  if (before !== word) text("announce", `State: ${word}`);
  text("state-sentence", status?.pause_asked && model.state !== "paused" ? "after the point that is being read" : model.sentence);
  text("bench", model.outline?.bench ?? "");
  text("run", status?.run ?? "");
  document.title = model.outline ? `${word} – isolux` : "isolux";
  const left = model.left;
  const over = ["completed", "interrupted", "failed", "evaluating"].includes(model.state);
  text("points", left ? `${left.done} of ${left.total}` : "–");
  text("time-left", left && !over ? duration(left.left_s) : "–");
  text("ends-at", left && !over && left.ends_utc && model.state !== "paused" ? ends(left) : "–");
  $("left").hidden = !left;
  for (const id of ["time-left", "ends-at"]) $(id).parentElement.hidden = $(id).textContent === "–";
  $("progress").hidden = !left;
  $("progress").value = left && left.total ? left.done / left.total : 0;
  commands();
}

/** A bench in virtual time ends by its own clock; what that is here depends on its speed. */
function ends(left) {
  if (!model.outline?.in_memory || !status?.times) return clock(left.ends_utc);
  return clock(new Date(Date.now() + (left.left_s * 1000) / status.times).toISOString());
}

function commands() {
  const running = connected && Boolean(status?.running) && !["evaluating", "completed", "interrupted", "failed"].includes(model.state);
  const paused = Boolean(status?.pause_asked);
  text("pause", paused ? "Go on" : "Pause");
  $("pause").disabled = !running;
  $("abort").disabled = !running;
  $("stop").disabled = !(running || (connected && status?.elsewhere));
  $("commands").hidden = !busy();
  $("report").hidden = !status?.report;
  $("left-behind").hidden = !status?.left_behind;
  if (status?.left_behind) text("left-behind", status.left_behind);
  results(status?.results ?? []);
  const notice = status?.elsewhere ? `This scan is made by ${status.elsewhere}. From here it can only be stopped.` : (answered ?? status?.notice);
  $("notice").hidden = !notice;
  if (notice) text("notice", notice);
  $("question").hidden = !status?.question;
  if (status?.question) text("question-words", status.question.words);
}

function results(names) {
  const shown = names.join();
  if (results.shown === shown) return;
  results.shown = shown;
  $("results").hidden = names.length === 0;
  $("result-files").replaceChildren(...names.map((name) => (
    make("li", {}, make("a", { href: `/results/${encodeURIComponent(name)}`, textContent: name, download: name }))
  )));
}

function readings() {
  const row = model.last;
  const at = row ?? {};
  text("axis-c", degrees(at.c_deg, 3));
  text("axis-gamma", degrees(at.gamma_deg, 3));
  const look = model.warmUps.at(-1);
  const warming = model.state === "warming_up" && look;
  text("lux", warming ? `${significant(look.illuminance_lx)} lx` : row ? withU(row.illuminance_lx, row.u_lx, "lx").replace(" (k = 2)", "") : "–");
  text("quality", row ? { ok: "✓ ok", over_range: "✕ over range", under_range: "✕ under range", failed: "✕ failed" }[row.quality] : "–");
  text("drift", percent(model.references.at(-1)?.drift_rel));
  text("ambient", at.ambient_c === null || at.ambient_c === undefined ? "–" : `${at.ambient_c.toFixed(1)} °C`);
  const watts = warming ? look.power_w : at.electrical?.power_w;
  text("power", watts === null || watts === undefined ? "not measured" : `${significant(watts)} W`);
  text("lamp-on", duration(warming ? look.lamp_s : at.lamp_s));
  for (const value of document.querySelectorAll("#scan .values dd")) value.parentElement.hidden = value.textContent === "–";
}

/** Of the visits to the reference point, the one farthest from their median, relative to it; null without visits. */
function largestDrift(references) {
  const levels = references.filter((row) => row.drift_rel !== undefined).map((row) => 1 + row.drift_rel).sort((a, b) => a - b);
  if (!levels.length) return null;
  const half = levels.length / 2;
  const middle = (levels[Math.ceil(half) - 1] + levels[Math.floor(half)]) / 2;
  const [low, high] = [levels[0] / middle - 1, levels.at(-1) / middle - 1];
  return -low > high ? low : high;
}

function checks() {
  const look = model.warmUps.at(-1);
  const { spread_rel: allowed, drift_rel: band } = model.outline;
  const drift = largestDrift(model.references);
  const unstable = look && look.spread_rel !== null ? `${(look.spread_rel * 100).toFixed(2)} % of ${(allowed * 100).toFixed(2)} %` : "window not full";
  const list = [
    model.stable ? ["open", `Lamp stable (${unstable})`] : ["wait", `Lamp not stable yet (${unstable})`],
    drift === null ? ["wait", "Reference not visited yet"]
      : Math.abs(drift) <= band ? ["open", `Reference in its band (${percent(drift)} of ± ${(band * 100).toFixed(2)} %)`]
        : ["shut", `Reference outside its band (${percent(drift)} of ± ${(band * 100).toFixed(2)} %)`],
    model.flagged ? ["shut", `${model.flagged} reading${model.flagged > 1 ? "s" : ""} flagged`] : ["open", "No reading flagged"],
  ];
  const shown = JSON.stringify(list);
  if (shown === checks.shown) return;
  checks.shown = shown;
  $("checks").replaceChildren(...list.map(([state, words]) => {
    const item = document.createElement("li");
    item.dataset.check = state;
    item.textContent = words;
    return item;
  }));
}

const KINDS = { baffled: "direct light blocked: stray light", lamp_off: "lamp off: light of the room", capped: "detector capped: offset" };

/** Readings without direct light, which no diagram of the light shows. */
function dark() {
  const planned = new Map();
  for (const point of model.outline.points) if (!point.spectrum && KINDS[point.kind]) planned.set(point.kind, (planned.get(point.kind) ?? 0) + 1);
  $("dark-panel").hidden = model.dark.size === 0;
  $("dark").replaceChildren(...[...planned].map(([kind, count]) => {
    const { last, points } = model.dark.get(kind) ?? {};
    const value = last ? withU(last.illuminance_lx, last.u_lx, "lx") : "–";
    const cells = [KINDS[kind], `${points?.size ?? 0} of ${count} points`, value].map((textContent) => make("td", { textContent }));
    return make("tr", {}, ...cells);
  }));
}

function journal() {
  const key = `${model.journal.length} ${model.journal[0]?.time_utc} ${model.journal[0]?.sentence}`;
  if (key === journal.key) return;
  journal.key = key;
  $("journal").replaceChildren(...model.journal.map((entry) => {
    const item = document.createElement("li");
    const time = document.createElement("time");
    time.dateTime = entry.time_utc;
    time.textContent = clockSeconds(entry.time_utc);
    const words = document.createElement("span");
    words.textContent = entry.sentence;
    item.append(time, words);
    return item;
  }));
}

function table() {
  $("rows").replaceChildren(...model.rows.map((row) => {
    const line = document.createElement("tr");
    const cells = [row.index, row.block, row.c_target_deg, row.gamma_target_deg, significant(row.illuminance_lx), row.u_lx === null ? "–" : significant(2 * row.u_lx, 2), row.quality];
    line.append(...cells.map((cell) => Object.assign(document.createElement("td"), { textContent: cell })));
    return line;
  }));
}

// Commands.
async function ask(body) {
  const answer = await command(body).catch(() => ({ ok: false, words: "the program did not answer" }));
  answered = answer.ok ? null : answer.words;
  text("announce", answer.words);
  changed();
  return answer.ok;
}

const pause = () => ask({ command: status?.pause_asked ? "resume" : "pause" });
const stop = () => ask({ command: "stop" });
$("pause").addEventListener("click", pause);
$("stop").addEventListener("click", stop);
$("abort").addEventListener("click", () => $("sure").showModal());
$("sure-yes").addEventListener("click", () => { $("sure").close(); ask({ command: "abort" }); });
$("sure-no").addEventListener("click", () => $("sure").close());
$("done").addEventListener("click", () => ask({ command: "answer", number: status.question.number, who: $("who").value }));
$("not-done").addEventListener("click", () => ask({ command: "answer", number: status.question.number, who: "" }));
$("theme").addEventListener("change", () => theme($("theme").value));
$("table-details").addEventListener("toggle", changed);
addEventListener("resize", () => { views[view()]?.refresh(); changed(); });
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
  if (["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName) || document.querySelector("dialog[open]")) return;
  if (event.key === "p" && !$("pause").disabled) pause();
  else if (event.key === "A" && !$("abort").disabled) $("sure").showModal();
  else if (event.key === "S" && !$("stop").disabled) stop();
  else if (event.key === "t") theme(THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + 1) % THEMES.length]);
  else return;
  event.preventDefault();
});

addEventListener("hashchange", () => { scrollTo(0, 0); draw(); });
acceptDrops($("inspect"), $("file"), $("inspected"));

// The stream.
subscribe(({ fresh, outline, events, status: now }) => {
  if (fresh) begin(model, outline);
  for (const event of events) add(model, event);
  const wasBusy = busy();
  if (now) status = now;
  follow(wasBusy);
  sensor.follow(status?.sensor ?? 0).catch(() => {});
  inMotion.follow(status?.in_motion ?? 0).then((fresh) => fresh && changed(), () => {});
  changed();
}, (open) => {
  connected = open;
  $("lost").hidden = open;
  document.body.classList.toggle("stale", !open);
  text("lost", open ? "" : "Connection lost. What is shown is what was last known; the bench goes on by itself. Trying again. After a new start of the program, open the address that its terminal shows.");
  changed();
});

theme(localStorage.getItem("isolux-theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
