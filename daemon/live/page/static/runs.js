// Runs of this rig among the daemon's logs; each opens its report.
import { showMessage } from "./control.js";

const byId = (id) => document.getElementById(id);
const cell = (tag, text, className = "") => Object.assign(document.createElement(tag), { textContent: text, className });

export class Runs {
  constructor(ask) {
    this.ask = ask;
    byId("list-runs").addEventListener("click", () => this.#list());
  }

  useRig(rig) {
    this.tip = rig.signals.find((signal) => signal.name === "tip.acceleration_mps2");
  }

  async #list() {
    byId("runs-note").textContent = "reading the logs …";
    try {
      const { runs } = await this.ask("/api/runs");
      byId("runs-note").textContent = runs.length ? "" : "no run yet";
      byId("runs").replaceChildren(byId("runs").caption, this.#head(), ...runs.map((run) => this.#row(run)));
    } catch (error) {
      byId("runs-note").textContent = error.message;
    }
  }

  #head() {
    const row = document.createElement("tr");
    row.append(...["started", "maneuver", "filter", "lasted", "valid", `vibration left / ${this.tip?.unit ?? "m/s²"}`, "report"].map((text) => cell("th", text)));
    return row;
  }

  #row(run) {
    const row = document.createElement("tr");
    const open = cell("button", `${run.log}, run ${run.run}`);
    open.type = "button";
    open.addEventListener("click", () => this.#open(run));
    const last = document.createElement("td");
    last.append(open);
    const left = run.vibration_mps2 === null ? "–" : (run.vibration_mps2 * (this.tip?.factor ?? 1)).toPrecision(3);
    const valid = cell("td", run.valid ? "valid" : `not valid: ${run.reason}`, run.valid ? "" : "no");
    row.append(cell("td", new Date(1000 * run.started_unix_s).toLocaleString()), cell("td", run.maneuver), cell("td", run.shaper), cell("td", `${run.duration_s.toFixed(1)} s`), valid, cell("td", left), last);
    return row;
  }

  /** A window opens at once: browsers block one that opens seconds after the click. */
  async #open(run) {
    const report = window.open("", "_blank");
    if (report) report.document.title = `making the report of ${run.log}, run ${run.run} …`;
    showMessage(`making the report of ${run.log}, run ${run.run}`, true);
    try {
      const { page } = await this.ask("/api/report", { log: run.log, run: run.run });
      if (report) report.location = page;
      else location.assign(page);
      showMessage("");
    } catch (error) {
      report?.close();
      showMessage(error.message);
    }
  }
}
