/** The explorer: controls, drawings and tables of one mechanism, kept up to date with each other. */

import { load, unpacked } from "./engine.js";
import { html, symbols, terms } from "./draw.js";
import { Controls } from "./controls.js";
import { MapView } from "./map.js";
import { EventView, MotionView } from "./motion.js";
import { ProblemView } from "./problem.js";
import { defaults, fromText, toText } from "./settings.js";

/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {{description: import("./engine.js").Description, module: string,
 *   presets: import("./controls.js").Preset[], initial: Partial<Settings>,
 *   words: Object<string, string>, tolerances: import("./motion.js").Tolerances,
 *   docs: string | null, notes: string[], version: string}} PageData */

/** Choices of laws that the glossary explains by their names. */
const LAW_WORDS = ["reload", "policy"];
/** Of a motion that follows every move of a slider: some tenths of a second of work. */
const MAX_STEPS = 10000;
const MAX_EVENTS = 1000;

/**
 * Fills an element with the explorer; returns it when it can be used.
 * @param {HTMLElement} root @param {PageData} data
 * @param {{link?: boolean, onchange?: (settings: Settings) => void}} [options]
 *   link: whether the address bar holds the settings
 */
export async function mount(root, data, { link = true, onchange } = {}) {
  root.classList.add("painleve");
  const missing = ["WebAssembly", "DecompressionStream"].filter((name) => !(name in globalThis));
  if (missing.length) {
    root.replaceChildren(html("p", { role: "alert" },
      `This page computes with ${missing.join(" and ")}, which this browser lacks: open it in a ` +
        "newer one. `painleve simulate` computes the same numbers."));
    return null;
  }
  const engine = await load(await unpacked(data.module), data.description);
  return new Explorer(root, engine, data, link, onchange);
}

export class Explorer {
  /**
   * @param {HTMLElement} root @param {import("./engine.js").Engine} engine @param {PageData} data
   * @param {boolean} link @param {((settings: Settings) => void) | undefined} onchange
   */
  constructor(root, engine, data, link, onchange) {
    this.root = root;
    this.engine = engine;
    this.data = data;
    this.link = link;
    this.onchange = onchange;
    this.first = defaults(data.description, data.initial);
    this.settings = this.first;
    this.term = terms(data.words);
    const change = this.change.bind(this);
    this.problem = new ProblemView(engine, this.term);
    this.map = new MapView(engine, change, root, this.term);
    this.motion = new MotionView(engine, change, this.term, data.tolerances);
    this.events = new EventView(engine, this.term);
    this.controls = new Controls(engine, data.presets, this.first, change, this.#buttons());
    this.law = html("p", { class: "law" });
    root.replaceChildren(...this.#parts());
    if (link) {
      addEventListener("hashchange", () => this.#read());
      this.#read();
    } else this.#refresh();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.map.key = "";
      this.#refresh();
    });
  }

  #parts() {
    const { data, term } = this;
    const { mechanism, motions } = data.description;
    const beside = motions.length > 1 ? "The same start with a contact that yields, and with a rigid one. " : "";
    const views = html("div", { class: "views", tabindex: -1 },
      this.#section("Motion", this.motion.element, "broad", "impacts",
        `${beside}Arrows are forces of the contact.`),
      this.#section("Cases of the rigid contact", this.map.element, "", "maps",
        "Drag the point: colours say how many motions a rigid contact allows."),
      this.#section("The contact problem at the start", this.problem.element, "", "complementarity",
        [symbols("Each line is the normal acceleration over the force F_n, "), term("A"), symbols(" F_n + "), term("B"),
          ". Where it meets what a contact can do is a solution."]),
      this.#section("Events and velocities", this.events.element, "broad", "reference/events",
        "What happened, in order, and the velocities before and after the first impact."));
    const skip = html("button", { type: "button", class: "skip", onclick: () => views.focus() },
      "Skip to the pictures");
    const words = Object.entries(data.words).map(([word, meaning]) =>
      [html("dt", {}, symbols(word)), html("dd", {}, meaning)]);
    const site = data.docs === null ? null : html("p", { class: "note" }, this.#more("index", "painleve-sym"));
    return [skip,
      html("header", {}, site, html("h1", {}, mechanism.name), html("p", {}, `${mechanism.title}.`), this.law,
        data.notes.map((own) => html("p", { class: "note" }, symbols(own)))),
      html("div", { class: "columns" }, this.controls.element, views),
      html("footer", {},
        html("details", {}, html("summary", {}, "Words of this page"), html("dl", {}, words)),
        mechanism.source ? html("p", {}, `Source: ${mechanism.source}.`) : null,
        html("p", {}, `Computed here by code that painleve-sym ${data.version} generated: SI units, ` +
          `relative tolerance ${data.tolerances.rtol}. `, this.#more("explorer")),
        data.docs === null ? html("p", {}, "The page stands alone; ",
          html("code", {}, "painleve explore --docs ADDRESS"), " adds links to the documentation.") : null)];
  }

  /**
   * @param {string} title @param {any} element @param {string} style
   * @param {string} page of the documentation @param {any} sentence
   */
  #section(title, element, style, page, sentence) {
    const id = `painleve-${Math.random().toString(36).slice(2)}`;
    return html("section", { "aria-labelledby": id, class: style || null }, html("h2", { id }, title),
      html("p", { class: "note" }, sentence, " ", this.#more(page)), element);
  }

  /** A link to a page of the documentation; nothing where the page stands alone. @param {string} page @param {string} [text] */
  #more(page, text = "More") {
    const { docs } = this.data;
    if (docs === null) return "";
    // In a frame of the site, the whole window goes there.
    return html("a", { href: `${docs}/${page}.html`, target: "_top" }, text);
  }

  #buttons() {
    const button = (/** @type {string} */ text, /** @type {() => void} */ onclick) =>
      html("button", { type: "button", onclick }, text);
    const close = button("Close the contact", () => {
      const values = this.engine.closed(this.settings.values, this.settings.contact);
      if (values) this.change({ values });
      else this.controls.say(["No coordinate closes this contact from here."]);
    });
    const reset = button("Reset", () => this.change({ ...this.first }));
    return [close, reset, this.link ? button("Copy link", () => this.#copy()) : null];
  }

  async #copy() {
    try {
      await navigator.clipboard.writeText(location.href);
      this.controls.say([], "The link is in the clipboard.");
    } catch {
      this.controls.say([], "The address bar of the browser has the link; copy it from there.");
    }
  }

  // ---- settings ----

  /** @param {Partial<Settings>} part */
  change(part) {
    this.settings = { ...this.settings, ...part };
    const drawn = Object.keys(part).some((key) => key !== "at");
    if (drawn && !this.waiting) {
      this.waiting = true;
      requestAnimationFrame(() => this.#refresh());
    }
    this.#write();
  }

  #write() {
    this.onchange?.(this.settings);
    if (!this.link) return;
    const text = toText(this.settings, this.first);
    this.written = text;
    history.replaceState(null, "", text ? `#${text}` : `${location.pathname}${location.search}`);
  }

  #read() {
    const text = location.hash.slice(1);
    if (text === this.written) return;
    const { settings, faults } = fromText(text, this.data.description, this.first);
    this.settings = settings;
    this.#refresh();
    this.controls.say(faults);
  }

  #refresh() {
    this.waiting = false;
    const { settings, engine } = this;
    this.controls.update(settings);
    const problem = engine.problem(settings.values, settings.contact);
    const options = { end: settings.end, rtol: this.data.tolerances.rtol, maxSteps: MAX_STEPS, maxEvents: MAX_EVENTS };
    const motions = engine.shown(settings);
    this.law.replaceChildren("Contact law: ", ...motions.flatMap(({ names: { law, choices } }, i) => [
      `${i ? "; beside it " : ""}${law}`,
      ...Object.entries(choices).flatMap(([name, value]) => [", ",
        LAW_WORDS.includes(name) ? this.term(name) : name.replaceAll("_", " "), ` ${value.replaceAll("_", " ")}`]),
    ]), ".");
    this.problem.update(settings, problem);
    this.map.update(settings, problem);
    const runs = motions.map((m) => m.run(settings.values, settings.force, options));
    this.motion.update(settings, runs);
    this.events.update(settings, runs);
    this.root.dataset.ready = "true";
  }
}
