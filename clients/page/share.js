// The same request elsewhere: links, and texts for a shell, Python and Octave.
import { pretty } from "./dom.js";

const PART = 8000;      // bytes of a link that mail and chat programs pass on

async function through(stream, bytes) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function pack(text) {
  const bytes = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(text));
  return btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

export async function unpack(part) {
  const bytes = Uint8Array.from(atob(part.replaceAll("-", "+").replaceAll("_", "/")), c => c.charCodeAt(0));
  return new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes));
}

// The link of a job, or of a request that was not run; null where it would be too long.
export async function link(id, text) {
  const base = location.href.split("#")[0];
  if (id) return `${base}#/job/${id}`;
  if (text.length > 50 * PART) return null;
  const part = await pack(text);
  return part.length < PART ? `${base}#/new?r=${part}` : null;
}

export function snippets(request, token) {
  const text = pretty(request), at = location.origin;
  const words = { null: "None", true: "True", false: "False" }, python = text.replace(/"(?:[^"\\]|\\.)*"|\b(?:null|true|false)\b/g, t => words[t] ?? t);      // not inside texts
  return {
    curl: `curl -s -H 'Content-Type: application/json'${token ? ' -H "Authorization: Bearer $TOKEN"' : ""} --data @- ${at}/v1/solve <<'END'\n${text}\nEND\n`,
    Python: `import sga\n\nclient = sga.Client("${at}"${token ? ", token=TOKEN" : ""})\nresult = client.solve(${python})\nprint(result.verdict)\n`,
    Octave: `request = tempname();\nf = fopen(request, "w");\nfputs(f, strjoin({${text.split("\n").map(l => `'${l.replaceAll("'", "''")}'`).join(", ...\n  ")}}, "\\n"));\nfclose(f);\n[status, text] = system(["curl -s -H 'Content-Type: application/json'${token ? ' -H \\"Authorization: Bearer $TOKEN\\"' : ""} --data @" request " ${at}/v1/solve"]);\njob = jsondecode(text);\ndisp(job.result.verdict)\n`,
  };
}
