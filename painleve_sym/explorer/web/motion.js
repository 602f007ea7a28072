/** Motions over time: animation of the mechanism, forces, events, and the jump beside them. */

import { Clock } from "./clock.js";
import { Frame, WIDTH, HEIGHT, html, pretty, short, span, svg } from "./draw.js";
import { Scene } from "./scene.js";

/** Seconds that an animation lasts, and still pictures in its place where motion is unwanted. */
const LASTS = 8;
const STILLS = 12;
const SAMPLES = 500;
const FRAMES = 24;

export class MotionView {
  /**
   * @param {import("./engine.js").Engine} engine
   * @param {(change: any) => void} change
   */
  constructor(engine, change) {
    this.engine = engine;
    this.change = change;
    this.playing = false;
    // Set by the first update.
    this.clock = /** @type {Clock} */ (/** @type {unknown} */ (null));
    this.frame = /** @type {Frame} */ (/** @type {unknown} */ (null));
    /** @type {any} */
    this.settings = null;
    /** @type {import("./engine.js").Run[]} */
    this.runs = [];
    /** @type {any} */
    this.box = null;
    this.largest = 0;
    this.cursor = svg("path", { class: "cursor" });
    this.labels = engine.motions.map((m) => (m.names.rigid ? "rigid" : `compliant (${m.names.law})`));
    const { scene } = engine.description;
    const titles = engine.motions.map((m) => (m.names.rigid ? "rigid" : "compliant"));
    this.scenes = scene ? titles.map((title, i) => new Scene(engine, i, title)) : [];
    this.button = html("button", { type: "button", onclick: () => this.#toggle() }, "Play");
    this.scrub = html("input", {
      ...{ type: "range", min: 0, max: 1, step: 0.001, "aria-label": "time of the animation" },
      oninput: () => this.#show(+this.scrub.value, true),
    });
    this.time = html("output", { class: "time" });
    this.magnify = html("input", {
      ...{ type: "range", min: 0, max: 1, step: 0.01 },
      oninput: () => change({ magnify: +this.magnify.value }),
    });
    this.figure = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
    this.legend = html("ul", { class: "legend" });
    this.faults = html("div", { role: "alert" });
    const missing = html("p", { class: "note" },
      "This mechanism has neither shapes nor bodies, so it is not drawn; everything else works. " +
        "[[shapes]] in its file says how to draw it.");
    this.element = html(
      "div",
      {},
      this.faults,
      scene ? html("div", { class: "pair" }, this.scenes.map((s) => s.element)) : missing,
      html("div", { class: "row" }, this.button, this.scrub, this.time),
      html("label", { class: "row" }, "magnify impacts ", this.magnify),
      this.figure,
      this.legend,
    );
  }

  /** @param {any} settings @param {import("./engine.js").Run[]} runs */
  update(settings, runs) {
    this.settings = settings;
    this.runs = runs;
    this.magnify.value = settings.magnify;
    const sentences = runs.flatMap((run, i) => this.#fault(run, this.labels[i]));
    this.faults.replaceChildren(...sentences.map((s) => html("p", { class: "fault" }, s)));
    const longest = runs.reduce((a, b) => ((b.end?.time ?? 0) > (a.end?.time ?? 0) ? b : a));
    const busiest = runs.reduce((a, b) => (b.times.length > a.times.length ? b : a));
    const end = longest.end?.time ?? 0;
    const times = [...busiest.times.filter((t) => t < end), end];
    this.clock = new Clock(end > 0 ? times : [0, 1], settings.magnify);
    this.#window();
    this.#forces();
    this.#show(settings.at, false);
  }

  /** @param {import("./engine.js").Run} run @param {string} label */
  #fault(run, label) {
    if (run.fault) return [`${label}: ${run.fault}.`];
    const { stop, time } = /** @type {any} */ (run.end);
    if (["t_end", "until"].includes(stop.name)) return [];
    return [`${label}: the motion ends at t = ${short(time)} s: ${stop.sentence}.`];
  }

  #window() {
    if (!this.scenes.length) return;
    const states = this.runs.flatMap((run) => {
      const parts = Array.from({ length: FRAMES + 1 }, (_, i) => i / FRAMES);
      return run.end ? parts.map((p) => run.at(this.clock.time(p))?.state).filter(Boolean) : [];
    });
    this.box = Scene.window(this.engine, this.settings.values, states);
  }

  // ---- forces over time ----

  #forces() {
    const parts = Array.from({ length: SAMPLES + 1 }, (_, i) => i / SAMPLES);
    /** @type {{label: string, style: string, points: number[][]}[]} */
    const curves = [];
    for (const [i, run] of this.runs.entries()) {
      if (!run.end) continue;
      const own = run.end.time;
      const moments = parts.map((p) => (this.clock.time(p) <= own ? run.at(this.clock.time(p)) : null));
      for (const name of run.motion.outputNames.filter((n) => /^(normal|tangential)_force/.test(n))) {
        const points = parts.map((p, k) => [p, moments[k] ? moments[k].outputs[name] : NaN]);
        const contact = this.engine.description.contacts.findIndex((c) => name.endsWith(`_${c.name}`));
        const kind = name.startsWith("normal") ? "normal" : "tangential";
        const style = `${kind} motion-${i} contact-${contact}`;
        const label = `${name.replace("normal_force", "F_n").replace("tangential_force", "F_t")}`;
        curves.push({ label: `${label}, ${this.labels[i]}`, style, points });
      }
    }
    const values = curves.flatMap((c) => c.points.map((p) => p[1]));
    this.largest = Math.max(...values.filter(Number.isFinite).map(Math.abs), 0);
    const frame = new Frame([0, 1], span(values));
    this.frame = frame;
    const marks = [0, 0.25, 0.5, 0.75, 1].map((at) => ({ at, text: short(this.clock.time(at), 3) }));
    const main = this.runs.find((run) => run.end);
    const events = main ? main.events.slice(0, 60) : [];
    this.figure.replaceChildren(
      frame.axes("time (s)", "force (N)", marks),
      ...events.map((e, i) => {
        const at = this.clock.part(e.time);
        const d = frame.path([[at, frame.y[0]], [at, frame.y[1]]]);
        const text = `${e.kind.replaceAll("_", " ")} at ${short(e.time)} s`;
        return svg("g", { class: "event" }, svg("path", { d }), svg("title", {}, text), events.length > 12
          ? null
          // Numbers of near events stand on two lines.
          : svg("text", { x: frame.left(at), y: i % 2 ? 28 : 19, "text-anchor": "middle" }, i + 1));
      }),
      ...curves.map((c) => svg("path", { d: frame.path(c.points), class: `curve ${c.style}` })),
      this.cursor,
    );
    this.figure.setAttribute(
      "aria-label",
      `Forces over time until ${short(this.clock.end)} s; the largest is ${short(this.largest)} N.`,
    );
    this.legend.replaceChildren(
      ...curves.map((c) =>
        html("li", {}, html("span", { class: `swatch line ${c.style}`, "aria-hidden": "true" }), c.label),
      ),
    );
  }

  // ---- playing ----

  #toggle() {
    if (this.playing) return this.#stop();
    this.playing = true;
    this.button.textContent = "Pause";
    let part = +this.scrub.value >= 1 ? 0 : +this.scrub.value;
    let since = performance.now();
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = (/** @type {number} */ now) => {
      if (!this.playing) return;
      const passed = (now - since) / 1000;
      if (!still || passed >= LASTS / STILLS) {
        part = Math.min(1, part + passed / LASTS);
        since = now;
        this.#show(part, false);
      }
      if (part < 1) requestAnimationFrame(step);
      else this.#stop();
    };
    requestAnimationFrame(step);
  }

  #stop() {
    this.playing = false;
    this.button.textContent = "Play";
    this.change({ at: +this.scrub.value });
  }

  /** @param {number} part @param {boolean} kept */
  #show(part, kept) {
    const t = this.clock.time(part);
    this.scrub.value = String(part);
    const slowing = this.clock.slowing(part);
    const slow = slowing > 1.5 ? `, ${short(slowing, 2)} times slower` : "";
    this.time.textContent = `t = ${short(t)} s${slow}`;
    this.scrub.setAttribute("aria-valuetext", `${short(t)} seconds`);
    const x = this.frame.left(part);
    const { y, height } = this.frame.inside;
    this.cursor.setAttribute("d", `M${x} ${y}v${height}`);
    this.scenes.forEach((scene, i) => {
      scene.update(this.settings.values, this.runs[i].at(t), this.box, this.largest);
    });
    if (kept) this.change({ at: part });
  }
}

/** Tables of the events of both motions, and of the velocities before and after. */
export class EventView {
  /** @param {import("./engine.js").Engine} engine @param {string[]} labels */
  constructor(engine, labels) {
    this.engine = engine;
    this.labels = labels;
    this.jump = html("div", { class: "wide", tabindex: 0, role: "region",
      "aria-label": "velocities before and after" });
    this.tables = labels.map((label) => html("div", { class: "wide", tabindex: 0, role: "region",
      "aria-label": `events, ${label}` }));
    this.element = html("div", {}, this.jump, ...this.tables);
  }

  /** @param {any} settings @param {import("./engine.js").Run[]} runs */
  update(settings, runs) {
    const hit = runs.some((run) => !run.fault && afterImpact(run));
    this.jump.hidden = !hit;
    this.jump.replaceChildren(...(hit ? [this.#velocities(settings, runs)] : []));
    runs.forEach((run, i) => this.tables[i].replaceChildren(this.#events(run, this.labels[i])));
  }

  /** @param {import("./engine.js").Run} run @param {string} label */
  #events(run, label) {
    const forces = run.motion.outputNames.filter((n) => n.startsWith("normal_force"));
    const speeds = this.engine.states.filter((n) => n.endsWith("_dot"));
    const head = ["", "time (s)", "event", "mode after", ...forces.map((f) => `${f.replace("normal_force", "F_n")} (N)`)];
    const rows = run.events.slice(0, 200).map((e, i) => [
      String(i + 1),
      number(e.time, "time"),
      `${e.kind.replaceAll("_", " ")}${e.contact ? ` (${e.contact})` : ""}`,
      e.mode_after.replaceAll("_", " "),
      ...forces.map((f) => number(e.outputs[f], f)),
      ...speeds.map((s) => number(e.after[s], s)),
    ]);
    const { end } = run;
    if (end) {
      rows.push([
        "",
        number(end.time, "time"),
        `end: ${end.stop.name.replaceAll("_", " ")}`,
        end.mode.replaceAll("_", " "),
        ...forces.map((f) => number(end.outputs[f], f)),
        ...speeds.map((s) => number(end.state[s], s)),
      ]);
    }
    return table(`Events, ${label}`, [...head, ...speeds.map((s) => `${pretty(s)} after`)], rows);
  }

  /** @param {any} settings @param {import("./engine.js").Run[]} runs */
  #velocities(settings, runs) {
    const speeds = this.engine.states.filter((n) => n.endsWith("_dot"));
    const rows = [["before", ...speeds.map((s) => number(settings.values[s], s))]];
    for (const [i, run] of runs.entries()) {
      const after = afterImpact(run);
      if (after) rows.push([`${this.labels[i]}: ${after.text}`, ...speeds.map((s) => number(after.state[s], s))]);
      else rows.push([`${this.labels[i]}: ${run.fault ? "not computed" : "no impact"}`, ...speeds.map(() => "")]);
    }
    return table("Velocities before and after the first impact", ["", ...speeds.map(pretty)], rows, true);
  }
}

/**
 * The state after the first impact of a run: where it ends, or where the contact force ends.
 * @param {import("./engine.js").Run} run
 */
export function afterImpact(run) {
  if (run.motion.names.rigid) {
    const own = (/** @type {string[]} */ ...kinds) => run.events.find((e) => kinds.includes(e.kind));
    const end = own("impact_end", "tangential_impact") ?? own("impact");
    return end ? { text: "after the jump", state: end.after } : null;
  }
  const parted = run.events.find((e) => e.kind === "separation");
  return parted ? { text: `at separation, t = ${short(parted.time)} s`, state: parted.after } : null;
}

/** @param {number} value @param {string} name */
const number = (value, name) => html("data", { value, "data-name": name }, short(value, 6));

/** @param {string} title @param {string[]} head @param {any[][]} rows @param {boolean} [named] */
function table(title, head, rows, named = false) {
  return html(
    "table",
    {},
    html("caption", {}, title),
    html("thead", {}, html("tr", {}, head.map((h) =>
      h ? html("th", { scope: "col" }, h) : html("td")))),
    html("tbody", {}, rows.map((row) =>
      html("tr", {}, row.map((cell, i) => html(named && !i ? "th" : "td", named && !i ? { scope: "row" } : {}, cell))))),
  );
}
