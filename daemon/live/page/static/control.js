// Buttons that ask the daemon for something. The e-stop goes first, waits for nothing and works by the key Esc from anywhere. It acts
// when it is pressed, by any finger: a browser makes no click of a second one while a first holds a button of driving by hand.
const byId = (id) => document.getElementById(id);
const MAY = { "arm-button": ["disarmed"], disarm: ["arming", "holding", "running", "stopping", "proving"], stop: ["running", "proving", "holding"] };
const ASKS = { "arm-button": "arm", disarm: "disarm", reset: "reset", stop: "stop" };
const AT_ONCE = ["estop", "stop", "disarm"]; // past every other request
const BY_HAND = "Use the e-stop of the rig, or longreach estop in a terminal.";

const ANSWER_MS = 8000; // the daemon itself waits 5 s for the loop

let done = { mode: null, reached: false };

/** What was done is no news any more when the mode has changed since. */
function forgetDone(mode) {
  if (mode === done.mode) done.reached = true;
  else if (done.reached && byId("message").className === "done") showMessage("");
}

export function showMessage(text, isDone = false, mode = null) {
  done = { mode, reached: false };
  byId("message").textContent = text;
  byId("message").className = isDone ? "done" : "";
  byId("message").hidden = !text;
}

export class Control {
  /** `now` sends a request past every other one; the usual request after it says what came of it. `letGo`: of whatever moves the arm. */
  constructor(ask, now, letGo) {
    this.ask = ask;
    this.now = now;
    this.letGo = letGo;
    this.allowed = null; // not known yet
    byId("estop").addEventListener("pointerdown", () => this.#stopAll());
    byId("estop").addEventListener("click", (event) => event.detail || this.#stopAll()); // by a key or an assistive device
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.preventDefault();
      this.#stopAll();
    }, true);
    for (const [id, method] of Object.entries(ASKS)) byId(id).addEventListener("click", () => this.#request(method));
    this.#show(false);
  }

  allow(allowed) {
    this.allowed = allowed;
    this.#show(allowed);
  }

  #show(allowed) {
    byId("control").hidden = !allowed;
    byId("readonly").hidden = allowed;
    byId("estop").setAttribute("aria-disabled", String(!allowed));
  }

  follow(status) {
    forgetDone(status.mode);
    for (const [id, modes] of Object.entries(MAY)) byId(id).disabled = !modes.includes(status.mode);
    byId("reset").disabled = !(status.mode === "fault" || (status.mode === "disarmed" && status.estop === "latched"));
  }

  #stopAll() {
    this.letGo();
    if (this.allowed === false) {
      showMessage("This page only looks. To stop: longreach estop in a terminal, or the e-stop of the rig.");
      return;
    }
    showMessage(`e-stop asked for, not confirmed yet. If anything moves: ${BY_HAND}`);
    this.#request("estop", "e-stop: outputs are safe; Reset clears it");
  }

  async #request(method, words = "") {
    if (AT_ONCE.includes(method)) this.now(method);
    try {
      const answer = await this.ask("/api/request", { method, params: {} }, ANSWER_MS);
      showMessage(words || `${method}: ${answer.mode}`, true, answer.mode);
    } catch (error) {
      showMessage(error.message + (method === "estop" ? `\n${BY_HAND}` : ""));
    }
  }
}
