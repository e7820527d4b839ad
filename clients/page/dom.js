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

// A number as one reads it: 6 digits are enough beside the raw answer.
export function number(v) {
  if (v === null || v === undefined) return "–";
  return typeof v === "number" ? String(Number(v.toPrecision(6))) : String(v);
}
