// A sensor's map to look into, for the report and for the page: value and place under the pointer, sections through it, linear or
// logarithmic colour, contours, a scale bar.

/** Colours between these, 256 of them. */
export function ramp(...stops) {
  return Array.from({ length: 256 }, (_, at) => {
    const place = (at / 255) * (stops.length - 1);
    const first = Math.min(Math.floor(place), stops.length - 2);
    return stops[first].map((part, k) => Math.round(part + (place - first) * (stops[first + 1][k] - part)));
  });
}

/** Numbers of a map that came as base64 of 32-bit floats, row 0 the smallest y. */
export function numbers({ values }) {
  if (values instanceof Float32Array) return values;
  return new Float32Array(Uint8Array.from(atob(values), (letter) => letter.charCodeAt(0)).buffer);
}

function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

/** Along x solid, along y dashed: told apart without their colours too. */
const SECTIONS = [["--section-x", []], ["--section-y", [5, 3]]];

export class SensorMap {
  /** `plain`: the picture alone, without switches and sections. `signed`: a scale as far below zero as
   *  above where both are there. */
  constructor(element, { title = null, plain = false, signed = false } = {}) {
    Object.assign(this, { title, signed, held: false, at: null });
    const box = (name, words) => {
      const input = make("input", { type: "checkbox", name });
      input.addEventListener("change", () => this.#paint());
      return [input, make("label", {}, input, ` ${words}`)];
    };
    const [log, logLabel] = box("log", "logarithmic");
    const [contour, contourLabel] = box("contour", "contours");
    Object.assign(this, { log, contour });
    this.picture = make("canvas", { tabIndex: 0 });
    this.picture.setAttribute("role", "img");
    this.bar = make("canvas", { width: 1, height: 256 });
    [this.high, this.low] = [make("span"), make("span")];
    this.said = make("p", { className: "said" });
    this.element = make("figure", { className: "map" });
    if (title) this.element.append(make("figcaption", { textContent: title }));
    const scale = make("div", { className: "scale" }, this.high, this.bar, this.low);
    scale.setAttribute("aria-hidden", "true");
    this.element.append(make("div", { className: "with-scale" }, this.picture, scale));
    if (!plain) this.element.append(make("p", { className: "switches" }, ...(signed ? [contourLabel] : [logLabel, " ", contourLabel])));
    this.element.append(this.said);
    if (!plain) {
      this.sections = make("canvas", { width: 420, height: 220, className: "sections" });
      this.sections.setAttribute("aria-hidden", "true");
      this.element.append(this.sections);
    }
    element.append(this.element);
    this.picture.addEventListener("pointermove", (event) => this.held || this.#follow(event));
    this.picture.addEventListener("click", (event) => {
      this.held = !this.held;
      this.#follow(event);
    });
    this.picture.addEventListener("keydown", (event) => this.#key(event));
  }

  /** `map`: nx, ny, size in mm, unit, digits, values, colours; nothing: hidden. `colours` may be others than its own. */
  show(map, colours = map?.colours) {
    this.element.hidden = !map;
    this.map = map;
    if (!map) return;
    this.values = numbers(map);
    this.colours = colours;
    const { nx, ny } = map;
    if (!this.at || this.at[0] >= nx || this.at[1] >= ny) this.at = [Math.floor(nx / 2), Math.floor(ny / 2)];
    let [low, high, sum] = [Infinity, -Infinity, 0];
    for (const value of this.values) [low, high, sum] = [Math.min(low, value), Math.max(high, value), sum + value];
    this.mean = sum / (nx * ny);
    [this.from, this.to] = [low, high];
    if (this.signed && low < 0 && high > 0) [low, high] = [-Math.max(-low, high), Math.max(-low, high)];
    // A logarithm needs a positive end; a map that touches zero is cut at a ten-thousandth of its largest value.
    Object.assign(this, { least: low, most: high, first: low > 0 ? low : 1e-4 * high });
    this.#paint();
  }

  #share(value) {
    if (this.most <= this.least) return 0.5;
    if (this.log.checked) return Math.log(Math.max(value, this.first) / this.first) / Math.log(this.most / this.first);
    return (value - this.least) / (this.most - this.least);
  }

  #words(number) {
    const { digits } = this.map;
    const magnitude = number === 0 ? 0 : Math.floor(Math.log10(Math.abs(number)));
    const plain = magnitude > -5 && magnitude < 7;
    const text = (plain ? number.toFixed(Math.max(0, digits - 1 - magnitude)) : number.toExponential(digits - 1)).replace("-", "−");
    return this.signed && number > 0 ? `+${text}` : text;
  }

  #paint() {
    if (!this.map) return;
    const { nx, ny, size, unit } = this.map;
    const scale = 420 / Math.max(...size);
    [this.picture.width, this.picture.height] = size.map((mm) => Math.max(16, Math.round(mm * scale)));
    const pen = this.picture.getContext("2d");
    const image = pen.createImageData(nx, ny);
    const shares = Float32Array.from(this.values, (value) => this.#share(value));
    const band = (x, y) => Math.floor(shares[y * nx + x] * 10);
    for (let y = 0; y < ny; y += 1) {
      for (let x = 0; x < nx; x += 1) {
        // Row 0 of the map is the lowest.
        const place = 4 * ((ny - 1 - y) * nx + x);
        const tone = this.colours[Math.max(0, Math.min(255, Math.round(255 * shares[y * nx + x])))];
        const edge = this.contour.checked && ((x + 1 < nx && band(x, y) !== band(x + 1, y)) || (y + 1 < ny && band(x, y) !== band(x, y + 1)));
        for (let k = 0; k < 3; k += 1) image.data[place + k] = edge ? (this.signed ? 0 : 255) : tone[k];
        image.data[place + 3] = 255;
      }
    }
    const small = make("canvas", { width: nx, height: ny });
    small.getContext("2d").putImageData(image, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(small, 0, 0, this.picture.width, this.picture.height);
    this.#bar();
    if (this.sections) {
      const [x, y] = [((this.at[0] + 0.5) / nx) * this.picture.width, (1 - (this.at[1] + 0.5) / ny) * this.picture.height];
      for (const [line, from, to] of [[SECTIONS[0], [0, y], [this.picture.width, y]], [SECTIONS[1], [x, 0], [x, this.picture.height]]]) {
        this.#pen(pen, line);
        pen.beginPath();
        pen.moveTo(...from);
        pen.lineTo(...to);
        pen.stroke();
      }
      this.#sections();
    }
    const value = this.values[this.at[1] * nx + this.at[0]];
    const place = (axis, count) => (((this.at[axis] + 0.5) / count - 0.5) * size[axis]).toFixed(2).replace("-", "−");
    const against = this.signed ? "" : `; ${(100 * (value / this.mean - 1)).toFixed(2).replace("-", "−")} % from the mean`;
    this.said.textContent = `${this.#words(value)} ${unit} at x ${place(0, nx)} mm, y ${place(1, ny)} mm${against}`;
    const range = `${this.title ?? "Map of the sensor"}: ${this.#words(this.from)} to ${this.#words(this.to)} ${unit}, mean ${this.#words(this.mean)} ${unit}`;
    this.picture.setAttribute("aria-label", `${range}. Arrow keys move the place that is read.`);
  }

  #pen(pen, [colour, dash]) {
    pen.strokeStyle = getComputedStyle(this.element).getPropertyValue(colour).trim();
    pen.setLineDash(dash);
  }

  #bar() {
    const pen = this.bar.getContext("2d");
    this.colours.forEach(([r, g, b], at) => {
      pen.fillStyle = `rgb(${r},${g},${b})`;
      pen.fillRect(0, 255 - at, 1, 1);
    });
    this.high.textContent = `${this.#words(this.most)} ${this.map.unit}`;
    this.low.textContent = `${this.#words(this.log.checked ? this.first : this.least)} ${this.map.unit}`;
  }

  #sections() {
    const pen = this.sections.getContext("2d");
    const { width, height } = this.sections;
    const { nx, ny, size } = this.map;
    const [left, top, right, bottom] = [66, 10, width - 14, height - 24];
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = pen.strokeStyle = getComputedStyle(this.element).color;
    pen.font = "11px sans-serif";
    pen.setLineDash([]);
    pen.strokeRect(left, top, right - left, bottom - top);
    pen.textAlign = "right";
    for (let k = 0; k <= 4; k += 1) {
      const t = k / 4;
      const number = this.log.checked ? this.first * (this.most / this.first) ** t : this.least + t * (this.most - this.least);
      pen.fillText(this.#words(number), left - 5, bottom - t * (bottom - top) + 4);
    }
    pen.textAlign = "center";
    const half = 0.5 * Math.max(...size);
    for (const x of [-half, 0, half]) pen.fillText(x.toFixed(1).replace("-", "−"), left + (x / half + 1) * 0.5 * (right - left), bottom + 14);
    pen.fillText("mm", left + 0.75 * (right - left), bottom + 14);
    const line = (section, count, mm, of) => {
      this.#pen(pen, section);
      pen.beginPath();
      for (let k = 0; k < count; k += 1) {
        const x = left + ((((k + 0.5) / count - 0.5) * mm) / half + 1) * 0.5 * (right - left);
        pen.lineTo(x, bottom - this.#share(of(k)) * (bottom - top));
      }
      pen.stroke();
    };
    line(SECTIONS[0], nx, size[0], (k) => this.values[this.at[1] * nx + k]);
    line(SECTIONS[1], ny, size[1], (k) => this.values[k * nx + this.at[0]]);
  }

  #move(x, y) {
    const { nx, ny } = this.map;
    this.at = [Math.max(0, Math.min(nx - 1, x)), Math.max(0, Math.min(ny - 1, y))];
    this.#paint();
  }

  #follow(event) {
    const box = this.picture.getBoundingClientRect();
    const { nx, ny } = this.map;
    this.#move(Math.floor(((event.clientX - box.left) / box.width) * nx), ny - 1 - Math.floor(((event.clientY - box.top) / box.height) * ny));
  }

  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    this.#move(this.at[0] + step[0], this.at[1] + step[1]);
  }
}
