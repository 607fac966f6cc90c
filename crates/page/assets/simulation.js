// The sensor in another pose: sliders, two stands beside each other, rays against the noise-free solution.

import { Chart, axis, line } from "./charts.js";
import { latest, study } from "./commands.js";
import { $, facts, make, stated } from "./dom.js";
import { SensorMap, numbers, ramp } from "./map.js";
import { shades } from "./sensor.js";
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

const SIGNED = ramp([5, 48, 97], [67, 147, 195], [247, 247, 247], [214, 96, 77], [103, 0, 31]);

/** What the pinned sensor has more than the one that is lit now, pixel by pixel. */
function difference(a, b) {
  if (!a || !b || a.unit !== b.unit || a.map.nx !== b.map.nx || a.map.ny !== b.map.ny) return null;
  const [of, from] = [numbers(a.map), numbers(b.map)];
  const values = of.map((value, at) => value - from[at]);
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const said = (value) => `${value > 0 ? "+" : ""}${significant(value, 3).replace("-", "−")} ${a.unit}`;
  const sizes = a.size_mm.join() === b.size_mm.join() ? "" : " The two sensors differ in size: the same pixel lies elsewhere.";
  const words = `A − B: smallest ${said(Math.min(...values))}, largest ${said(Math.max(...values))}, mean ${said(mean)} (${significant((100 * mean) / a.mean, 3).replace("-", "−")} % of the mean of A).${sizes}`;
  const crosses = values.some((value) => value < 0) && values.some((value) => value > 0);
  const signed = document.documentElement.dataset.theme === "red" ? ramp([0, 0, 0], [110, 0, 0], [255, 110, 110]) : SIGNED;
  // Of one sign, it has the colours of a map: a scale from zero would hide its shape.
  const colours = crosses ? signed : a.map.colours;
  return { map: { ...a.map, values, colours, digits: 3 }, words };
}

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
    this.ask = latest((requested) => this.#ask(requested));
    this.count = latest((requested) => this.#count(requested));
    this.map = new SensorMap($("lit-map"), { title: "Now (B)" });
    this.pinned = new SensorMap($("lit-map"), { title: "Pinned (A)" });
    this.gap = new SensorMap($("lit-map"), { title: "Difference A − B", signed: true });
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

  async #ask(requested) {
    try {
      this.b = await study({ study: "illuminated", requested });
      if (!this.scales) this.#sliders(this.b.requested);
      if (Object.keys(requested).length === 0) this.#set(this.b.requested);
      this.#draw();
      clearTimeout(this.settled);
      this.settled = setTimeout(() => this.count(this.b.requested), 400);
    } catch (error) {
      $("lit-text").textContent = error.message;
      for (const id of ["sliders", "lit-numbers"]) $(id).replaceChildren();
      [this.scales, this.b] = [null, null];
      this.#draw();
    }
  }

  async #count(requested) {
    try {
      this.counted = await study({ study: "convergence", requested });
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
    this.map.show(b?.map, shades(b?.map));
    this.pinned.show(a?.map, shades(a?.map));
    const gap = difference(a, b);
    this.gap.show(gap?.map);
    $("gap-text").textContent = gap?.words ?? (a && b ? "A and B have another unit or another number of pixels: no difference is drawn." : "");
    for (const id of ["pin", "as-scene"]) $(id).disabled = !b;
    $("unpin").disabled = !a;
    if (!b) return;
    const where = ({ requested }) => this.scales.map(([key, , unit]) => `${significant(requested[key], 4)} ${unit}`).join(", ");
    for (const [key, , unit] of this.scales) $(`value-${key}`).textContent = `${significant(b.requested[key], 4)} ${unit}`;
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
