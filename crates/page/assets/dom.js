// Elements, without HTML from text.

export const $ = (id) => document.getElementById(id);

/** An element with properties and children. */
export function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

/** A picture of the report, shown as an image: its text is read by its name. */
export function picture({ title, svg }) {
  const image = make("img", { alt: title, src: `data:image/svg+xml,${encodeURIComponent(svg)}` });
  return make("figure", {}, make("div", { className: "card" }, image), make("figcaption", { textContent: title }));
}

/** Rows of names and numbers as a list. */
export function facts(rows) {
  return make("dl", { className: "facts" }, ...rows.map(([name, value]) => make("div", {}, make("dt", { textContent: name }), make("dd", {}, value))));
}

/** A number as the report states it; what is missing in its uncertainty is set small. */
export function stated(text, beside) {
  const [value, ...missing] = text.split(", no uncertainty");
  const parts = missing.length ? [make("small", { textContent: `no uncertainty${missing.join(", no uncertainty")}` })] : [];
  if (beside) parts.push(make("small", { textContent: beside }));
  return make("span", {}, value, ...parts);
}
