// The map of the sensor by the scan so far, with its expanded uncertainty beside it.

import { SensorMap, ramp } from "./map.js";
import { significant } from "./words.js";

/** The colours of a map in this theme: its own, but in red light the shades of red alone. */
export function shades(map) {
  return document.documentElement.dataset.theme === "red" ? ramp([20, 0, 0], [255, 90, 90]) : map?.colours;
}

export class Sensor {
  constructor(element, text) {
    this.text = text;
    const row = document.createElement("div");
    row.className = "pair";
    element.append(row);
    this.map = new SensorMap(row, { title: "Light", plain: true });
    this.u = new SensorMap(row, { title: "U (k = 2)", plain: true });
    this.asked = 0;
    this.now = null;
    this.show();
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
    this.map.show(now?.map, shades(now?.map));
    this.u.show(now?.expanded, shades(now?.expanded));
    if (!now) {
      this.text.textContent = "Simulated after the first whole half-plane.";
      return;
    }
    const u = now.expanded ? "beside it the expanded uncertainty (k = 2) by missing half-planes, scatter, rounding and calibration" : "uncertainty not evaluated from one half-plane";
    const lux = now.unit === "lx" ? " In W/m² as soon as the spectrum is taken." : "";
    this.text.textContent = `Mean ${now.mean}, ${u}; smallest ÷ mean ${now.min_over_mean.toFixed(4)}. By ${now.half_planes} of ${now.planned} half-planes, not corrected; sensor ${now.size_mm.map((mm) => significant(mm, 3)).join(" × ")} mm at ${significant(now.distance_mm, 4)} mm of ${now.scene}.${lux}`;
  }
}
