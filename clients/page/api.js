// The service: requests with a token where one is needed, problems as errors, the stream of a job's progress.
import { $ } from "./dom.js";

const KEY = "sgad token";      // in sessionStorage: it ends with the tab

export class Problem extends Error {
  constructor(problem, status) {
    super(problem.detail || problem.title || `status ${status}`);
    this.problem = problem;
    this.status = status;
  }
}

// Asks the user for a token, once for all who wait for it. False: none was given.
let asking = null;
function askToken() {
  const dialog = $("token"), field = $("tokentext");
  asking ??= new Promise(done => {
    dialog.returnValue = "";
    field.value = "";
    dialog.showModal();
    dialog.addEventListener("close", () => {
      asking = null;
      const given = dialog.returnValue === "ok" && field.value.trim();
      if (given) sessionStorage.setItem(KEY, given);
      done(Boolean(given));
    }, { once: true });
  });
  return asking;
}

// A response of status 2xx; otherwise a Problem is thrown. 401 asks for a token, unless `quiet`.
export async function ask(path, { method = "GET", body, headers = {}, signal, quiet } = {}) {
  for (;;) {
    const token = sessionStorage.getItem(KEY), all = { ...headers };
    if (token) all.Authorization = "Bearer " + token;
    if (body !== undefined) all["Content-Type"] = "application/json";
    const r = await fetch(path, { method, body, headers: all, signal, cache: "no-store" });
    if (r.ok) return r;
    if (r.status === 401 && !quiet && await askToken()) continue;
    let problem = {};
    try { problem = await r.json(); } catch { /* no problem details: the status has to do */ }
    throw new Problem(problem, r.status);
  }
}

export const json = async (path, options) => (await ask(path, options)).json();

// One event of a stream: {event, data}.
function parse(block) {
  const out = { event: "message", data: "" };
  for (const line of block.split("\n")) {
    const at = line.indexOf(":");
    if (at > 0) out[line.slice(0, at)] = line.slice(at + 1).trimStart();
  }
  return out;
}

// Follows a job to its end. EventSource cannot send a token, so the stream is read as a response. Where there is no stream to be had, the
// job is asked for, which waits.
export async function follow(id, progress, signal) {
  for (;;) {
    try {
      const r = await ask(`/v1/jobs/${id}/events`, { signal, headers: { Accept: "text/event-stream" } });
      const reader = r.body.pipeThrough(new TextDecoderStream()).getReader();
      let rest = "";
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        const blocks = (rest + value).split("\n\n");
        rest = blocks.pop();
        for (const e of blocks.map(parse)) {
          if (e.event === "end") return;
          if (e.event === "progress") progress(JSON.parse(e.data).progress);
        }
      }
    } catch (e) {
      if (!(e instanceof Problem) || (e.status !== 429 && e.status !== 503)) throw e;
      const job = await json(`/v1/jobs/${id}`, { signal, headers: { Prefer: "wait=20" } });
      if (job.status !== "queued" && job.status !== "running") return;
      progress(job.progress);
    }
  }
}
