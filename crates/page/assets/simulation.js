// The sensor in another pose: sliders, two stands beside each other, rays against the noise-free solution.

import { Chart, axis, line } from "./charts.js";
import { latest, study } from "./commands.js";
import { $, facts, make, stated } from "./dom.js";
import { Picture } from "./sensor.js";
import { significant } from "./words.js";

/** Sliders in steps of 0 … 1000: [key, name, unit, value of a share, share of a value]. */
function scales(own) {
  const logarithmic = (middle, decades) => [(share) => middle * 10 ** (decades * (2 * share - 1)), (value) => (Math.log10(value / middle) / decades + 1) / 2];
  return [
    ["distance_mm", "Distance", "mm", ...logarithmic(own.distance_mm, 1)],
    ["tilt_x_deg", "Tilt", "°", (share) => Math.round((share - 0.5) * 1200) / 10, (value) => value / 120 + 0.5],
    ["pitch_um", "Pixel pitch", "µm", ...logarithmic(own.pitch_um, 0.5)],
    ["exposure_s", "Exposure", "s", ...logarithmic(own.exposure_s, 3)],
  ];
}

const power = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;
const powers = (_, values) => values.map((value) => (value !== null && power(value) ? value.toExponential(0).replace("e+", "e") : null));
const decades = (_, values) => values.map((value) => (value !== null && /^[125]/.test(value.toExponential()) ? significant(value, 2) : null));

class Rays extends Chart {
  draw(told) {
    const x = told.rays.map((one) => one.rays);
    const options = {
      scales: { x: { time: false, distr: 3 }, y: { distr: 3 } },
      axes: [axis("rays", { values: powers }), axis(`E / ${told.unit}`, { size: 68, values: decades })],
      series: [
        {}, line("mean", "--one", { points: { show: true, size: 5 } }), line("mean, noise-free", "--one", { dash: [6, 4] }),
        line("largest pixel", "--two", { points: { show: true, size: 5 } }), line("largest pixel, noise-free", "--two", { dash: [6, 4] }),
      ],
    };
    const [mean, largest] = told.noise_free;
    const last = told.rays.at(-1);
    const words = `Solid: counted rays on ${told.pixels.join(" × ")} pixels; dashed: noise-free. The mean and, above it, the largest pixel, which counting makes too large. With ${last.rays.toExponential(0)} rays the standard error of the mean is ${significant((100 * last.standard_error) / last.mean, 2)} %.`;
    this.show(options, [x, told.rays.map((one) => one.mean), x.map(() => mean), told.rays.map((one) => one.largest), x.map(() => largest)], words);
  }
}

export class Simulation {
  constructor() {
    this.ask = latest((asked) => this.#ask(asked));
    this.count = latest((asked) => this.#count(asked));
    this.map = new Picture($("lit-map"), "Now (B)");
    this.pinned = new Picture($("lit-map"), "Pinned (A)");
    this.rays = new Rays($("rays"), $("rays-text"), 240);
    $("pin").addEventListener("click", () => { this.a = this.b; this.#draw(); });
    $("unpin").addEventListener("click", () => { this.a = null; this.#draw(); });
    $("as-scene").addEventListener("click", () => this.ask({}));
  }

  stale() {
    [this.shown, this.a, this.b, this.scales] = [false, null, null, null];
  }

  open() {
    if (this.shown) return;
    this.shown = true;
    this.ask({});
  }

  async #ask(asked) {
    try {
      this.b = await study({ study: "lit", asked });
      if (!this.scales) this.#sliders(this.b.asked);
      if (Object.keys(asked).length === 0) this.#set(this.b.asked);
      this.#draw();
      clearTimeout(this.settled);
      this.settled = setTimeout(() => this.count(this.b.asked), 400);
    } catch (error) {
      $("lit-text").textContent = error.message;
      for (const id of ["sliders", "lit-numbers"]) $(id).replaceChildren();
      [this.scales, this.b] = [null, null];
      this.#draw();
    }
  }

  async #count(asked) {
    try {
      this.counted = await study({ study: "convergence", asked });
      this.rays.draw(this.counted);
    } catch (error) {
      $("rays-text").textContent = error.message;
    }
  }

  #sliders(own) {
    this.scales = scales(own);
    $("sliders").replaceChildren(...this.scales.map(([key, name]) => {
      const slider = make("input", { type: "range", min: 0, max: 1000, step: 1, id: `slider-${key}` });
      slider.addEventListener("input", () => this.#moved());
      const value = make("output", { id: `value-${key}` });
      value.setAttribute("for", slider.id);
      return make("div", { className: "slider" }, make("label", { textContent: name, htmlFor: slider.id }), slider, value);
    }));
  }

  #set(stand) {
    for (const [key, , , , share] of this.scales) $(`slider-${key}`).value = Math.round(1000 * share(stand[key]));
  }

  #moved() {
    this.ask(Object.fromEntries(this.scales.map(([key, , , value]) => [key, value($(`slider-${key}`).value / 1000)])));
  }

  #draw() {
    const [a, b] = [this.a, this.b];
    this.map.draw(b?.pixels ?? [1, 1], b?.map, b?.unit);
    this.pinned.draw(a?.pixels ?? [1, 1], a?.map, a?.unit);
    for (const id of ["pin", "as-scene"]) $(id).disabled = !b;
    $("unpin").disabled = !a;
    if (!b) return;
    const where = ({ asked }) => this.scales.map(([key, , unit]) => `${significant(asked[key], 4)} ${unit}`).join(", ");
    for (const [key, , unit] of this.scales) $(`value-${key}`).textContent = `${significant(b.asked[key], 4)} ${unit}`;
    const of = (stand, name) => stand.numbers.find((one) => one.name === name)?.value ?? "–";
    const rows = b.numbers.map((one) => [one.name, stated(one.value, a ? `A: ${of(a, one.name).split(", no uncertainty")[0]}` : null)]);
    if (a && a.unit === b.unit) rows.push(["mean, B ÷ A", significant(b.mean / a.mean, 5)]);
    $("lit-numbers").replaceChildren(facts(rows));
    const pinned = a ? ` A: ${where(a)}.` : "";
    $("lit-text").textContent = `${b.by}; ${b.size_mm.map((mm) => significant(mm, 4)).join(" × ")} mm. Now: ${where(b)}.${pinned} Solved in ${b.solver_ms.toFixed(0)} ms. ${b.findings.join(". ")}`;
  }

  refresh() {
    this.#draw();
    this.rays.refresh();
    if (this.counted) this.rays.draw(this.counted);
  }
}
