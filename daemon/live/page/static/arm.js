// The arm in plan, in the paper's frame: x to the right, y ahead, rotary 0 along y and positive anticlockwise; metres.
const TRAIL_S = 10;
const POINTS = 24; // of an arc or a bent link
const SVG = "http://www.w3.org/2000/svg";

export class Arm {
  constructor(svg, rig) {
    this.rig = rig;
    this.plane = rig.arm.kind === "rotary_prismatic";
    svg.replaceChildren();
    this.svg = svg;
    this.parts = {};
    for (const name of ["space", "path", "trail", "bearing", "link"]) this.#add(name, "path");
    for (const name of ["joint", "target", "tip"]) this.#add(name, "circle");
    this.joint = Object.keys(rig.joints)[0];
    this.scale = this.#frame();
    for (const name of ["joint", "target", "tip"]) this.parts[name].setAttribute("r", this.scale * (name === "target" ? 0.022 : 0.014));
    this.showPath([]);
  }

  #add(name, kind) {
    this.parts[name] = document.createElementNS(SVG, kind);
    this.parts[name].setAttribute("class", name);
    this.svg.append(this.parts[name]);
  }

  /** Draws what the joints can reach, and sets the picture's frame around it; returns its size. */
  #frame() {
    const space = this.plane ? this.#sector() : this.#bar();
    this.parts.space.setAttribute("d", `${line(space)}Z`);
    const all = [...space, [0, 0]];
    const [x, y] = [all.map((point) => point[0]), all.map((point) => -point[1])];
    const size = Math.max(Math.max(...x) - Math.min(...x), Math.max(...y) - Math.min(...y));
    const edge = 0.05 * size;
    const box = [Math.min(...x) - edge, Math.min(...y) - edge, Math.max(...x) - Math.min(...x) + 2 * edge, Math.max(...y) - Math.min(...y) + 2 * edge];
    this.svg.setAttribute("viewBox", box.join(" "));
    return size;
  }

  #sector() {
    const [low, high] = this.rig.joints.rotary.travel;
    const [near, far] = this.rig.joints.prismatic.travel;
    const angles = Array.from({ length: POINTS }, (_, k) => low + ((high - low) * k) / (POINTS - 1));
    return [...angles.map((angle) => this.#at(angle, far)), ...angles.reverse().map((angle) => this.#at(angle, near))];
  }

  /** One axis: a linear one along x, a rotary one as a sector of unit length. */
  #bar() {
    const { motion, travel } = this.rig.joints[this.joint];
    const [low, high] = travel;
    if (motion === "linear") return [[low, -0.05 * (high - low)], [high, -0.05 * (high - low)], [high, 0.05 * (high - low)], [low, 0.05 * (high - low)]];
    const angles = Array.from({ length: POINTS }, (_, k) => low + ((high - low) * k) / (POINTS - 1));
    return [[0, 0], ...angles.map((angle) => [-Math.sin(angle), Math.cos(angle)])];
  }

  #at(angle, extension, sideways = 0) {
    const r = this.rig.arm.hub_offset_m + extension;
    return [-r * Math.sin(angle) - sideways * Math.cos(angle), r * Math.cos(angle) - sideways * Math.sin(angle)];
  }

  showPath(points) {
    this.parts.path.setAttribute("d", line(points));
  }

  draw(history) {
    if (this.plane) this.#drawPlane(history);
    else this.#drawAxis(history);
  }

  #drawPlane(history) {
    const [angle, extension] = [history.si("rotary.position"), history.si("prismatic.position")];
    if (this.#lost(angle === null || extension === null)) return;
    const bend = history.si("tip.deflection_m") ?? 0;
    const link = Array.from({ length: POINTS }, (_, k) => k / (POINTS - 1)).map((s) => this.#at(angle, s * extension, bend * s * s * (1.5 - 0.5 * s)));
    this.parts.link.setAttribute("d", line(link));
    this.parts.bearing.setAttribute("d", line([[0, 0], this.#at(angle, 0)]));
    this.#place("joint", [0, 0]);
    this.#place("tip", link.at(-1));
    this.#place("target", this.#at(history.si("rotary.target") ?? angle, history.si("prismatic.target") ?? extension));
    this.parts.trail.setAttribute("d", line(this.#trail(history)));
  }

  #trail(history) {
    const si = (name, value) => {
      const signal = this.rig.signals[history.index[name]];
      return (value - signal.offset) / signal.factor;
    };
    const [t, angles, extensions] = history.newest(TRAIL_S, ["rotary.position", "prismatic.position"]);
    return t.map((_, k) => [angles[k], extensions[k]]).filter(([a, e]) => a !== null && e !== null)
      .map(([a, e]) => this.#at(si("rotary.position", a), si("prismatic.position", e)));
  }

  #drawAxis(history) {
    const position = history.si(`${this.joint}.position`);
    if (this.#lost(position === null)) return;
    const linear = this.rig.joints[this.joint].motion === "linear";
    const place = (value) => (linear ? [value, 0] : [-Math.sin(value), Math.cos(value)]);
    this.parts.link.setAttribute("d", line([linear ? [this.rig.joints[this.joint].travel[0], 0] : [0, 0], place(position)]));
    this.#place("joint", linear ? [this.rig.joints[this.joint].travel[0], 0] : [0, 0]);
    this.#place("tip", place(position));
    this.#place("target", place(history.si(`${this.joint}.target`) ?? position));
  }

  /** Where the arm is not known the picture says so and stays where it was. */
  #lost(unknown) {
    this.parts.link.classList.toggle("lost", unknown);
    return unknown;
  }

  #place(name, [x, y]) {
    this.parts[name].setAttribute("cx", x);
    this.parts[name].setAttribute("cy", -y);
  }
}

/** SVG's y points down. */
function line(points) {
  return points.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(4)} ${(-y).toFixed(4)}`).join("");
}
