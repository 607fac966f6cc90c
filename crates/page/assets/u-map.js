// The map of how uncertain every direction is, C all round and γ, with what was swept and what is swept next.

import { between, cells } from "./grid.js";

const MARGIN = { left: 44, right: 8, top: 16, bottom: 24 };
const HEIGHT = 300;
/** Upper ends of the shades, in % of the largest light; the last shade has none. They stay as the scan goes on. */
const ENDS = [0.1, 0.2, 0.5, 1, 2, 5, 10];
/** The weakest shade is no ground that shows through. */
const WEAKEST = 0.12;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const shade = (at) => between(colour("--low"), colour("--high"), WEAKEST + ((1 - WEAKEST) * at) / ENDS.length);
const shadeOf = (percent) => { const at = ENDS.findIndex((end) => percent <= end); return at < 0 ? ENDS.length : at; };

function item(mark, words) {
  const line = document.createElement("li");
  mark.classList.add("mark");
  mark.setAttribute("aria-hidden", "true");
  line.append(mark, words);
  return line;
}

function swatch(of) {
  const mark = document.createElement("span");
  // A style by script: the policy of the page allows none in its text.
  if (of === null) mark.classList.add("unknown");
  else mark.style.background = shade(of);
  return mark;
}

function sign(text, kind) {
  return Object.assign(document.createElement("span"), { textContent: text, className: kind });
}

export class UMap {
  constructor(element, legend) {
    Object.assign(this, { element, legend });
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    element.append(this.canvas);
  }

  show(now, words) {
    this.canvas.setAttribute("aria-label", words);
    this.#layout(now);
    this.#unknown();
    this.#cells(now);
    this.#axes();
    this.#planes(now);
    this.#legend();
  }

  #layout(now) {
    const width = Math.max(220, this.element.clientWidth);
    const ratio = window.devicePixelRatio || 1;
    Object.assign(this, { width, c: cells(now.c_deg), gamma: cells(now.gamma_deg) });
    const extent = (map) => { const all = [...map.values()].flat(); return [Math.min(...all), Math.max(...all)]; };
    [this.fromC, this.toC] = extent(this.c);
    [this.fromGamma, this.toGamma] = extent(this.gamma);
    Object.assign(this.canvas, { width: width * ratio, height: HEIGHT * ratio });
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${HEIGHT}px`;
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, width, HEIGHT);
  }

  #x(c) {
    return MARGIN.left + ((c - this.fromC) / (this.toC - this.fromC || 1)) * (this.width - MARGIN.left - MARGIN.right);
  }

  #y(gamma) {
    return MARGIN.top + ((gamma - this.fromGamma) / (this.toGamma - this.fromGamma || 1)) * (HEIGHT - MARGIN.top - MARGIN.bottom);
  }

  get #box() {
    return [MARGIN.left, MARGIN.top, this.width - MARGIN.left - MARGIN.right, HEIGHT - MARGIN.top - MARGIN.bottom];
  }

  /** Hatched: what is not known is no shade. */
  #unknown() {
    const { pen } = this;
    const [x, y, width, height] = this.#box;
    pen.save();
    pen.beginPath();
    pen.rect(x, y, width, height);
    pen.clip();
    pen.fillStyle = colour("--panel");
    pen.fillRect(x, y, width, height);
    pen.strokeStyle = colour("--line");
    pen.lineWidth = 1;
    pen.beginPath();
    for (let at = x - height; at < x + width; at += 7) {
      pen.moveTo(at, y + height);
      pen.lineTo(at + height, y);
    }
    pen.stroke();
    pen.restore();
  }

  #cells(now) {
    const { pen } = this;
    const shades = [...ENDS, 0].map((_, at) => shade(at));
    now.c_deg.forEach((c, plane) => now.gamma_deg.forEach((gamma, node) => {
      const u = now.u_rel[plane * now.gamma_deg.length + node];
      if (u === null) return;
      const [[c0, c1], [g0, g1]] = [this.c.get(c), this.gamma.get(gamma)];
      // Whole pixels: no ground between the cells.
      const [x0, x1, y0, y1] = [this.#x(c0), this.#x(c1), this.#y(g0), this.#y(g1)].map(Math.round);
      pen.fillStyle = shades[shadeOf(100 * u)];
      pen.fillRect(x0, y0, x1 - x0, y1 - y0);
    }));
  }

  #axes() {
    const { pen } = this;
    pen.strokeStyle = colour("--line");
    pen.lineWidth = 1;
    pen.strokeRect(...this.#box);
    pen.fillStyle = colour("--text");
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    const step = this.toC - this.fromC > 200 ? 90 : 30;
    for (let c = Math.ceil(this.fromC / step) * step; c <= this.toC; c += step) {
      pen.fillText(`C${c}°`, Math.min(this.#x(c), this.width - 18), HEIGHT - 8);
    }
    pen.textAlign = "right";
    for (let gamma = Math.ceil(this.fromGamma / 30) * 30; gamma <= this.toGamma; gamma += 30) {
      pen.fillText(`γ${gamma}°`, MARGIN.left - 5, this.#y(gamma) + 4);
    }
  }

  /** A full triangle above each half-plane that was swept; an open one and a dashed frame where the next one is, or
   *  the ring. */
  #planes(now) {
    const { pen } = this;
    const [left, top, width, height] = this.#box;
    const triangle = (c) => {
      const [from, to] = this.c.get(c);
      const x = this.#x((from + to) / 2);
      pen.beginPath();
      pen.moveTo(x - 4, top - 10);
      pen.lineTo(x + 4, top - 10);
      pen.lineTo(x, top - 3);
      pen.closePath();
    };
    pen.fillStyle = colour("--text");
    for (const c of now.swept_c_deg.filter((one) => this.c.has(one))) {
      triangle(c);
      pen.fill();
    }
    for (const c of (now.next?.c_deg ?? []).filter((one) => this.c.has(one))) {
      pen.strokeStyle = colour("--now");
      pen.lineWidth = 1.5;
      triangle(c);
      pen.stroke();
      const [from, to] = this.c.get(c).map((edge) => this.#x(edge));
      this.#frame(from, top, Math.max(2, to - from), height);
    }
    const ring = now.next?.ring_gamma_deg ?? null;
    if (ring !== null) this.#frame(left, this.#y(ring) - 2, width, 4);
  }

  /** Dashed, on a ground of its own: it lies over every shade. */
  #frame(...box) {
    const { pen } = this;
    for (const [name, width, dash] of [["--panel", 4, []], ["--now", 2, [5, 3]]]) {
      pen.strokeStyle = colour(name);
      pen.lineWidth = width;
      pen.setLineDash(dash);
      pen.strokeRect(...box);
    }
    pen.setLineDash([]);
  }

  #legend() {
    const ends = ["0", ...ENDS.map(String)];
    const shades = ENDS.map((end, at) => item(swatch(at), `${ends[at]} to ${end} %`));
    this.legend.replaceChildren(
      ...shades, item(swatch(ENDS.length), `above ${ENDS.at(-1)} %`), item(swatch(null), "not known yet"),
      item(sign("▼", "swept"), "swept"), item(sign("▽", "next"), "next"),
    );
  }
}
