// What the tests in a real browser share: the program, requests that no browser would send, themes, accessibility.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { request } from "node:http";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

export const [isolux, folder, pictures] = process.argv.slice(2);
const modules = createRequire(pathToFileURL(join(process.env.ISOLUX_NODE_MODULES, "x.js")));
const { chromium } = modules("playwright-core");
const axe = readFileSync(modules.resolve("axe-core/axe.min.js"), "utf8");
export const PATIENCE = 90_000;
const running = [];
mkdirSync(pictures, { recursive: true });

export function step(words) {
  console.log(`  ${words}`);
}

/** Starts the program; resolves with the launch address of its page. */
export function serve(args) {
  const child = spawn(isolux, args, { cwd: folder, env: { ...process.env, BROWSER: "true" }, stdio: ["ignore", "pipe", "pipe"] });
  running.push(child);
  let out = "";
  child.errors = "";
  return new Promise((resolve, reject) => {
    child.stdout.on("data", (chunk) => {
      out += chunk;
      const url = /http:\/\/\S+/.exec(out)?.[0];
      if (url) resolve({ child, url, port: Number(new URL(url).port) });
    });
    child.stderr.on("data", (chunk) => { child.errors += chunk; });
    child.on("exit", (code) => reject(new Error(`ended with ${code}: ${child.errors}`)));
  });
}

export function ended(child) {
  if (child.exitCode !== null || child.signalCode !== null) return Promise.resolve();
  return new Promise((resolve) => child.once("exit", resolve));
}

/** A request as no browser would send it. */
export function raw(port, { method = "GET", path = "/", headers = {}, body } = {}) {
  return new Promise((resolve, reject) => {
    const asked = request({ host: "127.0.0.1", port, method, path, headers, setHost: !("Host" in headers) }, (answer) => {
      let text = "";
      answer.on("data", (chunk) => { text += chunk; });
      answer.on("end", () => resolve({ status: answer.statusCode, headers: answer.headers, text }));
    });
    asked.on("error", reject);
    if (body) asked.write(body);
    asked.end();
  });
}

/** The next launch address, which the terminal shows after one was used. */
export async function next(child, seen) {
  for (;;) {
    const urls = [...child.errors.matchAll(/another browser: (\S+)/g)].map((found) => found[1]);
    if (urls.length > seen) return urls.at(-1);
    await new Promise((resolve) => child.stderr.once("data", resolve));
  }
}

/** Without serious faults by the rules of axe, or by those of these names. */
export async function accessible(page, where, rules) {
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(axe);
  const result = await page.evaluate((runOnly) => axe.run(document, { resultTypes: ["violations", "incomplete"], ...(runOnly && { runOnly }) }), rules);
  const serious = (list) => list.filter((one) => ["serious", "critical"].includes(one.impact));
  const told = [...serious(result.violations), ...serious(result.incomplete).filter((one) => one.id === "color-contrast" && one.nodes.some((node) => node.any.some((check) => check.data?.messageKey === null && check.data?.contrastRatio < 4.5)))];
  assert.deepEqual(told.map((one) => `${one.id}: ${one.nodes.map((node) => node.html.slice(0, 120)).join(" | ")}`), [], where);
}

export async function themes(page, name) {
  for (const theme of ["light", "dark", "red"]) {
    await page.selectOption("#theme", theme);
    await page.waitForFunction((wanted) => document.documentElement.dataset.theme === wanted, theme);
    // Another theme has other colours and nothing else.
    await accessible(page, `${name}, ${theme}`, theme === "light" ? undefined : ["color-contrast"]);
    await page.evaluate(() => new Promise((done) => { scrollTo(0, 0); setTimeout(() => requestAnimationFrame(done), 250); }));
    await page.screenshot({ path: join(pictures, `${name}-${theme}.png`), fullPage: true });
  }
  await page.selectOption("#theme", "light");
}

/** Screenshots as an operator's and a small screen show it, light and dark, with nothing to scroll sideways. */
export async function looks(page, name) {
  for (const width of [1280, 800]) {
    await page.setViewportSize({ width, height: 900 });
    for (const theme of ["light", "dark"]) {
      await page.selectOption("#theme", theme);
      await page.evaluate(() => new Promise((done) => { scrollTo(0, 0); setTimeout(() => requestAnimationFrame(done), 250); }));
      await page.screenshot({ path: join(pictures, `${name}-${width}-${theme}.png`), fullPage: true });
    }
    await accessible(page, `${name}, ${width} px`);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${name}, ${width} px: no scrolling sideways`);
  }
  await page.setViewportSize({ width: 1440, height: 1000 });
  await page.selectOption("#theme", "light");
}

/** The headings of the cards that are shown. */
export const headings = (page) => page.evaluate(() => [...document.querySelectorAll("main:not([hidden]) h2")].filter((one) => one.checkVisibility()).map((one) => one.textContent));

/** Starts a job of the folder. */
export async function begin(page, job) {
  await page.click("#views a[href='#/start']");
  await page.selectOption("#job", job);
  await page.click("#start");
}

export const state = (page, word) => page.waitForFunction((wanted) => document.getElementById("state-word").textContent === wanted, word, { timeout: PATIENCE });
export const points = (page) => page.locator("#points").textContent().then((text) => Number.parseInt(text, 10) || 0);
export const atLeast = (page, count) => page.waitForFunction((wanted) => Number.parseInt(document.getElementById("points").textContent, 10) >= wanted, count, { timeout: PATIENCE });

export function watch(page, complaints) {
  page.on("pageerror", (error) => complaints.push(`page: ${error.message}`));
  page.on("console", (message) => {
    // A screenshot reads the pixels of a canvas back, which the software renderer remarks on.
    const ofScreenshot = /GL Driver Message.*ReadPixels/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !ofScreenshot) complaints.push(`console: ${message.text()}`);
  });
}

/** Runs the steps of a test in Debian's chromium; nothing that was started outlives it. */
export async function inBrowser(steps) {
  const browser = await chromium.launch({
    executablePath: process.env.ISOLUX_CHROMIUM,
    args: process.getuid?.() === 0 ? ["--no-sandbox"] : [],
  });
  try {
    await steps(browser);
    console.log("every step was as expected");
  } finally {
    await browser.close();
    for (const child of running) if (child.exitCode === null) child.kill("SIGKILL");
  }
}
