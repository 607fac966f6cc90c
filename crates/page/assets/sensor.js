// Maps of a sensor; the one by the scan so far with its expanded uncertainty beside it.

import { significant } from "./words.js";

function colour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [0, 1, 2].map((at) => parseInt(text.slice(1 + 2 * at, 3 + 2 * at), 16));
}

export class Picture {
  constructor(element, title) {
    this.figure = document.createElement("figure");
    this.canvas = document.createElement("canvas");
    this.canvas.className = "pixels";
    this.canvas.setAttribute("role", "img");
    this.words = document.createElement("figcaption");
    this.words.className = "caption";
    this.title = title;
    this.figure.append(this.canvas, this.words);
    element.append(this.figure);
  }

  draw([nx, ny], values, unit) {
    this.figure.hidden = !values;
    if (!values) return;
    const low = values.reduce((a, b) => Math.min(a, b), Infinity);
    const high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [dark, bright] = [colour("--low"), colour("--high")];
    this.canvas.width = nx;
    this.canvas.height = ny;
    const pen = this.canvas.getContext("2d");
    const image = pen.createImageData(nx, ny);
    values.forEach((value, at) => {
      const share = high > low ? (value - low) / (high - low) : 0.5;
      // Rows begin at the lower edge of the sensor.
      const row = ny - 1 - Math.floor(at / nx);
      const target = 4 * (row * nx + (at % nx));
      for (let part = 0; part < 3; part += 1) image.data[target + part] = dark[part] + (bright[part] - dark[part]) * share;
      image.data[target + 3] = 255;
    });
    pen.putImageData(image, 0, 0);
    const words = `${this.title}: ${significant(low)} to ${significant(high)} ${unit}`;
    this.words.textContent = words;
    this.canvas.setAttribute("aria-label", words);
  }
}

export class Sensor {
  constructor(element, text) {
    this.text = text;
    const row = document.createElement("div");
    row.className = "pair";
    element.append(row);
    this.map = new Picture(row, "Light");
    this.u = new Picture(row, "Expanded uncertainty (k = 2)");
    this.asked = 0;
    this.now = null;
  }

  refresh() {
    this.show();
  }

  /** Fetches the map when the status counts a new one. */
  async follow(count) {
    if (count === this.asked) return;
    this.asked = count;
    this.now = null;
    if (count > 0) {
      const answer = await fetch("/api/sensor", { cache: "no-store" });
      if (answer.ok) this.now = await answer.json();
    }
    this.show();
  }

  show() {
    const now = this.now;
    this.map.draw(now?.pixels ?? [1, 1], now?.map, now?.unit);
    this.u.draw(now?.pixels ?? [1, 1], now?.expanded, now?.unit);
    if (!now) {
      this.text.textContent = "Simulated after the first whole half-plane.";
      return;
    }
    const u = now.expanded ? "by missing half-planes, scatter, rounding and calibration" : "uncertainty not evaluated from one half-plane";
    const lux = now.unit === "lx" ? " In W/m² as soon as the spectrum is taken." : "";
    this.text.textContent = `Mean ${now.mean}, ${u}; smallest ÷ mean ${now.min_over_mean.toFixed(4)}. By ${now.half_planes} of ${now.planned} half-planes, not corrected; sensor ${now.size_mm.map((mm) => significant(mm, 3)).join(" × ")} mm at ${significant(now.distance_mm, 4)} mm of ${now.scene}.${lux}`;
  }
}
