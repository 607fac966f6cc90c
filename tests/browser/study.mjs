// Results, simulation and diagnosis of a run in a real browser: `node study.mjs ISOLUX FOLDER PICTURES`, run by
// crates/cli/tests/browser.rs. `FOLDER/bench/day` judges a model by readings in one direction of a bench with backlash.

import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";

import { PATIENCE, accessible, ended, folder, inBrowser, pictures, serve, state, step, themes, watch } from "./helpers.mjs";

const narrow = async (page, name) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await accessible(page, `${name}, narrow`);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${name}: no scrolling sideways`);
  await page.evaluate(() => new Promise((done) => setTimeout(() => requestAnimationFrame(done), 250)));
  await page.screenshot({ path: join(pictures, `${name}-narrow.png`), fullPage: true });
  await page.setViewportSize({ width: 1440, height: 1000 });
};

const number = (page, name) => page.evaluate((wanted) => {
  const row = [...document.querySelectorAll(".facts div")].find((one) => one.firstChild.textContent === wanted);
  return row?.lastChild.firstChild.textContent ?? null;
}, name);

const changed = (page, name, before) => page.waitForFunction(([wanted, old]) => {
  const row = [...document.querySelectorAll(".facts div")].find((one) => one.firstChild.textContent === wanted);
  return row && row.lastChild.firstChild.textContent !== old;
}, [name, before], { timeout: PATIENCE });

await inBrowser(async (browser) => {
  const { child, url, port } = await serve(["serve", "bench", "--no-browser", "--speed", "3000"]);
  child.removeAllListeners("exit");
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 } });
  const complaints = [];
  const page = await context.newPage();
  watch(page, complaints);
  await page.goto(url);
  await page.waitForSelector("#show:visible");
  await page.selectOption("#shown", "day");
  await page.click("#show");
  await page.waitForFunction(() => /day$/.test(document.getElementById("run").textContent), null, { timeout: PATIENCE });

  step("a correction that is switched off moves the flux, and back");
  await page.click("#views a[href='#/results']");
  await page.waitForSelector("#figures img");
  const flux = await number(page, "luminous flux");
  assert.match(flux, / lm/);
  await page.uncheck("#correction-ambient");
  await changed(page, "luminous flux", flux);
  assert.match(await page.locator("#numbers").textContent(), new RegExp(`in the results: ${flux.slice(0, 6)}`));
  await page.check("#correction-ambient");
  await page.waitForFunction(([old]) => document.getElementById("numbers").textContent.includes(old) && !document.getElementById("numbers").textContent.includes("in the results"), [flux]);
  assert.ok(await page.evaluate(() => [...document.querySelectorAll("#figures img")].every((image) => image.complete && image.naturalWidth > 0)), "the figures are drawn");
  step("the photometric solid is turned");
  const solid = page.locator("#solid");
  await page.waitForSelector("#solid canvas");
  const before = await solid.getAttribute("data-turned");
  await solid.press("ArrowLeft");
  assert.notEqual(await solid.getAttribute("data-turned"), before);
  await themes(page, "results");
  await narrow(page, "results");

  step("a slider changes the simulation");
  await page.click("#views a[href='#/simulation']");
  await page.waitForSelector("#slider-distance_mm");
  const mean = await number(page, "mean");
  await page.click("#pin");
  const slide = (key, value) => page.locator(`#slider-${key}`).evaluate((slider, to) => { slider.value = to; slider.dispatchEvent(new Event("input")); }, value);
  await slide("distance_mm", 650);
  await changed(page, "mean", mean);
  assert.match(await page.locator("#value-distance_mm").textContent(), /^99[78]\.\d mm$/);
  const ratio = Number(await number(page, "mean, B ÷ A"));
  assert.ok(Math.abs(ratio * (10 ** 0.3) ** 2 - 1) < 0.02, `the inverse square law: ${ratio}`);
  const far = await number(page, "mean");
  await slide("tilt_x_deg", 750);
  await changed(page, "mean", far);
  const exposure = await number(page, "exposure");
  await slide("exposure_s", 600);
  await changed(page, "exposure", exposure);
  step("rays against the noise-free solution");
  await page.waitForFunction(() => /standard error of the mean is/.test(document.getElementById("rays-text").textContent), null, { timeout: PATIENCE });
  const times = await page.evaluate(async () => {
    const ask = async (distance) => {
      const began = performance.now();
      const answer = await fetch("/api/study", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ study: "lit", asked: { distance_mm: distance } }) });
      await answer.json();
      return performance.now() - began;
    };
    const all = [];
    for (let at = 0; at < 20; at += 1) all.push(await ask(400 + 10 * at));
    return all.sort((a, b) => a - b);
  });
  console.log(`  a move of a slider is answered in ${times[10].toFixed(0)} ms (median), ${times[19].toFixed(0)} ms at most`);
  await themes(page, "simulation");
  await narrow(page, "simulation");

  step("a diagnosis is accepted and undone");
  await page.click("#views a[href='#/diagnosis']");
  await page.waitForSelector("#add:enabled");
  assert.match(await page.locator("#plain").textContent(), /backlash|γ|zero/i);
  assert.match(await page.locator("#gaps").textContent(), /fitted readings\d/);
  await page.waitForSelector("#curves canvas");
  await themes(page, "diagnosis");
  await narrow(page, "diagnosis");
  const versions = () => readdirSync(join(folder, "healthy/run/results")).filter((name) => /model\.v\d+\.toml$/.test(name));
  assert.deepEqual(versions(), []);
  await page.click("#add");
  await page.waitForSelector("#undo:enabled", { timeout: PATIENCE });
  const [added] = versions();
  assert.match(readFileSync(join(folder, "healthy/run/results", added), "utf8"), /name = "(backlash|gamma_zero)"/);
  await page.click("#undo");
  await page.waitForSelector("#add:enabled", { timeout: PATIENCE });
  assert.deepEqual(versions(), []);

  step("the next measurement shows its plan, and nothing moves before the second button");
  const show = page.locator("#proposals button:enabled").first();
  await show.click();
  await page.waitForSelector("#plan[open]");
  assert.match(await page.locator("#plan-sentences").textContent(), /σ apart.*readings; C turns/);
  await accessible(page, "the plan");
  await page.screenshot({ path: join(pictures, "plan-light.png") });
  await page.click("#plan-no");
  assert.ok(!existsSync(join(folder, "bench/day-2")), "nothing was begun");
  await show.click();
  await page.waitForSelector("#plan[open]");
  await page.click("#plan-yes");
  await page.waitForFunction(() => /diagnosis 2 of the run/.test(document.getElementById("sentence").textContent), null, { timeout: PATIENCE });
  assert.ok(existsSync(join(folder, "bench/day-2/run.toml")));
  assert.match(await page.locator("#effects").textContent(), /backlash/);
  assert.doesNotMatch(await page.locator("#effects").textContent(), /cannot tell it from/);
  await page.screenshot({ path: join(pictures, "diagnosis-2-light.png"), fullPage: true });
  await page.click("#views a[href='#/live']");
  await state(page, "Completed");
  assert.deepEqual(complaints, [], "the console");

  const bytes = await page.evaluate(() => performance.getEntriesByType("resource").reduce((sum, one) => sum + (one.name.includes("/api/") ? 0 : one.decodedBodySize), 0));
  console.log(`  ${bytes} bytes of files with every view open`);
  assert.ok(bytes < 2_000_000, `${bytes} bytes`);
  assert.ok(port > 0);
  child.kill("SIGTERM");
  await ended(child);
});
