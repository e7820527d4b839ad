// An answer as one reads it. What has no place of its own is shown as it is, so that nothing is dropped.
import { h, number } from "./dom.js";
import { ranged, whole } from "./families.js";
import { m, math } from "./math.js";

const VERDICTS = {
  unique: "Through each point that satisfies the constraints goes one solution.",
  underdetermined: "Some unknowns can be chosen as any functions of time.",
  isolated: "Only isolated points satisfy all constraints.",
  inconsistent: "No point satisfies all consequences of the equations.",
};
const SHOWN = new Set(["verdict", "name", "equilibrium", "variables", "dimensions", "index", "constraints", "vector_field", "gauge", "assumptions", "strata", "symmetries", "trajectory", "trajectories",
  "tradeoff", "evidence", "warnings", "work", "consistent_initial"]);

const loop = text => text ? h("span", { class: "soft" }, ` for ${text.replaceAll(":", " … ")}`) : null;
const line = (...parts) => h("div", { class: "math" }, ...parts);
const badge = (kind, text = kind, title) => h("span", { class: "badge " + kind, title }, text);

// Any value: objects as terms, lists of objects as tables, the rest as text.
export function tree(value) {
  if (Array.isArray(value)) {
    if (value.length && value.every(v => v && typeof v === "object" && !Array.isArray(v))) return h("div", {}, value.map((v, i) => h("details", { class: "node", open: value.length < 4 }, h("summary", {}, v.name ?? v.expression ?? v.variable ?? `${i + 1}`), tree(v))));
    if (value.some(v => Array.isArray(v))) return h("table", {}, h("tbody", {}, value.map(row => h("tr", {}, [row].flat().map(v => h("td", {}, typeof v === "string" ? math(v) : tree(v)))))));
    return h("span", {}, value.length ? value.map((v, i) => [i ? ", " : "", tree(v)]) : "none");
  }
  if (value && typeof value === "object") return h("dl", { class: "facts" }, Object.entries(value).map(([k, v]) => [h("dt", {}, k.replaceAll("_", " ")), h("dd", {}, tree(v))]));
  return h("span", {}, number(value));
}

function warnings(list = []) {
  return list.map(w => h("p", { class: "note" }, "⚠ ", w.detail, h("span", { class: "soft" }, ` (${w.code})`)));
}

function field(result) {
  const f = result.vector_field;
  if (!f) return [];
  const gauge = result.gauge?.fields ?? [], free = f.free ?? [];
  return [h("h2", {}, "Reduced field"), free.length ? h("p", { class: "soft" }, "Any functions of time may stand for ", free.join(", "), "; each multiplies its gauge field below.") : null,
    Object.entries(f.components).filter(([x, rate]) => rate !== x + "'").map(([x, rate]) => ({ ...ranged(x), rate })).map(f => line(math(`der(${f.name})`.replace(/^der\((\w+)('*)\)$/, "$1$2'"), f.rate), loop(f.loop))),
    gauge.length ? h("h3", {}, "Gauge fields") : null,
    gauge.map((g, i) => line(free[i] ? h("span", { class: "soft" }, free[i] + ": ") : null, Object.entries(g).map(([x, v], k) => [k ? "  +  " : "", h("span", {}, "("), math(v), ") ", vector(ranged(x).name), loop(ranged(x).loop)])))];
}

function vector(x) {
  const inner = math(x);
  const e = m("math", m("mfrac", m("mi", "∂"), m("mrow", m("mi", "∂"), ...(inner.tagName === "math" ? [...inner.childNodes] : [m("mi", x)]))));
  e.setAttribute("aria-label", "d/d" + x);
  return e;
}

export function constraints(result) {
  const by = Map.groupBy ? Map.groupBy(result.constraints ?? [], c => c.generation) : (result.constraints ?? []).reduce((all, c) => all.set(c.generation, [...(all.get(c.generation) ?? []), c]), new Map());
  return [...by].map(([generation, list]) => h("div", {}, h("h3", {}, `Generation ${generation}`), list.map(c => line(math(c.expression, "0"), loop(c.for)))));
}

export function answer(job) {
  const r = job.result, d = r.dimensions;
  const other = Object.keys(r).filter(k => !SHOWN.has(k));
  return [
    h("div", { class: "card" }, h("div", { class: "verdict" }, r.verdict, r.equilibrium === true ? badge("", "equilibrium") : null), h("p", {}, VERDICTS[r.verdict] ?? ""),
      h("dl", { class: "facts" },
        d ? [h("dt", {}, "Dimensions"), h("dd", {}, [d.ambient, ...d.generations].join(" → "), d.final === null ? " → nothing" : "")] : null,
        r.index ? [h("dt", {}, "Generations of constraints"), h("dd", {}, number(r.index.generations)), h("dt", {}, "Differentiation index"), h("dd", {}, number(r.index.differentiation))] : null,
        r.variables ? [h("dt", {}, "Variables"), h("dd", {}, r.variables.map((v, i) => [i ? ", " : "", math(v.name), loop(v.for), v.role === "variable" ? "" : h("span", { class: "soft" }, ` ${v.role}`)]))] : null,
        r.assumptions?.length ? [h("dt", {}, "Assuming"), h("dd", {}, r.assumptions.map(a => line(a.expression ? math(a.expression) : "", h("span", {}, { not_zero: " is not 0" }[a.kind] ?? " " + (a.kind ?? "")))))] : null)),
    warnings(r.warnings),
    r.constraints ? [h("h2", {}, "Constraints"), r.constraints.length ? constraints(r) : h("p", {}, "None: every initial value is consistent.")] : null,
    field(r),
    r.consistent_initial ? [h("h2", {}, "Consistent start"), tree(r.consistent_initial)] : null,
    other.map(k => [h("h2", {}, k.replaceAll("_", " ")), h("div", { class: "card" }, tree(r[k]))]),
  ];
}

// -- The derivation: one card for each generation --

function basis(r) {
  const d = r.evidence?.decisions;
  if (!d) return null;
  if (d.split || d.no_value) return badge("undecided", "partly undecided", "Some zero or rank questions have no answer");
  if (d.zero_numeric || d.nonzero_numeric) return badge("numeric", "numeric decisions", "Some zeros were decided by many digits at points of the constraints");
  return d.zero_algebraic ? badge("algebraic", "algebraic", "Zeros were decided modulo primes, at random points of the constraints") : badge("proved", "proved", "Every zero and rank was decided exactly");
}

// "equations[2]" of the request, as it stands there.
function given(request, place) {
  const r = /^(\w+)\[(\d+)\]$/.exec(place), list = r && request?.system?.[r[1]];
  return Array.isArray(list) && typeof list[r[2]] === "string" ? list[r[2]] : null;
}

function origin(result, request, made) {
  if (made?.from === "restriction") return [h("p", { class: "step" }, "given as a restriction")];
  return (made?.combination ?? []).map((part, i) => {
    const word = [i ? "plus " : "made of ", part.factor === "1" ? null : [math(part.factor), " times "]];
    if (part.tangency_of !== undefined) return h("p", { class: "step" }, word, "the derivative along the motion of ", math(result.constraints[part.tangency_of]?.expression ?? "", "0"));
    const text = given(request, part.equation);
    return h("p", { class: "step" }, word, text ? [math(text.replace(/(==|~)/, "=")), h("span", { class: "soft" }, ` (${part.equation})`)] : part.equation);
  });
}

export function derivation(job, request) {
  const r = whole(job.result), d = r.dimensions, made = r.evidence?.constraints ?? [], generations = [...new Set((r.constraints ?? []).map(c => c.generation))];
  if (!r.constraints || !d) return [h("p", { class: "empty" }, "The answer has no constraints: ask for them with “want”.")];
  const size = [d.ambient, ...d.generations], cards = [];
  const card = (title, ...body) => cards.push(h("section", { class: "card", tabindex: "-1" }, h("h2", {}, title), ...body));
  card("As given", h("p", {}, `${d.ambient} variables: `, r.variables.map((v, i) => [i ? ", " : "", math(v.name)])),
    (Array.isArray(request?.system?.equations) ? request.system.equations : []).map(e => line(math(e.replace(/(==|~)/, "=")))));
  generations.forEach((g, i) => card([`Generation ${g}: from dimension ${size[i]} to ${size[i + 1] ?? "none"}`, basis(r)],
    r.constraints.map((c, k) => c.generation === g ? h("div", {}, line(math(c.expression, "0")), made[k] ? h("div", {}, origin(r, request, made[k])) : null) : null)));
  card(r.verdict === "inconsistent" ? "It stops: nothing is left" : "It stops: the motion stays on all constraints",
    h("p", {}, VERDICTS[r.verdict]), h("p", {}, d.final === null ? "" : `Final dimension ${d.final}`, r.gauge?.dimension ? `, ${r.gauge.dimension} of it free at each time.` : "."), field(r),
    r.evidence?.witness ? h("p", { class: "soft" }, `An independent witness checked ${r.evidence.witness.checked} at ${r.evidence.witness.points} points to ${r.evidence.witness.digits} digits.`) : null);
  let shown = cards.length;
  const at = h("span", { class: "soft", role: "status" });
  const step = to => {
    shown = Math.min(cards.length, Math.max(1, to));
    cards.forEach((c, i) => { c.classList.toggle("later", i >= shown); c.classList.toggle("now", i === shown - 1 && shown < cards.length); });
    at.textContent = `${shown} of ${cards.length}`;
    cards[shown - 1].scrollIntoView({ block: "nearest" });
  };
  const all = h("div", { class: "derivation" }, h("div", { class: "bar" }, h("button", { onclick: () => step(1) }, "From the start"), h("button", { onclick: () => step(shown - 1) }, "Back (p)"), h("button", { onclick: () => step(shown + 1) }, "Next (n)"), at), cards);
  all.step = by => step(shown + by);
  at.textContent = `${shown} of ${cards.length}`;
  return [all];
}

// -- Strata --

const KINDS = { pivot: "a divisor vanishes", branch: "another branch", side: "one side of a switch", instant: "at a time", domain: "a denominator vanishes", parameter: "for special parameters", excess: "no solution of the equations" };

const LISTED = ["instant", "domain", "excess"];      // what the service never solves

const keys = s => [s.where, ...(s.also ?? [])].map(where => JSON.stringify([s.kind, where, s.substituted, where.length ? null : s.description]));

// A node of the tree. One without a result of its own is solved as it is opened: `solve` runs the request again and opens the node of this key in the new answer.
function stratum(s, solve, opened) {
  const result = s.result, made = result || s.problem || s.same_as, open = keys(s).includes(opened), waits = !made && !LISTED.includes(s.kind);
  return h("details", { class: "node", open, ontoggle: e => { if (e.target.open && waits && !open) solve(keys(s)[0]); } },
    h("summary", {}, s.substituted ? Object.entries(s.substituted).map(([k, v], i) => [i ? ", " : "", math(k, v)]) : s.where.length ? s.where.map((w, i) => [i ? ", " : "", math(w, "0")]) : s.description ?? "at a point",
      badge("", KINDS[s.kind] ?? s.kind), result ? badge(result.verdict === "unique" ? "proved" : "algebraic", result.verdict) : null, s.meets_final_set === false ? badge("", "off the final set") : null),
    made ? null : h("p", { class: "soft" }, !waits ? "It is listed only: no system of its own belongs to it." : open ? "It was not solved." : "It is being solved …"),
    s.problem ? h("p", { class: "error" }, s.problem.detail) : null, s.same_as ? h("p", {}, "the same set as ", s.same_as.map((w, i) => [i ? ", " : "", math(w, "0")])) : null,
    s.point ? h("p", { class: "soft" }, "a point: ", Object.entries(s.point).map(([k, v]) => `${k} = ${number(v)}`).join(", ")) : null,
    s.parameters ? h("p", { class: "soft" }, "holds at ", Object.entries(s.parameters).map(([k, v]) => `${k} = ${v}`).join(", ")) : null,
    result ? [h("p", {}, `dimensions ${[result.dimensions.ambient, ...result.dimensions.generations].join(" → ")}`), constraints(result), field(result), warnings(result.warnings), (result.strata ?? []).map(inner => stratum(inner, solve, opened))] : null);
}

export function strata(job, solve, opened) {
  const list = job.result.strata ?? [], open = list.some(s => !s.result && !s.problem && !s.same_as && !LISTED.includes(s.kind));
  return [list.length ? h("h2", {}, "Strata") : null, list.length ? h("p", { class: "soft" }, "Where the answer may not hold, or is not the only one. One that is opened is solved as a system of its own.") : h("p", { class: "empty" }, "No strata are listed: what was divided by vanishes nowhere on the constraints, as far as was searched."),
    open && !opened ? h("button", { onclick: () => solve("all") }, "Solve each of them") : null, list.map(s => stratum(s, solve, opened)), warnings((job.result.warnings ?? []).filter(w => w.code.startsWith("strata")))];
}

// -- Symmetries --

const yes = v => v === true ? "yes" : v === false ? "no" : "unknown";
const vectors = f => Object.entries(f.field ?? f).filter(([, v]) => v !== "0").map(([x, v], i) => [i ? " + " : "", "(", math(v), ") ", vector(x)]);

export function symmetries(job) {
  const s = job.result.symmetries;
  if (!s) return [h("p", { class: "empty" }, "None were asked for. In JSON: “symmetries”: {“check”: […], “search”: {“degree”: 1}}, and “symmetries” in “want”.")];
  const rest = Object.fromEntries(Object.entries(s).filter(([k]) => !["checked", "found", "first_integrals", "commutators"].includes(k)));
  return [
    s.checked?.length ? [h("h2", {}, "Checked"), h("table", {}, h("thead", {}, h("tr", {}, ["Name", "Symmetry", "Tangent", "Gauge", "Defect"].map(t => h("th", { scope: "col" }, t)))),
      h("tbody", {}, s.checked.map(c => h("tr", {}, h("th", { scope: "row" }, c.name), h("td", {}, yes(c.symmetry)), h("td", {}, yes(c.tangent)), h("td", {}, yes(c.gauge)), h("td", {}, c.defect ? math(c.defect) : "–")))))] : null,
    s.found ? [h("h2", {}, "Found"), s.found.length ? s.found.map(f => line(vectors(f), f.gauge ? badge("", "gauge") : null)) : h("p", {}, "none")] : null,
    s.first_integrals?.length ? [h("h2", {}, "First integrals"), s.first_integrals.map(i => line(math(typeof i === "string" ? i : i.expression ?? "")))] : null,
    s.commutators?.length ? [h("h2", {}, "Commutators"), tree(s.commutators)] : null, h("h2", {}, "Details"), tree(rest)];
}
