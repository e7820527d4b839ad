// Motions as curves: columns against time, one column against another, errors by row. Each has a table of its numbers beside it.
import { h, number, replace, save } from "./dom.js";

const LIGHT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#1f6f9c", "#555555"], DARK = ["#56b4e9", "#e69f00", "#2fc99b", "#e391c0", "#f0e442", "#9ad0f5", "#bbbbbb"];
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 5], [1, 4]];
const ROWS = 200;

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const dark = () => matchMedia("(prefers-color-scheme: dark)").matches ? document.documentElement.dataset.theme !== "light" : document.documentElement.dataset.theme === "dark";
const style = k => ({ stroke: (dark() ? DARK : LIGHT)[k % 7], dash: DASHES[Math.floor(k / 7) % 6], width: 2 });

function axes(labels, log) {
  const axis = { stroke: css("--ink"), grid: { stroke: css("--edge"), width: 1 }, ticks: { stroke: css("--edge"), width: 1 }, labelSize: 22, size: 56 };
  return [{ ...axis, label: labels[0], size: 40 }, { ...axis, label: labels[1], ...(log ? { values: (_, v) => v.map(x => x === null ? "" : x.toExponential(0)) } : {}) }];
}

// The curve of one column against another, in the order of the samples: uPlot gives the scales.
function curve(u, series) {
  const path = new Path2D(), [xs, ys] = u.data[series];
  let open = false;
  for (let i = 0; i < xs.length; i++) {
    if (xs[i] === null || ys[i] === null) { open = false; continue; }
    path[open ? "lineTo" : "moveTo"](u.valToPos(xs[i], "x", true), u.valToPos(ys[i], "y", true));
    open = true;
  }
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
  u.ctx.clip();
  Object.assign(u.ctx, { strokeStyle: style(0).stroke, lineWidth: 2 * devicePixelRatio });
  u.ctx.stroke(path);
  u.ctx.restore();
  return null;
}

const spread = ([low, high]) => { const pad = (high - low || Math.abs(high) || 1) * 0.05; return [low - pad, high + pad]; };

// Events in a plot: a dashed line at the time of each, where time goes across, and a ring on each curve.
function marks(u, events, times, rings) {
  const c = u.ctx, { left, top, width, height } = u.bbox;
  c.save();
  c.beginPath();
  c.rect(left, top, width, height);
  c.clip();
  Object.assign(c, { strokeStyle: css("--soft"), lineWidth: devicePixelRatio });
  c.setLineDash([4, 4]);
  if (times) for (const e of events) {
    const x = u.valToPos(e.t, "x", true);
    c.beginPath();
    c.moveTo(x, top);
    c.lineTo(x, top + height);
    c.stroke();
  }
  c.setLineDash([]);
  Object.assign(c, { fillStyle: css("--ground"), lineWidth: 2 * devicePixelRatio });
  for (const r of rings) for (let i = 0; i < r.x.length; i++) {
    if (!Number.isFinite(r.x[i]) || !Number.isFinite(r.y[i])) continue;
    c.strokeStyle = r.stroke;
    c.beginPath();
    c.arc(u.valToPos(r.x[i], "x", true), u.valToPos(r.y[i], "y", true), 4 * devicePixelRatio, 0, 7);
    c.fill();
    c.stroke();
  }
  c.restore();
}

// One line of dots of all rings, for pictures.
const together = rings => rings.some(r => r.y.some(Number.isFinite)) ? [{ name: "events", dots: true, x: rings.flatMap(r => r.x), y: rings.flatMap(r => r.y) }] : [];

// The lines of a plot as a picture of its own; lines may have an x of their own, and be dots.
export function svg(title, x, lines, labels) {
  const W = 800, H = 480, L = 70, B = 50, flat = lines.flatMap(l => l.y).filter(Number.isFinite), xs = x.filter(Number.isFinite);
  const lim = a => spread(a.reduce(([p, q], v) => [Math.min(p, v), Math.max(q, v)], [Infinity, -Infinity])), [x0, x1] = lim(xs), [y0, y1] = lim(flat);
  const px = v => (L + (v - x0) / (x1 - x0) * (W - L - 20)).toFixed(2), py = v => (H - B - (v - y0) / (y1 - y0) * (H - B - 30)).toFixed(2), esc = t => String(t).replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);
  const tick = (a, b) => Array.from({ length: 6 }, (_, i) => a + (b - a) * i / 5);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${W} ${H}" font-family="sans-serif" font-size="13"><title>${esc(title)}</title><rect width="${W}" height="${H}" fill="#fff"/>`
    + tick(x0, x1).map(v => `<path d="M${px(v)} 30V${H - B}" stroke="#ddd"/><text x="${px(v)}" y="${H - B + 18}" text-anchor="middle">${number(Number(v.toPrecision(3)))}</text>`).join("")
    + tick(y0, y1).map(v => `<path d="M${L} ${py(v)}H${W - 20}" stroke="#ddd"/><text x="${L - 6}" y="${py(v)}" text-anchor="end">${number(Number(v.toPrecision(3)))}</text>`).join("")
    + lines.map((l, k) => `<path fill="none" stroke="${LIGHT[k % 7]}" stroke-linecap="round" stroke-width="${l.dots ? Math.max(6, 10 - 4 * k) : 2}" d="M${l.y.map((v, i) => [v, (l.x ?? x)[i]]).filter(p => p.every(Number.isFinite)).map(([v, u]) => `${px(u)} ${py(v)}`).join(l.dots ? "h0M" : "L")}${l.dots ? "h0" : ""}"/><text x="${L + 10 + 90 * k}" y="20" fill="${LIGHT[k % 7]}">${esc(l.name)}</text>`).join("")
    + `<text x="${W / 2}" y="${H - 10}" text-anchor="middle">${esc(labels[0])}</text></svg>`;
}

function table(columns, rows, name = "Table of the numbers") {
  return h("details", {}, h("summary", {}, `${name} (${rows.length} rows)`), h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": name },
    h("table", { class: "numbers" }, h("thead", {}, h("tr", {}, columns.map(c => h("th", { scope: "col" }, c)))), h("tbody", {}, rows.slice(0, ROWS).map(r => h("tr", {}, r.map(v => h("td", {}, number(v)))))))),
    rows.length > ROWS ? h("p", { class: "soft" }, `The first ${ROWS}; the CSV has all.`) : null);
}

// The middle of an enclosure stands for it.
const value = v => Array.isArray(v) ? (Number(v[0]) + Number(v[1])) / 2 : typeof v === "string" ? Number(v) : v;

// A panel of plots of one motion. Returns its elements and a function that draws them anew.
export function motion(t, title) {
  const columns = t.columns, rows = t.rows.map(r => r.map(value)), data = columns.map((_, c) => rows.map(r => r[c]));
  const events = (t.events ?? []).map(e => ({ ...e, t: value(e.t), at: [value(e.t), ...(e.values ?? []).map(value)] })), ringed = (across, up, stroke) => ({ stroke, x: events.map(e => e.at[columns.indexOf(across)]), y: events.map(e => e.at[columns.indexOf(up)]) });
  const place = h("div", { class: "plot", role: "img" }), chosen = new Set(columns.slice(1, 5)), kinds = ["against time", "phase plane", "errors by row"];
  let kind = kinds[0], plot = null, pair = [columns[1], columns[2] ?? columns[1]], shownLines = [], shownX = [], rings = [];
  const options = list => list.map(c => h("option", {}, c));
  const boxes = h("div", { class: "choices", role: "group", "aria-label": "Columns" }, columns.slice(1).map(c => h("label", {}, h("input", { type: "checkbox", checked: chosen.has(c), onchange: e => { chosen[e.target.checked ? "add" : "delete"](c); draw(); } }), " ", c)));
  const across = h("select", { "aria-label": "Across", onchange: e => { pair[0] = e.target.value; draw(); } }, options(columns)), up = h("select", { "aria-label": "Up", onchange: e => { pair[1] = e.target.value; draw(); } }, options(columns));
  [across.value, up.value] = pair;
  const planes = h("div", { class: "choices" }, h("label", {}, "across ", across), h("label", {}, "up ", up));
  const kindBox = h("select", { "aria-label": "Plot", onchange: e => { kind = e.target.value; draw(); } }, options(t.errors ? kinds : kinds.slice(0, 2)));
  function draw() {
    const size = { width: Math.max(320, Math.min(1100, place.parentElement?.clientWidth || 640)), height: 400 };
    plot?.destroy();
    boxes.hidden = kind !== kinds[0];
    planes.hidden = kind !== kinds[1];
    if (typeof uPlot === "undefined" || rows.length < 2) return replace(place, h("p", {}, rows.length < 2 ? "There are too few rows to plot." : "Plots are not available in this browser."));
    if (kind === kinds[1]) {
      const [x, y] = pair.map(c => data[columns.indexOf(c)]);
      [shownX, shownLines, rings] = [x, [{ name: pair[1], y }], [ringed(...pair, style(0).stroke)]];
      plot = new uPlot({ mode: 2, hooks: { draw: [u => marks(u, events, pair[0] === columns[0], rings)] }, ...size, legend: { show: false }, cursor: { drag: { x: true, y: true } }, scales: { x: { time: false, range: (_, a, b) => spread([a, b]) }, y: { range: (_, a, b) => spread([a, b]) } },
        axes: axes(pair), series: [{}, { facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }], paths: curve }] }, [null, [x, y]], place);
    } else {
      const errors = kind === kinds[2], list = columns.slice(1).filter(c => chosen.has(c));
      shownLines = errors ? [{ name: "estimated error", y: t.errors.map(v => v > 0 ? v : null) }] : list.map(c => ({ name: c, y: data[columns.indexOf(c)] }));
      shownX = data[0];
      rings = errors ? [] : list.map((c, k) => ringed(columns[0], c, style(k).stroke));
      plot = new uPlot({ ...size, hooks: { draw: [u => marks(u, events, true, rings)] }, cursor: { drag: { x: true, y: false } }, scales: { x: { time: false }, y: errors ? { distr: 3 } : {} }, axes: axes([columns[0], ""], errors),
        series: [{ label: columns[0] }, ...shownLines.map((l, k) => ({ label: l.name, ...style(k), value: (_, v) => number(v) }))] }, [shownX, ...shownLines.map(l => l.y)], place);
    }
    place.setAttribute("aria-label", `${kind}: ${kind === kinds[1] ? pair.join(", ") : shownLines.map(l => l.name).join(", ")}${events.length ? `; ${events.length} events are marked` : ""}; the table below has the numbers`);
  }
  const csv = () => save((title || "motion") + ".csv", "text/csv", [columns, ...t.rows].map(r => r.map(v => Array.isArray(v) ? `"${v.join(" ")}"` : v).join(",")).join("\n") + "\n");
  const ended = t.ended ? h("p", { class: "note" }, `It ended at t = ${number(t.ended.t)}: ${t.ended.detail ?? t.ended.reason}`) : null;
  const happened = events.length ? table(["event", ...columns, "direction"], events.map(e => [e.name, ...e.at, e.direction]), "Events") : null;
  return { draw, elements: [h("div", { class: "bar" }, kindBox, h("button", { onclick: csv }, "Save CSV"), h("button", { onclick: () => save((title || "motion") + ".svg", "image/svg+xml", svg(title, shownX, [...shownLines, ...together(rings)], [kind === kinds[1] ? pair[0] : columns[0]])) }, "Save SVG"),
    h("span", { class: "soft" }, "drag to zoom, double click for all")), boxes, planes, place, ended, happened, table(columns, rows)] };
}

// What is known of the numbers, and the work-precision table.
export function accuracy(result) {
  const t = result.trajectory, w = result.tradeoff, facts = (pairs) => h("dl", { class: "facts" }, pairs.filter(([, v]) => v !== undefined).map(([k, v]) => [h("dt", {}, k), h("dd", {}, number(v))]));
  return [t ? [h("h2", {}, "Motion"), facts([["estimated error", t.error_estimate], ["accuracy reached", t.accuracy_reached === undefined ? undefined : t.accuracy_reached ? "yes" : "no"], ["residual of the constraints", t.constraint_residual], ["start moved by", t.initial?.moved], ["method", t.method], ["arithmetic", t.arithmetic], ["gauge", t.gauge]])] : null,
    t?.column_errors ? [h("h3", {}, "Estimated error by column"), facts(t.columns.slice(1).map((c, i) => [c, t.column_errors[i]]))] : null,
    w ? [h("h2", {}, "Methods measured on this motion"), h("p", {}, w.advice ?? ""), h("table", { class: "numbers" }, h("thead", {}, h("tr", {}, ["method", "arithmetic", "rtol", "seconds", "error", "residual"].map(c => h("th", { scope: "col" }, c)))),
      h("tbody", {}, (w.rows ?? []).map(r => h("tr", {}, [r.method, r.arithmetic, r.rtol, r.seconds, r.error, r.residual].map(v => h("td", {}, number(v)))))))] : null,
    result.work?.seconds ? [h("h2", {}, "Seconds of each stage"), facts(Object.entries(result.work.seconds))] : null];
}
