// The local page in a real browser: `node page.mjs ISOLUX FOLDER PICTURES`, run by crates/cli/tests/browser.rs.
// Asserts text and state, not pixels; the pictures are for people.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { PATIENCE, accessible, atLeast, begin, ended, folder, headings, inBrowser, looks, next, pictures, points, raw, serve, state, step, themes, watch } from "./helpers.mjs";

async function refusals(port, url) {
  const own = `localhost:${port}`;
  const json = { "Content-Type": "application/json" };
  const stop = JSON.stringify({ command: "stop" });
  for (const [what, options, status] of [
    ["a name that an attacker chose", { headers: { Host: `evil.example:${port}` } }, 403],
    ["a name that begins like ours", { headers: { Host: `localhost.evil.example:${port}` } }, 403],
    ["another port", { headers: { Host: "localhost:1" } }, 403],
    ["a command of another site", { method: "POST", path: "/api/command", body: stop, headers: { Host: own, Origin: "http://evil.example", ...json } }, 403],
    ["a command without Origin", { method: "POST", path: "/api/command", body: stop, headers: { Host: own, ...json } }, 403],
    ["a cross-site command", { method: "POST", path: "/api/command", body: stop, headers: { Host: own, Origin: `http://${own}`, "Sec-Fetch-Site": "cross-site", ...json } }, 403],
    ["a form", { method: "POST", path: "/api/command", body: stop, headers: { Host: own, Origin: `http://${own}`, "Content-Type": "text/plain" } }, 415],
    ["a command without the cookie", { method: "POST", path: "/api/command", body: stop, headers: { Host: own, Origin: `http://${own}`, ...json } }, 401],
    ["events without the cookie", { path: "/api/events", headers: { Host: own } }, 401],
    ["the stream without the cookie", { path: "/api/stream", headers: { Host: own } }, 401],
    ["results without the cookie", { path: "/results/report.html", headers: { Host: own } }, 401],
    ["the report without the cookie", { path: "/report", headers: { Host: own } }, 401],
    ["a command by GET", { path: "/api/command?command=stop", headers: { Host: own } }, 401],
    ["the page without the code", { path: "/", headers: { Host: own } }, 401],
    ["a wrong code", { path: `/?code=${"0".repeat(48)}`, headers: { Host: own } }, 403],
  ]) {
    const answer = await raw(port, options);
    assert.equal(answer.status, status, what);
    assert.equal(answer.headers["access-control-allow-origin"], undefined, what);
    assert.match(answer.headers["content-security-policy"], /^default-src 'none'; script-src 'self'/, what);
    assert.equal(answer.headers["x-content-type-options"], "nosniff");
    assert.equal(answer.headers["referrer-policy"], "no-referrer");
    assert.equal(answer.headers["cross-origin-opener-policy"], "same-origin");
    assert.equal(answer.headers["cross-origin-resource-policy"], "same-origin");
    assert.equal(answer.headers["cache-control"], "no-store");
  }
  const path = new URL(url).pathname + new URL(url).search;
  const first = await raw(port, { path });
  assert.equal(first.status, 303);
  assert.match(first.headers["set-cookie"][0], new RegExp(`^isolux-${port}=[0-9a-f]{48}; HttpOnly; SameSite=Strict; Path=/$`));
  assert.equal((await raw(port, { path })).status, 403, "a code works once");
  const cookie = first.headers["set-cookie"][0].split(";")[0];
  const inside = { Host: own, Cookie: cookie };
  assert.equal((await raw(port, { path: "/api/events", headers: inside })).status, 200);
  const evil = await raw(port, { method: "POST", path: "/api/command", body: stop, headers: { ...inside, Origin: "http://evil.example", ...json } });
  assert.equal(evil.status, 403, "the cookie does not help another site");
  for (const path of ["/results/..%2Frun.toml", "/results/%2Fetc%2Fpasswd", "/../run.toml"]) {
    assert.equal((await raw(port, { path, headers: inside })).status, 404, path);
  }
  const nonsense = await raw(port, { method: "POST", path: "/api/command", body: "{\"command\":\"dance\"}", headers: { ...inside, Origin: `http://${own}`, ...json } });
  assert.equal(nonsense.status, 400);
}

/** A folder without anything: a day on the virtual bench by one click, and its warm-up while it goes on. */
async function warmsUp(browser) {
  const { child, url } = await serve(["serve", "fresh", "--no-browser", "--speed", "30"]);
  child.removeAllListeners("exit");
  const page = await browser.newPage({ viewport: { width: 1440, height: 1000 } });
  const complaints = [];
  watch(page, complaints);
  await page.goto(url);
  await page.click("#start-virtual");
  await state(page, "Warming up");
  await page.waitForFunction(() => /left$/.test(document.getElementById("warm-left").textContent), null, { timeout: PATIENCE });
  assert.deepEqual(await headings(page), ["The lamp warms up", "Checks and readings", "Directions (C, γ)", "Journal"]);
  assert.match(await page.locator("#warm-on-text").textContent(), /of at least 30 min 00 s/);
  assert.match(await page.locator("#warm-steady-text").textContent(), /0\.50 % of change in 15 min 00 s/);
  await page.waitForSelector("#warming canvas");
  const left = () => page.locator("#warm-left").textContent().then((text) => 60 * Number(/(\d+) min/.exec(text)?.[1] ?? 0) + Number(/(\d+) s left/.exec(text)?.[1] ?? 0));
  const before = await left();
  assert.ok(before > 0 && before <= 1800, `${before} s`);
  await looks(page, "warming-up");
  assert.ok((await left()) < before, "the time left falls");
  await page.click("#stop");
  await state(page, "Interrupted");
  assert.deepEqual(complaints, [], "the console");
  await page.close();
  child.kill("SIGTERM");
  await ended(child);
}

/** The time left of a warm-up by its looks, against the exponential that made them (its mean is 1). */
async function estimates(page) {
  const [early, late, rising] = await page.evaluate(async () => {
    const { warmUpLeft } = await import("/warmup.js");
    const outline = { least_s: 1800, window_s: 900, spread_rel: 0.005 };
    const light = (t, tau) => 1 + 0.3 * Math.exp(-t / tau);
    const left = (until, of) => {
      const warmUps = [];
      for (let at = 0; at <= until; at += 60) warmUps.push({ lamp_s: at, illuminance_lx: of(at), spread_rel: at < 900 ? null : Math.abs(of(at - 900) - of(at)) });
      return warmUpLeft({ warmUps, outline }).left_s;
    };
    return [left(600, (t) => light(t, 300)), left(2400, (t) => light(t, 1200)), left(2400, (t) => 1 + Math.exp((t - 4000) / 900))];
  });
  assert.equal(early, 1200, "before the window is full: the least time on");
  // 0.3·e^(−t/1200)·(e^(900/1200) − 1) = 0.005 at t = 1200·ln(0.3·1.117/0.005) s.
  const crossing = 1200 * Math.log((0.3 * (Math.exp(900 / 1200) - 1)) / 0.005);
  assert.ok(Math.abs(late - (crossing - 2400)) < 1, `${late} s`);
  assert.equal(rising, null, "light that does not become steadier");
}

function events(run) {
  return readFileSync(join(folder, run, "events.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
}

await inBrowser(async (browser) => {
  const first = await serve(["serve", ".", "--no-browser", "--speed", "300"]);
  first.child.removeAllListeners("exit");
  step("the wrong Host, Origin, cookie and code are refused");
  await refusals(first.port, first.url);

  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 } });
  const complaints = [];
  const page = await context.newPage();
  watch(page, complaints);
  await page.goto(await next(first.child, 0));
  assert.equal(new URL(page.url()).search, "", "the code is not in the address any more");
  await page.waitForSelector("#start:visible");
  const paint = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime);
  const bytes = await page.evaluate(() => performance.getEntriesByType("resource").reduce((sum, one) => sum + one.decodedBodySize, 0));
  console.log(`  first paint after ${Math.round(paint)} ms, ${bytes} bytes`);
  assert.ok(bytes < 2_000_000, `${bytes} bytes`);
  step("nothing yet: what a day is, one large button, the jobs");
  assert.deepEqual(await headings(page), ["Measure a luminaire", "Runs of this folder"]);
  assert.match(await page.locator("#steps").textContent(), /Warm up.*Scan.*Evaluate.*Report/s);
  assert.ok(await page.isEnabled("#start-virtual"));
  const large = await page.locator("#start-virtual").boundingBox();
  const small = await page.locator("#start").boundingBox();
  assert.ok(large.width * large.height > 3 * small.width * small.height, "the first button is the large one");
  assert.ok(await page.isHidden("#runs li") && await page.isVisible("#no-runs") && await page.isHidden("#commands"));
  await themes(page, "nothing");
  await looks(page, "nothing");
  await estimates(page);

  step("one click starts a day on the virtual bench, and its warm-up is shown with the time left");
  await warmsUp(browser);

  step("a spectrum is inspected and drawn, and nonsense is told");
  const table = ["wavelength_nm,value", ...Array.from({ length: 81 }, (_, at) => `${380 + 5 * at},${1 + at % 7}`)].join("\n");
  await page.setInputFiles("#file", { name: "lamp.csv", mimeType: "text/csv", buffer: Buffer.from(table) });
  await page.waitForSelector(".drawn svg");
  assert.ok(await page.evaluate(() => [...document.querySelectorAll(".drawn svg")].every((figure) => figure.querySelectorAll("path, rect").length > 3 && figure.getBoundingClientRect().width > 200)), "the pictures are drawn");
  assert.match(await page.locator("#inspected").textContent(), /lamp\.csv: spectrum/);
  await themes(page, "inspected");
  await page.setInputFiles("#file", { name: "lamp.ldt", mimeType: "", buffer: Buffer.from([0, 1, 2]) });
  await page.waitForFunction(() => /lamp\.ldt.*error/.test(document.getElementById("inspected").textContent), null, { timeout: PATIENCE });

  step("a scan is started by a click");
  await begin(page, "job.toml");
  await state(page, "Warming up");
  await state(page, "Scanning");
  assert.ok(await page.isHidden("#warm-panel") && await page.isVisible("#lamp-panel"), "the warm-up is over");
  assert.ok(!(await headings(page)).includes("Last spectrum"), "a card without content is not shown");
  await atLeast(page, 40);
  await page.waitForFunction(() => document.querySelector("#checks [data-check=open]") !== null);
  assert.match(await page.locator("#lux").textContent(), /lx/);
  assert.match(await page.locator("#time-left").textContent(), /min|s|h/);
  step("it is paused: axes at rest, lamp on, no point more");
  await page.click("#pause");
  await state(page, "Paused");
  const paused = await points(page);
  assert.match(await page.locator("#state-sentence").textContent(), /axes at rest .* lamp on/);
  await themes(page, "paused");
  assert.equal(await points(page), paused);

  step("seven tabs see the same");
  const tabs = [page];
  for (let tab = 1; tab < 7; tab += 1) {
    const another = await context.newPage();
    watch(another, complaints);
    await another.goto(`http://127.0.0.1:${first.port}/`);
    tabs.push(another);
  }
  for (const tab of tabs) {
    await state(tab, "Paused");
    assert.equal(await points(tab), paused);
  }
  step("resumed by a key in the seventh tab");
  await tabs[6].keyboard.press("p");
  for (const tab of tabs) {
    await state(tab, "Scanning");
    await atLeast(tab, paused + 5);
  }
  for (const tab of tabs.slice(1)) await tab.close();
  step("closed tabs harm nothing");
  await page.bringToFront();
  await atLeast(page, (await points(page)) + 40);
  await themes(page, "scanning");
  await page.setViewportSize({ width: 390, height: 844 });
  await accessible(page, "narrow");
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "no scrolling sideways");
  await page.screenshot({ path: join(pictures, "scanning-narrow.png"), fullPage: true });
  await page.setViewportSize({ width: 1440, height: 1000 });
  step("aborted by clicks");
  await page.click("#abort");
  await page.waitForSelector("#sure[open]");
  await page.click("#sure-no");
  assert.equal(await page.locator("#state-word").textContent(), "Scanning");
  await page.click("#abort");
  await page.click("#sure-yes");
  await state(page, "Interrupted");
  const header = readFileSync(join(folder, "day/run.toml"), "utf8");
  assert.match(header, /how = "interrupted"/);
  assert.match(header, /axes_at_rest = true/);
  const recorded = events("day").map((event) => event.event);
  assert.ok(recorded.includes("paused") && recorded.includes("resumed"));

  await page.waitForFunction(() => /axes at rest.*lamp on.*isolux switch STATION\.toml --lamp off/.test(document.getElementById("left-behind").textContent), null, { timeout: PATIENCE });

  step("a question to a person is answered by a button, and dark readings are shown");
  await begin(page, "asked.toml");
  await page.waitForSelector("#question:visible", { timeout: PATIENCE });
  assert.match(await page.locator("#question-words").textContent(), /take the cap off the lamp/);
  await page.waitForFunction(() => /capped.*1 of 1 points.* ± .* lx/.test(document.getElementById("dark").textContent), null, { timeout: PATIENCE });
  await accessible(page, "a question");
  await page.screenshot({ path: join(pictures, "question-light.png"), fullPage: true });
  await page.fill("#who", "Ada");
  await page.click("#done");
  await page.waitForSelector("#question", { state: "hidden", timeout: PATIENCE });
  // The lamp takes half an hour of virtual time to warm up: time for a click.
  await state(page, "Warming up");
  await page.click("#stop");
  await state(page, "Interrupted");
  assert.ok(events("day-2").some((event) => event.event === "asked" && /Ada/.test(JSON.stringify(event))));

  step("the runs of the folder are on cards with their light");
  await page.click("#views a[href='#/start']");
  // The list may be drawn anew at any moment; aborted early there may be one half-plane alone.
  await page.waitForFunction(() => {
    const svg = document.querySelector("#runs li[data-run=day] .light svg");
    return svg !== null && svg.querySelectorAll("path").length >= 1 && svg.getBoundingClientRect().width > 80;
  }, null, { timeout: PATIENCE });
  assert.match(await page.locator("#runs li[data-run=day]").textContent(), /interrupted/);
  assert.ok(await page.isHidden("#steps"));
  await page.click("#runs li[data-run=day] button");
  await page.waitForFunction(() => /day$/.test(document.getElementById("run").textContent), null, { timeout: PATIENCE });
  assert.equal(new URL(page.url()).hash, "#/live", "a run without results is shown as it was recorded");
  await page.click("#views a[href='#/start']");
  await page.waitForSelector("#runs li[data-run=day] [aria-current]");
  await looks(page, "runs");

  step("a fault is shown");
  await begin(page, "broken.toml");
  await page.waitForFunction(() => /127\.0\.0\.1:9/.test(document.getElementById("notice").textContent), null, { timeout: PATIENCE });
  await page.screenshot({ path: join(pictures, "fault-light.png"), fullPage: true });

  step("a scan that another process makes is shown, and can only be stopped");
  await page.click("#views a[href='#/start']");
  const other = await serve(["scan", "station.toml", "plan.toml", "--out", "other", "--open", "--speed", "600"]);
  other.child.removeAllListeners("exit");
  await page.waitForFunction(() => /made by .*only be stopped/.test(document.getElementById("notice").textContent), null, { timeout: PATIENCE });
  await page.waitForFunction(() => location.hash === "#/live", null, { timeout: PATIENCE });
  assert.ok(await page.isDisabled("#pause") && await page.isDisabled("#abort"));
  await page.click("#stop");
  await state(page, "Interrupted");
  await ended(other.child);
  assert.match(readFileSync(join(folder, "other/run.toml"), "utf8"), /how = "interrupted"/);
  assert.deepEqual(complaints, [], "the console");

  step("a lost connection is said, and comes back");
  const second = await context.newPage();
  await second.goto(`http://127.0.0.1:${first.port}/`);
  first.child.kill("SIGTERM");
  await ended(first.child);
  await page.waitForSelector("#lost:visible", { timeout: PATIENCE });
  const again = await serve(["serve", ".", "--no-browser", "--port", String(first.port)]);
  again.child.removeAllListeners("exit");
  await second.goto(again.url);
  await second.waitForSelector("#lost", { state: "hidden", timeout: PATIENCE });
  await page.waitForSelector("#lost", { state: "hidden", timeout: PATIENCE });
  again.child.kill("SIGTERM");
  await ended(again.child);
});
