// Drive by hand: the arm moves while a button is held. Each answer lets the next set point go, so that none waits before another;
// whatever hangs on the way, the daemon stops the arm when none comes.
import { showMessage } from "./control.js";

const PERIOD_MS = 40;
const SPEEDS = [1, 2, 5, 10, 20, 50, 100]; // % of the limits
const byId = (id) => document.getElementById(id);

// A rig file that states no link gives no frequency to follow, and no link that would swing.
function filterInWords(run) {
  if (run.shaper === "none") return "No filter: the rig file states no flexible link.";
  return `Filter ${run.shaper} on ${run.shaped_joints.join(", ")}: at rest ${run.flush_s.toFixed(2)} s after the joints have slowed down.`;
}

export class Drive {
  constructor(token, inWords) {
    this.token = token;
    this.inWords = inWords;
    this.socket = null;
    this.run = null;
    this.held = null; // what the held button asks for
    this.idle = { rate: {} };
    byId("drive-speed").replaceChildren(...SPEEDS.map((speed) => new Option(`${speed} %`, speed, speed === 10, speed === 10)));
    byId("drive").addEventListener("click", () => (this.socket ? this.#end() : this.#begin()));
    for (const [target, name] of [[window, "blur"], [document, "visibilitychange"]]) target.addEventListener(name, () => this.release());
    setInterval(() => this.#send(), PERIOD_MS);
  }

  follow(status) {
    byId("drive").disabled = !this.socket && status.mode !== "holding";
  }

  #begin() {
    const socket = new WebSocket(`ws://${location.host}/drive`);
    socket.onopen = () => {
      socket.send(this.token);
      socket.send(JSON.stringify({ method: "stream", params: {} }));
    };
    socket.onmessage = (message) => this.#take(JSON.parse(message.data));
    socket.onclose = () => this.#over();
    this.socket = socket;
    this.owed = 1; // answers
    byId("drive").textContent = "End driving";
  }

  #take(answer) {
    this.owed -= 1;
    if (answer.error) {
      showMessage(this.inWords(answer.error));
      this.#leave();
    } else if (answer.method === "stream") {
      this.run = answer.result;
      byId("drive-filter").textContent = filterInWords(this.run);
      this.#showPads();
    } else if ((this.ending && !this.owed) || answer.result.validity !== "running") {
      this.#leave();
    }
  }

  #leave() {
    this.run = null; // nothing is sent while it closes
    this.socket.close();
  }

  #send() {
    if (!this.run || this.owed || this.ending) return;
    const wanted = this.held ? this.held() : this.idle;
    this.idle = "tip_mps" in wanted ? { tip_mps: [0, 0] } : { rate: {} }; // the tip slows down on its line
    this.#ask(wanted);
  }

  #ask(wanted) {
    this.owed += 1;
    this.socket.send(JSON.stringify({ method: "set_point", params: { run: this.run.run, t_s: performance.now() / 1000, ...wanted } }));
  }

  #end() {
    this.release();
    if (!this.run) return this.#leave(); // it has not begun
    this.ending = true;
    this.#ask({ end: true });
  }

  #over() {
    this.release();
    Object.assign(this, { socket: null, run: null, ending: false, owed: 0 });
    byId("drive").textContent = "Drive";
    byId("pads").replaceChildren();
  }

  /** Let go: the arm slows down. */
  release() {
    this.held = null;
  }

  #showPads() {
    const share = () => byId("drive-speed").value / 100;
    const pads = Object.entries(this.run.limits).flatMap(([joint, limits]) =>
      [-1, 1].map((sign) => this.#pad(`${sign < 0 ? "−" : "+"} ${joint}`, () => ({ rate: { [joint]: sign * share() * limits.rate } }))));
    const tip = [["x", 0, -1], ["x", 0, 1], ["y", 1, -1], ["y", 1, 1]].map(([name, axis, sign]) =>
      this.#pad(`${sign < 0 ? "−" : "+"} tip ${name}`, () => ({ tip_mps: [0, 1].map((each) => (each === axis ? sign * share() * this.run.tip_speed_mps : 0)) })));
    byId("pads").replaceChildren(...pads, ...(this.run.tip_speed_mps > 0 ? tip : []));
  }

  #pad(name, wanted) {
    const pad = Object.assign(document.createElement("button"), { type: "button", textContent: name, className: "pad" });
    pad.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      pad.setPointerCapture(event.pointerId);
      this.held = wanted;
    });
    pad.addEventListener("pointermove", (event) => {
      if (!(event.buttons & 1)) this.release(); // another button of the mouse is still down
    });
    pad.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat) this.held = wanted; // a repeat is no press: what it began may have been let go
    });
    for (const let_go of ["pointerup", "pointercancel", "lostpointercapture", "keyup", "blur"]) pad.addEventListener(let_go, () => this.release());
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
    return pad;
  }
}
