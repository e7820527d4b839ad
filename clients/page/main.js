// The page: an editor whose text is checked while it is typed, a job, and its answer. It holds nothing that the service does not have.
import { $, h, pretty, replace } from "./dom.js";
import { Problem, ask, follow, json } from "./api.js";
import { Editor } from "./editor.js";
import { EXAMPLES } from "./examples.js";
import * as plain from "./plain.js";
import { places, range } from "./places.js";
import * as views from "./answer.js";
import { accuracy, motion } from "./plots.js";
import { charts } from "./charts.js";
import { link, snippets, unpack } from "./share.js";
import { list } from "./jobs.js";

const CHECK_MS = 300;
const TABS = ["Answer", "Derivation", "Strata", "Symmetries", "Plots", "Accuracy", "Raw"];
const state = { job: null, request: null, running: null, plots: [], derivation: null, checked: null, opened: null };
const editor = new Editor($("editor"), () => { location.hash && history.replaceState(null, "", location.pathname); later(); });

// -- The request --

const mode = () => editor.mode;

// What the text says: {text: the body, at: pointer -> place in the editor's text, request or null}.
function current() {
  const text = editor.text;
  if (mode() === "plain") {
    const { request, at } = plain.read(text);
    return { text: JSON.stringify(request), at, request };
  }
  try { return { text, at: places(text), request: JSON.parse(text) }; } catch { return { text, at: places(text), request: null }; }
}

function lines(request) {
  const radio = document.querySelector("input[name=mode][value=plain]"), possible = request ? Boolean(plain.write(request)) : !/^\s*[{[]/.test(editor.text);
  radio.disabled = mode() === "json" && !possible;
  radio.title = radio.disabled ? "This request says more than lines of equations can" : "";
}

function setMode(to) {
  document.querySelector(`input[name=mode][value=${to}]`).checked = true;
  $("help").hidden = to !== "plain";
}

function show(request, as) {
  const text = as === "plain" ? plain.write(request) : null;
  editor.set(text ?? pretty(request), text ? "plain" : "json");
  setMode(mode());
  $("name").value = request.system?.name ?? "";
  lines(request);
  check();
}

function change(to) {
  const { request } = current();
  if (to === mode()) return;
  if (!request && to === "plain" && !/^\s*[{[]/.test(editor.text)) {      // no JSON was begun: the lines stand as they are
    editor.set(editor.text, "plain");
    setMode("plain");
    return check();
  }
  if (!request) {
    setMode(mode());
    return said("This is no JSON yet: it cannot be written as equations.", "wrong");
  }
  show(request, to);
}

// The name goes into the text, where it is part of the request.
function rename(name) {
  const { request } = current();
  if (!request?.system) return;
  request.system.name = name || undefined;
  show(request, mode());
}

function said(text, kind = "") {
  $("said").textContent = text;
  $("said").className = kind;
}

// -- Live checking --

let timer = null, asked = null;
function later() {
  clearTimeout(timer);
  timer = setTimeout(check, CHECK_MS);
}

async function check() {
  clearTimeout(timer);
  const { text, at, request } = current(), source = editor.text;
  asked?.abort();
  asked = new AbortController();
  lines(request);
  if (!source.trim()) { replace($("problems")); return said("Type equations, or choose an example."); }
  try {
    const review = await json("/v1/check", { method: "POST", body: text, signal: asked.signal });
    if (editor.text === source) reviewed(review, source, at);
  } catch (e) {
    if (e.name !== "AbortError") said(e instanceof Problem ? e.message : "The service cannot be reached.", "wrong");
  }
}

function reviewed(review, source, at) {
  const ranges = review.problems.map(p => range(source, at, p)), n = review.problems.length;
  state.checked = review;
  editor.mark(ranges);
  const counts = review.equations === null ? "" : `, ${review.equations} equation${review.equations === 1 ? "" : "s"}, ${review.unknowns} unknown${review.unknowns === 1 ? "" : "s"}`;
  said(n ? `${n} problem${n === 1 ? "" : "s"}` : `Ready: form ${review.form}${counts}`, n ? "wrong" : "fine");
  const line = place => source.slice(0, place[0]).split("\n").length;
  replace($("problems"), review.problems.map((p, i) => h("li", {}, h("button", { onclick: () => editor.select(...ranges[i]) }, ranges[i][1] ? `Line ${line(ranges[i])}: ` : "", p.detail))),
    review.warnings.map(w => h("li", { class: "warning" }, h("button", { onclick: () => { const r = at.get(w.pointer); if (r) editor.select(...r); } }, "⚠ ", w.detail))));
}

// -- Running --

function progress(p) {
  if (!p) return replace($("progress"));
  const t = p.t === undefined ? "" : ` t = ${Number(p.t.toPrecision(4))}`;
  replace($("progress"), h("progress", { max: 1, value: p.fraction ?? 0, "aria-label": "Progress" }), h("span", {}, (p.stage ?? "") + t));
}

function busy(controller) {
  state.running = controller;
  $("run").disabled = Boolean(controller);
  $("cancel").hidden = !controller;
  if (!controller) progress(null);
}

// Runs what the editor has; again: the request of the answer that is shown, with members more, {opened: a stratum} in mind for its tree.
async function run(again) {
  if (state.running) return;
  const { text } = current();
  const controller = new AbortController();
  busy(controller);
  progress({ stage: "sending", fraction: 0 });
  try {
    const body = again ? JSON.stringify({ ...state.request, ...again.more }) : text;
    const job = await json("/v1/jobs", { method: "POST", body, signal: controller.signal });
    state.id = job.id;
    state.opened = again?.opened;
    await finish(job, controller.signal);
    history.replaceState(null, "", "#/job/" + job.id);
    state.request = JSON.parse(body);
  } catch (e) { failed(e); }
  busy(null);
  if ($("drawer").open) reload();
}

async function finish(job, signal) {
  if (job.status === "queued" || job.status === "running") {
    progress(job.progress);
    await follow(job.id, progress, signal);
    job = await json("/v1/jobs/" + job.id, { signal });
  }
  try { state.request = await json(`/v1/jobs/${job.id}/request`, { signal }); } catch { state.request = job.request ?? null; }
  draw(job);
}

async function cancel() {
  const id = state.id;
  if (id) try { await ask("/v1/jobs/" + id, { method: "DELETE" }); } catch (e) { failed(e); }
}

function failed(e) {
  if (e.name === "AbortError") return;
  said(e instanceof Problem ? e.message : "The service cannot be reached: " + e.message, "wrong");
  if (e instanceof Problem && e.problem.code) draw({ status: "failed", error: e.problem });
}

// -- The answer --

function problem(job) {
  const e = job.error ?? { detail: `The job was ${job.status}.` };
  return [h("div", { class: "card" }, h("div", { class: "verdict error" }, e.title ?? job.status), h("p", {}, e.detail ?? ""),
    h("dl", { class: "facts" }, [["code", e.code], ["stage", e.stage], ["at", e.pointer], ["column", e.column]].filter(([, v]) => v).map(([k, v]) => [h("dt", {}, k), h("dd", {}, String(v))]),
      e.code ? [h("dt", {}, "cause and cure"), cure(e.code)] : null))];
}

// What the service's own description says of a code: it stands where `type` leads.
let codes = null;
function cure(code) {
  const place = h("dd", {}, "…");
  codes ??= json("/v1/schema/problem");
  codes.then(s => replace(place, (s.$defs?.[code]?.description ?? "not described").replace(/^Status \d+\. /, "")), () => { codes = null; replace(place, "cannot be read now"); });
  return place;
}

function plots(result) {
  const name = result.name, many = result.trajectories, more = charts(result);
  if (!many && !result.trajectory) return more.length ? more : [h("p", { class: "empty" }, "The request has no motion: add “from 0 to 10” and “start …”, or a “trajectory” in JSON.")];
  const one = t => { const p = motion(t, name); state.plots = [p]; return p.elements; };
  if (!many) return [one(result.trajectory), more];
  const box = h("div", {}), draws = k => { replace(box, many[k].rows ? one(many[k]) : h("p", { class: "error" }, many[k].error?.detail ?? many[k].problem?.detail ?? "no motion")); state.plots.forEach(p => p.draw()); };
  queueMicrotask(() => draws(0));
  return [h("label", {}, "Set ", h("select", { onchange: e => draws(Number(e.target.value)) }, many.map((_, i) => h("option", { value: String(i) }, String(i + 1))))), box, more];
}

function raw(job) {
  const text = JSON.stringify(job, null, 2);
  return [h("div", { class: "bar" }, h("button", { onclick: () => navigator.clipboard.writeText(text) }, "Copy"), job.id ? h("a", { href: "/v1/jobs/" + job.id }, "as the service gives it") : null), h("pre", { class: "raw", tabindex: "0" }, text.length > 400000 ? text.slice(0, 400000) + "\n… (cut: the service gives all)" : text)];
}

function draw(job) {
  state.job = job;
  state.plots = [];
  state.derivation = null;
  const r = job.result, none = () => problem(job);
  const make = {
    Answer: () => r ? views.answer(job) : none(), Derivation: () => { if (!r) return none(); const d = views.derivation(job, state.request); state.derivation = d[0]; return d; },
    Strata: () => r ? views.strata(job, opened => run({ more: { strata: "solve" }, opened }), state.opened) : none(), Symmetries: () => r ? views.symmetries(job) : none(), Plots: () => r ? plots(r) : none(), Accuracy: () => r ? accuracy(r) : none(), Raw: () => raw(job),
  };
  for (const name of TABS) replace(panel(name), make[name]());
  choose(!r ? "Answer" : selected());
}

const panel = name => $("panel-" + name);
const selected = () => TABS.find(n => $("tab-" + n).getAttribute("aria-selected") === "true");

function choose(name, focus) {
  for (const n of TABS) {
    $("tab-" + n).setAttribute("aria-selected", String(n === name));
    $("tab-" + n).tabIndex = n === name ? 0 : -1;
    panel(n).hidden = n !== name;
  }
  if (focus) $("tab-" + name).focus();
  if (name === "Plots") state.plots.forEach(p => p.draw());
}

function tabs() {
  replace($("tabs"), TABS.map(n => h("button", { id: "tab-" + n, role: "tab", "aria-controls": "panel-" + n, onclick: () => choose(n) }, n)));
  replace($("panels"), TABS.map(n => h("div", { id: "panel-" + n, role: "tabpanel", "aria-labelledby": "tab-" + n, tabindex: "0" }, h("p", { class: "empty" }, "Choose an example or type equations, then Run (Ctrl+Enter)."))));
  $("tabs").addEventListener("keydown", e => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
    if (by) choose(TABS[(TABS.indexOf(selected()) + by + TABS.length) % TABS.length], true);
  });
  choose("Answer");
}

// -- Links, theme, dialogs --

async function open() {
  const [, kind, id] = /^#\/(job|new)(?:\/|\?r=)(.+)$/.exec(location.hash) ?? [];
  if (kind === "new") try { show(JSON.parse(await unpack(id)), "plain"); } catch { said("The link is damaged.", "wrong"); }
  if (kind !== "job") return;
  const controller = new AbortController();
  busy(controller);
  state.id = id;
  state.opened = null;
  try {
    const job = await json("/v1/jobs/" + encodeURIComponent(id), { signal: controller.signal });
    await finish(job, controller.signal);
    if (state.request) show(state.request, "plain");
  } catch (e) { failed(e); }
  busy(null);
}

async function copyLink() {
  const { request, text } = current(), made = location.hash.startsWith("#/job/");
  const url = await link(made ? state.id : null, request ? JSON.stringify(request) : text);
  if (!url) return said("The request is too long for a link: run it, then its job has one.", "wrong");
  if (!made) history.replaceState(null, "", url);
  try { await navigator.clipboard.writeText(url); said("The link is copied."); } catch { said(url); }
}

function copyAs() {
  const { request } = current();
  if (!request) return said("This is no JSON yet.", "wrong");
  const all = snippets(request, Boolean(sessionStorage.getItem("sgad token"))), pick = name => { $("snippet").textContent = all[name]; [...$("languages").children].forEach(b => b.setAttribute("aria-pressed", String(b.textContent === name))); };
  replace($("languages"), Object.keys(all).map(name => h("button", { type: "button", onclick: () => pick(name) }, name)));
  pick("curl");
  $("snippets").showModal();
}

function theme(to) {
  if (to) document.documentElement.dataset.theme = to;
  else delete document.documentElement.dataset.theme;
  if (selected() === "Plots") state.plots.forEach(p => p.draw());
}

const reload = () => list(null, failed);

function wire() {
  $("helptext").textContent = plain.HELP;
  $("run").addEventListener("click", () => run());
  $("cancel").addEventListener("click", cancel);
  $("copy").addEventListener("click", copyAs);
  $("copysnippet").addEventListener("click", () => navigator.clipboard.writeText($("snippet").textContent));
  $("link").addEventListener("click", copyLink);
  $("name").addEventListener("change", e => rename(e.target.value.trim()));
  $("present").addEventListener("click", e => { const on = document.body.classList.toggle("presenting"); e.target.setAttribute("aria-pressed", String(on)); if (selected() === "Plots") state.plots.forEach(p => p.draw()); });
  $("theme").addEventListener("click", () => { const dark = getComputedStyle(document.body).colorScheme.includes("dark") && !getComputedStyle(document.body).colorScheme.includes("light") || (!document.documentElement.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches); const to = dark ? "light" : "dark"; sessionStorage.setItem("sgad theme", to); theme(to); });
  document.querySelectorAll("input[name=mode]").forEach(r => r.addEventListener("change", () => change(r.value)));
  $("examples").append(...EXAMPLES.map(([file, title]) => h("option", { value: file }, title)));
  $("examples").addEventListener("change", async e => { if (e.target.value === "new") { editor.set("", "plain"); setMode("plain"); $("name").value = ""; check(); history.replaceState(null, "", location.pathname); } else if (e.target.value) try { show(await json(`/page/${e.target.value}.json`), "plain"); history.replaceState(null, "", location.pathname); } catch (x) { failed(x); } });
  $("drawer").addEventListener("toggle", () => $("drawer").open && reload());
  $("reload").addEventListener("click", reload);
  $("status").addEventListener("change", reload);
  addEventListener("hashchange", open);
  let resized = null;
  addEventListener("resize", () => { clearTimeout(resized); resized = setTimeout(() => selected() === "Plots" && state.plots.forEach(p => p.draw()), 150); });
  addEventListener("keydown", e => {
    if ((e.ctrlKey || e.metaKey) && e.key === "Enter") { e.preventDefault(); run(); }
    const typing = /^(INPUT|TEXTAREA|SELECT)$/.test(document.activeElement?.tagName) || e.ctrlKey || e.metaKey || e.altKey;
    if (!typing && selected() === "Derivation" && (e.key === "n" || e.key === "p")) state.derivation?.step(e.key === "n" ? 1 : -1);
  });
}

tabs();
wire();
theme(sessionStorage.getItem("sgad theme"));
editor.draw();
said("Type equations, or choose an example.");
open();
