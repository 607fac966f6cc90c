// Numbers and times as people read them.

/** Number with so many significant digits, without an exponent where it can be. */
export function significant(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const magnitude = Math.floor(Math.log10(Math.abs(value)));
  if (magnitude < -5 || magnitude > 6) return value.toExponential(digits - 1);
  return value.toFixed(Math.max(0, digits - 1 - magnitude));
}

/** Value ± U (k = 2) of a standard uncertainty u: the digits by the rule of the report (crates/units/src/digits.rs). */
export function withU(value, u, unit) {
  if (value === null || value === undefined) return "no number";
  if (!u || !Number.isFinite(u) || u <= 0) return `${significant(value)} ${unit}`;
  const [first, exponent] = (2 * u).toExponential().split("e");
  const place = Number(exponent) - (first[0] < "3" ? 1 : 0);
  const step = 10 ** Math.max(0, place);
  const said = (number) => (place > 0 ? (Math.round(number / step) * step).toFixed(0) : number.toFixed(Math.min(12, -place)));
  return `${said(value)} ± ${said(2 * u)} ${unit} (k = 2)`;
}

export function degrees(value, decimals = 2) {
  return value === null || value === undefined ? "–" : `${value.toFixed(decimals).replace("-", "−")}°`;
}

export function percent(rel, decimals = 2) {
  if (rel === null || rel === undefined) return "–";
  const text = Math.abs(rel * 100).toFixed(decimals);
  return `${rel < 0 ? "−" : "+"}${text} %`;
}

export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const s = Math.max(0, Math.round(seconds));
  const [h, min] = [Math.floor(s / 3600), Math.floor(s / 60) % 60];
  if (h) return `${h} h ${String(min).padStart(2, "0")} min`;
  return min ? `${min} min ${String(s % 60).padStart(2, "0")} s` : `${s} s`;
}

/** Time of day, local, with the day where it is another one. */
export function clock(utc) {
  const at = new Date(utc);
  if (Number.isNaN(at.getTime())) return "–";
  const time = at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", hour12: false });
  const days = Math.round((new Date(at).setHours(0, 0, 0, 0) - new Date().setHours(0, 0, 0, 0)) / 86400000);
  if (days === 0) return time;
  return days === 1 ? `${time} tomorrow` : `${time}, ${at.toLocaleDateString()}`;
}

export function clockSeconds(utc) {
  const at = new Date(utc);
  return Number.isNaN(at.getTime()) ? "" : at.toLocaleTimeString([], { hour12: false });
}
