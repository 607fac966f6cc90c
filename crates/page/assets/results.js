// The results of the run that is shown: numbers, corrections to switch, the report's pictures, the photometric solid.

import { latest, study } from "./commands.js";
import { $, facts, make, picture, stated } from "./dom.js";

export class Results {
  constructor() {
    this.ask = latest((without) => this.#ask(without));
    this.solid = null;
  }

  /** Another run, or another reduction of it: everything is asked anew. */
  stale() {
    this.shown = false;
  }

  open() {
    if (this.shown) return;
    this.shown = true;
    this.ask(null);
  }

  async #ask(without) {
    $("results-text").textContent = "The readings are being reduced.";
    try {
      this.#show(await study({ study: "results", without }));
    } catch (error) {
      $("results-text").textContent = error.message;
      for (const id of ["numbers", "corrections", "figures"]) $(id).replaceChildren();
      $("solid-panel").hidden = true;
    }
  }

  #show(told) {
    const off = told.corrections.filter((one) => !one.on).map((one) => one.word);
    const words = told.partial ? ["Partial: the run ended before its plan did."] : [];
    words.push(off.length ? `Without ${off.join(", ")}; nothing is written.` : "With every correction.");
    $("results-text").textContent = [...words, ...told.notes.map((note) => `${note.replace(/^[a-z]/, (first) => first.toUpperCase())}.`)].join(" ");
    const beside = (one) => (one.reported ? `in the results: ${one.reported}` : null);
    $("numbers").replaceChildren(facts(told.numbers.map((one) => [one.name, stated(one.value, beside(one))])));
    if ($("corrections").childElementCount === 0) this.#switches(told.corrections);
    for (const one of told.corrections) $(`correction-${one.word}`).checked = one.on;
    $("figures").replaceChildren(...told.figures.map(picture));
    this.#draw(told.solid);
  }

  #switches(corrections) {
    $("corrections").replaceChildren(...corrections.map((one) => {
      const box = make("input", { type: "checkbox", id: `correction-${one.word}`, value: one.word });
      box.addEventListener("change", () => this.ask([...$("corrections").querySelectorAll("input:not(:checked)")].map((other) => other.value)));
      const words = make("span", {}, make("b", { textContent: one.word.replaceAll("_", " ") }), ` – ${one.what}${one.on_in_report ? "" : " (off in the results)"}`);
      return make("label", { className: "switch" }, box, words);
    }));
  }

  async #draw(solid) {
    $("solid-panel").hidden = false;
    // The library is large: it is fetched when it is needed.
    const { Solid } = await import("./solid.js");
    this.solid ??= new Solid($("solid"), $("solid-text"));
    this.solid.show(solid);
  }

  refresh() {
    this.solid?.refresh();
  }
}
