// Status, joints, checks and events as text.
const EVENTS_SHOWN = 300;
const byId = (id) => document.getElementById(id);
const element = (tag, text, className = "") => Object.assign(document.createElement(tag), { textContent: text, className });
const digits = (value) => (typeof value === "number" ? Number(value.toPrecision(4)).toString() : value ?? "no value");

export function showStatus(status) {
  const mode = byId("mode");
  if (mode.textContent !== status.mode) mode.textContent = status.mode;
  mode.className = `mode ${status.mode}`;
  byId("run").textContent = status.fault ? `fault: ${status.fault.text}` : runLine(status.run);
  const { loop } = status;
  byId("loop").textContent = `cycle ${status.cycle}, ${loop.rate_Hz} Hz, late p99 ${Math.round(loop.late_us_p99)} us, overruns ${loop.overruns}, e-stop ${status.estop}`;
}

function runLine(run) {
  if (!run) return "no run yet";
  const what = `run ${run.run}: ${run.maneuver}, filter ${run.shaper}`;
  if (run.countdown_s > 0) return `${what}: MOTION STARTS IN ${run.countdown_s.toFixed(0)} s`;
  const of = run.duration_s === null ? "" : ` of ${run.duration_s.toFixed(1)}`; // driven by hand: nobody knows
  const where = `${run.elapsed_s.toFixed(1)}${of} s${run.segment_name ? `, ${run.segment_name}` : ""}`;
  return `${what}: ${where}, ${run.validity}${run.reason ? `, because ${run.reason}` : ""}`;
}

export function showJoints(status, rig) {
  if (!rig) return;
  const rows = Object.entries(status.joints).map(([name, joint]) => {
    const { unit, factor, offset } = rig.signals.find((signal) => signal.name === `${name}.position`);
    const shown = (value) => (value === null ? "–" : `${(factor * value + offset).toFixed(3)} ${unit}`);
    return [name, shown(joint.position), shown(joint.reference), joint.command_V === null ? "–" : `${joint.command_V.toFixed(3)} V`];
  });
  const lines = [["joint", "position", "reference", "command"], ...rows].map((cells, number) => {
    const row = document.createElement("tr");
    row.append(...cells.map((cell) => element(number ? "td" : "th", cell)));
    return row;
  });
  byId("joints").replaceChildren(byId("joints").caption, ...lines);
}

export function showChecks(checks) {
  const standing = (check) => (check.ok === null ? "unknown" : !check.ok ? "no" : check.severity === "warning" ? "warning" : "ok");
  const order = { no: 0, warning: 1, unknown: 2, ok: 3 };
  const sorted = [...checks].sort((a, b) => order[standing(a)] - order[standing(b)]);
  const failed = checks.filter((check) => check.ok === false).length;
  byId("ready").textContent = failed ? `${failed} of ${checks.length} checks stand in the way of arming` : "nothing stands in the way of arming";
  byId("checks").replaceChildren(...sorted.map((check) => {
    const item = element("li", "", standing(check));
    const limit = check.limit ? ` (limit ${check.limit})` : "";
    item.append(element("b", standing(check) === "no" ? "NO" : standing(check)), ` ${check.name}: ${digits(check.value)} ${check.unit ?? ""}${limit}, from ${check.source}`);
    if (standing(check) !== "ok" && check.next_step) item.append(element("div", check.next_step, "quiet"));
    return item;
  }));
}

export function showEvents(all, added) {
  const list = byId("events");
  for (const event of added) list.prepend(element("li", `${event.t_s.toFixed(3)} s  ${event.name}: ${event.text}`, event.level));
  while (list.childElementCount > EVENTS_SHOWN) list.lastElementChild.remove();
  return all;
}
