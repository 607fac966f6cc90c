// Results, simulation and diagnosis of a run in a real browser: `node study.mjs ISOLUX FOLDER PICTURES`, run by
// crates/cli/tests/browser.rs. `FOLDER/bench/day` judges a model by readings in one direction of a bench with backlash.

import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";

import { PATIENCE, accessible, ended, folder, inBrowser, looks, pictures, serve, state, step, themes, watch } from "./helpers.mjs";

const narrow = async (page, name) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await accessible(page, `${name}, narrow`);
  await page.evaluate(() => new Promise((done) => setTimeout(() => requestAnimationFrame(done), 250)));
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${name}: no scrolling sideways`);
  await page.screenshot({ path: join(pictures, `${name}-narrow.png`), fullPage: true });
  await page.setViewportSize({ width: 1440, height: 1000 });
};

/** The number of this name, without what stands beside it. */
function shown(wanted) {
  const row = [...document.querySelectorAll("main:not([hidden]) .facts div")].find((one) => one.firstChild.textContent === wanted);
  let first = row?.lastChild;
  while (first?.firstChild) first = first.firstChild;
  return first?.textContent ?? null;
}

/** The report's map tells value and place, keeps what is held, and its scene is turned, filtered and followed. */
async function explored(report) {
  const [map, said] = [report.locator("#map canvas").first(), report.locator("#map .said")];
  await map.scrollIntoViewIfNeeded();
  await map.hover({ position: { x: 30, y: 40 } });
  const first = await said.textContent();
  assert.match(first, /^\S+ lx at x −\S+ mm, y \S+ mm; \S+ % from the mean$/);
  await map.click({ position: { x: 200, y: 250 } });
  const held = await said.textContent();
  assert.notEqual(held, first);
  await map.hover({ position: { x: 60, y: 60 } });
  assert.equal(await said.textContent(), held, "a click holds the place");
  await report.check("#map [name=log]");
  await report.check("#map [name=contour]");
  const stage = report.locator(".stage");
  const turned = await stage.getAttribute("data-turned");
  await stage.press("ArrowLeft");
  assert.notEqual(await stage.getAttribute("data-turned"), turned);
  const band = await report.locator(".band").textContent();
  await report.locator(".low").evaluate((slider) => { slider.value = 600; slider.dispatchEvent(new Event("input")); });
  assert.notEqual(await report.locator(".band").textContent(), band);
  await report.locator(".low").evaluate((slider) => { slider.value = 360; slider.dispatchEvent(new Event("input")); });
  await report.click("[name=side]");
  await report.click("[name=lamp]");
  const box = await stage.boundingBox();
  for (let at = 0; at < 12 && !/^ray/.test(await report.locator(".ray-note").textContent()); at += 1) {
    await report.mouse.click(box.x + box.width / 2 + 3 * at, box.y + box.height / 2 + 2 * at);
  }
  assert.match(await report.locator(".ray-note").textContent(), /^ray \d+: (\d+ nm, )?from \(.*to pixel/);
  await report.click("[name=reset]");
}

const number = (page, name) => page.evaluate((wanted) => window.shownNumber(wanted), name);

const changed = (page, name, before) => page.waitForFunction(([wanted, old]) => window.shownNumber(wanted) !== old, [name, before], { timeout: PATIENCE });

await inBrowser(async (browser) => {
  const { child, url, port } = await serve(["serve", "bench", "--no-browser", "--speed", "3000"]);
  child.removeAllListeners("exit");
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 } });
  await context.addInitScript(`window.shownNumber = ${shown}`);
  const complaints = [];
  const page = await context.newPage();
  watch(page, complaints);
  await page.goto(url);
  step("a day is on a card with its numbers, which opens its results");
  const card = page.locator("#runs li[data-run=day] button");
  await page.waitForFunction(() => /luminous flux\S.* lm/.test(document.querySelector("#runs li[data-run=day]")?.textContent), null, { timeout: PATIENCE });
  const onCard = await card.textContent();
  await card.click();
  await page.waitForFunction(() => /day$/.test(document.getElementById("run").textContent) && location.hash === "#/results", null, { timeout: PATIENCE });

  step("a day that is done says its numbers and where more is");
  await page.click("#views a[href='#/live']");
  await page.waitForFunction(() => /luminous flux.* lm/.test(document.getElementById("finished").textContent), null, { timeout: PATIENCE });
  await looks(page, "done");
  await page.click("#finished a[href='#/results']");

  step("a correction that is switched off moves the flux, and back");
  await page.waitForSelector("#figures svg");
  const flux = await number(page, "luminous flux");
  assert.match(flux, / lm/);
  assert.ok(onCard.includes(`luminous flux${flux.replace(" (k = 2)", "")}`), `${onCard}: ${flux}`);
  await page.uncheck("#correction-dark");
  await changed(page, "luminous flux", flux);
  assert.match(await page.locator("#numbers").textContent(), new RegExp(`in the results: ${flux.slice(0, 6)}`));
  await page.check("#correction-dark");
  await page.waitForFunction(([old]) => document.getElementById("numbers").textContent.includes(old) && !document.getElementById("numbers").textContent.includes("in the results"), [flux]);
  assert.ok(await page.evaluate(() => [...document.querySelectorAll("#figures svg")].every((figure) => figure.querySelectorAll("path, rect").length > 3 && figure.getBoundingClientRect().width > 200)), "the figures are drawn");
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
  step("the difference of two poses is drawn with its sign");
  const gap = await page.locator("#gap-text").textContent();
  const [, mean_] = /mean \+(\S+) lx \((\S+) % of the mean of A\)/.exec(gap) ?? assert.fail(gap);
  assert.ok(Number(mean_) > 0 && /smallest \+/.test(gap), `nearer is brighter everywhere: ${gap}`);
  await page.hover("#lit-map figure:nth-child(3) canvas");
  assert.match(await page.locator("#lit-map figure:nth-child(3) .said").textContent(), /^\+\S+ lx at x \S+ mm, y \S+ mm$/);
  const exposure = await number(page, "exposure");
  await slide("exposure_s", 600);
  await changed(page, "exposure", exposure);
  step("rays against the noise-free solution");
  await page.waitForFunction(() => /standard error of the mean is/.test(document.getElementById("rays-text").textContent), null, { timeout: PATIENCE });
  await themes(page, "simulation");
  await narrow(page, "simulation");

  step("the report looks the same from the page and as a file, and complains of nothing");
  const file = `file://${join(folder, "bench/day/results/report.html")}`;
  for (const [name, address, colorScheme] of [["page", `http://127.0.0.1:${port}/report`, "light"], ["file", file, "dark"]]) {
    const report = await context.newPage();
    await report.emulateMedia({ colorScheme });
    watch(report, complaints);
    await report.goto(address);
    await report.waitForSelector(".viewer[data-drawn=webgl] .stage[data-turned]", { timeout: PATIENCE });
    await explored(report);
    await report.screenshot({ path: join(pictures, `report-${name}-${colorScheme}.png`), fullPage: true });
    await report.close();
  }
  const old = await context.newPage();
  watch(old, complaints);
  await old.addInitScript(() => { HTMLCanvasElement.prototype.getContext = ((own) => function get(kind, ...more) { return kind.startsWith("webgl") ? null : own.call(this, kind, ...more); })(HTMLCanvasElement.prototype.getContext); });
  await old.goto(file);
  await old.waitForSelector(".viewer[data-drawn=svg] .stage svg path", { timeout: PATIENCE, state: "attached" });
  await old.locator(".viewer").screenshot({ path: join(pictures, "report-no-webgl.png") });
  await old.close();

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

  step("ten updates a second with 100,000 points");
  const load = await page.evaluate(async () => {
    const modules = ["state", "polar", "grid", "charts"].map((name) => import(`/${name}.js`));
    const [{ add, begin, empty }, { Polar }, { Grid }, { Curve, Reference }] = await Promise.all(modules);
    const points = Array.from({ length: 100_080 }, (_, at) => ({ block: "lit", kind: "lit", spectrum: false, c_deg: Math.floor(at / 278), gamma_deg: (at % 278) * 0.65 }));
    const model = empty();
    begin(model, { points, drift_rel: 0.02, spread_rel: 0.005, window_s: 900, distance_mm: 3600 });
    const panel = document.getElementById("scan");
    panel.hidden = false;
    const places = Array.from({ length: 8 }, () => panel.appendChild(document.createElement("div")));
    const parts = [new Polar(places[0], places[1]), new Grid(places[2], places[3]), new Curve(places[4], places[5], 272), new Reference(places[6], places[7], 136)];
    let next = 0;
    const read = () => {
      const { c_deg, gamma_deg } = points[next];
      add(model, { event: "reading", role: "point", point: next, kind: "lit", c_target_deg: c_deg, gamma_target_deg: gamma_deg, illuminance_lx: 30 * Math.max(0, Math.cos((gamma_deg * Math.PI) / 180)), u_lx: 0.01, quality: "ok", distance_mm: 3600, time_s: next });
      next += 1;
    };
    while (next < 99_000) read();
    for (const part of parts) part.draw(model);
    const times = [];
    while (next + 20 < points.length && times.length < 50) {
      for (let at = 0; at < 20; at += 1) read();
      const began = performance.now();
      await Promise.all(parts.map((part) => part.draw(model)));
      await new Promise(requestAnimationFrame);
      times.push(performance.now() - began);
    }
    const words = places[3].textContent;
    const spoke = places[0].querySelectorAll("svg line[stroke='#6d28a8'], svg circle[fill='#6d28a8']").length;
    places.forEach((place) => place.remove());
    return { words, spoke, times: times.sort((a, b) => a - b) };
  });
  assert.match(load.words, /^100000 of 100080 lit directions done/);
  assert.ok(load.spoke >= 2, "the current ray and its reading");
  console.log(`  100,000 points: an update of 20 readings is drawn in ${load.times[25].toFixed(0)} ms (median), ${load.times[49].toFixed(0)} ms at most`);

  const bytes = await page.evaluate(() => performance.getEntriesByType("resource").reduce((sum, one) => sum + (one.name.includes("/api/") ? 0 : one.decodedBodySize), 0));
  console.log(`  ${bytes} bytes of files with every view open`);
  assert.ok(bytes < 2_000_000, `${bytes} bytes`);
  assert.ok(port > 0);
  child.kill("SIGTERM");
  await ended(child);
});
