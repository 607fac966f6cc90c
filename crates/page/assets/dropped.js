// Files that are dropped on the page: the program inspects and draws them, nothing is kept.

import { inspect } from "./commands.js";
import { facts, make, picture } from "./dom.js";
import { significant } from "./words.js";

function base64(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
}

/** Numbers and texts of an object, at most two levels deep; lists are left to the command line. */
function quantities(object, prefix = "") {
  return Object.entries(object).flatMap(([key, value]) => {
    const name = `${prefix}${key}`.replaceAll("_", " ");
    if (typeof value === "number") return [[name, significant(value, 6)]];
    if (typeof value === "string" || typeof value === "boolean") return [[name, String(value)]];
    if (value && typeof value === "object" && !Array.isArray(value) && !prefix) return quantities(value, `${key} `);
    return [];
  });
}

function show(told, target) {
  const parts = [];
  for (const one of told.inspections) {
    const kind = one.kind ? `${one.kind}, ${one.format ?? "format not known"}` : "of no known format";
    parts.push(make("h3", { textContent: `${one.file}: ${kind}${one.readable ? "" : ", not readable"}` }));
    const findings = one.findings.map((found) => {
      const { line } = found;
      return `${found.severity} ${found.code}${line ? `, line ${line}` : ""}: ${found.message}${found.fix ? `. ${found.fix}` : ""}`;
    });
    const lines = findings.length ? findings : ["no findings"];
    parts.push(make("ul", {}, ...lines.map((textContent) => make("li", { textContent }))), facts(quantities(one.quantities ?? {})));
  }
  const drawn = told.pictures.map(([title, svg]) => picture({ title: title.replaceAll(".", " "), svg }));
  target.replaceChildren(...parts, make("div", { className: "drawn" }, ...drawn));
}

export function acceptDrops(zone, input, target) {
  async function take(file) {
    location.hash = "#/inspect";
    target.replaceChildren(make("p", { textContent: `${file.name} is being read` }));
    try {
      show(await inspect({ name: file.name, base64: await base64(file) }), target);
    } catch (error) {
      target.replaceChildren(make("p", { textContent: `${file.name}: ${error.message}` }));
    }
  }
  input.addEventListener("change", () => input.files[0] && take(input.files[0]));
  addEventListener("dragover", (event) => {
    event.preventDefault();
    zone.classList.add("over");
  });
  addEventListener("dragleave", () => zone.classList.remove("over"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    const file = event.dataTransfer?.files[0];
    if (file) take(file);
  });
}
