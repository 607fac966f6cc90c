// The polar diagram: γ = 0° points down, a pair of half-planes is one curve, the current ray is a spoke.

import { curve } from "./state.js";
import { significant } from "./words.js";

const NS = "http://www.w3.org/2000/svg";
const SIZE = 360;
const CENTRE = [SIZE / 2, SIZE / 2];
const RADIUS = 148;

function make(name, attributes, parent, text) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}

/** The smallest round number that is not less; a quarter of it is round too. */
function nice(value) {
  if (!(value > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(value));
  return [1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10].map((one) => one * ten).find((one) => one >= value * 0.999);
}

function place(gamma, side, share) {
  const angle = (gamma * Math.PI) / 180;
  return [CENTRE[0] + side * Math.sin(angle) * share * RADIUS, CENTRE[1] + Math.cos(angle) * share * RADIUS];
}

/** One curve through C on the right and C + 180° on the left. */
function path(model, c, top) {
  const opposite = (c + 180) % 360;
  const right = curve(model, c).map(([gamma, cd]) => place(gamma, 1, Math.max(0, cd / top)));
  const left = curve(model, opposite).filter(([gamma]) => gamma > 0 || right.length === 0)
    .map(([gamma, cd]) => place(gamma, -1, Math.max(0, cd / top)));
  const points = [...left.reverse(), ...right];
  return points.map(([x, y], index) => `${index ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
}

export class Polar {
  constructor(element, text) {
    this.text = text;
    this.svg = make("svg", { viewBox: `0 0 ${SIZE} ${SIZE}`, role: "img" }, element);
    this.frame = make("g", {}, this.svg);
    this.c90 = make("path", { class: "c90" }, this.svg);
    this.c0 = make("path", { class: "c0" }, this.svg);
    this.current = make("path", { class: "current" }, this.svg);
    this.spoke = make("line", { class: "spoke" }, this.svg);
    this.tip = make("circle", { class: "tip", r: 4 }, this.svg);
    this.top = 0;
  }

  #frame(top, reach) {
    this.frame.replaceChildren();
    // Light downwards alone needs no upper half.
    const from = reach > 90 ? 0 : SIZE / 2 - 62;
    this.svg.setAttribute("viewBox", `0 ${from} ${SIZE} ${SIZE - from}`);
    const legend = from + 12;
    for (let share = 0.25; share <= 1; share += 0.25) {
      make("circle", { class: "ring", cx: CENTRE[0], cy: CENTRE[1], r: share * RADIUS }, this.frame);
      const label = `${significant(top * share, 3)}${share === 1 ? " cd" : ""}`;
      make("text", { x: CENTRE[0] + 4, y: CENTRE[1] + share * RADIUS - 3 }, this.frame, label);
    }
    for (let gamma = 0; gamma <= (reach > 90 ? 180 : 90); gamma += 30) {
      for (const side of gamma % 180 ? [1, -1] : [1]) {
        const [x, y] = place(gamma, side, 1);
        make("line", { class: "axis", x1: CENTRE[0], y1: CENTRE[1], x2: x, y2: y }, this.frame);
        const [tx, ty] = place(gamma, side, 1.1);
        make("text", { x: tx, y: ty + 4, "text-anchor": "middle" }, this.frame, `${gamma}°`);
      }
    }
    make("line", { class: "c0", x1: 6, y1: legend, x2: 32, y2: legend }, this.frame);
    make("text", { x: 37, y: legend + 4 }, this.frame, "C0–C180");
    make("line", { class: "c90", x1: 6, y1: legend + 16, x2: 32, y2: legend + 16 }, this.frame);
    make("text", { x: 37, y: legend + 20 }, this.frame, "C90–C270");
    make("line", { class: "current", x1: 6, y1: legend + 32, x2: 32, y2: legend + 32 }, this.frame);
    make("text", { x: 37, y: legend + 36 }, this.frame, "current");
  }

  draw(model) {
    const top = nice(model.maxCd);
    const reach = model.reach;
    if (top !== this.top || reach !== this.reach) {
      [this.top, this.reach] = [top, reach];
      this.#frame(top, reach);
    }
    this.c0.setAttribute("d", path(model, 0, top));
    this.c90.setAttribute("d", path(model, 90, top));
    const row = model.last;
    const lit = row && row.kind === "lit";
    const right = lit && row.c_deg < 180;
    const c = lit ? (right ? row.c_deg : row.c_deg - 180) : null;
    this.current.setAttribute("d", lit && c !== 0 && c !== 90 ? path(model, c % 180, top) : "");
    for (const part of [this.spoke, this.tip]) part.toggleAttribute("hidden", !lit);
    this.spoke.setAttribute("visibility", lit ? "visible" : "hidden");
    this.tip.setAttribute("visibility", lit ? "visible" : "hidden");
    if (lit) {
      const side = right || row.c_deg === 360 ? 1 : -1;
      const [x, y] = place(row.gamma_deg, side, 1);
      for (const [key, value] of Object.entries({ x1: CENTRE[0], y1: CENTRE[1], x2: x, y2: y })) this.spoke.setAttribute(key, value);
      const cd = (row.illuminance_lx ?? 0) * (row.distance_mm / 1000) ** 2;
      const [tx, ty] = place(row.gamma_deg, side, Math.max(0, Math.min(1, cd / top)));
      this.tip.setAttribute("cx", tx);
      this.tip.setAttribute("cy", ty);
    }
    const planes = model.planes.size;
    const words = planes
      ? `E·d² of what was read so far, not corrected: largest ${significant(model.maxCd, 3)} cd; ${planes} half-plane${planes > 1 ? "s" : ""}.`
      : "No lit reading yet.";
    this.text.textContent = words;
    this.svg.setAttribute("aria-label", `Polar diagram. ${words}`);
  }
}
