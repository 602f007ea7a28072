/** The map over two quantities: cases of the rigid contact, or outcomes of motions. */

import { Frame, WIDTH, HEIGHT, html, pretty, short, svg, withUnit, zeros } from "./draw.js";

/** @typedef {import("./settings.js").Settings} Settings */

/** Colour and words of each case, and of each outcome. @type {Object<string, [string, string]>} */
const CASES = {
  slip: ["--slip", "slip: one solution"],
  liftoff: ["--liftoff", "lift-off: one solution"],
  inconsistent: ["--none", "no solution"],
  indeterminate: ["--two", "several solutions"],
  outside: ["--outside", "outside the model"],
};
/** @type {Object<string, [string, string]>} */
const OUTCOMES = {
  open: ["--opens", "lifts off at once"],
  separation: ["--parts", "pressed into the ground, then released"],
  liftoff: ["--parts", "lifts off later"],
  slip_stop: ["--stops", "the slip stops"],
  "no event": ["--slides", "slides to the end"],
  left_domain: ["--leaves", "leaves the model"],
  outside: ["--outside", "outside the model"],
};
const OTHERS = ["--other-1", "--other-2", "--other-3"];
/** Part of a map that its point keeps from the edge. */
const ROOM = 0.1;

/** Kinds of events that decide what follows from a start. */
export const DECIDING = [
  ...["slip_stop", "separation", "liftoff", "impact", "jam", "singular", "tangential_impact"],
  ...["force_reversal"],
];

const POINTS = 121;
export const RUNS = 100;
/** Milliseconds of work between two pictures of a map that fills. */
const PORTION = 30;
const LOOSE = 1e-6;

/**
 * The range of an axis, wider where the point of the map would be at its edge or beyond.
 * @param {any} quantity @param {number} value
 */
export function rangeAround({ range: [low, high], lower, upper }, value) {
  const room = ROOM * (high - low);
  const ends = [value < low + room / 2 ? value - room : low, value > high - room / 2 ? value + room : high];
  // Where the range ends at a bound of the quantity, there is nothing beyond.
  return [Math.max(ends[0], Math.min(low, lower ?? -Infinity)), Math.min(ends[1], Math.max(high, upper ?? Infinity))];
}

export class MapView {
  /**
   * @param {import("./engine.js").Engine} engine
   * @param {(change: Partial<Settings>) => void} change
   * @param {Element} root @param {import("./draw.js").Term} term
   */
  constructor(engine, change, root, term) {
    this.engine = engine;
    this.change = change;
    this.root = root;
    this.term = term;
    this.key = "";
    this.turn = 0;
    this.held = false;
    // Set by the first update.
    this.settings = /** @type {Settings} */ (/** @type {unknown} */ (null));
    this.frame = /** @type {Frame} */ (/** @type {unknown} */ (null));
    /** @type {any} */
    this.problem = null;
    /** @type {any[]} */
    this.quantities = [...engine.description.states, ...engine.description.parameters];
    this.picture = svg("image", { preserveAspectRatio: "none", class: "raster" });
    this.lines = svg("g");
    this.axes = svg("g");
    this.point = svg("g", {
      ...{ tabindex: 0, role: "slider", class: "point", onkeydown: this.#keys.bind(this) },
      ...{ "aria-label": "start state on the map; arrow keys move it", "aria-valuenow": 0 },
    }, svg("circle", { r: 13, class: "halo" }), svg("circle", { r: 5 }));
    this.figure = svg(
      "svg",
      {
        ...{ viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "map", role: "group" },
        ...{ onpointerdown: this.#down.bind(this), onpointermove: this.#move.bind(this) },
        ...{ "aria-label": "map over two quantities", onpointerup: () => (this.held = false) },
      },
      ...[this.picture, this.lines, this.axes, this.point],
    );
    this.legend = html("ul", { class: "legend" });
    this.note = html("p", { class: "note", role: "status" });
    const { domain } = engine.description;
    // Where in the domain it ends is not said of a region.
    const ends = [...new Set(domain.map((meaning) => meaning.replace(/ at .*/, "")))].join(" or ");
    this.outcomes = { ...OUTCOMES, ...(ends && { left_domain: ["--leaves", ends] }) };
    this.choices = [0, 1].map((i) => this.#axis(i));
    const kinds = [["contact", "rigid contact"], ["outcomes", `outcomes of ${RUNS}² motions`]];
    this.kinds = kinds.map(([value, text]) => {
      const radio = html("input", {
        ...{ type: "radio", name: `map-${Math.random()}`, value },
        onchange: () => this.change({ map: /** @type {any} */ (value) }),
      });
      return { value, radio, label: html("label", {}, radio, ` ${text}`) };
    });
    this.element = html(
      "div",
      {},
      html("div", { class: "row" }, this.choices.map((c) => c.label)),
      html("div", { class: "row", role: "radiogroup", "aria-label": "what the map shows" },
        this.kinds.map((k) => k.label)),
      ...[this.figure, this.legend, this.note],
    );
  }

  /** @param {number} i */
  #axis(i) {
    const options = this.quantities.map((q) => {
      return html("option", { value: q.name }, withUnit(q.name, q.unit));
    });
    const select = html("select", {
      onchange: () => {
        const over = [...this.settings.over];
        // The other axis takes the old name where both would be the same.
        if (over[1 - i] === select.value) over[1 - i] = over[i];
        over[i] = select.value;
        this.change({ over });
      },
    }, options);
    return { select, label: html("label", {}, `${["across", "up"][i]} `, select) };
  }

  /** @param {string} name */
  #range(name) {
    return rangeAround(this.quantities.find((q) => q.name === name), this.settings.values[name]);
  }

  /** @param {Settings} settings @param {any} problem */
  update(settings, problem) {
    this.settings = settings;
    this.problem = problem;
    const [a, b] = settings.over;
    this.choices.forEach((c, i) => (c.select.value = settings.over[i]));
    this.kinds.forEach((k) => (k.radio.checked = k.value === settings.map));
    const held = { ...settings.values };
    delete held[a];
    delete held[b];
    const slip = problem.slip || -1;
    const ranges = [this.#range(a), this.#range(b)];
    const { end, force, reload } = settings;
    const own = settings.map === "contact" ? [slip] : [end, force, reload];
    const key = JSON.stringify([settings.over, settings.map, settings.contact, held, ranges, own]);
    if (key !== this.key) {
      this.key = key;
      this.frame = new Frame(ranges[0], ranges[1]);
      const units = settings.over.map((n) => this.quantities.find((q) => q.name === n).unit);
      const labels = settings.over.map((n, i) => withUnit(n, units[i]));
      this.axes.replaceChildren(this.frame.axes(labels[0], labels[1]));
      for (const [name, value] of Object.entries(this.frame.inside)) {
        this.picture.setAttribute(name, value);
      }
      this.lines.replaceChildren();
      this.turn++;
      if (settings.map === "contact") this.#cases(slip);
      else this.#outcomes(this.turn);
    }
    this.#place();
  }

  #place() {
    const [a, b] = this.settings.over;
    const [x, y] = [this.settings.values[a], this.settings.values[b]];
    const place = `translate(${this.frame.left(x)} ${this.frame.top(y)})`;
    this.point.setAttribute("transform", place);
    const text = `${pretty(a)} = ${short(x)}, ${pretty(b)} = ${short(y)}: ${this.problem.word.name}`;
    this.point.setAttribute("aria-valuetext", text);
    this.point.setAttribute("aria-valuenow", x);
    this.point.setAttribute("aria-valuemin", this.frame.x[0]);
    this.point.setAttribute("aria-valuemax", this.frame.x[1]);
  }

  /** @param {number} slip */
  #cases(slip) {
    const { over, contact, values } = this.settings;
    const { cases, push, B, pull } = this.engine.map(
      ...[values, over[0], this.frame.x, POINTS, over[1], this.frame.y, POINTS, contact, slip],
    );
    const bilateral = this.engine.description.contacts[contact].bilateral;
    this.#paint(cases, POINTS, CASES);
    const fields = [["A", push], ["B", B], ...(bilateral ? [["A in pull", pull]] : [])];
    for (const [i, [name, grid]] of fields.entries()) {
      const pieces = zeros((p, q) => /** @type {any} */ (grid)[p * POINTS + q], POINTS, POINTS);
      if (!pieces.length) continue;
      const d = pieces.map((piece) => this.frame.path(piece.map((end) => this.#ofGrid(end)))).join("");
      this.lines.append(svg("path", { d, class: `zero zero-${i}` }));
      this.legend.append(this.#entry(`line zero-${i}`, "", `${name} = 0`, /** @type {string} */ (name)));
    }
    const { name } = this.engine.description.contacts[contact];
    const several = this.engine.description.contacts.length > 1;
    this.note.textContent =
      `Drawn as if ${several ? `${name} alone` : "the contact"} were closed and ` +
      `slid to the ${slip < 0 ? "left" : "right"}.`;
  }

  /** @param {number[]} place */
  #ofGrid(place) {
    return [this.frame.x, this.frame.y].map(([low, high], i) => {
      return low + ((high - low) * place[i]) / (POINTS - 1);
    });
  }

  /** Fills the map column by column, so that the page stays responsive. @param {number} turn */
  async #outcomes(turn) {
    const { engine, settings, frame } = this;
    const [motion] = engine.shown(settings);
    const words = new Array(RUNS * RUNS).fill("outside");
    const [a, b] = settings.over.map((name) => engine.index(name));
    const options = { end: settings.end, rtol: LOOSE, maxSteps: 2000 };
    const until = DECIDING.filter((k) => k !== "liftoff" || motion.names.rigid.length);
    let [spent, since] = [0, performance.now()];
    for (let i = 0; i < RUNS; i++) {
      const x = frame.x[0] + ((frame.x[1] - frame.x[0]) * i) / (RUNS - 1);
      const line = /** @type {any} */ ([b, frame.y, RUNS]);
      const column = motion.outcomes(
        ...[settings.values, settings.force, line, /** @type {any} */ ([a, x]), options, until],
      );
      column.forEach((word, j) => (words[i * RUNS + j] = word));
      const now = performance.now();
      if (now - since < PORTION && i < RUNS - 1) continue;
      spent += now - since;
      this.#paint(words, RUNS, this.outcomes);
      this.note.textContent =
        `${(i + 1) * RUNS} motions with the law ${motion.names.law} until ` +
        `t = ${short(settings.end)} s, computed in ${short(spent / 1000, 2)} s.`;
      await new Promise((resolve) => setTimeout(resolve));
      if (turn !== this.turn) return;
      since = performance.now();
    }
    this.note.dataset.seconds = String(spent / 1000);
    // The page reads its own motions again.
    motion.set(settings.values);
  }

  /** @param {string} style @param {string} colour @param {string} text @param {string} [word] */
  #entry(style, colour, text, word) {
    const swatch = html("span", { class: `swatch ${style}`, "aria-hidden": "true" });
    if (colour) swatch.style.background = `var(${colour})`;
    return html("li", {}, swatch, this.term(text, word));
  }

  /** @param {string[]} words @param {number} count @param {any} legend words and colours */
  #paint(words, count, legend) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = count;
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const style = getComputedStyle(this.root);
    const image = context.createImageData(count, count);
    /** @type {Object<string, {colour: string, text: string, rgb: number[], count: number}>} */
    const known = {};
    let others = 0;
    for (const [i, word] of words.entries()) {
      const own = (known[word] ??= (() => {
        const [colour, text] = legend[word] ?? [OTHERS[others++ % OTHERS.length], word.replaceAll("_", " ")];
        const digits = style.getPropertyValue(colour).trim().slice(1);
        const rgb = [0, 2, 4].map((k) => parseInt(digits.slice(k, k + 2), 16));
        return { colour, text, rgb, count: 0 };
      })());
      own.count++;
      const at = 4 * ((count - 1 - (i % count)) * count + Math.floor(i / count));
      image.data.set([...own.rgb, 255], at);
    }
    context.putImageData(image, 0, 0);
    this.picture.setAttribute("href", canvas.toDataURL());
    this.counts = Object.fromEntries(Object.entries(known).map(([w, k]) => [w, k.count]));
    this.figure.dataset.counts = JSON.stringify(this.counts);
    this.legend.replaceChildren(
      ...Object.entries(known).map(([word, k]) => {
        const part = short((100 * k.count) / words.length, 2);
        return this.#entry("", k.colour, `${k.text} (${part} %)`, word.replaceAll("_", " "));
      }),
    );
  }

  // ---- the point that is dragged ----

  /** @param {PointerEvent} event */
  #down(event) {
    this.held = true;
    this.figure.setPointerCapture(event.pointerId);
    this.#move(event);
    this.point.focus({ preventScroll: true });
    event.preventDefault();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (!this.held) return;
    const box = this.figure.getBoundingClientRect();
    const left = ((event.clientX - box.left) / box.width) * WIDTH;
    const top = ((event.clientY - box.top) / box.height) * HEIGHT;
    // Four digits: a place on the screen has no more.
    this.#take(this.frame.at(left, top).map((v) => +v.toPrecision(4)));
  }

  /** @param {number[]} place */
  #take(place) {
    const [a, b] = this.settings.over;
    this.change({ values: { ...this.settings.values, [a]: place[0], [b]: place[1] } });
  }

  /** @param {KeyboardEvent} event */
  #keys(event) {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
    const move = /** @type {any} */ (moves)[event.key];
    if (!move) return;
    event.preventDefault();
    const part = event.shiftKey ? 0.1 : 0.01;
    this.#take(
      [this.frame.x, this.frame.y].map((range, i) => {
        const value = this.settings.values[this.settings.over[i]];
        const next = value + move[i] * part * (range[1] - range[0]);
        return +Math.min(range[1], Math.max(range[0], next)).toPrecision(5);
      }),
    );
  }
}
