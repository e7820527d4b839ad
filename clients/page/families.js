// What long lists of an answer say once, with a loop: {"for": "i = 2:9", "count", "place", ...}, and "u[i = 1:9]" as the name of a member.

const isFamily = e => typeof e?.for === "string" && typeof e.count === "number" && typeof e.place === "string";
const RANGE = /^([A-Za-z_]\w*)\[([^[\]]*:[^[\]]*)\]('*)$/;

// 2*i-1: sums of products of whole numbers and names.
const index = (text, values) => text.split(/(?=[+-])/).reduce((sum, term) =>
  sum + (term[0] === "-" ? -1 : 1) * term.replace(/^[+-]/, "").split("*").reduce((all, f) => all * (values[f.trim()] ?? Number(f)), 1), 0);

function put(v, values) {
  if (typeof v === "string") return v.replace(/([A-Za-z_]\w*)\[([^[\]]*)\]|(?<![\w.])[A-Za-z_]\w*/g, (all, base, indices) => base ? `${base}[${indices.split(",").map(e => index(e, values))}]` : values[all] ?? all);
  if (Array.isArray(v)) return v.map(e => put(e, values));
  if (!v || typeof v !== "object") return v;
  const made = Object.fromEntries(Object.entries(v).map(([k, e]) => [put(k, values), put(e, values)]));
  const place = /^constraints\[(\d+)\]$/.exec(made.tangency_of);
  return place ? { ...made, tangency_of: Number(place[1]) } : made;
}

function* passes(parts, values = {}) {
  if (!parts.length) return yield values;
  const [, name, low, high] = /^\s*(\w+)\s*=\s*(\d+):(\d+)\s*$/.exec(parts[0]);
  for (let k = Number(low); k <= Number(high); k++) yield* passes(parts.slice(1), { ...values, [name]: k });
}

// An answer, or a part of one, with every family written out.
export function whole(v) {
  if (Array.isArray(v)) {
    if (!v.some(isFamily)) return v.some(e => e && typeof e === "object") ? v.map(whole) : v;
    const placed = new Map(), others = v.filter(e => !isFamily(e)).map(whole);
    for (const { for: loop, count, place, ...body } of v.filter(isFamily)) {
      const one = Object.keys(body).join() === "expression" ? body.expression : body;
      for (const values of passes(loop.split(","))) placed.set(index(place, values), put(one, values));
    }
    return Array.from({ length: placed.size + others.length }, (_, k) => placed.has(k) ? placed.get(k) : others.shift());
  }
  if (!v || typeof v !== "object") return v;
  return Object.fromEntries(Object.entries(v).flatMap(([key, e]) => {
    const r = RANGE.exec(key);
    if (!r) return [[key, whole(e)]];
    const ranges = r[2].split(",").map(s => s.trim());
    return [...passes(ranges.filter(s => s.includes(":")))].map(values => [`${r[1]}[${ranges.map(s => values[s.split("=")[0].trim()] ?? s)}]${r[3]}`, put(e, values)]);
  }));
}

// A member's name without its ranges, and the loop that it stands for: u[i = 1:9,0] is u[i,0] for i = 1:9.
export function ranged(key) {
  const r = RANGE.exec(key);
  if (!r) return { name: key, loop: "" };
  const ranges = r[2].split(",").map(s => s.trim());
  return { name: `${r[1]}[${ranges.map(s => s.split("=")[0].trim())}]${r[3]}`, loop: ranges.filter(s => s.includes(":")).join(", ") };
}
