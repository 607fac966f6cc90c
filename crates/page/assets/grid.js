// The map of directions: done, flagged and next, shaded by what was read.

import { nextPoint } from "./state.js";
import { significant } from "./words.js";

const MARGIN = { left: 40, right: 8, top: 8, bottom: 30 };
const HEIGHT = 272;

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Between two #rrggbb. */
export function between(low, high, share) {
  const part = (text, at) => parseInt(text.slice(1 + 2 * at, 3 + 2 * at), 16);
  const mixed = [0, 1, 2].map((at) => Math.round(part(low, at) + (part(high, at) - part(low, at)) * share));
  return `rgb(${mixed.join(",")})`;
}

/** The middle of the steps of a list of angles. */
export function cells(angles) {
  const sorted = [...new Set(angles)].sort((a, b) => a - b);
  const edges = sorted.map((angle, at) => {
    const before = at > 0 ? (sorted[at - 1] + angle) / 2 : angle - ((sorted[1] ?? angle + 10) - angle) / 2;
    const after = at + 1 < sorted.length ? (sorted[at + 1] + angle) / 2 : angle + (angle - (sorted[at - 1] ?? angle - 10)) / 2;
    return [angle, [before, after]];
  });
  return new Map(edges);
}

/** Directions that are read at rest: those that are swept have a map of their own. */
export const isShown = (point) => point.kind === "lit" && !point.spectrum && !point.in_motion;

export class Grid {
  constructor(element, text) {
    this.element = element;
    this.text = text;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    element.append(this.canvas);
    this.outline = null;
    this.shown = new Map();
  }

  /** Everything is drawn anew: after a change of size or theme. */
  refresh() {
    this.outline = null;
  }

  #layout(model) {
    this.outline = model.outline;
    this.shown.clear();
    this.marked = null;
    this.points = [...model.points.values()].filter(isShown);
    this.c = cells(this.points.map((point) => point.c_deg));
    this.gamma = cells(this.points.map((point) => point.gamma_deg));
    const all = (map) => [...map.values()].flat();
    const extent = (map) => (map.size ? [Math.min(...all(map)), Math.max(...all(map))] : [0, 1]);
    [this.fromC, this.toC] = extent(this.c);
    [this.fromGamma, this.toGamma] = extent(this.gamma);
    const width = Math.max(220, this.element.clientWidth);
    const ratio = window.devicePixelRatio || 1;
    this.width = width;
    this.canvas.width = width * ratio;
    this.canvas.height = HEIGHT * ratio;
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${HEIGHT}px`;
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.colours = { low: colour("--low"), high: colour("--high"), line: colour("--line"), text: colour("--text"), mark: colour("--mark"), now: colour("--now"), panel: colour("--panel"), grid: colour("--grid") };
    this.#axes();
  }

  #x(c) {
    return MARGIN.left + ((c - this.fromC) / (this.toC - this.fromC || 1)) * (this.width - MARGIN.left - MARGIN.right);
  }

  #y(gamma) {
    return MARGIN.top + ((gamma - this.fromGamma) / (this.toGamma - this.fromGamma || 1)) * (HEIGHT - MARGIN.top - MARGIN.bottom);
  }

  #axes() {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, HEIGHT);
    pen.fillStyle = this.colours.text;
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    const step = this.toC - this.fromC > 200 ? 90 : 30;
    for (let c = Math.ceil(this.fromC / step) * step; c <= this.toC; c += step) pen.fillText(`C${c}°`, Math.min(this.#x(c), this.width - 18), HEIGHT - 12);
    pen.textAlign = "right";
    const [first, last] = [Math.ceil(this.fromGamma / 30) * 30, this.toGamma];
    for (let gamma = first; gamma <= last; gamma += 30) pen.fillText(`γ${gamma}°`, MARGIN.left - 5, this.#y(gamma) + 4);
  }

  #cell(point, status, share) {
    const { pen, colours } = this;
    const [c, gamma] = [this.c.get(point.c_deg), this.gamma.get(point.gamma_deg)];
    const [x0, x1, y0, y1] = [this.#x(c[0]), this.#x(c[1]), this.#y(gamma[0]), this.#y(gamma[1])];
    pen.fillStyle = status === "open" ? colours.panel : between(colours.low, colours.high, share);
    pen.fillRect(x0, y0, x1 - x0, y1 - y0);
    const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
    if (status === "open") {
      pen.fillStyle = colours.line;
      pen.fillRect(x - 0.75, y - 0.75, 1.5, 1.5);
    }
    if (status === "flagged") {
      const r = Math.max(2.5, Math.min(x1 - x0, y1 - y0) / 2 - 1);
      pen.fillStyle = colours.panel;
      pen.fillRect(x0, y0, x1 - x0, y1 - y0);
      pen.strokeStyle = colours.mark;
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(x - r, y - r);
      pen.lineTo(x + r, y + r);
      pen.moveTo(x + r, y - r);
      pen.lineTo(x - r, y + r);
      pen.stroke();
    }
  }

  /** The ring reaches over the neighbours of its point. */
  #ring(point) {
    const { pen, colours } = this;
    const [c, gamma] = [this.c.get(point.c_deg), this.gamma.get(point.gamma_deg)];
    const [x0, x1, y0, y1] = [this.#x(c[0]), this.#x(c[1]), this.#y(gamma[0]), this.#y(gamma[1])];
    // Within the map: what it lies over can then be drawn again without the labels.
    pen.save();
    pen.beginPath();
    pen.rect(MARGIN.left, MARGIN.top, this.width - MARGIN.left - MARGIN.right, HEIGHT - MARGIN.top - MARGIN.bottom);
    pen.clip();
    pen.strokeStyle = colours.now;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc((x0 + x1) / 2, (y0 + y1) / 2, Math.max(4, Math.min(x1 - x0, y1 - y0) / 2 + 1), 0, 2 * Math.PI);
    pen.stroke();
    pen.restore();
  }

  /** What lies below the ring of a point is drawn again. */
  #erase(point) {
    const [c, gamma] = [this.c.get(point.c_deg), this.gamma.get(point.gamma_deg)];
    const [x, y] = [(this.#x(c[0]) + this.#x(c[1])) / 2, (this.#y(gamma[0]) + this.#y(gamma[1])) / 2];
    const r = Math.max(4, Math.min(this.#x(c[1]) - this.#x(c[0]), this.#y(gamma[1]) - this.#y(gamma[0])) / 2 + 1) + 2;
    for (const other of this.points) {
      const [from, to] = this.c.get(other.c_deg);
      if (this.#x(to) < x - r || this.#x(from) > x + r) continue;
      const [low, high] = this.gamma.get(other.gamma_deg);
      if (this.#y(high) >= y - r && this.#y(low) <= y + r) this.shown.delete(other);
    }
  }

  draw(model) {
    if (!model.outline) return;
    const top = model.maxCd;
    // The shades are logarithmic over three decades: the scale changes with the largest value.
    const decade = Math.ceil(Math.log10(top || 1) * 4);
    if (model.outline !== this.outline || decade !== this.decade || this.element.clientWidth !== this.seen) {
      [this.decade, this.seen] = [decade, this.element.clientWidth];
      this.#layout(model);
    }
    const scale = 10 ** (decade / 4);
    const share = (cd) => Math.max(0, Math.min(1, 1 + Math.log10(Math.max(cd ?? 0, 1e-30) / scale) / 3));
    const next = nextPoint(model);
    // The ring reaches over its neighbours: they are drawn again.
    if (this.marked && this.marked !== next) this.#erase(this.marked);
    let done = 0;
    for (const point of this.points) {
      done += point.status === "open" ? 0 : 1;
      if (this.shown.get(point) === point.status) continue;
      this.shown.set(point, point.status);
      this.#cell(point, point.status, share(point.cd));
    }
    this.marked = next && !next.spectrum && next.kind === "lit" ? next : null;
    if (this.marked) this.#ring(next);
    const total = this.points.length;
    const where = next ? `; next C ${next.c_deg}°, γ ${next.gamma_deg}° (block ${next.block}, ring)` : "";
    const words = total ? `${done} of ${total} lit directions done, ${model.flagged} flagged (cross)${where}. Shades: three decades up to ${significant(scale, 2)} cd.` : "The plan has no lit directions.";
    this.text.textContent = words;
    this.canvas.setAttribute("aria-label", `Map of directions. ${words}`);
  }
}
