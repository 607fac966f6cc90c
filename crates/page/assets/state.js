// What the tab knows of the scan: the events, added up. No drawing, no network.

export function empty() {
  return {
    outline: null, state: null, sentence: "", warmUps: [], stable: false, references: [], planes: new Map(),
    points: new Map(), last: null, spectrum: null, left: null, journal: [], rows: [], maxCd: 0, reach: 0, dark: new Map(),
    cursor: 0, flagged: 0, version: 0, second: null,
  };
}

const ROWS_SHOWN = 200;
const JOURNAL_SHOWN = 500;

/** A scan begins, or is shown from its record. */
export function begin(model, outline) {
  Object.assign(model, empty(), { outline });
  if (!outline) return;
  outline.points.forEach((point, index) => model.points.set(index, { ...point, status: "open" }));
  model.reach = outline.points.reduce((most, point) => (point.kind === "lit" ? Math.max(most, Math.abs(point.gamma_deg)) : most), 0);
}

export function add(model, event) {
  model.version += 1;
  if (event.state) {
    [model.state, model.sentence] = [event.state, event.sentence];
    if (event.state === "warming_up") [model.stable, model.warmUps] = [false, []];
    // A plan that begins in the dark has not looked at the lamp yet.
    if (event.state === "scanning") model.stable = model.warmUps.length > 0;
  }
  if (event.left) model.left = event.left;
  if (event.sentence) {
    model.journal.unshift(event);
    model.journal.length = Math.min(model.journal.length, JOURNAL_SHOWN);
  }
  switch (event.event) {
    case "warm_up": model.warmUps.push(event); break;
    case "reading": reading(model, event); break;
    case "spectrum": spectrum(model, event); break;
    // What is swept a second time, until it is.
    case "second_sweep": model.second = event; break;
    case "sweep": model.second = null; break;
  }
}

function reading(model, row) {
  model.last = row;
  model.rows.unshift(row);
  model.rows.length = Math.min(model.rows.length, ROWS_SHOWN);
  if (row.role === "reference") {
    if (row.kind === "lit") model.references.push(row);
    return;
  }
  const point = model.points.get(row.point);
  if (point) {
    const flagged = row.quality !== "ok";
    if (flagged && point.status !== "flagged") model.flagged += 1;
    Object.assign(point, { status: flagged ? "flagged" : "done", lux: row.illuminance_lx });
  }
  if (row.kind !== "lit") {
    const points = model.dark.get(row.kind)?.points ?? new Set();
    model.dark.set(row.kind, { last: row, points: points.add(row.point) });
  }
  // A direction that is read again at rest shows whether the sweeps hold; it is no part of the light.
  if (row.kind !== "lit" || row.illuminance_lx === null || row.role === "check") return;
  // I = E·d², by the inverse square law; nothing is corrected yet.
  const cd = row.illuminance_lx * (row.distance_mm / 1000) ** 2;
  if (point) point.cd = cd;
  const plane = model.planes.get(row.c_target_deg) ?? new Map();
  plane.set(row.gamma_target_deg, cd);
  model.planes.set(row.c_target_deg, plane);
  model.maxCd = Math.max(model.maxCd, cd);
}

function spectrum(model, event) {
  if (event.curve) model.spectrum = event;
  const open = [...model.points.values()].find((point) => point.spectrum && point.status === "open");
  if (open) open.status = "done";
}

/** The first point of the plan that is read at rest and was not yet; a point that was read stays so. */
export function nextPoint(model) {
  const isLeft = (point) => !point || (point.status === "open" && !point.in_motion);
  while (!isLeft(model.points.get(model.cursor))) model.cursor += 1;
  return model.points.get(model.cursor) ?? null;
}

/** The curve of a half-plane as [γ, cd], by γ. */
export function curve(model, c) {
  const plane = model.planes.get(c) ?? (c === 0 ? model.planes.get(360) : undefined);
  return plane ? [...plane].sort((a, b) => a[0] - b[0]) : [];
}

export const STATES = {
  homing: ["Homing", "wait"],
  warming_up: ["Warming up", "wait"],
  scanning: ["Scanning", "run"],
  paused: ["Paused", "pause"],
  resuming: ["Resuming", "wait"],
  evaluating: ["Evaluating", "wait"],
  completed: ["Completed", "done"],
  interrupted: ["Interrupted", "end"],
  failed: ["Failed", "fault"],
};
