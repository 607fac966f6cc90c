// The light on a sensor in three dimensions: luminaire, photometric solid, sensor with its map, rays to be followed and filtered.
// It is shown as the lamp sees it: C 0° to the right, C 90° up, γ = 0° away from the viewer.

import { Stage, segments, solidParts, world } from "./stage.js";

/** The colour of a wavelength, r, g, b from 0 to 1. */
function rgb(nm) {
  if (nm === null) return [0.88, 0.66, 0];
  let [r, g, b] = [0, 0, 0];
  if (nm < 440) [r, b] = [Math.max(0, (440 - nm) / 60), 1];
  else if (nm < 490) [g, b] = [(nm - 440) / 50, 1];
  else if (nm < 510) [g, b] = [1, (510 - nm) / 20];
  else if (nm < 580) [r, g] = [(nm - 510) / 70, 1];
  else if (nm < 645) [r, g] = [1, (645 - nm) / 65];
  else r = 1;
  const far = nm < 420 ? (nm - 380) / 40 : nm > 700 ? (780 - nm) / 80 : 1;
  return [r, g, b].map((part) => (0.45 + 0.55 * Math.max(0, Math.min(1, far))) * Math.min(1, part) * 0.92);
}

/** The picture of the map on the sensor; in cells of one colour where the renderer knows no pictures. */
async function mapParts(three, { corners: [origin, right, , up], picture }, cells) {
  const image = new Image();
  image.src = picture;
  await image.decode();
  const place = (s, t) => world(origin.map((o, k) => o + s * (right[k] - o) + t * (up[k] - o)));
  const n = cells || 1;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = cells ? [n, n] : [image.width, image.height];
  const pen = canvas.getContext("2d");
  pen.drawImage(image, 0, 0, canvas.width, canvas.height);
  const pixels = cells ? pen.getImageData(0, 0, n, n).data : null;
  const [places, uv, tints] = [[], [], []];
  for (let x = 0; x < n; x += 1) {
    for (let y = 0; y < n; y += 1) {
      for (const [dx, dy] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
        places.push(...place((x + dx) / n, (y + dy) / n));
        uv.push((x + dx) / n, (y + dy) / n);
        if (!cells) continue;
        // The picture's first row is the largest y of the sensor.
        const [r, g, b] = pixels.slice(4 * ((n - 1 - y) * n + x));
        tints.push(...new three.Color().setRGB(r / 255, g / 255, b / 255, three.SRGBColorSpace).toArray());
      }
    }
  }
  const geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(places, 3));
  if (cells) geometry.setAttribute("color", new three.Float32BufferAttribute(tints, 3));
  else geometry.setAttribute("uv", new three.Float32BufferAttribute(uv, 2));
  const texture = cells ? null : new three.CanvasTexture(canvas);
  if (texture) Object.assign(texture, { colorSpace: three.SRGBColorSpace, magFilter: three.NearestFilter });
  return new three.Mesh(geometry, new three.MeshBasicMaterial({ map: texture, vertexColors: Boolean(cells), side: three.DoubleSide }));
}

export async function showScene(three, scene, root) {
  const { reach, rays, corners } = scene;
  const find = (selector) => root.querySelector(selector);
  const box = find(".stage");
  const [low, high, band, note] = [".low", ".high", ".band", ".ray-note"].map(find);
  const shown = (name) => find(`[name=${name}]`).checked;
  const stage = new Stage(three, box, { up: [0, 1, 0], height: 620, simple: true });
  root.dataset.drawn = stage.drawn;
  if (stage.drawn === "svg") find(".mode").textContent = "This browser gives no WebGL: the scene is drawn simplified; turning, following and filtering work as well.";
  stage.camera.fov = 21;
  Object.assign(stage.camera, { near: 0.002 * reach, far: 20 * reach });
  Object.assign(stage.controls, { minDistance: 0.02 * reach, maxDistance: 12 * reach });
  const map = await mapParts(three, scene, stage.drawn === "svg" ? 24 : 0);
  let [chosen, followed] = [-1, 1];

  const axes = [["C0 (x)", [0.22 * reach, 0, 0], "--bad"], ["C90 (y)", [0, 0.22 * reach, 0], "--good"], ["γ = 0 (z)", [0, 0, reach], "--link"]];
  const label = (text, colour) => {
    const span = Object.assign(document.createElement("span"), { className: "label", textContent: text });
    span.style.color = `var(${colour})`;
    box.append(span);
    return span;
  };
  const labels = axes.map(([text, , colour]) => label(text, colour));
  const head = label("●", "--ink");
  const put = (span, point) => {
    const [x, y] = stage.onScreen(world(point));
    Object.assign(span.style, { left: `${x.toFixed(1)}px`, top: `${y.toFixed(1)}px` });
  };
  const along = (ray, share) => ray.a.map((from, k) => from + share * (ray.b[k] - from));
  const visible = (ray) => ray.nm === null || (ray.nm >= +low.value && ray.nm <= +high.value);
  const tint = (nm) => new three.Color().setRGB(...rgb(nm), three.SRGBColorSpace);

  function fan(outline) {
    const places = outline.slice(2).flatMap((last, at) => [outline[0], outline[at + 1], last].flatMap(world));
    const geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(places, 3));
    return new three.Mesh(geometry, new three.MeshBasicMaterial({ color: "rgb(255,204,64)", side: three.DoubleSide }));
  }

  function rayParts() {
    // Lines of one colour together: the SVG renderer knows one colour an object.
    const groups = new Map();
    for (const ray of rays.filter(visible)) {
      const nm = ray.nm === null ? null : Math.round(ray.nm / 10) * 10;
      groups.set(nm, [...(groups.get(nm) ?? []), ray]);
    }
    const parts = [...groups].map(([nm, these]) => segments(three, these.flatMap((ray) => [world(ray.a), world(ray.b)]), new three.LineBasicMaterial({
      color: tint(nm), transparent: true, opacity: chosen < 0 ? 0.6 : 0.1, depthWrite: false,
    })));
    const ray = rays[chosen];
    if (ray) parts.push(segments(three, [world(ray.a), world(along(ray, followed))], new three.LineBasicMaterial({ color: tint(ray.nm) })));
    return parts;
  }

  /** Built anew after every change but that of the camera. */
  function build() {
    const frame = corners.flatMap((corner, at) => [world(corner), world(corners[(at + 1) % 4])]);
    const parts = [segments(three, frame, new three.LineBasicMaterial({ color: stage.colour("--ink") })), ...scene.emitter.map(fan)];
    for (const [, to, colour] of axes) parts.push(segments(three, [[0, 0, 0], world(to)], new three.LineBasicMaterial({ color: stage.colour(colour), transparent: true, opacity: 0.6 })));
    if (shown("map")) parts.push(map);
    if (shown("rays")) parts.push(...rayParts());
    if (shown("solid")) parts.push(...solidParts(three, scene.solid, 0.35 * reach, { face: "rgb(242,178,56)", edge: stage.colour("--muted"), opacity: 0.3, depthWrite: false }));
    stage.fill(...parts);
    const ray = rays[chosen];
    const mm = (point) => point.map((one) => one.toFixed(2)).join(", ");
    note.textContent = ray
      ? `ray ${chosen + 1}: ${ray.nm === null ? "" : `${ray.nm.toFixed(0)} nm, `}from (${mm(ray.a)}) mm to pixel (${ray.pixel.join(", ")}) at (${mm(ray.b)}) mm`
      : "Drag or use the arrow keys to turn, the wheel or + and − to come nearer, shift and drag to move; click a ray to follow it.";
    band.textContent = `${low.value}–${high.value} nm, ${rays.filter(visible).length} rays`;
    stage.render();
  }
  stage.after = () => {
    axes.forEach(([, to], at) => put(labels[at], to));
    head.hidden = chosen < 0;
    if (chosen >= 0) put(head, along(rays[chosen], followed));
  };

  function follow(index) {
    [chosen, followed] = [index, index < 0 ? 1 : 0];
    let begun = null;
    const step = (now) => {
      if (chosen !== index) return;
      begun ??= now;
      followed = Math.min(1, (now - begun) / 1200);
      build();
      if (followed < 1) requestAnimationFrame(step);
    };
    if (index >= 0) requestAnimationFrame(step);
    build();
  }

  /** The ray within eight pixels of a place on the screen. */
  function nearest(x, y) {
    let [best, least] = [-1, 8];
    if (!shown("rays")) return best;
    rays.forEach((ray, index) => {
      if (!visible(ray)) return;
      const [a, b] = [ray.a, ray.b].map((end) => stage.onScreen(world(end)));
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const share = Math.max(0, Math.min(1, ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy || 1)));
      const distance = Math.hypot(x - a[0] - share * dx, y - a[1] - share * dy);
      if (distance < least) [best, least] = [index, distance];
    });
    return best;
  }

  let pressed = null;
  box.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  box.addEventListener("pointerup", (event) => {
    const still = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) <= 3;
    pressed = null;
    if (!still || event.button !== 0) return;
    const corner = box.getBoundingClientRect();
    const hit = nearest(event.clientX - corner.left - box.clientLeft, event.clientY - corner.top - box.clientTop);
    follow(hit === chosen ? -1 : hit);
  });
  for (const input of root.querySelectorAll("input[type=checkbox]")) input.addEventListener("change", build);
  for (const slider of [low, high]) slider.addEventListener("input", () => follow(-1));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);

  const middle = corners[0].map((_, k) => corners.reduce((sum, corner) => sum + corner[k] / 4, 0));
  const across = Math.hypot(...corners[2].map((one, k) => one - corners[0][k]));
  const views = {
    reset: [[0.49, 0.34, 0.8], [0, 0.05 * reach, 0.5 * reach], 2.4 * reach],
    lamp: [[0, 0, 1], [0, 0, 0.5 * reach], 2.2 * reach],
    side: [[1, 0, 0], [0, 0, 0.5 * reach], 2.5 * reach],
    sensor: [[0.45, 0.3, 0.85], middle, 4 * across],
  };
  const look = (name) => {
    const [along_, at, distance] = views[name];
    stage.look(world(at.map((one, k) => one - distance * along_[k])), world(at));
  };
  for (const button of root.querySelectorAll("button")) button.addEventListener("click", () => { look(button.name); follow(-1); });
  look("reset");
  build();
}
