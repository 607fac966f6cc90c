// Files that are dropped on the page: the program inspects and draws them, nothing is kept.

import { inspect } from "./commands.js";
import { facts, make, picture } from "./dom.js";

function base64(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
}

/** A row without a name goes on with the one above. */
function joined(rows) {
  return rows.reduce((all, [name, value]) => {
    if (name || all.length === 0) return [...all, [name, value]];
    const [before, first] = all.at(-1);
    return [...all.slice(0, -1), [before, `${first}; ${value}`]];
  }, []);
}

function show(told, target) {
  target.replaceChildren(...told.contents.flatMap((one) => {
    const findings = one.findings.map((found) => {
      const { line } = found;
      return `${found.severity} ${found.code}${line ? `, line ${line}` : ""}: ${found.message}${found.fix ? `. ${found.fix}` : ""}`;
    });
    const lines = findings.length ? findings : ["no findings"];
    return [
      make("h3", { textContent: `${one.file}: ${one.what}` }),
      make("ul", {}, ...lines.map((textContent) => make("li", { textContent }))),
      facts(joined(one.quantities)), make("div", { className: "drawn" }, ...one.figures.map(picture)),
    ];
  }));
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
