// Buttons that ask the daemon for something. The e-stop goes first, waits for nothing and works by the key Esc from anywhere.
const byId = (id) => document.getElementById(id);
const MAY = { "arm-button": ["disarmed"], disarm: ["arming", "holding", "running", "stopping", "proving"], stop: ["running", "proving", "holding"] };
const ASKS = { "arm-button": "arm", disarm: "disarm", reset: "reset", stop: "stop" };

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
  /** `estopNow` sends an e-stop past every other request; the request after it says what came of it. */
  constructor(ask, estopNow) {
    this.ask = ask;
    this.estopNow = estopNow;
    this.allowed = false;
    byId("estop").addEventListener("click", () => this.#stopAll());
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.preventDefault();
      this.#stopAll();
    }, true);
    for (const [id, method] of Object.entries(ASKS)) byId(id).addEventListener("click", () => this.#request(method));
    this.allow(false);
  }

  allow(allowed) {
    this.allowed = allowed;
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
    if (!this.allowed) {
      showMessage("This page only looks. To stop: longreach estop in a terminal, or the e-stop of the rig.");
      return;
    }
    this.estopNow();
    this.#request("estop", "e-stop: outputs are safe; Reset clears it");
  }

  async #request(method, words = "") {
    try {
      const answer = await this.ask("/api/request", { method, params: {} });
      showMessage(words || `${method}: ${answer.mode}`, true, answer.mode);
    } catch (error) {
      const more = method === "estop" ? "\nUse the e-stop of the rig, or longreach estop in a terminal." : "";
      showMessage(error.message + more);
    }
  }
}
