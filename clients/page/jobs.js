// The drawer of jobs: newest first, by status, to open or to take away.
import { $, h, replace } from "./dom.js";
import { ask, json } from "./api.js";

const seconds = j => j.started && j.finished ? ((new Date(j.finished) - new Date(j.started)) / 1000).toFixed(2) : "";

export async function list(open, failed) {
  const status = $("status").value;
  try {
    const page = await json(`/v1/jobs?limit=50${status ? "&status=" + status : ""}`);
    replace($("jobs"), page.jobs.map(j => h("tr", {}, h("td", {}, h("a", { href: "#/job/" + j.id }, j.name || j.id.slice(0, 10))), h("td", {}, j.form ?? ""), h("td", {}, j.status, j.verdict ? h("span", { class: "soft" }, ", " + j.verdict) : null), h("td", {}, new Date(j.created).toLocaleString()), h("td", {}, seconds(j)),
      h("td", {}, h("button", { "aria-label": `Remove ${j.name || j.id.slice(0, 10)}`, onclick: async () => { try { await ask("/v1/jobs/" + j.id, { method: "DELETE" }); } catch (e) { failed(e); } list(open, failed); } }, ["queued", "running"].includes(j.status) ? "Cancel" : "Remove")))));
    if (!page.jobs.length) replace($("jobs"), h("tr", {}, h("td", { colspan: "6" }, "none")));
  } catch (e) { failed(e); }
}
