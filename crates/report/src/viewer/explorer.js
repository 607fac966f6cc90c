// A sensor's map to look into: value and place under the pointer, sections through it, linear or logarithmic colour, contours.
((map, element) => {
  "use strict";
  const bytes = Uint8Array.from(atob(map.values), (letter) => letter.charCodeAt(0));
  const values = new Float32Array(bytes.buffer);
  const { nx, ny } = map;
  const finite = values.filter(Number.isFinite);
  const low = finite.reduce((a, b) => Math.min(a, b), Infinity);
  const high = finite.reduce((a, b) => Math.max(a, b), -Infinity);
  const [picture, sections] = element.querySelectorAll("canvas");
  const said = element.querySelector(".said");
  const log = element.querySelector("[name=log]");
  const contour = element.querySelector("[name=contour]");
  let at = [Math.floor(nx / 2), Math.floor(ny / 2)];
  let held = false;

  // A logarithm needs a positive end; a map that touches zero is cut at a ten-thousandth of its largest value.
  const least = low > 0 ? low : 1e-4 * high;
  const share = (value) => {
    if (high <= low) return 0.5;
    if (log.checked) return Math.log(Math.max(value, least) / least) / Math.log(high / least);
    return (value - low) / (high - low);
  };
  const value = (x, y) => values[y * nx + x];
  const words = (number) => number.toPrecision(map.digits);
  const millimetres = (k, n, size) => (((k + 0.5) / n - 0.5) * size).toFixed(2);

  function paint() {
    const context = picture.getContext("2d");
    const image = context.createImageData(nx, ny);
    const levels = 10;
    const band = (x, y) => Math.floor(share(value(x, y)) * levels);
    for (let y = 0; y < ny; y++) {
      for (let x = 0; x < nx; x++) {
        // Row 0 of the map is the lowest.
        const place = 4 * ((ny - 1 - y) * nx + x);
        const tone = map.colours[Math.max(0, Math.min(255, Math.round(255 * share(value(x, y)))))];
        const edge = contour.checked && ((x + 1 < nx && band(x, y) !== band(x + 1, y)) || (y + 1 < ny && band(x, y) !== band(x, y + 1)));
        for (let k = 0; k < 3; k++) image.data[place + k] = edge ? 255 : tone[k];
        image.data[place + 3] = 255;
      }
    }
    const small = document.createElement("canvas");
    small.width = nx;
    small.height = ny;
    small.getContext("2d").putImageData(image, 0, 0);
    context.imageSmoothingEnabled = false;
    context.drawImage(small, 0, 0, picture.width, picture.height);
    const [x, y] = [((at[0] + 0.5) / nx) * picture.width, (1 - (at[1] + 0.5) / ny) * picture.height];
    context.lineWidth = 1;
    for (const [colour, from, to] of [["#ff5a4d", [0, y], [picture.width, y]], ["#7fb0ff", [x, 0], [x, picture.height]]]) {
      context.strokeStyle = colour;
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    }
    draw();
    const number = value(...at);
    said.textContent =
      `${words(number)} ${map.unit} at x ${millimetres(at[0], nx, map.size[0])} mm, y ${millimetres(at[1], ny, map.size[1])} mm; ` +
      `${(100 * (number / map.mean - 1)).toFixed(2)} % from the mean`;
  }

  function draw() {
    const context = sections.getContext("2d");
    const { width, height } = sections;
    const [left, top, right, bottom] = [62, 14, width - 18, height - 26];
    context.clearRect(0, 0, width, height);
    context.fillStyle = context.strokeStyle = getComputedStyle(element).color;
    context.font = "11px sans-serif";
    context.strokeRect(left, top, right - left, bottom - top);
    for (let k = 0; k <= 4; k++) {
      const t = k / 4;
      const number = log.checked ? least * (high / least) ** t : low + t * (high - low);
      context.textAlign = "right";
      context.fillText(words(number), left - 5, bottom - t * (bottom - top) + 4);
    }
    context.textAlign = "center";
    const half = 0.5 * Math.max(...map.size);
    for (const x of [-half, 0, half]) context.fillText(x.toFixed(1), left + (x / half + 1) * 0.5 * (right - left), bottom + 14);
    context.fillText("mm", right - 30, bottom + 24);
    const line = (colour, count, size, of) => {
      context.strokeStyle = colour;
      context.beginPath();
      for (let k = 0; k < count; k++) {
        const mm = ((k + 0.5) / count - 0.5) * size;
        const x = left + (mm / half + 1) * 0.5 * (right - left);
        context.lineTo(x, bottom - share(of(k)) * (bottom - top));
      }
      context.stroke();
    };
    line("#ff5a4d", nx, map.size[0], (k) => value(k, at[1]));
    line("#5b93ff", ny, map.size[1], (k) => value(at[0], k));
  }

  function follow(event) {
    const box = picture.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * nx);
    const y = ny - 1 - Math.floor(((event.clientY - box.top) / box.height) * ny);
    at = [Math.max(0, Math.min(nx - 1, x)), Math.max(0, Math.min(ny - 1, y))];
    paint();
  }
  picture.addEventListener("pointermove", (event) => held || follow(event));
  picture.addEventListener("click", (event) => {
    held = !held;
    follow(event);
  });
  picture.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    at = [Math.max(0, Math.min(nx - 1, at[0] + step[0])), Math.max(0, Math.min(ny - 1, at[1] + step[1]))];
    paint();
  });
  for (const box of [log, contour]) box.addEventListener("change", paint);
  paint();
})
