// Elements, without HTML from text.

export const $ = (id) => document.getElementById(id);

/** An element with properties and children. */
export function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

/** A picture of the report as a part of the page, whose colours follow the theme (viewer.css). */
export function inline(svg) {
  const picture = document.importNode(new DOMParser().parseFromString(svg, "image/svg+xml").documentElement, true);
  picture.classList.add("drawing");
  return picture;
}

/** A picture of the report with its title. */
export function picture({ title, svg }) {
  const drawing = inline(svg);
  drawing.setAttribute("aria-label", title);
  const { width, height } = drawing.viewBox.baseVal;
  return make("figure", { className: width > 3.5 * height ? "wide" : "" }, make("div", { className: "card" }, drawing), make("figcaption", { textContent: title }));
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
