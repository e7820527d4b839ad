// A text field over a coloured copy of its text, with line numbers and marks under what is wrong. The field itself stays what browsers and
// screen readers know: colours and marks are its background.
import { h, replace } from "./dom.js";

const JSON_TOKENS = /("(?:[^"\\]|\\.)*")(\s*:)?|-?\d[\d.eE+-]*|\b(?:true|false|null)\b/g;
const PLAIN_TOKENS = /#.*|^\s*(?:let|start|hold|from|output|tolerance|want|variables|name)\b(?!\s*=)|\b\d[\d.]*(?:[eE][+-]?\d+)?/gm;
const MOST = 200000;      // of a longer text nothing is coloured

function tokens(text, mode) {
  const out = [];
  if (text.length > MOST) return out;
  for (const m of text.matchAll(mode === "json" ? JSON_TOKENS : PLAIN_TOKENS)) {
    const kind = mode === "json" ? (m[1] ? (m[2] ? "k" : "s") : "n") : m[0][0] === "#" ? "c" : /^\s*[a-z]/.test(m[0]) ? "k" : "n";
    out.push([m.index, m.index + (m[1] ? m[1].length : m[0].length), kind]);
  }
  return out;
}

// Pieces of the text between all ends of tokens and marks, each with its classes.
function* segments(text, kinds, marks) {
  const cuts = [...new Set([0, text.length, ...kinds.flatMap(k => [k[0], k[1]]), ...marks.flat()])].filter(c => c <= text.length).sort((a, b) => a - b);
  let k = 0;
  for (let i = 0; i + 1 < cuts.length; i++) {
    const [from, to] = [cuts[i], cuts[i + 1]];
    while (k < kinds.length && kinds[k][1] <= from) k++;
    const kind = k < kinds.length && kinds[k][0] <= from ? kinds[k][2] : "";
    yield [text.slice(from, to), kind + (marks.some(m => m[0] <= from && to <= m[1]) ? " bad" : "")];
  }
}

export class Editor {
  constructor(place, changed) {
    this.mode = "plain";
    this.marks = [];
    this.gutter = h("div", { class: "gutter", "aria-hidden": "true" });
    this.copy = h("pre", { "aria-hidden": "true" });
    this.field = h("textarea", { spellcheck: "false", autocapitalize: "off", autocomplete: "off", wrap: "off", "aria-label": "Request", "aria-describedby": "said" });
    place.append(this.gutter, h("div", { class: "paper" }, this.copy, this.field));
    this.field.addEventListener("input", () => { this.marks = []; this.draw(); changed(); });
    this.field.addEventListener("scroll", () => this.scroll());
  }
  get text() { return this.field.value; }
  set(text, mode) {
    this.mode = mode;
    this.marks = [];
    this.field.value = text;
    this.field.scrollTop = this.field.scrollLeft = 0;
    this.draw();
  }
  mark(ranges) {
    this.marks = ranges.filter(([from, to]) => to > from);
    this.field.setAttribute("aria-invalid", String(ranges.length > 0));
    this.draw();
  }
  select(from, to) {
    this.field.focus();
    this.field.setSelectionRange(from, to);
    const line = this.text.slice(0, from).split("\n").length - 1, height = this.field.scrollHeight / this.text.split("\n").length;
    if (line * height < this.field.scrollTop || (line + 2) * height > this.field.scrollTop + this.field.clientHeight) this.field.scrollTop = Math.max(0, (line - 3) * height);
  }
  draw() {
    const text = this.text, lines = text.split("\n").length;
    replace(this.copy, [...segments(text, tokens(text, this.mode), this.marks)].map(([piece, kind]) => kind ? h("span", { class: kind.trim() }, piece) : piece), "\n ");
    const bad = new Set(this.marks.map(m => text.slice(0, m[0]).split("\n").length));
    replace(this.gutter, Array.from({ length: lines }, (_, i) => [bad.has(i + 1) ? h("b", {}, `● ${i + 1}`) : String(i + 1), "\n"]));
    this.scroll();
  }
  scroll() {
    this.copy.scrollTop = this.gutter.scrollTop = this.field.scrollTop;
    this.copy.scrollLeft = this.field.scrollLeft;
  }
}
