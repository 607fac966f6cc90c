// Three dimensions by three, for the report and for the page: a scene that is turned by hand, and the photometric solid.
// The world is x to C 0°, y to C 90°, z against the axis of the light: right-handed, as CIE 121 counts C seen from above.

/** A point of the luminaire frame, whose z is the axis of the light. */
export const world = ([x, y, z]) => [x, y, -z];

/** Half-planes round the circle: what a rotational or symmetric distribution leaves out is the same light again. */
function around({ c_deg: c, gamma_deg: gamma, intensity_cd: cd }) {
  const plane = (at) => cd.slice(at * gamma.length, (at + 1) * gamma.length);
  const last = c.at(-1);
  if (c.length === 1) return Array.from({ length: 73 }, (_, at) => [at * 5, plane(0)]);
  const planes = c.map((angle, at) => [angle, plane(at)]);
  if (last <= 90) planes.push(...planes.slice(0, -1).reverse().map(([angle, one]) => [180 - angle, one]));
  if (last <= 180) planes.push(...planes.slice(0, -1).reverse().map(([angle, one]) => [360 - angle, one]));
  if (planes.at(-1)[0] < 360) planes.push([360, planes[0][1]]);
  return planes;
}

/** The surface of a distribution and the lines on it; `size` is the radius of its largest intensity. */
export function solidParts(three, solid, size, { face, edge, opacity, depthWrite = true }) {
  const [planes, gamma] = [around(solid), solid.gamma_deg];
  const top = Math.max(...solid.intensity_cd);
  const places = [];
  for (const [c, cd] of planes) {
    gamma.forEach((angle, at) => {
      const [azimuth, polar, r] = [(c * Math.PI) / 180, (angle * Math.PI) / 180, top > 0 ? (size * Math.max(0, cd[at])) / top : 0];
      places.push(...world([r * Math.sin(polar) * Math.cos(azimuth), r * Math.sin(polar) * Math.sin(azimuth), r * Math.cos(polar)]));
    });
  }
  const [faces, edges, n] = [[], [], gamma.length];
  for (let plane = 0; plane + 1 < planes.length; plane += 1) {
    for (let at = 0; at + 1 < n; at += 1) {
      const [a, b, c, d] = [plane * n + at, plane * n + at + 1, (plane + 1) * n + at, (plane + 1) * n + at + 1];
      faces.push(a, b, c, b, d, c);
      edges.push(a, b);
      if (at % 5 === 0) edges.push(a, c);
    }
  }
  const position = new three.Float32BufferAttribute(places, 3);
  const surface = new three.BufferGeometry().setAttribute("position", position).setIndex(faces);
  surface.computeVertexNormals();
  const lines = new three.BufferGeometry().setAttribute("position", position).setIndex(edges);
  const skin = { color: face, side: three.DoubleSide, transparent: true, opacity, depthWrite };
  return [
    new three.Mesh(surface, new three.MeshLambertMaterial(skin)),
    new three.LineSegments(lines, new three.LineBasicMaterial({ color: edge, transparent: true, opacity: 0.35, depthWrite })),
  ];
}

/** Lines through points of the world. */
export function segments(three, points, material) {
  const geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(points.flat(), 3));
  return new three.LineSegments(geometry, material);
}

export class Stage {
  /** Where there is no WebGL, `simple` lets the library's SVG renderer draw. `up` is the direction that is up on the screen. */
  constructor(three, element, { up, height, simple = false }) {
    Object.assign(this, { three, element, height, after: () => {} });
    const webgl = Boolean(document.createElement("canvas").getContext("webgl2"));
    this.drawn = webgl ? "webgl" : simple ? "svg" : null;
    if (!this.drawn) return;
    this.renderer = webgl ? new three.WebGLRenderer({ antialias: true, alpha: true }) : new three.SVGRenderer();
    const canvas = this.renderer.domElement;
    element.append(canvas);
    canvas.setAttribute("role", "img");
    this.scene = new three.Scene();
    this.camera = new three.PerspectiveCamera(35, 1, 0.1, 20);
    this.camera.up.set(...up);
    this.controls = new three.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.render());
    element.addEventListener("keydown", (event) => this.#key(event));
    addEventListener("resize", () => this.render());
  }

  colour(name) {
    return new this.three.Color(getComputedStyle(this.element).getPropertyValue(name).trim());
  }

  /** Everything in place of what was there. */
  fill(...parts) {
    const light = new this.three.DirectionalLight(0xffffff, 2);
    light.position.set(2, -4, 3);
    for (const part of this.scene.children) part.geometry?.dispose();
    this.scene.clear();
    this.scene.add(new this.three.AmbientLight(0xffffff, 1.4), light, ...parts);
  }

  look(from, at) {
    this.camera.position.set(...from);
    this.controls.target.set(...at);
    this.controls.update();
    this.render();
  }

  /** The place on the element of a point of the world, in CSS pixels. */
  onScreen(point) {
    const { x, y } = new this.three.Vector3(...point).project(this.camera);
    return [((x + 1) / 2) * this.element.clientWidth, ((1 - y) / 2) * this.renderedHeight];
  }

  render() {
    const width = this.element.clientWidth;
    if (!width) return;
    const height = Math.min(this.height, width);
    this.renderedHeight = height;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(this.controls.target);
    this.camera.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    this.element.dataset.turned = this.camera.position.toArray().map((one) => one.toPrecision(4)).join(" ");
    this.after();
  }

  /** About the axis that is up, and towards it; nearer and further. */
  #key(event) {
    const turn = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] }[event.key];
    const nearer = { "+": 0.9, "-": 1.1 }[event.key];
    if (!turn && !nearer) return;
    event.preventDefault();
    const { up } = this.camera;
    const at = this.camera.position.clone().sub(this.controls.target).multiplyScalar(nearer ?? 1);
    if (turn) {
      const polar = at.angleTo(up);
      const wanted = Math.max(0.05, Math.min(Math.PI - 0.05, polar + turn[1]));
      at.applyAxisAngle(up.clone().cross(at).normalize(), wanted - polar).applyAxisAngle(up, turn[0]);
    }
    this.camera.position.copy(at.add(this.controls.target));
    this.render();
  }
}
