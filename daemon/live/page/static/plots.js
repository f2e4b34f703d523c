// Live plots. They follow the newest data until somebody pauses or zooms.
const COLOURS = ["#2f6fb5", "#d9622b", "#2c8a3f", "#9a5fb0", "#b8860b", "#c4271b", "#5f7d8c", "#d0559a"];
const HEIGHT = 170;
const PERIOD_MS = 33; // 30 pictures a second
const STORED_UNIT = /_(V|Pa|C|us|m|mps2)$/; // of a log's field; the plot has the unit of the rig file in its title
const OWN = "own";
const byId = (id) => document.getElementById(id);

export class Plots {
  constructor(rig, history) {
    this.rig = rig;
    this.history = history;
    this.paused = false;
    this.drawnMs = 0;
    this.closing = new AbortController();
    this.#takeColour();
    this.plots = rig.plots.map((plot) => this.#make(plot.title, plot.signals));
    this.#offerSignals();
    this.#listen();
  }

  #takeColour() {
    this.colour = getComputedStyle(document.body).color;
  }

  #listen() {
    const { signal } = this.closing;
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#takeColour(), { signal });
    byId("pause").addEventListener("click", () => this.#pause(!this.paused), { signal });
    byId("window").addEventListener("change", () => this.#pause(false), { signal });
    this.resizing = new ResizeObserver(() => this.plots.forEach((plot) => plot.u.setSize({ width: plot.box.clientWidth, height: HEIGHT })));
    this.resizing.observe(byId("plots"));
    this.seen = new Set();
    this.seeing = new IntersectionObserver((changes) => changes.forEach((each) => this.seen[each.isIntersecting ? "add" : "delete"](each.target)));
    this.plots.forEach((plot) => this.seeing.observe(plot.box));
  }

  close() {
    this.closing.abort();
    this.resizing.disconnect();
    this.seeing.disconnect();
    this.plots.forEach((plot) => plot.u.destroy());
    byId("plots").replaceChildren();
  }

  #pause(paused) {
    this.paused = paused;
    byId("pause").textContent = paused ? "Live" : "Pause";
    byId("pause").setAttribute("aria-pressed", String(paused));
    this.history.fresh = true;
  }

  #make(title, names) {
    const box = document.createElement("div");
    box.className = "plot";
    const heading = document.createElement("h3");
    box.append(heading);
    byId("plots").append(box);
    const signals = names.map((name) => this.rig.signals[this.history.index[name]]);
    const units = [...new Set(signals.map((signal) => signal.unit))].filter(Boolean);
    heading.textContent = units.length ? `${title} / ${units.join(", ")}` : title;
    const u = new uPlot(this.#options(box, signals, units), [[], ...names.map(() => [])], box);
    u.root.setAttribute("role", "img");
    u.root.setAttribute("aria-label", `plot of ${names.join(", ")}`);
    return { title, names, box, u };
  }

  #options(box, signals, units) {
    const axis = { stroke: () => this.colour, grid: { stroke: "#8883", width: 1 }, ticks: { stroke: "#8886", width: 1 } };
    const bare = (signal) => signal.name.replace(STORED_UNIT, "");
    const named = (signal) => (units.length > 1 ? `${bare(signal)} / ${signal.unit}` : bare(signal));
    return {
      width: box.clientWidth || 320,
      height: HEIGHT,
      cursor: { sync: { key: "live" }, drag: { x: true, y: false } },
      scales: { x: { time: false } },
      axes: [{ ...axis, size: 30 }, { ...axis, size: 62 }],
      series: [
        { label: "t", value: (_, value) => (value == null ? "" : `${value.toFixed(2)} s`) },
        ...signals.map((signal, number) => ({
          label: named(signal),
          stroke: COLOURS[number % COLOURS.length],
          width: 1.5,
          value: (_, value) => (value == null ? "" : value.toPrecision(4)),
        })),
      ],
      hooks: { setSelect: [(u) => u.select.width > 0 && this.#pause(true)] },
    };
  }

  /** Whether something was drawn. */
  draw() {
    const now = performance.now();
    if (this.paused || now - this.drawnMs < PERIOD_MS || !this.history.t.length) {
      this.history.fresh = !this.paused && this.history.t.length > 0;
      return false;
    }
    this.drawnMs = now;
    const seconds = Number(byId("window").value);
    for (const plot of this.plots) if (this.seen.has(plot.box)) plot.u.setData(this.history.newest(seconds, plot.names));
    return true;
  }

  #offerSignals() {
    const offered = this.rig.signals.map((signal) => {
      const label = document.createElement("label");
      const tick = document.createElement("input");
      tick.type = "checkbox";
      tick.value = signal.name;
      label.append(tick, ` ${signal.name}${signal.unit ? ` / ${signal.unit}` : ""}`);
      return label;
    });
    byId("signals").replaceChildren(...offered);
    byId("signals").addEventListener("change", () => this.#showOwn(), { signal: this.closing.signal });
  }

  #showOwn() {
    const names = [...byId("signals").querySelectorAll("input:checked")].map((tick) => tick.value);
    const old = this.plots.findIndex((plot) => plot.title === OWN);
    if (old >= 0) {
      const [plot] = this.plots.splice(old, 1);
      plot.u.destroy();
      plot.box.remove();
    }
    if (!names.length) return;
    const plot = this.#make(OWN, names);
    this.plots.push(plot);
    this.seeing.observe(plot.box);
  }
}
