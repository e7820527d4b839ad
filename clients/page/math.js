// Expressions of the grammar as MathML, which browsers set and read aloud themselves. What cannot be read stands as its text.

const GREEK = Object.fromEntries(("alpha α beta β gamma γ delta δ epsilon ε zeta ζ eta η theta θ iota ι kappa κ lambda λ mu μ nu ν xi ξ rho ρ sigma σ tau τ upsilon υ phi φ chi χ psi ψ omega ω "
  + "Gamma Γ Delta Δ Theta Θ Lambda Λ Xi Ξ Pi Π Sigma Σ Phi Φ Psi Ψ Omega Ω pi π").split(" ").reduce((all, w, i, a) => i % 2 ? all : [...all, [w, a[i + 1]]], []));
const NS = "http://www.w3.org/1998/Math/MathML";
const MOST = 20000;

export function m(tag, ...children) {
  const e = document.createElementNS(NS, tag);
  e.append(...children);
  return e;
}

function* lex(text) {
  const token = /\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*(?:\[[-+*\w,]+\])?)('*)|(<=|>=|==|!=|\*\*|[-+*/^(),=<>])|(\S))/gy;
  for (let r; (r = token.exec(text)) && r[0];) {
    if (r[5]) throw new SyntaxError(r[5]);
    yield r[1] ? { number: r[1] } : r[2] ? { name: r[2], order: r[3].length } : { op: r[4] };
  }
}

// A tree: {number}, {name, order}, {op, args}, {call, args}.
export function parse(text) {
  const tokens = [...lex(text)];
  let at = 0;
  const next = op => tokens[at]?.op === op && ++at;
  const level = (ops, below) => () => {
    let left = below();
    for (let op; ops.includes(op = tokens[at]?.op);) { at++; left = { op, args: [left, below()] }; }
    return left;
  };
  const atom = () => {
    const t = tokens[at++];
    if (!t) throw new SyntaxError("end");
    if (t.op === "(") {
      const inside = equation();
      if (!next(")")) throw new SyntaxError(")");
      return inside;
    }
    if (t.op) throw new SyntaxError(t.op);
    if (t.name && !t.order && next("(")) {
      const args = [equation()];
      while (next(",")) args.push(equation());
      if (!next(")")) throw new SyntaxError(")");
      return { call: t.name, args };
    }
    return t;
  };
  const power = () => {
    const base = atom();
    return next("^") || next("**") ? { op: "^", args: [base, signed()] } : base;
  };
  const signed = () => next("-") ? { op: "neg", args: [signed()] } : next("+") ? signed() : power();
  const product = level(["*", "/"], signed), sum = level(["+", "-"], product), equation = level(["=", "<", ">", "<=", ">=", "==", "!="], sum);
  const tree = equation();
  if (at < tokens.length) throw new SyntaxError("more");
  return tree;
}

const RANK = { "=": 0, "<": 0, ">": 0, "<=": 0, ">=": 0, "==": 0, "!=": 0, "+": 1, "-": 1, neg: 2, "*": 3, "/": 4, "^": 5 };
const rank = t => t.op ? RANK[t.op] : 6;
const paren = e => m("mrow", m("mo", "("), e, m("mo", ")"));
const wrapped = (t, least) => rank(t) < least ? paren(set(t)) : set(t);

function name(t) {
  const r = /^(.*?)_?(\d+|\[.*\])$/.exec(t.name) ?? [null, t.name, null];
  const [word, index] = r[1] ? [r[1], r[2]] : [t.name, null];
  let base = m("mi", GREEK[word] ?? word.replaceAll("_", " ").trim());
  if (t.order === 1 || t.order === 2) {
    // A dot above a low letter; above a tall one, or a word, it would be lost.
    const low = /^[acegmnopqrsuvwxyzαγεηικμνοπρσςτυχω]$/.test(base.textContent);
    base = low ? m("mover", base, m("mo", t.order === 1 ? "˙" : "¨")) : m("msup", base, m("mo", "′".repeat(t.order)));
    if (low) base.setAttribute("accent", "true");
  } else if (t.order > 2) base = m("msup", base, m("mrow", m("mo", "("), m("mn", String(t.order)), m("mo", ")")));
  return index ? m("msub", base, m("mn", index.replace(/[[\]]/g, ""))) : base;
}

function call(t) {
  const [x] = t.args, order = t.args[1]?.number;
  if (t.call === "sqrt") return m("msqrt", set(x));
  if (t.call === "cbrt") return m("mroot", set(x), m("mn", "3"));
  if (t.call === "abs") return m("mrow", m("mo", "|"), set(x), m("mo", "|"));
  if (t.call === "exp") return m("msup", m("mi", "e"), set(x));
  if (t.call === "der" && x.name && !x.order) return name({ name: x.name, order: Number(order ?? 1) });
  const inside = t.args.flatMap((a, i) => i ? [m("mo", ","), set(a)] : [set(a)]);
  return m("mrow", m("mi", t.call === "der" ? "d/dt" : t.call), m("mo", "\u2061"), paren(m("mrow", ...inside)));
}

function set(t) {
  if (t.number) return m("mn", t.number);
  if (t.name) return name(t);
  if (t.call) return call(t);
  const [a, b] = t.args;
  switch (t.op) {
    case "neg": return m("mrow", m("mo", "−"), wrapped(a, 3));
    case "/": return m("mfrac", set(a), set(b));
    case "^": return m("msup", wrapped(a, 6), set(b));
    case "*": return m("mrow", wrapped(a, 2), m("mo", (b.number || (b.op && b.args[0].number)) ? "·" : "\u2062"), gap(), wrapped(b, 3));
    case "-": return m("mrow", set(a), m("mo", "−"), wrapped(b, 2));
    case "+": return m("mrow", set(a), m("mo", "+"), wrapped(b, 2));
    default: return m("mrow", set(a), m("mo", { "<=": "≤", ">=": "≥", "==": "=", "!=": "≠" }[t.op] ?? t.op), set(b));
  }
}

function gap() {
  const space = m("mspace");
  space.setAttribute("width", "0.12em");
  return space;
}

// A <math> of an expression; with `after`, more of the same grammar behind "=".
export function math(text, after) {
  const whole = after === undefined ? String(text) : `${text} = ${after}`;
  try {
    if (whole.length > MOST) throw new SyntaxError("long");
    const e = m("math", set(parse(whole)));
    e.setAttribute("aria-label", whole);
    return e;
  } catch {
    const code = document.createElement("code");
    code.textContent = whole;
    return code;
  }
}
