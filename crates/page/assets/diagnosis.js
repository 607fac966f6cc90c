// The diagnosis of the run that is shown: the sentence, the gap, the effects with add and undo, what to measure next.

import { Chart, axis, line } from "./charts.js";
import { command, study } from "./commands.js";
import { $, facts, make, picture } from "./dom.js";
import { significant } from "./words.js";

class Curves extends Chart {
  draw(curve) {
    const options = {
      scales: { x: { time: false } },
      axes: [axis("γ / °"), axis("E / lx", { size: 62 })],
      series: [{}, line("measured", "--text", { width: 0, points: { show: true, size: 5 } }), line("simulated before", "--one", { dash: [6, 4] }), line("simulated after", "--two")],
    };
    this.show(options, [curve.gamma_deg, curve.measured_lx, curve.before_lx, curve.after_lx], "Measured (points), simulated without the effects (dashed) and with them (solid).");
  }
}

class Residuals extends Chart {
  draw(curve) {
    const options = {
      scales: { x: { time: false } },
      axes: [axis("γ / °"), axis("residual / lx", { size: 62 })],
      series: [{}, line("before", "--one", { dash: [6, 4] }), line("after", "--two"), line("+U", "--line"), line("−U", "--line")],
    };
    const minus = (model) => curve.measured_lx.map((lux, at) => lux - model[at]);
    const band = [curve.u_lx, curve.u_lx.map((u) => -u)];
    this.show(options, [curve.gamma_deg, minus(curve.before_lx), minus(curve.after_lx), ...band], "What is left without the effects (dashed) and with them (solid); thin: the expanded uncertainty of a reading (k = 2).");
  }
}

export class Diagnosis {
  constructor() {
    this.curves = new Curves($("curves"), $("curves-text"), 240);
    this.residuals = new Residuals($("residuals"), $("residuals-text"), 200);
    $("add").addEventListener("click", () => this.#say({ command: "add_to_model" }));
    $("undo").addEventListener("click", () => this.#say({ command: "take_out_of_model" }));
    $("half-planes").addEventListener("change", () => this.#plot());
    $("plan-no").addEventListener("click", () => $("plan").close());
    $("plan-yes").addEventListener("click", () => {
      $("plan").close();
      this.#say({ command: "measure", number: this.number, seen: this.seen });
    });
  }

  stale() {
    this.shown = false;
  }

  async open() {
    if (this.shown) return;
    this.shown = true;
    try {
      this.#show(await study({ study: "diagnosis" }));
    } catch (error) {
      this.#show(null, error.message);
    }
  }

  async #say(body) {
    const answer = await command(body).catch(() => ({ words: "the program did not answer" }));
    $("diagnosis-said").textContent = answer.words;
  }

  #show(told, instead = "This run has no diagnosis: a day makes one at its end, isolux diagnose MODEL RUN by hand.") {
    this.told = told;
    for (const panel of document.querySelectorAll("[data-view=diagnosis] .panel.of-diagnosis")) panel.hidden = !told;
    $("plain").textContent = told?.plain ?? instead;
    if (!told) return;
    const rounds = told.round > 1 ? ` This is diagnosis ${told.round} of the run, with the readings of further measurements.` : "";
    $("sentence").textContent = `${told.sentence}. ${told.same_record ? `${told.same_record}.` : ""}${rounds}`;
    $("gaps").replaceChildren(...told.gaps.map(([name, ...numbers]) => make("tr", {}, make("th", { scope: "row", textContent: name }), ...numbers.map((one) => make("td", { textContent: one === null ? "–" : one.toFixed(3) })))));
    this.#effects(told);
    const pairs = told.curves.map((curve, at) => new Option(`C ${curve.c_deg}° – ${curve.c_deg + 180}°, ${significant(curve.distance_mm, 5)} mm`, at));
    $("half-planes").replaceChildren(...pairs);
    $("curves-panel").hidden = told.curves.length === 0;
    this.#plot();
    $("diagnosis-figures").replaceChildren(...told.figures.map(picture));
    this.#proposals(told.next);
  }

  #effects(told) {
    $("effects").replaceChildren(...told.effects.flatMap((effect) => {
      const others = effect.equivalents.length ? [make("p", { className: "caption", textContent: `These readings cannot tell it from ${effect.equivalents.join(", ")}.` })] : [];
      return [make("h3", { textContent: effect.name }), facts(effect.parameters.map((one) => [one.name, one.value])), ...others];
    }));
    $("no-effects").hidden = told.effects.length > 0;
    $("add").disabled = told.effects.length === 0 || Boolean(told.added);
    $("undo").disabled = !told.added;
    $("model-text").textContent = told.added ? `The effects are in ${told.added}; the simulation is lit by it.` : `Judged: ${told.model}. Adding writes its next version beside it.`;
  }

  #proposals(next) {
    $("proposals").replaceChildren(...next.map((one, number) => {
      const show = make("button", { type: "button", textContent: "Show its plan", disabled: !one.plan });
      show.addEventListener("click", () => this.#plan(number));
      const words = `${one.what}: ${one.splits.join(" and ")} would lie ${one.expected_sigma.toFixed(1)} σ apart${one.plan ? "" : " (poses of a camera: no plan of the axes)"}`;
      return make("li", {}, make("span", { textContent: words }), show);
    }));
    $("no-proposals").hidden = next.length > 0;
  }

  /** Nothing moves before the second button. */
  async #plan(number) {
    try {
      const shown = await study({ study: "next", number });
      [this.number, this.seen] = [number, shown.fingerprint];
      $("plan-sentences").replaceChildren(...shown.sentences.map((sentence) => make("li", { textContent: sentence })));
      $("plan-text").textContent = shown.text;
      $("plan").showModal();
    } catch (error) {
      $("diagnosis-said").textContent = error.message;
    }
  }

  #plot() {
    const curve = this.told?.curves[$("half-planes").value];
    if (!curve) return;
    this.curves.draw(curve);
    this.residuals.draw(curve);
  }

  refresh() {
    this.curves.refresh();
    this.residuals.refresh();
    this.#plot();
  }
}
