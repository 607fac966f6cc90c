// The photometric solid: intensity as the distance from the light centre, to be turned.

import {
  AmbientLight, BufferGeometry, Color, DirectionalLight, DoubleSide, Float32BufferAttribute, LineBasicMaterial, LineSegments, Mesh,
  MeshLambertMaterial, OrbitControls, PerspectiveCamera, Scene, WebGLRenderer,
} from "./vendor/three.min.js";
import { significant } from "./words.js";

const colour = (name) => new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());

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

export class Solid {
  constructor(element, text) {
    Object.assign(this, { element, text });
    try {
      this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    } catch {
      text.textContent = "This browser gives no WebGL: the solid is not drawn; the pictures beside it show the same light.";
      return;
    }
    element.append(this.renderer.domElement);
    this.renderer.domElement.setAttribute("role", "img");
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.1, 20);
    // γ = 0° points down, as in the polar diagram.
    this.camera.position.set(1.2, 0.2, 1.6);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enablePan = false;
    this.controls.addEventListener("change", () => this.#render());
    element.addEventListener("keydown", (event) => this.#key(event));
    addEventListener("resize", () => this.#render());
  }

  show(solid) {
    if (!this.renderer) return;
    this.solid = solid;
    this.refresh();
  }

  /** Everything is drawn anew: after a change of data or theme. */
  refresh() {
    if (!this.solid || !this.renderer) return;
    const planes = around(this.solid);
    const gamma = this.solid.gamma_deg;
    const top = Math.max(...this.solid.intensity_cd);
    const places = [];
    for (const [c, cd] of planes) {
      gamma.forEach((angle, at) => {
        const [azimuth, polar, r] = [(c * Math.PI) / 180, (angle * Math.PI) / 180, Math.max(0, cd[at]) / top];
        places.push(r * Math.sin(polar) * Math.cos(azimuth), -r * Math.cos(polar), -r * Math.sin(polar) * Math.sin(azimuth));
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
    const position = new Float32BufferAttribute(places, 3);
    const surface = new BufferGeometry().setAttribute("position", position).setIndex(faces);
    surface.computeVertexNormals();
    const lines = new BufferGeometry().setAttribute("position", position).setIndex(edges);
    const axes = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 0, -1.15, 0, 0, 0, 0, 1.15, 0, 0, 0, 0, 0, 0, 0, -1.15], 3));
    this.scene.clear();
    const light = new DirectionalLight(0xffffff, 2);
    light.position.set(2, 3, 4);
    this.scene.add(
      new AmbientLight(0xffffff, 1.4), light,
      new Mesh(surface, new MeshLambertMaterial({ color: colour("--one"), side: DoubleSide, transparent: true, opacity: 0.85 })),
      new LineSegments(lines, new LineBasicMaterial({ color: colour("--text"), transparent: true, opacity: 0.35 })),
      new LineSegments(axes, new LineBasicMaterial({ color: colour("--two") })),
    );
    const words = `Photometric solid: the longest ray is ${significant(top, 4)} cd. Lines to γ 0° (down), C 0° and C 90°. Drag or use the arrow keys to turn it, the wheel or + and − to come nearer.`;
    this.text.textContent = words;
    this.renderer.domElement.setAttribute("aria-label", words);
    this.#render();
  }

  #render() {
    const width = this.element.clientWidth;
    if (!width) return;
    const height = Math.min(420, width);
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(0, -0.5, 0);
    this.controls.target.set(0, -0.5, 0);
    this.renderer.render(this.scene, this.camera);
    this.element.dataset.turned = this.camera.position.toArray().map((one) => one.toFixed(2)).join(" ");
  }

  #key(event) {
    const turn = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] }[event.key];
    const nearer = { "+": 0.9, "-": 1.1 }[event.key];
    if (!turn && !nearer) return;
    event.preventDefault();
    const at = this.camera.position.clone().sub(this.controls.target);
    const [r, theta, phi] = [at.length() * (nearer ?? 1), Math.atan2(at.x, at.z) + (turn?.[0] ?? 0), Math.acos(at.y / at.length()) + (turn?.[1] ?? 0)];
    const polar = Math.max(0.05, Math.min(Math.PI - 0.05, phi));
    at.set(r * Math.sin(polar) * Math.sin(theta), r * Math.cos(polar), r * Math.sin(polar) * Math.cos(theta));
    this.camera.position.copy(at.add(this.controls.target));
    this.#render();
  }
}
