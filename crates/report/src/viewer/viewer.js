// A viewer of a lit sensor: no network. WebGL through regl where there is WebGL, else the same scene on a 2-D canvas.
// The luminaire frame is shown as the lamp sees it: x to the right, y up, z away from the viewer, which makes it
// left-handed (CIE 121: C runs counter-clockwise then).
(function (scene, root) {
  "use strict";
  var canvas = root.querySelector(".pen"), pen = canvas.getContext("2d"), note = root.querySelector(".ray-note");
  var low = root.querySelector(".low"), high = root.querySelector(".high"), show = {};
  root.querySelectorAll("input[type=checkbox]").forEach(function (box) {
    show[box.name] = box.checked;
    box.addEventListener("change", function () { show[box.name] = box.checked; draw(); });
  });
  var yaw = -0.55, pitch = 0.35, zoom = 1.8, chosen = -1, focus = 0.5, drag = null, followed = 1;
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
  function rgb(nm) {
    if (nm === null) { return [0.88, 0.66, 0]; }
    var r = 0, g = 0, b = 0;
    if (nm < 440) { r = Math.max(0, (440 - nm) / 60); b = 1; } else if (nm < 490) { g = (nm - 440) / 50; b = 1; }
    else if (nm < 510) { g = 1; b = (510 - nm) / 20; } else if (nm < 580) { r = (nm - 510) / 70; g = 1; }
    else if (nm < 645) { r = 1; g = (645 - nm) / 65; } else { r = 1; }
    var dim = nm < 420 ? 0.45 + 0.55 * Math.max(0, (nm - 380) / 40) : nm > 700 ? 0.45 + 0.55 * Math.max(0, (780 - nm) / 80) : 1;
    return [r, g, b].map(function (v) { return dim * Math.min(1, v) * 0.92; });
  }
  function colour(nm) {
    return "rgb(" + rgb(nm).map(function (v) { return Math.round(255 * v); }).join(",") + ")";
  }
  function visible(ray) {
    return ray.nm === null || (ray.nm >= +low.value && ray.nm <= +high.value);
  }

  // ---- WebGL -------------------------------------------------------------------------------------------------------------
  function webgl() {
    var regl = createREGL({ canvas: root.querySelector(".gl"), attributes: { antialias: true, preserveDrawingBuffer: true }, onDone: function () { /* asked below */ } });
    if (!regl) { return null; }
    var place = "precision highp float; uniform vec2 turn, window; uniform float reach, focus, zoom;" +
      "vec4 place(vec3 p) { float z = p.z - reach * focus; float a = cos(turn.x) * p.x + sin(turn.x) * z, b = -sin(turn.x) * p.x + cos(turn.x) * z;" +
      "float y = cos(turn.y) * p.y - sin(turn.y) * b, depth = 2.2 * reach + sin(turn.y) * p.y + cos(turn.y) * b;" +
      "float k = 3.0 * zoom * min(window.x, window.y), n = 0.05 * reach, f = 8.0 * reach;" +
      "return vec4(k * a / window.x, k * y / window.y, ((f + n) * depth - 2.0 * f * n) / (f - n), depth); }";
    var uniforms = {
      turn: function () { return [yaw, pitch]; }, window: function () { return [canvas.width, canvas.height]; },
      reach: reach, focus: function () { return focus; }, zoom: function () { return zoom; }
    };
    var blend = { enable: true, func: { srcRGB: "src alpha", srcAlpha: 1, dstRGB: "one minus src alpha", dstAlpha: 1 } };
    function painted(points, colours, primitive, writes) {
      return regl({
        vert: place + "attribute vec3 position; attribute vec4 tint; varying vec4 shade; void main() { shade = tint; gl_Position = place(position); }",
        frag: "precision mediump float; varying vec4 shade; void main() { gl_FragColor = shade; }",
        attributes: { position: points, tint: colours }, uniforms: uniforms, count: points.length,
        primitive: primitive, blend: blend, depth: { enable: true, mask: writes }
      });
    }
    function triangles(p, tint, points, colours) {
      for (var k = 1; k + 1 < p.length; k++) { [p[0], p[k], p[k + 1]].forEach(function (v) { points.push(v); colours.push(tint); }); }
    }
    var faces = [[], []], edges = [[], []], lamp = [[], []];
    scene.solid.forEach(function (quad) {
      var p = quad.points, u = [0, 1, 2].map(function (k) { return p[2][k] - p[0][k]; }), v = [0, 1, 2].map(function (k) { return p[3][k] - p[1][k]; });
      var n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]], l = Math.hypot(n[0], n[1], n[2]) || 1;
      var light = 0.65 + 0.35 * Math.abs((0.5 * n[0] + 0.8 * n[1] - 0.3 * n[2]) / l);
      triangles(p, [0.95 * light, 0.70 * light, 0.22 * light, 0.30], faces[0], faces[1]);
      [[0, 1], [0, 3]].forEach(function (e) { e.forEach(function (k) { edges[0].push(p[k]); edges[1].push([0.5, 0.35, 0.05, 0.35]); }); });
    });
    scene.emitter.forEach(function (outline) { triangles(outline, [1, 0.8, 0.25, 1], lamp[0], lamp[1]); });
    var ends = [], tints = [], nms = [];
    scene.rays.forEach(function (ray) {
      [ray.a, ray.b].forEach(function (p) { ends.push(p); tints.push(rgb(ray.nm)); nms.push(ray.nm === null ? -1 : ray.nm); });
    });
    var rays = ends.length && regl({
      vert: place + "attribute vec3 position, tint; attribute float nm; varying vec3 shade; varying float keep; uniform vec2 band;" +
        "void main() { shade = tint; keep = nm < 0.0 || (nm >= band.x && nm <= band.y) ? 1.0 : 0.0; gl_Position = place(position); }",
      frag: "precision mediump float; varying vec3 shade; varying float keep; uniform float alpha; void main() { if (keep < 0.5) discard; gl_FragColor = vec4(shade, alpha); }",
      attributes: { position: ends, tint: tints, nm: nms },
      uniforms: Object.assign({ band: function () { return [+low.value, +high.value]; }, alpha: function () { return chosen < 0 ? 0.6 : 0.1; } }, uniforms),
      count: ends.length, primitive: "lines", blend: blend, depth: { enable: true, mask: false }
    });
    var texture = regl.texture({ width: 1, height: 1, data: [200, 200, 200, 255] });
    var c = scene.corners;
    var map = regl({
      vert: place + "attribute vec3 position; attribute vec2 at; varying vec2 where; void main() { where = at; gl_Position = place(position); }",
      frag: "precision mediump float; varying vec2 where; uniform sampler2D picture; void main() { gl_FragColor = texture2D(picture, where); }",
      attributes: { position: [c[0], c[1], c[2], c[0], c[2], c[3]], at: [[0, 1], [1, 1], [1, 0], [0, 1], [1, 0], [0, 0]] },
      uniforms: Object.assign({ picture: function () { return texture; } }, uniforms), count: 6
    });
    // The picture's first row is the top: the largest y of the sensor.
    var image = new Image();
    image.onload = function () { texture = regl.texture({ data: image, mag: "nearest", min: "linear" }); draw(); };
    image.src = scene.picture;
    var frame = [c[0], c[1], c[1], c[2], c[2], c[3], c[3], c[0]];
    var border = painted(frame, frame.map(function () { return [0.13, 0.16, 0.2, 1]; }), "lines", true);
    var solid = faces[0].length && painted(faces[0], faces[1], "triangles", false), mesh = edges[0].length && painted(edges[0], edges[1], "lines", false);
    var emitter = painted(lamp[0], lamp[1], "triangles", true);
    return function () {
      regl.poll();
      regl.clear({ color: [1, 1, 1, 1], depth: 1 });
      if (show.map) { map(); }
      border(); emitter();
      if (show.rays && rays) { rays(); }
      if (show.solid && solid) { solid(); mesh(); }
    };
  }
  var paint = null;
  try { paint = webgl(); } catch (error) { /* no WebGL, or less of it than is needed: the canvas below */ }
  if (!paint) {
    root.querySelector(".gl").style.display = "none";
    root.querySelector(".mode").textContent = "This browser gives no WebGL: the scene is drawn simplified, on a 2-D canvas; turning, following and filtering work as well.";
  }
  root.setAttribute("data-drawn", paint ? "webgl" : "2d");

  // ---- 2-D canvas ---------------------------------------------------------------------------------------------------------
  function polygon(points, fill, stroke) {
    pen.beginPath();
    points.forEach(function (p, k) { if (k) { pen.lineTo(p[0], p[1]); } else { pen.moveTo(p[0], p[1]); } });
    pen.closePath();
    if (fill) { pen.fillStyle = fill; pen.fill(); }
    if (stroke) { pen.strokeStyle = stroke; pen.stroke(); }
  }
  function segment(a, b, tint, alpha, width) {
    pen.strokeStyle = tint; pen.globalAlpha = alpha; pen.lineWidth = width;
    pen.beginPath(); pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1]); pen.stroke();
    pen.globalAlpha = 1; pen.lineWidth = 1;
  }
  function simplified() {
    var list = [];
    if (show.solid) {
      scene.solid.forEach(function (quad) {
        var p = quad.points.map(project);
        var depth = (p[0][2] + p[1][2] + p[2][2] + p[3][2]) / 4;
        list.push({ depth: depth, draw: function () { polygon(p, "rgba(240,180,60,0.16)", "rgba(150,105,20,0.35)"); } });
      });
    }
    if (show.map) {
      scene.cells.forEach(function (cell) {
        var p = cell.points.map(project);
        list.push({ depth: (p[0][2] + p[2][2]) / 2, draw: function () { polygon(p, cell.colour, cell.colour); } });
      });
    }
    scene.emitter.forEach(function (outline) {
      var p = outline.map(project);
      list.push({ depth: p[0][2], draw: function () { polygon(p, "rgba(255,220,120,0.9)", "#8a6a10"); } });
    });
    if (show.rays) {
      scene.rays.forEach(function (ray) {
        if (!visible(ray)) { return; }
        var a = project(ray.a), b = project(ray.b);
        list.push({ depth: (a[2] + b[2]) / 2, draw: function () { segment(a, b, colour(ray.nm), chosen < 0 ? 0.55 : 0.1, 1); } });
      });
    }
    list.sort(function (a, b) { return b.depth - a.depth; }).forEach(function (face) { face.draw(); });
  }
  function axes() {
    [["C0 (x)", [1, 0, 0], "#b3261e"], ["C90 (y)", [0, 1, 0], "#2e7d4f"], ["γ = 0 (z)", [0, 0, 1], "#2458a8"]].forEach(function (axis) {
      var l = axis[1][2] ? reach : 0.22 * reach, o = project([0, 0, 0]), e = project(axis[1].map(function (v) { return v * l; }));
      pen.setLineDash([4, 4]); segment(o, e, axis[2], 1, 1); pen.setLineDash([]);
      pen.fillStyle = axis[2]; pen.font = "13px sans-serif"; pen.fillText(axis[0], e[0] + 5, e[1] - 4);
    });
  }
  function draw() {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    if (paint) { paint(); } else { simplified(); }
    axes();
    var shown = scene.rays.filter(visible).length;
    root.querySelector(".band").textContent = low.value + "–" + high.value + " nm, " + shown + " rays";
    if (chosen >= 0) {
      var ray = scene.rays[chosen], a = project(ray.a), b = project(ray.b);
      var head = project([0, 1, 2].map(function (k) { return ray.a[k] + followed * (ray.b[k] - ray.a[k]); }));
      segment(a, b, colour(ray.nm), 0.5, 1.5); segment(a, head, colour(ray.nm), 1, 3);
      pen.beginPath(); pen.arc(head[0], head[1], 4, 0, 6.3); pen.fillStyle = colour(ray.nm); pen.fill();
      note.textContent = "ray " + (chosen + 1) + ": " + (ray.nm === null ? "" : ray.nm.toFixed(0) + " nm, ") + "from (" +
        ray.a.map(function (v) { return v.toFixed(2); }).join(", ") + ") mm to pixel (" + ray.pixel.join(", ") + ") at (" +
        ray.b.map(function (v) { return v.toFixed(2); }).join(", ") + ") mm";
    } else { note.textContent = "Drag to turn, wheel to zoom, shift and drag to move along the axis, click a ray to follow it."; }
  }

  // ---- hands --------------------------------------------------------------------------------------------------------------
  function follow(index) {
    chosen = index; followed = index < 0 ? 1 : 0;
    var begun = null;
    function step(now) {
      if (chosen !== index) { return; }
      begun = begun || now; followed = Math.min(1, (now - begun) / 1200); draw();
      if (followed < 1) { requestAnimationFrame(step); }
    }
    if (index >= 0) { requestAnimationFrame(step); }
    draw();
  }
  function nearest(x, y) {
    var best = -1, least = 8;
    if (!show.rays) { return best; }
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
  canvas.addEventListener("pointerdown", function (event) {
    drag = { at: place(event), moved: false };
    try { canvas.setPointerCapture(event.pointerId); } catch (error) { /* a pointer that has gone is not captured */ }
  });
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
    if (drag && !drag.moved) { var p = place(event), hit = nearest(p[0], p[1]); follow(hit === chosen ? -1 : hit); }
    drag = null;
  });
  canvas.addEventListener("wheel", function (event) { event.preventDefault(); zoom = Math.max(0.3, Math.min(60, zoom * Math.exp(-event.deltaY * 0.0012))); draw(); }, { passive: false });
  [low, high].forEach(function (slider) { slider.addEventListener("input", function () { follow(-1); }); });
  root.querySelectorAll("button").forEach(function (button) {
    button.addEventListener("click", function () {
      var view = { lamp: [0, 0, 0.5, 1.8], side: [-1.5707, 0, 0.5, 1.6], sensor: [-0.5, 0.3, 1, 14], reset: [-0.55, 0.35, 0.5, 1.8] }[button.name];
      yaw = view[0]; pitch = view[1]; focus = view[2]; zoom = view[3]; follow(-1);
    });
  });
  draw();
})
