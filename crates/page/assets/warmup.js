// The warm-up while it goes on: its curve, what is asked of the lamp, and how long that will take.

import { WarmUp } from "./charts.js";
import { $ } from "./dom.js";
import { duration } from "./words.js";

/** Looks of which the fall of the spread is taken. */
const LOOKS = 12;

/** Seconds until the spread of the light is within what is allowed, if it goes on falling as it did: the light of a lamp
 *  that warms up approaches its end exponentially, and so the spread over a window falls. Null where it does not fall. */
export function untilSteady(looks, allowed) {
  const known = looks.filter((look) => look.spread_rel > 0).slice(-LOOKS);
  if (known.length === 0) return null;
  const last = known.at(-1);
  if (last.spread_rel <= allowed) return 0;
  const n = known.length;
  const mean = (of) => known.reduce((sum, look) => sum + of(look), 0) / n;
  const [t, y] = [mean((look) => look.lamp_s), mean((look) => Math.log(look.spread_rel))];
  const across = mean((look) => (look.lamp_s - t) * (Math.log(look.spread_rel) - y));
  const along = mean((look) => (look.lamp_s - t) ** 2);
  const slope = along > 0 ? across / along : 0;
  if (slope >= 0) return null;
  return Math.max(0, t + (Math.log(allowed) - y) / slope - last.lamp_s);
}

/** What is left of the warm-up: least time on and steady light, whichever takes longer. `left_s` is null where nobody
 *  can say. */
export function warmUpLeft({ warmUps, outline }) {
  const last = warmUps.at(-1);
  const least = Math.max(outline.least_s, outline.window_s);
  const leastLeft = Math.max(0, least - (last?.lamp_s ?? 0));
  const full = last && last.spread_rel !== null;
  const steady = full ? untilSteady(warmUps, outline.spread_rel) : 0;
  return { leastLeft, least, full: Boolean(full), left_s: steady === null ? null : Math.max(leastLeft, steady) };
}

export class Warming {
  constructor() {
    this.chart = new WarmUp($("warming"), $("warming-text"), 400);
  }

  refresh() {
    this.chart.refresh();
  }

  draw(model, times) {
    const { leastLeft, least, full, left_s } = warmUpLeft(model);
    const last = model.warmUps.at(-1);
    const on = last?.lamp_s ?? 0;
    const here = left_s !== null && model.outline.in_memory && times ? `; ${duration(left_s / times)} at ${times} times the speed` : "";
    // Before the window is full nobody knows how the lamp goes on after the least time.
    const [number, why] = model.state === "homing" ? ["The axes search their reference.", "Then the lamp is switched on and watched."]
      : left_s === null ? ["Time left not known", "The light does not become steadier; it is watched until it does."]
        : [`${full ? "About" : "At least"} ${duration(left_s)} left`, `${left_s > leastLeft ? "until the light is steady" : "by the least time on"}${here}`];
    this.#say("warm-left", number);
    this.#say("warm-why", why);
    const { spread_rel: allowed, window_s } = model.outline;
    const words = last ? `Light since the lamp was switched on. Band: the light has to stay within it for ${duration(window_s)}.` : "";
    this.chart.draw(model, Math.max(least, on + (left_s ?? 0)), words);
    $("warm-on").value = Math.min(1, on / least);
    this.#say("warm-on-text", `${duration(on)} of at least ${duration(least)}`);
    const spread = last?.spread_rel ?? null;
    $("warm-steady").value = spread === null ? 0 : Math.min(1, allowed / spread);
    this.#say("warm-steady-text", spread === null
      ? `at most ${(allowed * 100).toFixed(2)} % of change in ${duration(window_s)}; the window is not full`
      : `${(spread * 100).toFixed(2)} % of change in ${duration(window_s)}, at most ${(allowed * 100).toFixed(2)} %`);
  }

  #say(id, words) {
    if ($(id).textContent !== words) $(id).textContent = words;
  }
}
