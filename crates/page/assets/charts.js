// The charts that uPlot draws. Colours come from the theme; nothing here knows where the data come from.

import { curve } from "./state.js";
import { degrees, duration, percent, significant } from "./words.js";

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function axis(label, extra = {}) {
  return {
    label, labelSize: 18, labelFont: "11px system-ui, sans-serif", font: "11px system-ui, sans-serif", size: 46,
    stroke: () => colour("--text"), grid: { stroke: () => colour("--grid"), width: 1 }, ticks: { stroke: () => colour("--line"), width: 1 }, ...extra,
  };
}

/** A chart that is made when it first has data, and made again after a change of theme. */
export class Chart {
  constructor(element, text, height) {
    Object.assign(this, { element, text, height, plot: null });
  }

  refresh() {
    this.plot?.destroy();
    this.plot = null;
  }

  show(options, data, words) {
    this.text.textContent = words;
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", words);
    const width = this.element.clientWidth;
    if (!data || data[0].length === 0) {
      this.refresh();
      return;
    }
    if (this.plot && this.plot.width !== width) this.plot.setSize({ width, height: this.height });
    if (this.plot) this.plot.setData(data);
    else this.plot = new uPlot({ width, height: this.height, legend: { show: false }, cursor: { show: false }, ...options }, data, this.element);
  }
}

export const line = (label, name, extra = {}) => ({ label, stroke: () => colour(name), width: 1.6, points: { show: false }, spanGaps: true, ...extra });

export class Curve extends Chart {
  draw(model) {
    const row = model.last && model.last.kind === "lit" ? model.last : null;
    const now = row ? row.c_target_deg % 180 : null;
    const pairs = [["C0–C180", "--c0", 0, {}], ["C90–C270", "--c90", 90, { dash: [6, 4] }]];
    const names = pairs.map(([, , c]) => c);
    const shown = names.includes(now) || now === null ? pairs : [...pairs, [`C${now}`, "--now", now, { dash: [1, 3] }]];
    const series = shown.map(([, , c]) => new Map([
      ...curve(model, c + 180).filter(([gamma]) => gamma > 0).map(([gamma, cd]) => [-gamma, cd]), ...curve(model, c),
    ]));
    const x = [...new Set(series.flatMap((one) => [...one.keys()]))].sort((a, b) => a - b);
    const key = shown.map(([label]) => label).join();
    if (key !== this.key) this.refresh();
    this.key = key;
    const options = {
      scales: { x: { time: false }, y: { range: (_, low, high) => [Math.min(0, low ?? 0), (high || 1) * 1.05] } },
      axes: [axis("γ / °, left: the opposite half-plane"), axis("I / cd", { size: 60 })],
      series: [{}, ...shown.map(([label, name, , extra]) => line(label, name, extra))],
    };
    const legend = shown.map(([label], at) => `${label} ${["solid", "dashed", "dotted"][at]}`).join(", ");
    const ray = row ? ` Current ray: C ${degrees(row.c_target_deg, 1)}, γ ${degrees(row.gamma_target_deg, 1)}.` : "";
    this.show(options, [x, ...series.map((one) => x.map((gamma) => one.get(gamma) ?? null))], x.length ? `${legend}.${ray}` : "No lit reading yet.");
  }
}

/** The light over the time since the lamp was switched on, and the band in which the last window must stay. */
export class WarmUp extends Chart {
  /** Up to `end_s`, where the warm-up is expected to end, with `said` below; without them as far as the looks go. */
  draw(model, end_s = 0, said = null) {
    const looks = model.warmUps;
    const last = looks.at(-1);
    const { spread_rel: allowed, window_s: window } = model.outline;
    this.end = Math.max(end_s, last?.lamp_s ?? 0) / 60;
    const options = {
      scales: { x: { time: false, range: () => [0, this.end || 1] } },
      axes: [axis("lamp on / min"), axis("E / lx", { size: 62, space: 24 })],
      series: [{}, line("E", "--one"), line("upper", "--good", { dash: [6, 4] }), line("lower", "--good", { dash: [6, 4] })],
      bands: [{ series: [2, 3], fill: () => `${colour("--good")}22` }],
    };
    const spread = last?.spread_rel ?? null;
    const power = last?.power_spread_rel ?? null;
    let words = "The lamp was not watched yet.";
    if (last) {
      words = spread === null
        ? `Warm-up: ${significant(last.illuminance_lx)} lx after ${duration(last.lamp_s)}; the window of ${duration(window)} is not full.`
        : `Warm-up: ${(spread * 100).toFixed(2)} % of ${(allowed * 100).toFixed(2)} % over ${duration(window)}${power === null ? "" : `; power ${(power * 100).toFixed(2)} %`}.`;
    }
    this.show(options, looks.length ? band(looks, allowed, window, this.end) : null, said ?? words);
  }
}

/** The light, and the band as wide as is allowed about the middle of the last window, drawn on to the end. */
function band(looks, allowed, window_s, end) {
  const last = looks.at(-1).lamp_s;
  const within = looks.filter((look) => look.lamp_s >= last - window_s).map((look) => look.illuminance_lx);
  const middle = (Math.max(...within) + Math.min(...within)) / 2;
  const inWindow = (x) => x * 60 >= last - window_s - 1e-6;
  const x = looks.map((look) => look.lamp_s / 60);
  const lux = looks.map((look) => look.illuminance_lx);
  if (end > x.at(-1)) {
    x.push(end);
    lux.push(null);
  }
  const edge = (sign) => x.map((at) => (inWindow(at) ? middle * (1 + (sign * allowed) / 2) : null));
  return [x, lux, edge(1), edge(-1)];
}

export class Reference extends Chart {
  draw(model) {
    const visits = model.references.filter((row) => row.time_s !== null && row.drift_rel !== undefined);
    const band = model.outline?.drift_rel ?? 0.02;
    const reach = Math.max(band, ...visits.map((row) => Math.abs(row.drift_rel))) * 125;
    const options = {
      scales: { x: { time: false }, y: { range: () => [-this.reach, this.reach] } },
      axes: [axis("run / min"), axis("drift / %", { size: 62, space: 24 })],
      series: [{}, line("drift", "--one", { points: { show: true, size: 5 } }), line("+", "--line", { dash: [4, 4] }), line("−", "--line", { dash: [4, 4] })],
    };
    this.reach = reach;
    const last = visits.at(-1);
    const words = last
      ? `Reference point: ${percent(last.drift_rel)} since the first of ${visits.length} visits; band ± ${(band * 100).toFixed(2)} % (dashed).`
      : "The reference point was not visited yet.";
    const x = visits.map((row) => row.time_s / 60);
    this.show(options, x.length ? [x, visits.map((row) => row.drift_rel * 100), x.map(() => band * 100), x.map(() => -band * 100)] : null, words);
  }
}

const PREFIXES = [[1, "W"], [1e-3, "mW"], [1e-6, "µW"], [1e-9, "nW"]];

export class Spectrum extends Chart {
  draw(model) {
    const one = model.spectrum;
    const values = one?.curve.irradiance_w_m2_nm ?? [];
    const top = values.reduce((best, value, at) => (value !== null && value > (values[best] ?? -Infinity) ? at : best), 0);
    const [unit, name] = PREFIXES.find(([size]) => (values[top] ?? 0) >= size) ?? PREFIXES.at(-1);
    if (name !== this.unit) this.refresh();
    this.unit = name;
    const options = {
      scales: { x: { time: false } },
      axes: [axis("λ / nm"), axis(`Eλ / ${name}·m⁻²·nm⁻¹`, { size: 60 })],
      series: [{}, line("Eλ", "--one")],
    };
    if (!one) {
      this.show(options, null, "No spectrum yet.");
      return;
    }
    const shown = values.map((value) => (value === null ? null : value / unit));
    this.show(options, [one.curve.wavelength_nm, shown], `Spectrum ${one.index}: peak ${significant(shown[top], 3)} ${name}/(m²·nm) at ${one.curve.wavelength_nm[top].toFixed(1)} nm.`);
  }
}
