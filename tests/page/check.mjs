// The page in a browser, against a daemon: check.mjs URL TOKEN_URL TOKEN NODE_FOLDER PICTURES
// Every check is counted; the last line is "N passed, N failed".
import { spawnSync } from "node:child_process";
import { createRequire } from "node:module";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [url, guarded, token, modules, pictures] = process.argv.slice(2);
const require = createRequire(join(modules, "/"));
const { chromium } = require("playwright-core");
const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const here = dirname(fileURLToPath(import.meta.url));
let passed = 0, failed = 0;
mkdirSync(pictures, { recursive: true });

function check(ok, label, detail = "") {
  if (ok) passed++;
  else { failed++; console.log(`FAILED ${label}: ${typeof detail === "string" ? detail : JSON.stringify(detail)}`.slice(0, 1500)); }
}

// A page of its own, with what it must not do written down: errors, what the policy stops, requests to other hosts.
async function open(browser, at, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1360, height: 850 }, ...options });
  await context.addInitScript(() => addEventListener("securitypolicyviolation", e => console.error("policy:", e.violatedDirective, e.blockedURI)));
  const page = await context.newPage(), log = [], host = new URL(at).origin;
  page.on("pageerror", e => log.push("error: " + e.message));
  page.on("console", m => { if (m.type() === "error" && !/status of 4\d\d/.test(m.text())) log.push("console: " + m.text()); });
  page.on("request", r => { if (!/^(data|blob):/.test(r.url()) && new URL(r.url()).origin !== host) log.push("another host: " + r.url()); });
  await page.goto(at);
  return { page, log, context };
}

// axe runs in the page as a debugger does: the page's own policy stays in force.
async function accessible(page, label) {
  await page.evaluate(AXE);
  const found = await page.evaluate(async () => (await axe.run(document, { resultTypes: ["violations"] })).violations.map(v => `${v.id}: ${v.nodes.slice(0, 3).map(n => n.html.slice(0, 120)).join(" | ")}`));
  check(found.length === 0, `${label}: axe-core has no findings`, found);
}

async function choose(page, example) {
  await page.selectOption("#examples", example);
  await page.waitForSelector("#said.fine");
}

async function run(page) {
  await page.click("#run");
  await page.waitForFunction(() => document.querySelector("#run").disabled === false && location.hash.startsWith("#/job/"));
  await page.waitForSelector("#panel-Answer .verdict", { state: "attached" });
}

const tab = (page, name) => page.click("#tab-" + name);
const text = (page, selector) => page.textContent(selector);

async function examples(browser) {
  const { page, log } = await open(browser, url);
  const names = await page.$$eval("#examples option", all => all.map(o => o.value).filter(v => v && v !== "new"));
  check(names.length >= 8, "there are examples", names);
  for (const name of names) {
    const request = await page.evaluate(n => fetch(`/page/${n}.json`).then(r => r.json()), name);
    await choose(page, name);
    await page.click("input[value=json] + span");
    const typed = JSON.parse(await page.inputValue("textarea"));
    check(request.system.form === "equations" && request.trajectory ? typed.system.equations.join() === request.system.equations.join() : JSON.stringify(typed) === JSON.stringify(request), `${name}: the editor has the example`, typed);
    await page.waitForSelector("#said.fine");
    await run(page);
    const shown = JSON.parse(await text(page, "#panel-Raw pre")), posted = await page.evaluate(id => fetch(`/v1/jobs/${id}/request`).then(r => r.json()), shown.id);
    check(shown.status === "done" && shown.result.verdict === await text(page, "#panel-Answer .verdict"), `${name}: the verdict is shown`, shown.error);
    check(posted.system.name === request.system.name && (request.system.form !== "equations" || JSON.stringify(posted.system.equations) === JSON.stringify(request.system.equations)), `${name}: what was posted is the example`, posted);
    check((await page.$$("#panel-Answer math")).length >= 2, `${name}: formulas`);
    check((await page.$$("#panel-Answer code")).length === 0, `${name}: every expression could be set`, await page.$$eval("#panel-Answer code", all => all.map(c => c.textContent)));
    const dimensions = shown.result.dimensions;
    check((await text(page, "#panel-Answer dl")).includes([dimensions.ambient, ...dimensions.generations].join(" → ")), `${name}: dimensions`);
    await tab(page, "Derivation");
    if (shown.result.constraints) check((await page.$$("#panel-Derivation .card")).length === new Set(shown.result.constraints.map(c => c.generation)).size + 2, `${name}: a card for each generation`);
    await tab(page, "Plots");
    if (request.trajectory) {
      await page.waitForSelector("#panel-Plots .u-over");
      const ink = await page.$eval("#panel-Plots canvas", c => { const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n; });
      check(ink > 2000, `${name}: curves are drawn`, ink);
      check(await text(page, "#panel-Plots summary").then(t => t.includes(`(${shown.result.trajectory.rows.length} rows)`)), `${name}: the table beside them`);
    } else check((await text(page, "#panel-Plots")).includes("no motion"), `${name}: there is no motion, and that is said`);
    await tab(page, "Answer");
  }
  check(log.length === 0, "examples: no errors, nothing stopped by the policy, one host", log);
  await page.context().close();
}

async function marks(browser) {
  const { page, log } = await open(browser, url);
  await page.fill("textarea", "x' = 3*y + 2)\ny' = lambda*x\nlet lam = 1*\nstart x = 1, y = -+\nfrom 0 to 1");
  await page.waitForSelector(".bad");
  const marked = await page.$$eval("#editor .bad", all => all.map(b => b.textContent));
  check(marked[0] === ")" && marked.slice(1).join() === "*,+", "the wrong columns alone are marked", marked);
  const lines = await page.$$eval("#problems button", all => all.map(b => b.textContent));
  check(lines.length >= 2 && lines.some(l => l.startsWith("Line 1:")) && lines.some(l => l.startsWith("Line 3:")), "problems name their lines", lines);
  await page.click("#problems li:nth-child(2) button");
  const at = await page.$eval("textarea", t => t.value.slice(t.selectionStart, t.selectionEnd));
  check(at !== "" && marked.includes(at), "a problem leads to its place", at);
  check(await page.getAttribute("textarea", "aria-invalid") === "true" && /problem/.test(await text(page, "#said")), "it is said to all");
  await page.fill("textarea", "x' = 3*y\ny' = lambda*x\nlet lam = 1\nstart x = 1");
  await page.waitForSelector("#said.wrong");
  await page.fill("textarea", "x' = 3*y\ny' = -x\nlet k = 1");
  await page.waitForSelector("#said.fine");
  check((await text(page, "#problems")).includes("k is used nowhere"), "warnings are shown", await text(page, "#problems"));
  await page.click("input[value=json] + span");
  const broken = (await page.inputValue("textarea")).replace("3*y", "3*\\u0079 +* 1");
  await page.fill("textarea", broken);
  await page.waitForSelector(".bad");
  check((await text(page, ".bad")) === "*", "in JSON, behind an escape too", await text(page, ".bad"));
  await page.fill("textarea", '{"system": {"form": "equations",\n "variables": ["x"] "equations": []}}');
  await page.waitForSelector("#editor .gutter b");
  check((await text(page, "#editor .gutter b")).endsWith("2"), "JSON that is none: its line is marked");
  check(log.length === 0, "marks: no errors", log);
  await page.context().close();
}

async function ways(browser) {
  const { page, log } = await open(browser, url);
  await choose(page, "pendulum");
  const plain = await page.inputValue("textarea");
  await page.click("input[value=json] + span");
  const json = JSON.parse(await page.inputValue("textarea"));
  await page.click("input[value=plain] + span");
  check(await page.inputValue("textarea") === plain && json.system.variables.join() === "x,y,lambda", "lines to JSON and back are the same lines", json);
  await page.focus("textarea");
  await page.keyboard.press("Control+Enter");
  await page.waitForFunction(() => location.hash.startsWith("#/job/"));
  await page.focus("#tab-Answer");
  await page.keyboard.press("ArrowRight");
  check(await page.getAttribute("#tab-Derivation", "aria-selected") === "true", "tabs by arrow keys");
  await page.click("text=From the start");
  await page.focus("#tab-Derivation");
  await page.keyboard.press("n");
  check((await page.$$eval("#panel-Derivation .card", all => all.filter(c => c.offsetParent).length)) === 2, "n shows one generation more");
  await page.keyboard.press("p");
  check((await page.$$eval("#panel-Derivation .card", all => all.filter(c => c.offsetParent).length)) === 1, "p takes it away");
  await page.click("#present");
  check(!await page.isVisible("textarea"), "present hides the editor");
  await page.click("#present");
  const link = page.url(), other = await open(browser, link);
  await other.page.waitForSelector("#panel-Answer .verdict");
  const sorted = t => t.split(/[\n,]|let |start /).map(s => s.trim()).filter(Boolean).sort().join("\n");      // members are sorted in what the service keeps
  check(sorted(await other.page.inputValue("textarea")) === sorted(plain), "a link opens the request and its answer", await other.page.inputValue("textarea"));
  await other.page.context().close();
  await page.fill("textarea", "x' = -x\n");
  await page.waitForSelector("#said.fine");
  await page.click("#link");
  await page.waitForFunction(() => location.hash.startsWith("#/new"));
  const fresh = await open(browser, page.url());
  await fresh.page.waitForFunction(() => document.querySelector("textarea").value !== "");
  check(await fresh.page.inputValue("textarea") === "x' = -x\n", "a link to a request that was not run");
  await fresh.page.context().close();
  await page.click("#copy");
  for (const name of ["curl", "Python", "Octave"]) {
    await page.click(`#languages >> text=${name}`);
    check((await text(page, "#snippet")).includes("x' = -x") || (await text(page, "#snippet")).includes("x'' = -x"), `copy as ${name}`);
  }
  await page.click("#snippets button.main");
  await page.click("#drawer > summary");
  await page.waitForSelector("#jobs a");
  check(/pendulum/.test(await text(page, "#jobs")), "jobs are listed by name", await text(page, "#jobs"));
  check(log.length === 0, "ways: no errors", log);
  await page.context().close();
}

// What is copied runs as it is, in a shell, Python and Octave, and asks for the very job of the page, whatever its texts have in them.
async function copied(browser) {
  const { page, log } = await open(browser, url);
  const request = { system: { name: "it's \"null\", true \\ 100 % of $HOME \u03c6", form: "equations", variables: ["x", "true_", "lam"], parameters: { k: null }, equations: ["x'' = -lam*x", "true_' = k*x", "x^2 + true_^2 = 1"] } };
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify(request));
  await page.waitForSelector("#said.fine");
  await run(page);
  const verdict = await text(page, "#panel-Answer .verdict"), jobs = () => page.evaluate(() => fetch("/v1/jobs?limit=500").then(r => r.json()).then(l => l.jobs.length)), before = await jobs();
  await page.click("#copy");
  const env = { ...process.env, no_proxy: "*", PYTHONPATH: join(here, "../../clients/python"), PYTHONDONTWRITEBYTECODE: "1" };
  for (const [name, ...command] of [["curl", "bash", "-c"], ["Python", "/usr/bin/python3", "-c"], ["Octave", "octave-cli", "--quiet", "--norc", "--eval"]]) {
    await page.click(`#languages >> text=${name}`);
    const ran = spawnSync(command[0], [...command.slice(1), await text(page, "#snippet")], { encoding: "utf8", env, timeout: 120000 });
    const said = name === "curl" ? JSON.parse(ran.stdout || "{}").result?.verdict : (ran.stdout ?? "").trim();
    check(ran.status === 0 && said === verdict && await jobs() === before, `what is copied for ${name} runs, and is the page's job`, [ran.status, ran.stdout?.slice(0, 300), ran.stderr?.slice(0, 500), await jobs() - before]);
  }
  await page.click("#snippets button.main");
  check(log.length === 0, "copied: no errors", log);
  await page.context().close();
}

// Everything by keys alone: an example chosen, run, its tabs, its plot.
async function keys(browser) {
  const { page, log } = await open(browser, url);
  const reach = async selector => {
    for (let k = 0; k < 60 && !await page.evaluate(s => document.activeElement?.matches(s), selector); k++) await page.keyboard.press("Tab");
    return page.evaluate(s => document.activeElement?.matches(s) && getComputedStyle(document.activeElement).outlineStyle !== "none" || document.activeElement?.matches(s + ":focus-visible"), selector);
  };
  check(await reach("#examples"), "keys: Tab reaches the examples, and is seen there");
  await page.keyboard.type("pendulum");
  await page.waitForSelector("#said.fine");
  check(await reach("#run"), "keys: and the button that runs");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector("#run").disabled === false && location.hash.startsWith("#/job/"));
  await page.waitForSelector("#panel-Answer .verdict", { state: "attached" });
  check(await reach("[role=tab][aria-selected=true]"), "keys: and the tabs");
  for (let k = 0; k < 8 && await page.getAttribute("#tab-Plots", "aria-selected") !== "true"; k++) await page.keyboard.press("ArrowRight");
  await page.waitForSelector("#panel-Plots .u-over");
  check(log.length === 0, "keys: no errors", log);
  await page.context().close();
}

// Symmetries of a system that is known: what was asked, what was found, and integrals.
async function symmetries(browser) {
  const { page, log } = await open(browser, url);
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify({ system: { form: "lagrangian", coordinates: ["x", "y"], lagrangian: "(x'^2 + y'^2)/2 - (x^2 + y^2)/2" }, want: ["constraints", "index", "vector_field", "gauge", "symmetries"],
    symmetries: { check: [{ name: "turn", field: { x: "-y", y: "x", "x'": "-y'", "y'": "x'" } }, { name: "push", field: { x: "1", y: "0", "x'": "0", "y'": "0" } }] } }));
  await run(page);
  await tab(page, "Symmetries");
  const shown = await text(page, "#panel-Symmetries"), { checked } = JSON.parse(await text(page, "#panel-Raw pre")).result.symmetries;
  check(checked[0].symmetry === true && checked[1].symmetry === false && /turn/.test(shown) && /push/.test(shown), "symmetries: what was asked is shown by its name", shown.slice(0, 600));
  check((await page.$$("#panel-Symmetries math, #panel-Symmetries table, #panel-Symmetries dl")).length > 0 && shown.length > 20, "symmetries: with formulas");
  check(log.length === 0, "symmetries: no errors", log);
  await page.context().close();
}

// The exports for people, in their tools: MathML drawn by this browser, LaTeX read by KaTeX, strictly.
async function exported(browser) {
  const { page, log } = await open(browser, url);
  const katex = require("katex");
  for (const example of ["pendulum", "arm", "turning"]) {
    await choose(page, example);
    await run(page);
    const id = JSON.parse(await text(page, "#panel-Raw pre")).id;
    const [latex, mathml] = await page.evaluate(id => Promise.all(["latex", "mathml"].map(l => fetch(`/v1/jobs/${id}/code?language=${l}`).then(r => r.text()))), id);
    const blocks = latex.replace(/^%.*$/gm, "").match(/\\begin\{align\*\}[^]*?\\end\{align\*\}/g) ?? [];
    const said = blocks.map(b => { try { katex.renderToString(b, { displayMode: true, strict: "error", throwOnError: true }); return ""; } catch (e) { return String(e.message).slice(0, 300); } }).join("");
    check(said === "" && blocks.length >= 2, `${example}: KaTeX reads the LaTeX`, said || latex.slice(0, 300));
    const drawn = await page.evaluate(xml => {
      const made = new DOMParser().parseFromString(xml, "application/xml"), root = made.documentElement;
      if (root.localName !== "math") return { wrong: root.textContent.slice(0, 200) };
      const at = document.body.appendChild(document.importNode(root, true)), box = at.getBoundingClientRect(), rows = [...at.querySelectorAll("mtr")].map(r => r.getBoundingClientRect());
      at.remove();
      return { height: box.height, width: box.width, rows: rows.length, apart: rows.every((r, i) => r.height > 5 && (i === 0 || r.top >= rows[i - 1].bottom - 1 || r.left !== rows[i - 1].left)) };
    }, mathml);
    check(drawn.rows >= 3 && drawn.height > 20 * drawn.rows / 2 && drawn.width > 50 && drawn.apart, `${example}: the browser draws the MathML`, drawn);
  }
  check(log.length === 0, "exported: no errors", log);
  await page.context().close();
}

const SLOW = `{"system": {"form": "equations", "variables": ["x"], "equations": ["x'' = -1001*x + (${Array.from({ length: 400 }, (_, k) => `sin(x + ${k})`).join(" + ")})*1e-15"]},
 "want": ["trajectory"], "trajectory": {"stop": 8000, "samples": 2, "initial": {"x": 1, "x'": 0}}, "limits": {"seconds": 120}}`;

// What the documents show is taken, and each line does what they say.
async function documented(browser) {
  const { page, log } = await open(browser, url);
  const shown = /```text\n([^]*?)```/.exec(readFileSync(join(import.meta.dirname ?? new URL(".", import.meta.url).pathname, "../../doc/page.md"), "utf8"))[1];
  await page.fill("textarea", shown);
  await page.waitForSelector("#said.fine");
  await run(page);
  const posted = await page.evaluate(id => fetch(`/v1/jobs/${id}/request`).then(r => r.json()), JSON.parse(await text(page, "#panel-Raw pre")).id);
  const should = { accuracy: { rtol: "1e-9" }, system: { equations: ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"], form: "equations", name: "pendulum", parameters: { L: "1/2", g: "9.81" }, variables: ["x", "lam", "y"] },
    trajectory: { hold: ["x"], initial: { x: "1/2", y: 0 }, outputs: ["x", "y", "x^2 + y^2"], samples: 201, start: 0, stop: 10 } };
  check(JSON.stringify(posted) === JSON.stringify(should), "the lines of doc/page.md are this request", posted);
  await tab(page, "Plots");
  await page.waitForSelector("#panel-Plots .u-over");
  check((await page.$$eval("#panel-Plots input[type=checkbox]", all => all.length)) === 3, "its outputs are the columns");
  check(log.length === 0, "documented: no errors", log);
  await page.context().close();
}

// Responses, eigenvalues and work-precision as pictures: numbers of a system that is known.
async function pictured(browser) {
  const { page, log } = await open(browser, url), points = d => d.split(/[ML]/).filter(Boolean).map(p => p.split(/[ h]/).map(Number));
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify({ system: { form: "descriptor", states: ["v", "i"], inputs: ["u"], outputs: ["vc", "ic"], E: [[1, 0], [0, 0]], A: [[0, 1], [-1, -1]], B: [[0], [1]], C: [[1, 0], [0, 1]] },
    want: ["transfer", "linearization"], transfer: { frequencies: { from: "1/100", to: 100, points: 41 } } }));
  await run(page);
  await tab(page, "Plots");
  const shown = () => page.$$eval("#panel-Plots figure", all => all.map(f => ({ title: f.textContent, drawn: f.querySelector("img").naturalWidth > 0, lines: [...new DOMParser().parseFromString(decodeURIComponent(f.querySelector("img").src.slice(19)), "image/svg+xml").querySelectorAll("path[fill=none]")].map(p => p.getAttribute("d")) })));
  const all = await shown();
  check(all.map(f => f.title.replace(" Save SVG", "")).join() === "Magnitude in dB,Phase in degrees,Poles and zeros,Eigenvalues" && all.every(f => f.drawn), "Bode, poles, eigenvalues are drawn", all.map(f => f.title));
  const [low, high] = all[0].lines.map(points), middle = low[20], ends = [low[0][1], high[40][1]];
  check(low.length === 41 && Math.abs(middle[1] - high[20][1]) < 0.1 && Math.abs(ends[0] - ends[1]) < 0.1 && middle[1] > ends[0], "Bode: both -3 dB at 1, 0 dB at the ends", [middle, ends]);
  const [first, second] = all[1].lines.map(points);
  check(first.every((p, i) => i === 0 || p[1] > first[i - 1][1]) && first.every((p, i) => Math.abs(p[1] - second[i][1] - (first[0][1] - second[0][1])) < 0.1), "Bode: phases fall, a quarter apart", first.slice(0, 3));
  check(all[2].lines.length === 1 && points(all[2].lines[0]).length === 1, "one pole, no zero", all[2].lines);
  await page.fill("textarea", JSON.stringify({ system: { form: "equations", variables: ["x"], equations: ["x' = -x"] }, want: ["tradeoff"], trajectory: { stop: 1, samples: 3, initial: { x: 1 } } }));
  await run(page);
  await tab(page, "Plots");
  const work = (await shown()).at(-1);
  check(/^Work and precision/.test(work?.title) && work.drawn && work.lines.length >= 2 && work.lines.some(l => points(l).length >= 3), "work and precision by method", work);
  await accessible(page, "pictures");
  check(log.length === 0, "pictured: no errors", log);
  await page.context().close();
}

// A stratum that was only listed is solved as it is opened, is open in the new answer, and can be opened again without a job more.
async function strata(browser) {
  const { page, log } = await open(browser, url);
  const jobs = () => page.evaluate(() => fetch("/v1/jobs?limit=500").then(r => r.json()).then(l => l.jobs.length)), nodes = () => page.$$eval("#panel-Strata details.node", all => all.map(d => ({ open: d.open, inside: d.parentElement.matches("details"), text: d.textContent })));
  await page.fill("textarea", "x*x' = y\ny' = -k*x*z\nx*z + y = 0\nlet k\nname strata of the page");
  await page.waitForSelector("#said.fine");
  await run(page);
  await tab(page, "Strata");
  const listed = await nodes(), before = await jobs();
  check(listed.length >= 1 && listed.every(n => !n.open && /being solved/.test(n.text)), "strata are listed, unsolved", listed);
  await page.fill("textarea", "x' = 5*x");                    // what is solved is the request of the answer, not what is typed by now
  await page.waitForSelector("#said.fine");
  const first = page.url();                                   // typing took the job's mark away from it
  await page.focus("#panel-Strata details.node > summary");
  await page.keyboard.press("Enter");
  await page.waitForFunction(at => document.querySelector("#run").disabled === false && location.href !== at, first);
  const solved = await nodes(), shown = JSON.parse(await text(page, "#panel-Raw pre")), [one] = shown.result.strata;
  check(await jobs() === before + 1 && shown.result.name === "strata of the page" && one.result?.verdict === "underdetermined", "opening one solves it", shown.result);
  check(solved[0].open && solved[0].text.includes(one.result.verdict) && /dimensions/.test(solved[0].text) && solved.slice(1).every(n => !n.open), "it is open in the new answer, with its verdict", solved);
  check(await page.getAttribute("#tab-Strata", "aria-selected") === "true", "its tab stays");
  await page.click("#panel-Strata details.node > summary");
  await page.click("#panel-Strata details.node > summary");
  check((await nodes())[0].open && await jobs() === before + 1 && await page.isEnabled("#run"), "closed and opened again it asks for nothing");
  // Strata inside a stratum, and every one at once by the button.
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify({ system: { form: "quasilinear", variables: ["x", "y", "z"], A: [["x", 0, 0], [0, "y", 0], [0, 0, 1]], alpha: ["y*z", "x", "1"] } }));
  await page.waitForSelector("#said.fine");
  await run(page);
  await tab(page, "Strata");
  const again = page.url();
  check((await nodes()).length >= 2, "two pivots are listed", await nodes());
  await page.click("text=Solve each of them");
  await page.waitForFunction(at => document.querySelector("#run").disabled === false && location.href !== at, again);
  const tree = JSON.parse(await text(page, "#panel-Raw pre")).result.strata, count = list => list.reduce((n, s) => n + 1 + count(s.result?.strata ?? []), 0);
  check((await nodes()).length === count(tree) && count(tree) > tree.length && (await nodes()).filter(n => n.inside).length === count(tree) - tree.length, "the tree has all of the answer's, inside each other", count(tree));
  check((await nodes()).every(n => !/being solved/.test(n.text)), "each is solved", await nodes());
  await accessible(page, "strata");
  check(log.length === 0, "strata: no errors", log);
  await page.context().close();
}

// Events of a motion are marked in its plots, at their times, in the picture that is saved too, and listed.
async function events(browser) {
  const { page, log } = await open(browser, url);
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify({ system: { form: "equations", variables: ["x"], equations: ["x'' = -x"] }, trajectory: { stop: 7, samples: 41, initial: { x: 1, "x'": 0 }, events: [{ name: "zero", expression: "x" }, { name: "turn", expression: "x'" }] } }));
  await run(page);
  await tab(page, "Plots");
  await page.waitForSelector("#panel-Plots .u-over");
  const times = JSON.parse(await text(page, "#panel-Raw pre")).result.trajectory.events.map(e => e.t);
  check(times.length === 4 && times.every((t, i) => Math.abs(t - (i + 1) * Math.PI / 2) < 1e-9), "the events of a cosine", times);
  // Painted pixels of a column of the plot, of the colour of the lines at events.
  const dashed = at => page.evaluate(share => {
    const over = document.querySelector("#panel-Plots .u-over").getBoundingClientRect(), canvas = document.querySelector("#panel-Plots canvas"), box = canvas.getBoundingClientRect(), scale = canvas.width / box.width;
    const soft = document.createElement("canvas").getContext("2d");
    soft.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--soft").trim();
    const of = soft.fillStyle.match(/[0-9a-f]{2}/g).map(v => parseInt(v, 16)), x = Math.round((over.left + share * over.width - box.left) * scale), y = Math.round((over.top - box.top) * scale);
    const d = canvas.getContext("2d").getImageData(x - 1, y, 3, Math.round(over.height * scale)).data;
    let n = 0;
    for (let i = 0; i < d.length; i += 4) n += d[i + 3] > 40 && of.every((v, k) => Math.abs(v - d[i + k]) < 40);
    return n;
  }, at);
  const at = await Promise.all(times.map(t => dashed(t / 7))), between = await Promise.all([1, 3, 5, 6].map(k => dashed((k * Math.PI / 4 + 0.2) / 7)));
  check(Math.min(...at) > 100 && Math.max(...between) < Math.min(...at) / 4, "a line at the time of each, none between", [at, between]);
  check(/4 events are marked/.test(await page.getAttribute("#panel-Plots .plot", "aria-label")), "said to who does not see them");
  const rows = await page.$$eval("#panel-Plots details:nth-of-type(1) tbody tr", all => all.map(r => [...r.children].map(c => c.textContent)));
  check(rows.length === 4 && rows.map(r => r[0]).join() === "zero,turn,zero,turn" && rows.every((r, i) => Math.abs(Number(r[1]) - times[i]) < 1e-4), "they are listed", rows);
  const saved = async () => { const [file] = await Promise.all([page.waitForEvent("download"), page.click("text=Save SVG")]); return readFileSync(await file.path(), "utf8"); };
  const dots = svg => (/<path[^>]*d="M([^"]*h0)"[^>]*\/><text[^>]*>events</.exec(svg)?.[1] ?? "").split("h0").filter(Boolean).length;
  check(dots(await saved()) === 8, "and in the picture saved: four on each of two curves");
  await page.selectOption("[aria-label=Plot]", "phase plane");
  check(dots(await saved()) === 4, "in the phase plane: four");
  await page.selectOption("[aria-label=Plot]", "errors by row");
  check(await dashed(times[0] / 7) > 100, "a line among the errors too");
  await accessible(page, "events");
  check(log.length === 0, "events: no errors", log);
  await page.context().close();
}

async function stopping(browser) {
  const { page, log } = await open(browser, url);
  await page.click("input[value=json] + span");
  await page.fill("textarea", SLOW);
  await page.waitForSelector("#said.fine");
  await page.click("#run");
  await page.waitForFunction(() => /trajectory/.test(document.querySelector("#progress").textContent));
  check(await page.isVisible("#cancel") && await page.isDisabled("#run"), "a running job shows its stage and can be cancelled");
  await page.click("#cancel");
  await page.waitForFunction(() => !document.querySelector("#run").disabled);
  check(/cancelled/.test(await text(page, "#panel-Raw pre")), "it is cancelled", (await text(page, "#panel-Answer")).slice(0, 200));
  check(log.length === 0, "stopping: no errors", log);
  await page.context().close();
}

async function refusals(browser) {
  const { page, log } = await open(browser, url);
  await page.click("input[value=json] + span");
  await page.fill("textarea", JSON.stringify({ system: { form: "equations", variables: ["x", "y"], equations: ["x' = y", "y' = -x", "x^2 + y^2 = 1"] }, trajectory: { stop: 1, initial: { x: 5, y: 5 }, hold: ["x", "y"] } }));
  await page.waitForSelector("#said.fine");
  await run(page);
  await page.waitForFunction(() => /Cure:/.test(document.querySelector("#panel-Answer").textContent));
  check(/inconsistent_initial/.test(await text(page, "#panel-Answer")), "a job that failed says why, with cause and cure", await text(page, "#panel-Answer"));
  await page.fill("textarea", '{"system": {"form": "equations", "variables": ["<img src=x onerror=alert(1)>"], "equations": ["x = 1"]}}');
  await page.waitForSelector("#said.wrong");
  check((await page.$$("#problems img")).length === 0 && (await text(page, "#problems")).includes("<img"), "text of the service stays text");
  await page.route("**/v1/check", r => r.abort());
  await page.fill("textarea", "{}");
  await page.waitForFunction(() => /cannot be reached/.test(document.querySelector("#said").textContent));
  check(true, "without the service the page says so");
  check(log.filter(l => !/ERR_FAILED/.test(l)).length === 0, "refusals: no errors", log);
  await page.context().close();
}

async function tokens(browser) {
  const { page, log } = await open(browser, guarded);
  await page.selectOption("#examples", "cawley");
  await page.waitForSelector("#token[open]");
  await accessible(page, "the dialog of the token");
  await page.fill("#tokentext", "sgad_wrong");
  await page.click("#token button.main");
  await page.waitForFunction(() => document.querySelector("#token").open);
  await page.fill("#tokentext", token);
  await page.click("#token button.main");
  await page.waitForSelector("#said.fine");
  await run(page);
  check((await text(page, "#panel-Answer .verdict")) === "underdetermined", "with the token it answers", await text(page, "#panel-Answer"));
  check(!page.url().includes(token) && !(await page.content()).includes(token) && await page.evaluate(() => localStorage.length) === 0, "the token is in no address and is kept with the tab only");
  check(log.length === 0, "tokens: no errors", log);
  await page.context().close();
}

// A picture as 24 x 16 mean greys: what is somewhere else, missing or of another colour shows; smoothing does not. PAGE_PICTURES=write keeps them anew.
// They are of one version of the browser (its first number) with one set of fonts, told by widths of texts: with others nothing is compared, and that is said.
const kept = join(here, "pictures.json"), known = existsSync(kept) ? JSON.parse(readFileSync(kept, "utf8")) : {};
async function compared(page, name, png) {
  const greys = await page.evaluate(async source => {
    const image = new Image(), canvas = new OffscreenCanvas(240, 160), to = canvas.getContext("2d");
    image.src = source;
    await image.decode();
    to.drawImage(image, 0, 0, 240, 160);
    const p = to.getImageData(0, 0, 240, 160).data, sums = Array(384).fill(0);
    for (let i = 0; i < 38400; i++) sums[Math.floor(i / 2400) * 24 + Math.floor(i % 240 / 10)] += (p[4 * i] + p[4 * i + 1] + p[4 * i + 2]) / 300;
    return sums.map(Math.round);
  }, "data:image/png;base64," + png.toString("base64"));
  const drawn = await page.evaluate(() => {
    const to = new OffscreenCanvas(10, 10).getContext("2d");
    return ["sans-serif", "system-ui", "monospace", "serif"].map(font => { to.font = `100px ${font}`; return to.measureText("Wilmgq 0123 \u03bb\u2202").width.toFixed(2); }).join(" ");
  }) + " " + page.context().browser().version().split(".")[0];
  if (process.env.PAGE_PICTURES === "write") { known.drawn = drawn; known[name] = greys; writeFileSync(kept, "{" + Object.entries(known).map(([k, v]) => `\n"${k}": ${JSON.stringify(v)}`).join(",") + "\n}\n"); }
  if (known.drawn !== drawn) { console.log(`${name}: not compared: the pictures kept are of another browser or other fonts (${drawn})`); return; }
  const apart = greys.map((v, i) => Math.abs(v - (known[name]?.[i] ?? 999))), mean = apart.reduce((a, b) => a + b) / 384;
  check(mean < 0.7 && Math.max(...apart) < 16, `${name}: the picture is as it was`, `${mean} apart, ${Math.max(...apart)} at most`);
}

async function looks(browser) {
  for (const [scheme, zoom] of [["light", 1], ["dark", 1], ["light", 2]]) {
    const { page, log } = await open(browser, url, { colorScheme: scheme, viewport: { width: 1360 / zoom, height: 850 / zoom }, deviceScaleFactor: zoom });
    await accessible(page, `${scheme} ${zoom}: empty`);
    await choose(page, "turning");
    await run(page);
    for (const name of ["Answer", "Derivation", "Strata", "Symmetries", "Accuracy", "Raw"]) {
      await tab(page, name);
      for (const node of await page.$$(`#panel-${name} details:not([open]) > summary`)) await node.click();
      await accessible(page, `${scheme} ${zoom}: ${name}`);
    }
    await choose(page, "pendulum");
    await run(page);
    await tab(page, "Plots");
    for (const kind of ["phase plane", "errors by row", "against time"]) {
      await page.selectOption("[aria-label=Plot]", kind);
      await page.waitForSelector("#panel-Plots .u-over");
      const name = `${scheme}-${zoom}-${kind.replaceAll(" ", "-")}`;
      await compared(page, name, await page.screenshot({ path: join(pictures, name + ".png") }));
    }
    await page.fill("textarea", "x' = 3*y +* 2");
    await page.waitForSelector("#said.wrong");
    await accessible(page, `${scheme} ${zoom}: Plots and a problem`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    check(wide <= 0, `${scheme} ${zoom}: nothing is wider than the window`, wide);
    const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    check((ground === "rgb(255, 255, 255)") === (scheme === "light"), `${scheme}: its ground`, ground);
    check(log.length === 0, `${scheme} ${zoom}: no errors`, log);
    await page.context().close();
  }
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM || "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1"] });
const parts = [examples, marks, ways, copied, keys, symmetries, exported, documented, pictured, strata, events, stopping, refusals, tokens, looks], asked = process.env.PAGE_PARTS?.split(",");
for (const part of parts.filter(p => !asked || asked.includes(p.name)))
  try { await part(browser); } catch (e) { check(false, part.name, String(e.stack ?? e)); }
await browser.close();
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
