// Live data in, requests out. The token comes from the address (behind #) and stays in this window.
import { Arm } from "./arm.js";
import { Control, showMessage } from "./control.js";
import { Drive } from "./drive.js";
import { History } from "./history.js";
import { Maneuver } from "./maneuver.js";
import { Plots } from "./plots.js";
import { Runs } from "./runs.js";
import { showChecks, showEvents, showJoints, showStatus } from "./tables.js";

const AGAIN_MS = 1000;
const STALE_MS = 1500; // without a new cycle
const byId = (id) => document.getElementById(id);

function keptToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

const token = keptToken();

/** The answer of the page's server; throws an Error with the refusal's words. */
export async function ask(path, content) {
  const options = { headers: { Authorization: `Bearer ${token}` } };
  if (content !== undefined) {
    options.method = "POST";
    options.headers["Content-Type"] = "application/json";
    options.body = JSON.stringify(content);
  }
  const response = await fetch(path, options);
  const answer = await response.json();
  if (answer.error) throw new Error(inWords(answer.error));
  return answer;
}

function inWords(error) {
  const unit = error.unit ? ` ${error.unit}` : "";
  const value = error.value ? `: ${error.value}${unit}` : "";
  const limit = error.limit ? ` (limit: ${error.limit}${unit})` : "";
  return `${error.where ? `${error.where}: ` : ""}${error.what}${value}${limit}. ${error.next_step ?? ""}`;
}

const view = { rig: null, history: null, arm: null, plots: null, events: [], lastCycleMs: 0, lost: "connecting" };
const control = new Control(ask, () => view.socket?.readyState === WebSocket.OPEN && view.socket.send("estop"));
const runs = new Runs(ask);
const drive = new Drive(token, inWords);
const maneuver = new Maneuver(ask, (plan) => view.arm?.showPath(plan.path));

function begin(rig) {
  view.rig = rig;
  view.history = new History(rig);
  view.arm = new Arm(byId("arm"), rig);
  view.plots?.close();
  view.plots = new Plots(rig, view.history);
  view.events = [];
  byId("events").replaceChildren();
  byId("rig").textContent = rig.played ? `${rig.name}, played from ${rig.played}` : rig.name;
  byId("rig").title = rig.description;
  document.title = `${rig.name} – longreach`;
  maneuver.useRig(rig);
  runs.useRig(rig);
}

function take(content) {
  if ("control" in content) control.allow(content.control);
  if ("control" in content) maneuver.allow(content.control);
  if ("lost" in content) view.lost = content.lost;
  if (content.rig) begin(content.rig);
  if (content.samples && view.history) {
    view.history.add(content.samples);
    view.lastCycleMs = performance.now();
  }
  if (content.status) {
    showStatus(content.status);
    showJoints(content.status, view.rig);
    control.follow(content.status);
    drive.follow(content.status);
    maneuver.follow(content.status);
  }
  if (content.checks) showChecks(content.checks);
  if (content.events) showEvents((view.events = [...view.events, ...content.events].slice(-5000)), content.events);
}

function connect() {
  const socket = new WebSocket(`ws://${location.host}/live`);
  view.socket = socket;
  socket.onopen = () => socket.send(token);
  socket.onmessage = (message) => take(JSON.parse(message.data));
  socket.onclose = (closed) => {
    view.lost = closed.code === 4401 ? "the token is missing or wrong. Open the address that `longreach ui` prints." : "the page's server does not answer. See `longreach ui`.";
    if (closed.code !== 4401) setTimeout(connect, AGAIN_MS);
  };
}

function showLost() {
  const silent = performance.now() - view.lastCycleMs > STALE_MS;
  document.body.classList.toggle("stale", silent);
  byId("lost").hidden = !silent;
  if (silent && view.rig?.played && !view.lost) byId("lost").textContent = "The log has ended.";
  else if (silent) byId("lost").textContent = `No live data: ${view.lost || "the loop makes no new cycle"}\nTo stop: longreach estop in a terminal, or the e-stop of the rig.`;
}

function draw() {
  if (view.history?.fresh && !document.hidden) {
    view.history.fresh = false;
    view.arm.draw(view.history);
    if (view.plots.draw()) byId("behind").textContent = `${Math.max(0, Math.round(Date.now() - 1000 * view.history.newestUnix_s))} ms behind`;
  }
  requestAnimationFrame(draw);
}

connect();
setInterval(showLost, 250);
requestAnimationFrame(draw);
maneuver.load().catch((error) => showMessage(error.message));
