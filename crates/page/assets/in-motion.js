// A scan in motion: how uncertain every direction is, which sweep follows and why, and how its uncertainty falls. The
// program works all of it out of the sweeps; here it is drawn.

import { Chart, axis, line } from "./charts.js";
import { $ } from "./dom.js";
import { UMap } from "./u-map.js";
import { significant } from "./words.js";

const HEIGHT = 150;
// The space does not break.
const percent = (rel) => `${significant(100 * rel, 3)}\u00a0%`;
const list = (planes) => planes.map((c) => `C ${c}°`).join(", ");

/** An uncertainty after each sweep, with the target as a line where there is one. */
class Falling extends Chart {
  draw(after, wanted, label, words) {
    const sweeps = after.map((one) => one.sweeps);
    this.top = 1.1 * Math.max(wanted ?? 0, ...after.map((one) => one.u_rel)) * 100;
    this.span = [Math.min(...sweeps) - 0.5, Math.max(...sweeps) + 0.5];
    const whole = (_, values) => values.map((value) => (Number.isInteger(value) ? String(value) : ""));
    const options = {
      scales: { x: { time: false, range: () => this.span }, y: { range: () => [0, this.top || 1] } },
      axes: [axis("sweeps made", { values: whole }), axis(label, { size: 52, space: 24 })],
      series: [{}, line("u", "--one", { points: { show: true, size: 6 } }), line("target", "--two", { dash: [6, 4] })],
    };
    const target = sweeps.map(() => (wanted === null ? null : 100 * wanted));
    // A line of one point is none: the target goes from edge to edge.
    const [x, u] = [[this.span[0], ...sweeps, this.span[1]], [null, ...after.map((one) => 100 * one.u_rel), null]];
    this.show(options, after.length ? [x, u, [target[0] ?? null, ...target, target[0] ?? null]] : null, words);
  }
}

const OVER = {
  completed: "The scan is completed.",
  evaluating: "The scan is completed.",
  interrupted: "The scan was ended. Resumed, it goes on with what follows.",
  failed: "The scan failed. Resumed, it goes on with what follows.",
};

/** What comes next and why. */
function nextWords({ next, target }, { state, second }) {
  const ended = OVER[state];
  if (next) {
    const later = next.later_c_deg.length ? ` Behind it, by what is known now: ${list(next.later_c_deg)}.` : "";
    const opposite = next.c_deg.length > 1 ? `, which reads ${list(next.c_deg)}` : "";
    return [ended ?? "", `Next: ${next.what}${opposite}.`, `Why: ${next.reason}.${later}`];
  }
  if (second && !ended) {
    const [from, to] = second.gamma_deg;
    return ["", `Now: C ${second.c_deg}°, γ ${from}° to ${to}° once more.`, `Why: ${second.reason}.`];
  }
  const done = target ? "No further half-plane is needed or left to choose from." : "All half-planes of the plan are swept.";
  return [ended ?? "", done, ended ? "" : "Second sweeps, gaps and directions at rest follow where the plan has them."];
}

export class InMotion {
  constructor() {
    this.map = new UMap($("u-map"), $("u-map-legend"));
    this.target = new Falling($("u-target"), $("u-target-text"), HEIGHT);
    this.sensor = new Falling($("u-sensor"), $("u-sensor-text"), HEIGHT);
    Object.assign(this, { asked: 0, now: null, drawn: null });
  }

  /** Everything is drawn anew: after a change of theme. */
  refresh() {
    this.drawn = null;
    this.target.refresh();
    this.sensor.refresh();
  }

  /** Fetches what is known when the status counts another sweep; whether it did. */
  async follow(count) {
    if (count === this.asked) return false;
    this.asked = count;
    const answer = count > 0 ? await fetch("/api/in-motion", { cache: "no-store" }) : null;
    this.now = answer?.ok ? await answer.json() : null;
    return true;
  }

  draw(model) {
    const { now } = this;
    if (!now) return;
    const words = nextWords(now, model);
    const key = JSON.stringify([this.asked, words, $("u-map").clientWidth]);
    if (this.drawn === key) return;
    this.drawn = key;
    const [ended, what, why] = words;
    const strong = Object.assign(document.createElement("strong"), { textContent: what });
    $("in-motion-next").replaceChildren(ended ? `${ended} ` : "", strong, why ? ` ${why}` : "");
    const text = this.#mapWords();
    $("u-map-text").textContent = text;
    this.map.show(now, `Map of the uncertainty of every direction. ${text}`);
    const { target, sensor } = now;
    $("u-target-part").hidden = !target;
    $("u-sensor-part").hidden = !sensor;
    if (target) this.target.draw(target.after, target.wanted_rel, "u / %", this.#targetWords(target));
    if (sensor) this.sensor.draw(sensor, null, "U / %", this.#sensorWords(sensor));
  }

  #mapWords() {
    const { block, sweeps, c_deg: planes, swept_c_deg: swept, u_rel: all, largest_cd: largest } = this.now;
    const known = all.filter((u) => u !== null);
    const most = known.length ? `, at most ${percent(Math.max(...known))}` : "";
    const of = largest === null ? "" : ` Largest light ${significant(largest, 3)} cd, E·d², not corrected.`;
    const one = sweeps === 1 ? "sweep" : "sweeps";
    const share = Math.round((100 * known.length) / all.length);
    return `u (k = 1) of each direction in % of the largest light so far: ${share} % of the directions known${most}. `
      + `Block ${block}: ${sweeps} ${one}, ${swept.length} of ${planes.length} half-planes read.${of}`;
  }

  #targetWords({ of, wanted_rel: wanted, after }) {
    const last = after.at(-1);
    if (!last) return `Target: u (k = 1) ${of}, ${percent(wanted)}. Known from when the rings are swept.`;
    const reached = last.u_rel <= wanted ? "reached" : "not reached yet";
    return `u (k = 1) ${of}, by what is interpolated: ${percent(last.u_rel)} after ${last.sweeps} sweeps; `
      + `target ${percent(wanted)} (dashed), ${reached}.`;
  }

  #sensorWords(sensor) {
    const last = sensor.at(-1);
    return last
      ? `U (k = 2) of the mean on the sensor of the job's scene: ${percent(last.u_rel)} after ${last.sweeps} sweeps.`
      : "Sensor of the job's scene: known from when the rings are swept.";
  }
}
