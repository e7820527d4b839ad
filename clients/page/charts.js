// What is no motion as pictures: responses over frequency (Bode), eigenvalues, poles and zeros in the plane, work against precision.
import { h, number, save } from "./dom.js";
import { svg } from "./plots.js";

const log10 = v => v > 0 ? Math.log10(v) : NaN;

function chart(title, lines, labels) {
  const drawn = lines.filter(l => l.x.some((x, i) => Number.isFinite(x) && Number.isFinite(l.y[i])));
  if (!drawn.length) return [];
  const text = svg(title, drawn.flatMap(l => l.x), drawn, labels);
  return [h("figure", {}, h("img", { src: "data:image/svg+xml," + encodeURIComponent(text), width: 640, height: 384, alt: `${title}, ${labels[0]}: ${drawn.map(l => l.name).join(", ")}` }),
    h("figcaption", {}, title, " ", h("button", { onclick: () => save(title.toLowerCase() + ".svg", "image/svg+xml", text) }, "Save SVG")))];
}

// Degrees, without jumps of a whole turn.
function phases(points) {
  let turn = 0, last = null;
  return points.map(([re, im]) => {
    const v = Math.atan2(im, re) * 180 / Math.PI;
    if (last !== null) turn += v - last > 180 ? -360 : v - last < -180 ? 360 : 0;
    last = v;
    return v + turn;
  });
}

// Columns: omega, then re and im of each entry.
function bode(r) {
  const x = r.rows.map(row => log10(row[0])), entries = r.columns.slice(1).filter(c => c.startsWith("re ")).map((c, k) => ({ name: c.slice(3), points: r.rows.map(row => [row[1 + 2 * k], row[2 + 2 * k]]) }));
  const label = ["log10 of the frequency"];
  return [chart("Magnitude in dB", entries.map(e => ({ name: e.name, x, y: e.points.map(p => 20 * log10(Math.hypot(...p))) })), label), chart("Phase in degrees", entries.map(e => ({ name: e.name, x, y: phases(e.points) })), label)];
}

const dots = (name, list) => ({ name, dots: true, x: (list ?? []).map(v => Number(v[0])), y: (list ?? []).map(v => Number(v[1])) });

function precision(rows) {
  const of = new Map();
  for (const r of rows) { const name = `${r.method} ${r.arithmetic}`; of.set(name, [...of.get(name) ?? [], r]); }
  return chart("Work and precision", [...of].map(([name, list]) => ({ name, x: list.map(r => log10(r.error)), y: list.map(r => log10(r.seconds)) })), ["log10 of the error; up: log10 of the seconds"]);
}

export function charts(result) {
  const t = result.transfer, points = Array.isArray(result.linearization) ? result.linearization : [];
  return [t?.response?.rows?.length ? bode(t.response) : [], t?.poles || t?.zeros ? chart("Poles and zeros", [dots("poles", t.poles), dots("zeros", t.zeros)], ["real part; up: imaginary part"]) : [],
    points.map(l => chart(`Eigenvalues${l.t == null ? "" : ` at ${number(l.t)}`}`, [dots("eigenvalues", l.eigenvalues), dots("zeros", l.zeros)], ["real part; up: imaginary part"])), result.tradeoff?.rows ? precision(result.tradeoff.rows) : []].flat(9);
}
