// Files that are dropped on the page: the program inspects and draws them, nothing is kept.

import { significant } from "./words.js";

const make = (name, words, className) => Object.assign(document.createElement(name), { textContent: words ?? "", className: className ?? "" });

function base64(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
}

/** Numbers and texts of an object, at most two levels deep; lists are left to the command line. */
function facts(object, prefix = "") {
  return Object.entries(object).flatMap(([key, value]) => {
    const name = `${prefix}${key}`.replaceAll("_", " ");
    if (typeof value === "number") return [[name, significant(value, 6)]];
    if (typeof value === "string" || typeof value === "boolean") return [[name, String(value)]];
    if (value && typeof value === "object" && !Array.isArray(value) && !prefix) return facts(value, `${key} `);
    return [];
  });
}

function show(told, name, target) {
  const parts = [];
  for (const one of told.inspections) {
    const kind = one.kind ? `${one.kind}, ${one.format ?? "format not known"}` : "of no known format";
    parts.push(make("h3", `${one.file}: ${kind}${one.readable ? "" : ", not readable"}`));
    const list = make("ul");
    for (const found of one.findings) {
      const line = found.line;
      list.append(make("li", `${found.severity} ${found.code}${line ? `, line ${line}` : ""}: ${found.message}${found.fix ? `. ${found.fix}` : ""}`));
    }
    if (!one.findings.length) list.append(make("li", "no findings"));
    const numbers = make("dl", "", "facts");
    for (const [key, value] of facts(one.quantities ?? {})) {
      const row = make("div");
      row.append(make("dt", key), make("dd", value));
      numbers.append(row);
    }
    parts.push(list, numbers);
  }
  const drawn = make("div", "", "drawn");
  for (const [title, svg] of told.pictures) {
    const card = make("div");
    card.append(Object.assign(new Image(), { alt: title.replaceAll(".", " "), src: `data:image/svg+xml,${encodeURIComponent(svg)}` }));
    drawn.append(card);
  }
  target.replaceChildren(...parts, drawn);
}

export function acceptDrops(zone, input, target) {
  async function take(file) {
    target.replaceChildren(make("p", `${file.name} is being read`));
    try {
      const body = JSON.stringify({ name: file.name, base64: await base64(file) });
      const answer = await fetch("/api/inspect", { method: "POST", headers: { "Content-Type": "application/json" }, body });
      if (!answer.ok) throw new Error((await answer.text()).trim());
      show(await answer.json(), file.name, target);
    } catch (error) {
      target.replaceChildren(make("p", `${file.name}: ${error.message}`));
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
    if (file && !zone.hidden) take(file);
  });
}
