// The start: one button for the virtual bench, the jobs of the folder, and its runs as cards.

import { latest, study } from "./commands.js";
import { $, inline, make } from "./dom.js";

/** Its name among the jobs (crates/page/src/runs.rs). */
const VIRTUAL = "virtual darkroom";
/** Cards that are shown at first. */
const FIRST = 12;
const STANDING = { being_made: "being measured", completed: "completed", interrupted: "interrupted", failed: "failed", broken_off: "broken off" };

/** Day and time of day. */
function when(utc) {
  const at = new Date(utc);
  if (Number.isNaN(at.getTime())) return "";
  return `${at.toLocaleDateString([], { year: "numeric", month: "short", day: "numeric" })}, ${at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", hour12: false })}`;
}

/** Numbers as a list of terms. */
export function tiles(numbers) {
  return numbers.map(([name, value]) => make("div", {}, make("dt", { textContent: name }), make("dd", { textContent: value.replace(" (k = 2)", "") })));
}

export class Start {
  /** `ask` carries a command to the program; resolves to whether it is done. */
  constructor(ask) {
    Object.assign(this, { ask, key: "", known: new Map(), all: false });
    this.load = latest((names) => this.#load(names));
    $("start-virtual").addEventListener("click", () => this.#begin(VIRTUAL));
    $("start").addEventListener("click", () => this.#begin($("job").value));
    $("all-runs").addEventListener("click", () => {
      this.all = true;
      this.key = "";
      this.draw(this.status);
    });
  }

  #begin(job) {
    location.hash = "#/live";
    this.ask({ command: "start", job });
  }

  draw(status) {
    this.status = status;
    const busy = Boolean(status.running || status.elsewhere);
    const own = status.jobs.filter((job) => job !== VIRTUAL);
    $("begin").hidden = status.jobs.length === 0;
    $("start-group").hidden = own.length === 0;
    this.#options(own);
    for (const id of ["start-virtual", "start"]) $(id).disabled = busy;
    const speed = status.times ? `, ${status.times} times faster than real time` : "";
    const words = busy ? "A scan is on: it is shown under Live. The next one can be started after it."
      : `The virtual bench needs no instrument: its lamp warms up, is scanned and evaluated as a real one${speed}, and a report is written. Nothing real moves.`;
    if ($("begin-text").textContent !== words) $("begin-text").textContent = words;
    const names = this.all ? status.runs : status.runs.slice(0, FIRST);
    $("no-runs").hidden = names.length > 0;
    // What a day is made of, for somebody who has seen none.
    $("steps").hidden = names.length > 0;
    $("all-runs").hidden = names.length === status.runs.length;
    $("all-runs").textContent = `All ${status.runs.length} runs`;
    // Another list, a scan that began or ended, other results of the run that is shown: every card may be another one.
    const key = JSON.stringify([names, busy, status.run, status.results]);
    if (key === this.key) return;
    this.key = key;
    this.#cards(names);
    this.load(names);
  }

  #options(names) {
    const select = $("job");
    if ([...select.options].map((option) => option.value).join("\n") === names.join("\n")) return;
    const before = select.value;
    select.replaceChildren(...names.map((name) => new Option(name, name)));
    if (names.includes(before)) select.value = before;
  }

  async #load(names) {
    for (const name of names) {
      const card = await study({ study: "card", run: name }).catch((error) => ({ failed: error.message }));
      this.known.set(name, card);
      const place = [...$("runs").children].find((item) => item.dataset.run === name);
      place?.replaceChildren(this.#card(name));
    }
  }

  #cards(names) {
    $("runs").replaceChildren(...names.map((name) => {
      const item = make("li", {}, this.#card(name));
      item.dataset.run = name;
      return item;
    }));
  }

  #card(name) {
    const card = this.known.get(name);
    const { status } = this;
    const shown = status.run && (status.run === name || status.run.endsWith(`/${name}`) || (name === "." && status.run === status.folder));
    const picture = make("div", { className: card?.picture ? "light card" : "light" });
    if (card?.picture) picture.append(inline(card.picture));
    else picture.append(make("span", { textContent: card ? "no light yet" : "" }));
    const title = make("strong", { textContent: name === "." ? "this folder" : name });
    const lines = card?.failed ? [make("span", { className: "said", textContent: card.failed })] : [
      make("span", { className: "said", textContent: card ? card.of : "" }),
      make("span", { className: "said", textContent: card ? `${when(card.started_utc)} · ${STANDING[card.state]}` : "" }),
      ...(card?.numbers ?? []).slice(0, 3).map(([what, value]) => make("span", { className: "number" }, make("span", { textContent: what }), make("b", { textContent: value.replace(" (k = 2)", "") }))),
    ];
    const button = make("button", { type: "button", className: "run", disabled: Boolean(status.running) }, picture, make("span", { className: "words" }, title, ...lines));
    if (card && !card.failed) button.dataset.state = card.state;
    if (shown) button.setAttribute("aria-current", "true");
    button.addEventListener("click", async () => {
      if (await this.ask({ command: "show", run: name })) location.hash = card?.numbers?.length ? "#/results" : "#/live";
    });
    return button;
  }
}
