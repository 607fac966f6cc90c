// The polar diagram of the scan so far: drawn by the program as the report draws its own, with the current ray as a spoke.

import { latest, study } from "./commands.js";
import { inline, make } from "./dom.js";
import { curve } from "./state.js";
import { significant } from "./words.js";

/** The curve through C and C + 180°, whose γ is counted below zero. */
function pair(model, c) {
  const right = curve(model, c);
  const left = curve(model, (c + 180) % 360).filter(([gamma]) => gamma > 0 || right.length === 0);
  return [...left.map(([gamma, cd]) => [-gamma, cd]).reverse(), ...right];
}

export class Polar {
  constructor(element, text) {
    Object.assign(this, { element, text });
    // The last picture stays where the program does not answer; the page says that the connection is lost.
    this.ask = latest((so_far) => study({ study: "polar", so_far }).then((told) => this.#show(told), () => {}));
  }

  #show({ svg }) {
    const picture = inline(svg);
    picture.setAttribute("aria-label", `Polar diagram. ${this.text.textContent}`);
    this.element.replaceChildren(make("div", { className: "card" }, picture));
  }

  /** Resolves when the picture shows what was known when it was asked for. */
  async draw(model) {
    if (this.outline === model.outline && this.drawn === model.version) return;
    [this.outline, this.drawn] = [model.outline, model.version];
    const planes = model.planes.size;
    this.text.textContent = planes
      ? `E·d² of what was read so far, not corrected: largest ${significant(model.maxCd, 3)} cd; ${planes} half-plane${planes > 1 ? "s" : ""}.`
      : "No lit reading yet.";
    const row = model.last?.kind === "lit" ? model.last : null;
    const c = row ? row.c_target_deg % 180 : 0;
    const side = row && row.c_target_deg >= 180 && row.c_target_deg < 360 ? -1 : 1;
    const cd = row ? (row.illuminance_lx ?? 0) * (row.distance_mm / 1000) ** 2 : 0;
    await this.ask({
      c0: pair(model, 0), c90: pair(model, 90), current: c === 0 || c === 90 ? null : [`C${c}–C${c + 180}`, pair(model, c)],
      ray: row ? [side * row.gamma_target_deg, cd] : null, peak_cd: model.maxCd, reach_deg: model.reach,
    });
  }
}
