// A small viewer of a lit sensor on a 2-D canvas: no library, no network. The luminaire frame is shown as the lamp sees
// it: x to the right, y up, z away from the viewer, which makes it left-handed (CIE 121: C runs counter-clockwise then).
(function (scene, root) {
  "use strict";
  var canvas = root.querySelector("canvas"), pen = canvas.getContext("2d"), note = root.querySelector(".ray-note");
  var low = root.querySelector(".low"), high = root.querySelector(".high"), show = {};
  root.querySelectorAll("input[type=checkbox]").forEach(function (box) {
    show[box.name] = box.checked;
    box.addEventListener("change", function () { show[box.name] = box.checked; draw(); });
  });
  var yaw = -0.55, pitch = 0.35, zoom = 1, chosen = -1, focus = 0.5, drag = null;
  var reach = scene.reach;

  function rotate(p) {
    var z0 = p[2] - reach * focus, x = p[0], y = p[1];
    var a = Math.cos(yaw) * x + Math.sin(yaw) * z0, b = -Math.sin(yaw) * x + Math.cos(yaw) * z0;
    return [a, Math.cos(pitch) * y - Math.sin(pitch) * b, Math.sin(pitch) * y + Math.cos(pitch) * b];
  }
  function project(p) {
    var r = rotate(p), size = Math.min(canvas.width, canvas.height), depth = 2.2 * reach + r[2];
    var k = zoom * 1.5 * size / Math.max(depth, 0.05 * reach);
    return [canvas.width / 2 + k * r[0], canvas.height / 2 - k * r[1], r[2]];
  }
  function colour(nm) {
    if (nm === null) { return "#e0a800"; }
    var r = 0, g = 0, b = 0;
    if (nm < 440) { r = Math.max(0, (440 - nm) / 60); b = 1; } else if (nm < 490) { g = (nm - 440) / 50; b = 1; }
    else if (nm < 510) { g = 1; b = (510 - nm) / 20; } else if (nm < 580) { r = (nm - 510) / 70; g = 1; }
    else if (nm < 645) { r = 1; g = (645 - nm) / 65; } else { r = 1; }
    var dim = nm < 420 ? 0.45 + 0.55 * Math.max(0, (nm - 380) / 40) : nm > 700 ? 0.45 + 0.55 * Math.max(0, (780 - nm) / 80) : 1;
    return "rgb(" + [r, g, b].map(function (v) { return Math.round(255 * dim * Math.min(1, v) * 0.92); }).join(",") + ")";
  }
  function polygon(points, fill, stroke) {
    pen.beginPath();
    points.forEach(function (p, k) { if (k) { pen.lineTo(p[0], p[1]); } else { pen.moveTo(p[0], p[1]); } });
    pen.closePath();
    if (fill) { pen.fillStyle = fill; pen.fill(); }
    if (stroke) { pen.strokeStyle = stroke; pen.stroke(); }
  }
  function visible(ray) {
    return ray.nm === null || (ray.nm >= +low.value && ray.nm <= +high.value);
  }
  function faces() {
    var list = [];
    if (show.solid) {
      scene.solid.forEach(function (quad) {
        var p = quad.points.map(project);
        var depth = (p[0][2] + p[1][2] + p[2][2] + p[3][2]) / 4;
        list.push({ depth: depth, draw: function () { polygon(p, "rgba(240,180,60,0.16)", "rgba(150,105,20,0.35)"); } });
      });
    }
    if (show.map) {
      scene.map.cells.forEach(function (cell) {
        var p = cell.points.map(project);
        list.push({ depth: (p[0][2] + p[2][2]) / 2, draw: function () { polygon(p, cell.colour, cell.colour); } });
      });
    }
    scene.emitter.forEach(function (outline) {
      var p = outline.map(project);
      list.push({ depth: p[0][2], draw: function () { polygon(p, "rgba(255,220,120,0.9)", "#8a6a10"); } });
    });
    if (show.rays) {
      scene.rays.forEach(function (ray, index) {
        if (!visible(ray)) { return; }
        var a = project(ray.a), b = project(ray.b);
        list.push({
          depth: (a[2] + b[2]) / 2, draw: function () {
            pen.strokeStyle = colour(ray.nm);
            pen.globalAlpha = chosen < 0 ? 0.55 : index === chosen ? 1 : 0.1;
            pen.lineWidth = index === chosen ? 3 : 1;
            pen.beginPath(); pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1]); pen.stroke();
            pen.globalAlpha = 1; pen.lineWidth = 1;
          }
        });
      });
    }
    return list;
  }
  function axes() {
    [["C0 (x)", [1, 0, 0], "#b3261e"], ["C90 (y)", [0, 1, 0], "#2e7d4f"], ["γ = 0 (z)", [0, 0, 1], "#2458a8"]].forEach(function (axis) {
      var l = axis[0] === "γ = 0 (z)" ? reach : 0.22 * reach, o = project([0, 0, 0]), e = project(axis[1].map(function (v) { return v * l; }));
      pen.strokeStyle = axis[2]; pen.setLineDash([4, 4]);
      pen.beginPath(); pen.moveTo(o[0], o[1]); pen.lineTo(e[0], e[1]); pen.stroke(); pen.setLineDash([]);
      pen.fillStyle = axis[2]; pen.font = "13px sans-serif"; pen.fillText(axis[0], e[0] + 5, e[1] - 4);
    });
  }
  function draw() {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    axes();
    faces().sort(function (a, b) { return b.depth - a.depth; }).forEach(function (face) { face.draw(); });
    var shown = scene.rays.filter(visible).length;
    root.querySelector(".band").textContent = low.value + "–" + high.value + " nm, " + shown + " rays";
    if (chosen >= 0) {
      var ray = scene.rays[chosen];
      note.textContent = "ray " + (chosen + 1) + ": " + (ray.nm === null ? "" : ray.nm.toFixed(0) + " nm, ") + "from (" +
        ray.a.map(function (v) { return v.toFixed(2); }).join(", ") + ") mm to pixel (" + ray.pixel.join(", ") + ") at (" +
        ray.b.map(function (v) { return v.toFixed(2); }).join(", ") + ") mm";
    } else { note.textContent = "Drag to turn, wheel to zoom, shift and drag to move along the axis, click a ray to follow it."; }
  }
  function nearest(x, y) {
    var best = -1, least = 8;
    scene.rays.forEach(function (ray, index) {
      if (!visible(ray)) { return; }
      var a = project(ray.a), b = project(ray.b), dx = b[0] - a[0], dy = b[1] - a[1], l = dx * dx + dy * dy || 1;
      var t = Math.max(0, Math.min(1, ((x - a[0]) * dx + (y - a[1]) * dy) / l));
      var d = Math.hypot(x - a[0] - t * dx, y - a[1] - t * dy);
      if (d < least) { least = d; best = index; }
    });
    return best;
  }
  function place(event) {
    var box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) * canvas.width / box.width, (event.clientY - box.top) * canvas.height / box.height];
  }
  canvas.addEventListener("pointerdown", function (event) { drag = { at: place(event), moved: false }; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", function (event) {
    if (!drag) { return; }
    var now = place(event), dx = now[0] - drag.at[0], dy = now[1] - drag.at[1];
    if (Math.abs(dx) + Math.abs(dy) > 3) { drag.moved = true; }
    if (!drag.moved) { return; }
    if (event.shiftKey) { focus = Math.max(0, Math.min(1, focus - dy / canvas.height)); } else {
      yaw += dx * 0.006; pitch = Math.max(-1.55, Math.min(1.55, pitch + dy * 0.006));
    }
    drag.at = now; draw();
  });
  canvas.addEventListener("pointerup", function (event) {
    if (drag && !drag.moved) { var p = place(event), hit = nearest(p[0], p[1]); chosen = hit === chosen ? -1 : hit; draw(); }
    drag = null;
  });
  canvas.addEventListener("wheel", function (event) { event.preventDefault(); zoom = Math.max(0.3, Math.min(60, zoom * Math.exp(-event.deltaY * 0.0012))); draw(); }, { passive: false });
  [low, high].forEach(function (slider) { slider.addEventListener("input", function () { chosen = -1; draw(); }); });
  root.querySelectorAll("button").forEach(function (button) {
    button.addEventListener("click", function () {
      var view = { lamp: [0, 0, 0.5, 1], side: [-1.5707, 0, 0.5, 1], sensor: [-0.5, 0.3, 1, 9], reset: [-0.55, 0.35, 0.5, 1] }[button.name];
      yaw = view[0]; pitch = view[1]; focus = view[2]; zoom = view[3]; chosen = -1; draw();
    });
  });
  draw();
})
