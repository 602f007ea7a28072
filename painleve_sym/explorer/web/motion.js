/** Motions over time: animation of the mechanism, forces, events, and the jump beside them. */

import { Clock } from "./clock.js";
import { Frame, WIDTH, HEIGHT, html, pretty, short, span, svg, symbols } from "./draw.js";
import { Scene, magnification, windowOf } from "./scene.js";

/** @typedef {import("./draw.js").Term} Term */
/** @typedef {import("./engine.js").Run} Run */

/** Seconds that an animation lasts, and still pictures in its place where motion is unwanted. */
const LASTS = 8;
const STILLS = 12;
const SAMPLES = 500;
const FRAMES = 24;
/** Events with a line of their own among the forces, those with a number, and rows of a table. */
const [LINES, NUMBERED, ROWS] = [60, 12, 200];

/** @typedef {{rtol: number, openFrom: number}} Tolerances of the motions, and the residual from which
 *   on an energy balance does not close */

/** @type {Object<string, string>} */
const MODES = {
  slip_neg: "slip to the left",
  slip_pos: "slip to the right",
  flight_indented: "flight, indented",
};

/** Words of a mode for readers, each with its meaning. @param {string} mode @param {Term} term */
export const modeWords = (mode, term) =>
  mode.split(", ").map((own, i) => {
    const [, contact, words] = /** @type {string[]} */ (/^(.*: )?(.*)$/.exec(own));
    const parts = words.split("/").map((part, k) => {
      const text = part.replaceAll("_", " ");
      return [k ? ", " : "", term(MODES[part] ?? text, text)];
    });
    return [i ? "; " : "", contact ?? "", parts];
  });

/** What a motion is called, and with its law. @param {Run} run */
const kindOf = ({ motion: { names } }) => (names.rigid.length ? "rigid" : "compliant");

/**
 * What to know of a run that did not simply end: sentences of faults, and of what is ordinary.
 * @param {Run} run @param {Tolerances} tolerances
 */
export function remarks(run, { rtol, openFrom }) {
  const [kind, { end, fault, motion }] = [kindOf(run), run];
  /** @type {{faults: string[], notes: string[]}} */
  const said = { faults: [], notes: [] };
  if (fault || !end) {
    said.faults.push(`${kind}: ${fault}.`);
    return said;
  }
  const { stop, time, residual } = end;
  const at = `${kind}: the motion ends at t = ${short(time)} s`;
  if (stop.name === "left_domain") {
    said.notes.push(`${at}: ${motion.engine.bound({ ...run.values, ...end.state })}.`);
  } else if (stop.name.endsWith("_limit")) {
    const what = stop.name.replace("_limit", "s");
    said.faults.push(`${at}: the page follows no more ${what}. Fix: end earlier, or use painleve simulate.`);
  } else if (!["t_end", "until"].includes(stop.name)) said.faults.push(`${at}: ${stop.sentence}.`);
  const gains = run.events.filter((e) => e.kind === "reload")
    .map((e) => e.before.contact_dissipation - e.after.contact_dissipation).filter((gain) => gain > 0);
  if (gains.length) {
    const count = gains.length === 1 ? "1 reload creates" : `${gains.length} reloads create`;
    said.notes.push(`${kind}: ${count} ${short(gains.reduce((a, b) => a + b), 3)} J by the reload rule ` +
      `${motion.names.choices.reload}, which is thermodynamically inadmissible.`);
  }
  if (residual < openFrom) said.notes.push(`${kind}: the energy balance closes to ${short(residual, 2)}.`);
  else if (!Number.isFinite(residual)) said.faults.push(`${kind}: The energies are not finite.`);
  else {
    said.faults.push(`${kind}: The energy balance is off by ${short(100 * residual, 2)} % of its largest ` +
      `term, more than rtol ${rtol} explains: works and energies are not exact, and states may not be.`);
  }
  return said;
}

/** How many events are rounding, which are not listed. @param {Run} run */
function foldedWords({ events, eventsAboveTolerance: { length } }) {
  const count = events.length - length;
  return count ? `${count} ${count === 1 ? "event" : "events"} below the tolerance` : "";
}

/** What the lines among the forces are. @param {number} count of events */
export function eventWords(count) {
  if (count > LINES) return `events, the first ${LINES} of ${count}`;
  return count > NUMBERED ? "events" : "events, numbered as below";
}

export class MotionView {
  /**
   * @param {import("./engine.js").Engine} engine
   * @param {(change: any) => void} change @param {Term} term @param {Tolerances} tolerances
   */
  constructor(engine, change, term, tolerances) {
    this.engine = engine;
    this.change = change;
    this.term = term;
    this.tolerances = tolerances;
    this.playing = false;
    // Set by the first update.
    this.clock = /** @type {Clock} */ (/** @type {unknown} */ (null));
    this.frame = /** @type {Frame} */ (/** @type {unknown} */ (null));
    /** @type {any} */
    this.settings = null;
    /** @type {Run[]} */
    this.runs = [];
    /** @type {any} */
    this.box = null;
    this.bent = 1;
    this.largest = 0;
    this.cursor = svg("path", { class: "cursor" });
    const { motions, scene } = engine.description;
    const titles = [...new Set(motions.map((m) => (m.rigid.length ? "rigid" : "compliant")))];
    this.scenes = scene ? titles.map((title) => new Scene(engine, title, term)) : [];
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
    this.notes = html("div", { class: "note", role: "status" });
    this.element = html(
      "div",
      { class: "motion" },
      this.faults,
      html("div", {},
        html("div", { class: "pair" }, this.scenes.map((s) => s.element)),
        html("div", { class: "row" }, this.button, this.scrub, this.time),
        html("label", { class: "row" }, "magnify short times ", this.magnify),
        this.notes),
      html("div", {}, this.figure, this.legend),
    );
  }

  /** @param {any} settings @param {Run[]} runs */
  update(settings, runs) {
    this.settings = settings;
    this.runs = runs;
    this.magnify.value = settings.magnify;
    const longest = runs.reduce((a, b) => ((b.end?.time ?? 0) > (a.end?.time ?? 0) ? b : a));
    const busiest = runs.reduce((a, b) => (b.times.length > a.times.length ? b : a));
    const end = longest.end?.time ?? 0;
    const times = [...busiest.times.filter((t) => t < end), end];
    this.clock = new Clock(end > 0 ? times : [0, 1], settings.magnify);
    this.#window();
    this.#say();
    this.#forces();
    this.#show(settings.at, false);
  }

  #say() {
    const all = this.runs.map((run) => remarks(run, this.tolerances));
    const { scene } = this.engine.description;
    const notes = all.flatMap((r) => r.notes);
    if (this.bent > 1) notes.unshift(`Deflections are drawn ${short(this.bent)} times as large.`);
    if (!scene) notes.unshift("This mechanism has neither shapes nor bodies, so it is not drawn.");
    if (!scene?.declared && (!scene || scene.shapes.some((s) => s.kind === "dot"))) {
      notes.unshift("[[shapes]] in the mechanism's file say how it looks (page Mechanisms, section Shapes).");
    }
    const paragraphs = (/** @type {string[]} */ sentences, /** @type {string} */ style) =>
      sentences.map((s) => html("p", { class: style }, s));
    this.faults.replaceChildren(...paragraphs(all.flatMap((r) => r.faults), "fault"));
    this.notes.replaceChildren(...paragraphs(notes, ""));
  }

  #window() {
    if (!this.scenes.length) return;
    const states = this.runs.flatMap((run) => {
      const parts = Array.from({ length: FRAMES + 1 }, (_, i) => i / FRAMES);
      return parts.flatMap((p) => [run.at(this.clock.time(p))?.state ?? []].flat());
    });
    this.bent = magnification(this.engine, this.settings.values, states);
    this.box = windowOf(this.engine, this.settings.values, states, this.bent);
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
        const { contacts } = this.engine.description;
        const contact = contacts.findIndex((c) => name.endsWith(`_${c.name}`));
        const kind = name.startsWith("normal") ? "normal" : "tangential";
        const of = contact < 0 ? "" : ` of ${contacts[contact].name}`;
        const label = `${kind === "normal" ? "F_n" : "F_t"}${of}, ${kindOf(run)}`;
        curves.push({ label, style: `${kind} motion-${i} contact-${contact}`, points });
      }
    }
    const values = curves.flatMap((c) => c.points.map((p) => p[1]));
    this.largest = Math.max(...values.filter(Number.isFinite).map(Math.abs), 0);
    const frame = new Frame([0, 1], this.largest ? span(values) : [0, 1]);
    this.frame = frame;
    const marks = this.clock.marks().map(({ at, time }) => ({ at, text: short(time, 3) }));
    const main = this.runs.find((run) => run.end);
    const listed = main?.eventsAboveTolerance ?? [];
    const events = listed.slice(0, LINES);
    const folded = main ? foldedWords(main) : "";
    const time = this.settings.magnify ? "time (s), magnified where it is short" : "time (s)";
    const { x, y, width, height } = frame.inside;
    const middle = { x: x + width / 2, y: y + height / 2, "text-anchor": "middle" };
    this.figure.replaceChildren(
      frame.axes(time, "force (N)", marks),
      ...events.map((e, i) => {
        const at = this.clock.part(e.time);
        const d = frame.path([[at, frame.y[0]], [at, frame.y[1]]]);
        const text = `${e.kind.replaceAll("_", " ")} at ${short(e.time)} s`;
        // Numbers of near events stand on two lines.
        const place = { x: frame.left(at), y: i % 2 ? 28 : 19, "text-anchor": "middle" };
        return svg("g", { class: "event" }, svg("path", { d }), svg("title", {}, text),
          events.length > NUMBERED ? null : svg("text", place, i + 1));
      }),
      ...curves.map((c) => svg("path", { d: frame.path(c.points), class: `curve ${c.style}` })),
      ...(this.largest ? [] : [svg("text", middle, "no contact force until the end")]),
      this.cursor,
    );
    this.figure.setAttribute(
      "aria-label",
      `Forces over time until ${short(this.clock.end)} s; the largest is ${short(this.largest)} N.`,
    );
    this.legend.replaceChildren(
      ...curves.map((c) =>
        html("li", {}, html("span", { class: `swatch line ${c.style}`, "aria-hidden": "true" }), symbols(c.label)),
      ),
      events.length ? html("li", {},
        html("span", { class: "swatch line event", "aria-hidden": "true" }), eventWords(listed.length)) : "",
      ...(folded ? [html("li", {}, folded)] : []),
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
      const moment = this.runs[i].at(t);
      const mode = moment && html("span", {}, modeWords(moment.mode, this.term));
      scene.update(this.settings.values, moment, this.box, this.largest, this.bent, mode);
    });
    if (kept) this.change({ at: part });
  }
}

/** Tables of the events of both motions, and of the velocities before and after. */
export class EventView {
  /** @param {import("./engine.js").Engine} engine @param {Term} term */
  constructor(engine, term) {
    this.engine = engine;
    this.term = term;
    this.speeds = engine.states.filter((n) => n.endsWith("_dot"));
    const units = new Map(engine.description.states.map((s) => [s.name, s.unit]));
    /** @param {string} name @param {string} moment */
    this.head = (name, moment = "") => `${pretty(name)}${moment} (${units.get(name)})`;
    this.element = html("div", {});
  }

  /** @param {any} settings @param {Run[]} runs */
  update(settings, runs) {
    const jump = runs.some((run) => !run.fault && afterImpact(run));
    this.element.replaceChildren(
      ...(jump ? [scrolled("velocities before and after", this.#velocities(settings, runs))] : []),
      ...runs.filter((run) => run.end).map((run) => scrolled(`events, ${kindOf(run)}`, this.#events(run))),
    );
  }

  /** @param {Run} run */
  #events(run) {
    const forces = run.motion.outputNames.filter((n) => n.startsWith("normal_force"));
    const head = ["", "time (s)", "event", "mode after",
      ...forces.map((f) => `${f.replace("normal_force", "F_n")} (N)`),
      ...this.speeds.map((s) => this.head(s, " after"))];
    const { length } = run.eventsAboveTolerance;
    const rows = run.eventsAboveTolerance.slice(0, ROWS).map((e, i) => [
      String(i + 1),
      [e.time],
      [this.#word(e.kind, e.sentence), e.contact ? ` (${e.contact})` : ""],
      modeWords(e.mode_after, this.term),
      ...forces.map((f) => [e.outputs[f]]),
      ...this.speeds.map((s) => [e.after[s]]),
    ]);
    const { end } = run;
    if (end) {
      rows.push(["", [end.time], ["end: ", this.#word(end.stop.name, end.stop.sentence)],
        modeWords(end.mode, this.term), ...forces.map((f) => [end.outputs[f]]),
        ...this.speeds.map((s) => [end.state[s]])]);
    }
    const names = ["", "time", "", "", ...forces, ...this.speeds];
    const few = length > ROWS ? `, the first ${ROWS} of ${length}` : "";
    const folded = foldedWords(run);
    const title = `Events, ${kindOf(run)}${few}${folded && `, without ${folded}`}`;
    return table(title, head, rows, names, [run]);
  }

  /** A kind with its sentence. @param {string} name @param {string} sentence */
  #word(name, sentence) {
    return html("abbr", { title: sentence }, name.replaceAll("_", " "));
  }

  /** @param {any} settings @param {Run[]} runs */
  #velocities(settings, runs) {
    const rows = [["before", ...this.speeds.map((s) => [settings.values[s]])]];
    for (const run of runs) {
      const after = afterImpact(run);
      const text = after?.text ?? (run.fault ? "not computed" : "no impact");
      rows.push([`${kindOf(run)}: ${text}`, ...this.speeds.map((s) => (after ? [after.state[s]] : ""))]);
    }
    const head = ["", ...this.speeds.map((s) => this.head(s))];
    return table("Velocities before and after the first impact", head, rows, ["", ...this.speeds], runs);
  }
}

/** A region that scrolls by itself, also by keys. @param {string} label @param {any} content */
const scrolled = (label, content) =>
  html("div", { class: "wide", tabindex: 0, role: "region", "aria-label": label }, content);

/**
 * The state after the first impact of a run: where it ends, or where the contact force ends.
 * @param {import("./engine.js").Run} run
 */
export function afterImpact(run) {
  if (run.motion.names.rigid.length) {
    const own = (/** @type {string[]} */ ...kinds) => run.events.find((e) => kinds.includes(e.kind));
    const end = own("impact_end", "tangential_impact") ?? own("impact");
    return end ? { text: "after the jump", state: end.after } : null;
  }
  const parted = run.events.find((e) => e.kind === "separation");
  return parted ? { text: `at separation, t = ${short(parted.time)} s`, state: parted.after } : null;
}

/**
 * A table. A cell of one number is an array of it; the others are texts or elements.
 * @param {string} title @param {any[]} head @param {any[][]} rows @param {string[]} names
 * @param {Run[]} runs whose tolerance says which speeds and forces are 0
 */
function table(title, head, rows, names, runs) {
  const isNumber = (/** @type {any} */ cell) => Array.isArray(cell) && typeof cell[0] === "number";
  const zeros = names.map((name) => (/_dot$|_force/.test(name) ? Math.max(...runs.map((r) => r.tolerance(name))) : 0));
  const content = (/** @type {any} */ cell, /** @type {number} */ k) => {
    if (!isNumber(cell)) return cell;
    const value = Math.abs(cell[0]) <= zeros[k] ? 0 : cell[0];
    return html("data", { value: cell[0], "data-name": names[k] }, short(value, 6));
  };
  // The first column names the rows where it is a text of words.
  const named = (/** @type {any} */ cell, /** @type {number} */ k) => !k && /[a-z]/.test(cell);
  return html(
    "table",
    {},
    html("caption", {}, title),
    html("thead", {}, html("tr", {}, head.map((h) =>
      h ? html("th", { scope: "col" }, symbols(h)) : html("td")))),
    html("tbody", {}, rows.map((row) => html("tr", {}, row.map((cell, k) =>
      named(cell, k) ? html("th", { scope: "row" }, cell) : html("td", {}, content(cell, k)))))),
  );
}
