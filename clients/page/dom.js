// Making elements. Text is text: nothing that comes from the service or the user is ever read as HTML.
export const $ = id => document.getElementById(id);

export function h(tag, attributes = {}, ...children) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) e.addEventListener(name.slice(2), value);
    else if (name in e && typeof value !== "string") e[name] = value;
    else if (value !== false && value != null) e.setAttribute(name, value);
  }
  e.append(...children.flat(9).filter(c => c != null && c !== false));
  return e;
}

export function replace(element, ...children) {
  element.replaceChildren(...children.flat(9).filter(c => c != null && c !== false));
}

// Saves text under a name, as a download.
export function save(name, type, text) {
  const url = URL.createObjectURL(new Blob([text], { type }));
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

// JSON with what is short on one line: rows of matrices, lists of names.
const SHORT = 88;
export function pretty(value, margin = "") {
  const flat = JSON.stringify(value, null, 1)?.replace(/\n\s*/g, " ");
  if (value === null || typeof value !== "object" || flat.length + margin.length <= SHORT) return typeof value === "object" ? spaced(value) : flat;
  const inner = margin + "  ", list = Array.isArray(value);
  const parts = list ? value.map(v => inner + pretty(v, inner)) : Object.entries(value).filter(([, v]) => v !== undefined).map(([k, v]) => `${inner}${JSON.stringify(k)}: ${pretty(v, inner)}`);
  return `${list ? "[" : "{"}\n${parts.join(",\n")}\n${margin}${list ? "]" : "}"}`;
}

function spaced(v) {
  if (v === null || typeof v !== "object") return JSON.stringify(v);
  if (Array.isArray(v)) return `[${v.map(spaced).join(", ")}]`;
  const members = Object.entries(v).filter(([, m]) => m !== undefined).map(([k, m]) => `${JSON.stringify(k)}: ${spaced(m)}`);
  return members.length ? `{ ${members.join(", ")} }` : "{}";
}

// A number as one reads it: 6 digits are enough beside the raw answer.
export function number(v) {
  if (v === null || v === undefined) return "–";
  return typeof v === "number" ? String(Number(v.toPrecision(6))) : String(v);
}
