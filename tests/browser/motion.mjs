// A day in motion on the local page in a real browser: `node motion.mjs ISOLUX FOLDER PICTURES`, run by crates/cli/tests/browser.rs.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { PATIENCE, accessible, begin, ended, folder, headings, inBrowser, looks, pictures, serve, state, step, themes, watch } from "./helpers.mjs";

const events = (run) => readFileSync(join(folder, run, "events.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
const words = (page, id) => page.locator(`#${id}`).textContent();
const known = (page) => page.evaluate(() => fetch("/api/in-motion").then((answer) => answer.json()));
const share = (text) => Number(/(\d+) % of the directions known/.exec(text)?.[1]);

/** What is drawn in the middle of a cell of the map, as text. */
const drawn = (page, c, gamma) => page.evaluate(([wantedC, wantedGamma]) => {
  const canvas = document.querySelector("#u-map canvas");
  const ratio = canvas.width / canvas.clientWidth;
  const [left, right, top, bottom] = [44, 8, 16, 24];
  const x = left + ((wantedC + 2.5) / 360) * (canvas.clientWidth - left - right);
  const y = top + (wantedGamma / 180) * (canvas.clientHeight - top - bottom);
  return [...canvas.getContext("2d").getImageData(x * ratio, y * ratio, 1, 1).data].join();
}, [c, gamma]);

async function narrow(page, name) {
  await page.setViewportSize({ width: 390, height: 844 });
  await accessible(page, `${name}, narrow`);
  for (const theme of ["light", "dark"]) {
    await page.selectOption("#theme", theme);
    await page.evaluate(() => new Promise((done) => { setTimeout(() => requestAnimationFrame(done), 250); }));
    await page.screenshot({ path: join(pictures, `${name}-narrow-${theme}.png`), fullPage: true });
  }
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${name}: no scrolling sideways`);
  await page.selectOption("#theme", "light");
  await page.setViewportSize({ width: 1440, height: 1000 });
}

await inBrowser(async (browser) => {
  const { child, url } = await serve(["serve", ".", "--no-browser", "--speed", "60"]);
  child.removeAllListeners("exit");
  const page = await browser.newPage({ viewport: { width: 1440, height: 1000 } });
  const complaints = [];
  watch(page, complaints);
  await page.goto(url);

  step("from its first sweep a scan in motion shows what is known; nothing is, yet");
  await begin(page, "job.toml");
  await page.waitForSelector("#in-motion-panel:visible", { timeout: PATIENCE });
  assert.match(await words(page, "in-motion-next"), /Next: .*Why: /);
  assert.match(await words(page, "u-target-text"), /^Target: .*1\.00\u00a0%\. Known from when the rings are swept/);

  step("paused among its half-planes it says what comes next, for the reason that events.jsonl has");
  await page.waitForFunction(() => /sweep 9 around a ring/.test(document.getElementById("journal").textContent), null, { timeout: PATIENCE });
  await page.click("#pause");
  await state(page, "Paused");
  // One look at the record may still be under way.
  const sweeps = events("day").filter((event) => event.event === "sweep").length;
  await page.waitForFunction((made) => fetch("/api/in-motion").then((answer) => answer.json()).then((now) => now.sweeps === made), sweeps, { timeout: PATIENCE });
  await page.waitForFunction((made) => document.getElementById("u-map-text").textContent.includes(`${made} sweeps`), sweeps, { timeout: PATIENCE });
  assert.ok(Number((await words(page, "points")).split(" of ")[0]) >= sweeps, "sweeps count as points");
  const middle = await known(page);
  assert.ok(middle.next && middle.target.after.length > 0, JSON.stringify(middle.next));
  const reasons = events("day").filter((event) => event.event === "half_planes");
  const next = await words(page, "in-motion-next");
  assert.ok(next.includes(middle.next.reason), next);
  assert.ok(!(await headings(page)).includes("Directions (C, γ)"), "directions that are swept have one map");
  const [swept] = middle.swept_c_deg;
  const ground = await page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue("--panel").trim());
  assert.notEqual(await drawn(page, swept, 60), ground);
  await themes(page, "motion-paused");
  await looks(page, "motion-paused");
  await narrow(page, "motion-paused");

  step("the map is that of the record: the same after the page is loaded again");
  const text = await words(page, "u-map-text");
  await page.reload();
  await page.waitForFunction((wanted) => document.getElementById("u-map-text").textContent === wanted, text, { timeout: PATIENCE });

  step("at the end the target is reached, and every direction is known");
  await page.click("#pause");
  await state(page, "Completed");
  await page.waitForFunction(() => /, reached\.$/.test(document.getElementById("u-target-text").textContent), null, { timeout: PATIENCE });
  const last = await known(page);
  assert.equal(last.next, null);
  assert.ok(last.target.after.length > middle.target.after.length);
  assert.deepEqual(last.target.after.slice(0, middle.target.after.length), middle.target.after);
  assert.ok(last.target.after.at(-1).u_rel <= last.target.wanted_rel);
  assert.ok(last.sensor.at(-1).u_rel < last.sensor[0].u_rel, "so does U of the sensor");
  assert.ok(middle.u_rel.includes(null) === false || share(text) < 100);
  assert.equal(share(await words(page, "u-map-text")), 100);
  assert.match(await words(page, "in-motion-next"), /^The scan is completed\. No further half-plane/);
  const said = events("day").filter((event) => event.event === "half_planes").map((event) => event.reason);
  assert.ok(said.includes(middle.next.reason), `${middle.next.reason}: ${said.join(" | ")}`);
  assert.ok(reasons.length <= said.length);
  await themes(page, "motion-done");
  await looks(page, "motion-done");
  await narrow(page, "motion-done");
  assert.deepEqual(complaints, [], "the console");
  child.kill("SIGTERM");
  await ended(child);
});
