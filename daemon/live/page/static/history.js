// What was received: one column a signal, in the units of the rig file, the newest two minutes.
const KEPT_S = 125;
const CUT_AT = 1.25; // cut when so many times as much is there: cutting at every row would cost more than drawing

export class History {
  constructor(rig) {
    this.rig = rig;
    this.index = Object.fromEntries(rig.signals.map((signal, number) => [signal.name, number]));
    this.columns = rig.signals.map(() => []);
    this.newestUnix_s = 0;
    this.fresh = false;
  }

  /** Rows: unix_s, then every signal in SI; null is not known. */
  add(rows) {
    const { signals } = this.rig;
    for (const row of rows) {
      this.newestUnix_s = row[0];
      signals.forEach((signal, number) => {
        const value = row[number + 1];
        this.columns[number].push(value === null ? null : signal.factor * value + signal.offset);
      });
    }
    this.#cut();
    this.fresh = true;
  }

  #cut() {
    const t = this.columns[this.rig.at_t_s];
    if (t.at(-1) - t[0] < KEPT_S * CUT_AT) return;
    const gone = this.from(t.at(-1) - KEPT_S);
    for (const column of this.columns) column.splice(0, gone);
  }

  get t() {
    return this.columns[this.rig.at_t_s];
  }

  /** Number of the first row not before t. */
  from(t_s) {
    const { t } = this;
    let low = 0;
    let high = t.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (t[middle] < t_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** t and the named columns of the newest `seconds`, as uPlot takes them. */
  newest(seconds, names) {
    const first = this.from(this.t.at(-1) - seconds);
    return [this.t.slice(first), ...names.map((name) => this.columns[this.index[name]].slice(first))];
  }

  /** The newest value in SI, null when it is not known or the rig has no such signal. */
  si(name) {
    const number = this.index[name];
    const value = number === undefined ? null : this.columns[number].at(-1);
    const signal = this.rig.signals[number];
    return value === null || value === undefined ? null : (value - signal.offset) / signal.factor;
  }
}
