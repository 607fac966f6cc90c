// The photometric solid of the results: intensity as the distance from the light centre, γ = 0° down as in the polar diagram.

import { Stage, segments, solidParts, world } from "./stage.js";
import * as three from "./vendor/three.min.js";
import { significant } from "./words.js";

export class Solid {
  constructor(element, text) {
    this.text = text;
    this.stage = new Stage(three, element, { up: [0, 0, 1], height: 420 });
    if (!this.stage.drawn) {
      text.textContent = "This browser gives no WebGL: the solid is not drawn; the pictures beside it show the same light.";
      return;
    }
    this.stage.controls.enablePan = false;
    this.stage.look([1.2, -1.6, 0.2], [0, 0, -0.5]);
  }

  show(solid) {
    this.solid = solid;
    this.refresh();
  }

  /** Everything is drawn anew: after a change of data or theme. */
  refresh() {
    const { stage, solid } = this;
    if (!solid || !stage.drawn) return;
    const axes = [[0, 0, 1.15], [1.15, 0, 0], [0, 1.15, 0]].flatMap((end) => [[0, 0, 0], world(end)]);
    stage.fill(
      ...solidParts(three, solid, 1, { face: stage.colour("--one"), edge: stage.colour("--text"), opacity: 0.85 }),
      segments(three, axes, new three.LineBasicMaterial({ color: stage.colour("--two") })),
    );
    const words = `Photometric solid: the longest ray is ${significant(Math.max(...solid.intensity_cd), 4)} cd. Lines to γ 0° (down), C 0° and C 90°. Drag or use the arrow keys to turn it, the wheel or + and − to come nearer.`;
    this.text.textContent = words;
    stage.renderer.domElement.setAttribute("aria-label", words);
    stage.render();
  }
}
