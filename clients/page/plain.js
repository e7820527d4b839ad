// Equations as lines, and the request that they are. Each piece knows where it stands, so that problems of the request can be shown there.

export const HELP = `x'' = -lam*x            an equation; x', x'' or der(x) are derivatives
x^2 + y^2 = L^2         constraints stand among the others
let g = 9.81, L = 1/2   values of parameters; let k alone keeps it as a symbol
start x = 1, y = 0      where a motion starts (what is left out is found)
hold x                  what of it must not be moved
from 0 to 10, 201 samples
output x^2 + y^2        columns of their own; otherwise all variables
tolerance 1e-9          relative, of the motion
want structure, gauge   what is computed; otherwise the usual
variables x, y, lam     their order; otherwise as they appear
name pendulum
# a remark`;

const FUNCTIONS = new Set(("sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt cbrt abs sign min max der pi "
  + "hypot log10 log2 step if and or not").split(" "));
export const KEYWORDS = /^\s*(let|start|hold|from|output|tolerance|want|variables|name)\b(?!\s*=)/;

const escape = key => key.replaceAll("~", "~0").replaceAll("/", "~1");

// Pieces between commas outside parentheses: [{text, at}], without blanks around them.
function pieces(text, at) {
  const out = [];
  let depth = 0, from = 0;
  const end = to => {
    const raw = text.slice(from, to), lead = raw.length - raw.trimStart().length;
    if (raw.trim()) out.push({ text: raw.trim(), at: at + from + lead });
    from = to + 1;
  };
  for (let i = 0; i < text.length; i++) {
    if (text[i] === "(") depth++;
    else if (text[i] === ")") depth--;
    else if (text[i] === "," && depth <= 0) end(i);
  }
  end(text.length);
  return out;
}

// "name = value" -> [name, value or null, place of the value]
function assignment(piece) {
  const at = piece.text.indexOf("=");
  if (at < 0) return [piece.text, null, piece.at];
  const value = piece.text.slice(at + 1);
  return [piece.text.slice(0, at).trim(), value.trim(), piece.at + at + 1 + value.length - value.trimStart().length];
}

const number = text => /^[+-]?\d+$/.test(text) && text.length < 15 ? Number(text) : text;

// {request, at: pointer -> [start, end)} of a text.
export function read(text) {
  const at = new Map(), equations = [], parameters = {}, initial = {}, outputs = [], hold = [];
  const system = { form: "equations" }, trajectory = {}, request = { system };
  let listed = null, moves = false;
  const put = (pointer, place, length) => at.set(pointer, [place, place + length]);
  const words = {
    name: (rest, place) => { system.name = rest.trim(); put("/system/name", place, rest.length); },
    let: (rest, place) => pieces(rest, place).forEach(p => {
      const [key, value, from] = assignment(p);
      parameters[key] = value === null ? null : number(value);
      put("/system/parameters/" + escape(key), from, (value ?? key).length);
    }),
    start: (rest, place) => pieces(rest, place).forEach(p => {
      const [key, value, from] = assignment(p);
      initial[key] = number(value ?? "");
      put("/trajectory/initial/" + escape(key), from, (value || key).length);
      moves = true;
    }),
    hold: (rest, place) => pieces(rest, place).forEach(p => { put("/trajectory/hold/" + hold.length, p.at, p.text.length); hold.push(p.text); }),
    output: (rest, place) => pieces(rest, place).forEach(p => { put("/trajectory/outputs/" + outputs.length, p.at, p.text.length); outputs.push(p.text); }),
    want: (rest, place) => { request.want = pieces(rest, place).map((p, i) => (put("/want/" + i, p.at, p.text.length), p.text)); },
    variables: (rest, place) => { listed = pieces(rest, place); },
    tolerance: (rest, place) => { request.accuracy = { rtol: number(rest.trim()) }; put("/accuracy/rtol", place, rest.length); },
    from: (rest, place) => {
      const m = /^(\s*)(.*?)(\s+to\s+)(.*?)(?:,\s*(\S+)\s+samples?)?\s*$/.exec(rest);
      moves = true;
      put("/trajectory", place, rest.length);
      trajectory.start = number(m ? m[2] : rest.trim());
      put("/trajectory/start", place + (m ? m[1].length : 0), m ? m[2].length : rest.length);
      if (m) {
        trajectory.stop = number(m[4]);
        put("/trajectory/stop", place + m[1].length + m[2].length + m[3].length, m[4].length);
        if (m[5]) trajectory.samples = number(m[5]), put("/trajectory/samples", place + rest.lastIndexOf(m[5]), m[5].length);
      }
    },
  };
  let place = 0;
  for (const line of text.split("\n")) {
    const code = line.replace(/#.*/, ""), word = KEYWORDS.exec(code);
    if (word) words[word[1]](code.slice(word[0].length), place + word[0].length);
    else if (code.trim()) {
      const lead = code.length - code.trimStart().length;
      put("/system/equations/" + equations.length, place + lead, code.trim().length);
      equations.push(code.trim());
    }
    place += line.length + 1;
  }
  const names = listed ? listed.map(p => [p.text, p.at]) : appearing(equations, at, parameters);
  system.variables = names.map(([name], i) => (put("/system/variables/" + i, names[i][1], name.length), name));
  system.equations = equations;
  if (Object.keys(parameters).length) system.parameters = parameters;
  put("/system", 0, 0);
  if (moves) request.trajectory = trajectory;
  if (Object.keys(initial).length) trajectory.initial = initial;
  if (hold.length) trajectory.hold = hold;
  if (outputs.length) trajectory.outputs = outputs;
  return { request, at };
}

// Names of the equations that are nothing else, in the order in which they appear.
function appearing(equations, at, parameters) {
  const seen = new Map();
  equations.forEach((text, i) => {
    for (const m of text.matchAll(/[A-Za-z_]\w*/g)) {
      const digits = /[\d.]$/.test(text.slice(0, m.index)) && /^e\d*$/i.test(m[0]);
      if (!digits && m[0] !== "t" && !FUNCTIONS.has(m[0]) && !(m[0] in parameters) && !seen.has(m[0]))
        seen.set(m[0], at.get("/system/equations/" + i)[0] + m.index);
    }
  });
  return [...seen];
}

const only = (object, keys) => Object.keys(object).every(k => keys.includes(k));
const simple = v => v === null || typeof v === "string" || typeof v === "number";
const list = v => Array.isArray(v) ? v : [v];

// The lines of a request, or null where lines cannot say all of it.
export function write(request) {
  const s = request?.system, t = request?.trajectory, a = request?.accuracy;
  if (!s || s.form !== "equations" || !only(request, ["system", "trajectory", "want", "accuracy"]) || !only(s, ["name", "form", "variables", "parameters", "equations"])) return null;
  if (t && (!only(t, ["start", "stop", "samples", "initial", "hold", "outputs"]) || t.stop === undefined)) return null;
  if (a && !only(a, ["rtol"])) return null;
  const equations = list(s.equations ?? []), parameters = Object.entries(s.parameters ?? {}), initial = Object.entries(t?.initial ?? {});
  if (![...equations, ...list(s.variables ?? [])].every(e => typeof e === "string" && !/[#\n]/.test(e) && !KEYWORDS.test(e)) || ![...parameters, ...initial].every(([, v]) => simple(v))) return null;
  const pairs = (word, entries) => entries.length ? [`${word} ${entries.map(([k, v]) => v === null ? k : `${k} = ${v}`).join(", ")}`] : [];
  const lines = [...(s.name ? ["name " + s.name.replace(/[#\n]/g, " ")] : []), ...equations, ...pairs("let", parameters), ...pairs("start", initial)];
  if (t?.hold?.length) lines.push("hold " + list(t.hold).join(", "));
  if (t?.outputs?.length) lines.push("output " + list(t.outputs).join(", "));
  if (t) lines.push(`from ${t.start ?? 0} to ${t.stop}${t.samples ? `, ${t.samples} samples` : ""}`);
  if (a) lines.push("tolerance " + a.rtol);
  if (request.want) lines.push("want " + list(request.want).join(", "));
  if (read(lines.join("\n")).request.system.variables.join() !== list(s.variables ?? []).join()) lines.splice(s.name ? 1 : 0, 0, "variables " + list(s.variables ?? []).join(", "));
  return lines.join("\n") + "\n";
}
