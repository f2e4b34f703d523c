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
const CLOSED = { 4401: "the token is missing or wrong. Open the address that `longreach ui` prints.", 4429: "too many windows look already. Close one." };
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

/** The answer of the page's server; throws an Error with the refusal's words, or when none has come for `limit_ms`: what hangs on the way
 *  is taken back, since its sender no longer waits for it. */
export async function ask(path, content, limit_ms) {
  const options = { headers: { Authorization: `Bearer ${token}` } };
  if (content !== undefined) {
    options.method = "POST";
    options.headers["Content-Type"] = "application/json";
    options.body = JSON.stringify(content);
  }
  if (limit_ms) options.signal = AbortSignal.timeout(limit_ms);
  const response = await fetch(path, options).catch((error) => {
    throw new Error(error.name === "TimeoutError" ? `no answer within ${limit_ms / 1000} s` : error.message);
  });
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
const control = new Control(ask, (method) => view.socket?.readyState === WebSocket.OPEN && view.socket.send(method), () => drive.release());
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
    noteDelay();
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

/** How much later than the quickest one a cycle came: only differences of the two clocks count, which may be any. */
function noteDelay() {
  const delayMs = Date.now() - 1000 * view.history.newestUnix_s;
  view.leastDelayMs = Math.min(view.leastDelayMs ?? delayMs, delayMs);
  view.behindMs = delayMs - view.leastDelayMs;
}

function connect() {
  const socket = new WebSocket(`ws://${location.host}/live`);
  view.socket = socket;
  socket.onopen = () => socket.send(token);
  socket.onmessage = (message) => take(JSON.parse(message.data));
  socket.onclose = (closed) => {
    view.lost = CLOSED[closed.code] ?? "the page's server does not answer. See `longreach ui`.";
    if (closed.code !== 4401) setTimeout(connect, AGAIN_MS);
  };
}

function showLost() {
  const late = view.behindMs > STALE_MS && !view.rig?.played;
  const silent = late || performance.now() - view.lastCycleMs > STALE_MS;
  document.body.classList.toggle("stale", silent);
  byId("lost").hidden = !silent;
  if (silent && view.rig?.played && !view.lost) byId("lost").textContent = "The log has ended.";
  else if (late) byId("lost").textContent = `What you see is ${(view.behindMs / 1000).toFixed(1)} s old: the connection is too slow.\nTo stop: the e-stop of the rig.`;
  else if (silent) byId("lost").textContent = `No live data: ${view.lost || "the loop makes no new cycle"}\nTo stop: longreach estop in a terminal, or the e-stop of the rig.`;
}

function draw() {
  if (view.history?.fresh && !document.hidden) {
    view.history.fresh = false;
    view.arm.draw(view.history);
    if (view.plots.draw()) byId("behind").textContent = `${Math.round(view.behindMs)} ms behind`;
  }
  requestAnimationFrame(draw);
}

connect();
setInterval(showLost, 250);
requestAnimationFrame(draw);
maneuver.load().catch((error) => showMessage(error.message));
