// The form of a maneuver: its parameters, what it would do, and its start.
import { showMessage } from "./control.js";

const PLANNING_S = 8; // of a long program; a start that takes longer is taken back
const SETTLE_S = 10; // wait at most so long until the arm is at rest, as `longreach start` does
const byId = (id) => document.getElementById(id);

export class Maneuver {
  constructor(ask, onPlan) {
    this.ask = ask;
    this.onPlan = onPlan;
    this.form = byId("maneuver");
    this.maneuvers = [];
    this.form.maneuver.addEventListener("change", () => this.#showParameters());
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#start();
    });
    byId("plan").addEventListener("click", () => this.#plan());
  }

  async load() {
    const { maneuvers, shapers } = await this.ask("/api/maneuvers");
    this.maneuvers = maneuvers;
    this.form.maneuver.replaceChildren(...maneuvers.map((each) => new Option(each.name, each.name)));
    this.form.shaper.replaceChildren(...shapers.map((name) => new Option(name, name)));
    this.#showParameters();
  }

  useRig(rig) {
    this.rig = rig;
  }

  allow(control) {
    byId("start").hidden = !control;
  }

  follow(status) {
    byId("start").disabled = status.mode !== "holding";
  }

  #chosen() {
    return this.maneuvers.find((each) => each.name === this.form.maneuver.value);
  }

  #showParameters() {
    const { description, parameters } = this.#chosen();
    byId("description").textContent = description;
    byId("parameters").replaceChildren(...Object.entries(parameters).map(([key, value]) => {
      const label = document.createElement("label");
      const input = document.createElement("input");
      Object.assign(input, { name: `of.${key}`, value, defaultValue: value, autocomplete: "off" });
      label.append(`${key} `, input);
      return label;
    }));
    byId("planned").replaceChildren();
    this.onPlan({ path: [] });
  }

  #params() {
    const changed = [...this.form.elements].filter((input) => input.name.startsWith("of.") && input.value !== input.defaultValue);
    return {
      maneuver: { name: this.form.maneuver.value },
      parameters: changed.map((input) => `${input.name.slice(3)}=${input.value}`),
      shaper: { kind: this.form.shaper.value },
      repeat: Number(this.form.repeat.value),
      approach: this.form.approach.checked,
    };
  }

  async #plan() {
    byId("planned").textContent = "planning …";
    try {
      const plan = await this.ask("/api/plan", this.#params());
      showMessage("");
      byId("planned").replaceChildren(...this.#lines(plan).map((text) => Object.assign(document.createElement("p"), { className: "quiet", textContent: text })));
      this.onPlan(plan);
    } catch (error) {
      byId("planned").replaceChildren();
      showMessage(error.message);
    }
  }

  #lines(plan) {
    const lines = [`takes ${plan.duration_s.toFixed(1)} s, filter ${plan.shaper}`];
    for (const [joint, peaks] of Object.entries(plan.peaks)) {
      const { unit, factor, offset } = this.rig.signals.find((signal) => signal.name === `${joint}.position`);
      const shown = (value) => (factor * value + offset).toPrecision(4);
      lines.push(`${joint}: ${shown(peaks.lowest)} to ${shown(peaks.highest)} ${unit}, at most ${(factor * peaks.rate).toPrecision(3)} ${unit}/s`);
    }
    if (plan.tip) lines.push(`tip: ${plan.tip.speed_mps.toPrecision(3)} m/s, ${plan.tip.acceleration_mps2.toPrecision(3)} m/s² across the link`);
    for (const { move, nominal_mps2, worst_mps2 } of plan.vibration)
      lines.push(`after ${move}: vibration ${nominal_mps2.toFixed(3)} m/s² predicted, up to ${worst_mps2.toFixed(3)} within ±10 % of the frequency`);
    if (!plan.vibration.length) lines.push("vibration: no move with a hold to predict");
    return lines;
  }

  async #start() {
    const params = this.#params();
    showMessage(`start of ${params.maneuver.name}: waiting until the arm is at rest, at most ${SETTLE_S} s`, true);
    try {
      const run = await this.ask("/api/request", { method: "start", params: { ...params, settle_s: SETTLE_S } }, 1000 * (SETTLE_S + PLANNING_S));
      showMessage(`run ${run.run} starts in ${run.countdown_s.toFixed(0)} s and takes ${run.duration_s.toFixed(1)} s`, true, "running");
    } catch (error) {
      showMessage(error.message);
    }
  }
}
