/** The explorer: controls, drawings and tables of one mechanism, kept up to date with each other. */

import { load, unpacked } from "./engine.js";
import { html, short, whole, withUnit } from "./draw.js";
import { MapView } from "./map.js";
import { EventView, MotionView } from "./motion.js";
import { ProblemView } from "./problem.js";
import { defaults, fault, fromText, toText } from "./settings.js";

/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {{name: string, look: string, settings: Partial<Settings>}} Preset */
/** @typedef {{description: import("./engine.js").Description, module: string,
 *   presets: Preset[], initial: Partial<Settings>, version: string}} PageData */

const RTOL = 1e-11;
/** Of a motion that follows every move of a slider: some tenths of a second of work. */
const MAX_STEPS = 10000;
const MAX_EVENTS = 1000;
/** Positions of a slider. */
const NOTCHES = 1000;

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
    const { description } = data;
    this.first = defaults(description, data.initial);
    this.settings = this.first;
    const change = this.change.bind(this);
    this.problem = new ProblemView(engine);
    this.map = new MapView(engine, change, root);
    this.motion = new MotionView(engine, change);
    this.events = new EventView(engine, this.motion.labels);
    /** @type {any[]} */
    this.fields = [];
    this.notice = html("div", { role: "alert", class: "notice" });
    const { mechanism } = description;
    root.replaceChildren(
      html("header", {}, html("h1", {}, mechanism.name), html("p", {}, `${mechanism.title}.`)),
      this.#controls(),
      html("div", { class: "views" },
        section("Which rigid motions are possible", this.map.element),
        section("The contact problem at the start", this.problem.element),
        section("Motion", this.motion.element),
        section("Events and velocities", this.events.element, true)),
      html("footer", {}, mechanism.source ? html("p", {}, `Source: ${mechanism.source}.`) : null,
        html("p", {}, `Computed here by code that painleve-sym ${data.version} generated: SI units, ` +
          `relative tolerance ${RTOL}.`)),
    );
    if (link) {
      addEventListener("hashchange", () => this.#read());
      this.#read();
    } else this.#refresh();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.map.key = "";
      this.#refresh();
    });
  }

  // ---- controls ----

  #controls() {
    const { states, parameters, contacts, motions } = this.data.description;
    const friction = new Set(contacts.map((/** @type {any} */ c) => c.friction));
    const own = new Set(motions.flatMap((m) => m.parameters));
    const isLaw = (/** @type {any} */ p) => p.of === "law" || friction.has(p.name);
    const used = parameters.filter((p) => own.has(p.name));
    const coordinates = states.filter((s) => !s.name.endsWith("_dot"));
    const velocities = states.filter((s) => s.name.endsWith("_dot"));
    return html(
      "section",
      { class: "controls", "aria-label": "state and parameters" },
      this.notice,
      this.#presets(),
      this.#group("Coordinates", coordinates, true),
      this.#group("Velocities", velocities, true),
      this.#group("Contact", used.filter(isLaw), true, this.#force()),
      this.#group("Mechanism", used.filter((p) => !isLaw(p)), false),
      this.#more(),
    );
  }

  /** @param {string} title @param {any[]} quantities @param {boolean} open @param {any[]} more */
  #group(title, quantities, open, more = []) {
    const fields = quantities.map((q) => this.#field(q));
    return html("details", { open }, html("summary", {}, title), ...fields, ...more);
  }

  /** @param {any} q */
  #field(q) {
    const { name, meaning, unit } = q;
    const scale = sliderScale(q);
    const range = html("input", {
      ...{ type: "range", min: 0, max: NOTCHES, step: 1, "aria-label": `${meaning} (${name})` },
      oninput: () => take(scale.value(+range.value)),
    });
    const number = html("input", {
      ...{ type: "number", step: "any", name, title: meaning },
      "aria-label": `${meaning} (${name}), ${unit}`,
      onchange: () => take(number.value === "" ? NaN : +number.value),
    });
    const take = (/** @type {number} */ value) => {
      const problem = fault(q, value);
      number.setAttribute("aria-invalid", String(Boolean(problem)));
      this.#say(problem ? [problem] : []);
      if (!problem) this.change({ values: { ...this.settings.values, [name]: value } });
    };
    this.fields.push((/** @type {Settings} */ { values }) => {
      const text = whole(values[name]);
      if (number.value !== text) number.value = text;
      number.setAttribute("aria-invalid", "false");
      range.value = String(scale.notch(values[name]));
      range.setAttribute("aria-valuetext", `${short(values[name])} ${unit === "1" ? "" : unit}`);
    });
    const label = html("span", { class: "name", title: meaning }, withUnit(name, unit));
    return html("div", { class: "field" }, label, range, number);
  }

  #force() {
    const motion = this.data.description.motions[0];
    if (!motion.pressable) return [];
    const number = html("input", {
      ...{ type: "number", step: "any", min: 0, name: "initial-force", placeholder: "none" },
      "aria-label": "force at the start that compresses the contact, N; none where empty",
      onchange: () => {
        const force = number.value === "" ? null : +number.value;
        if (force !== null && !(force >= 0)) this.#say([`initial force: got ${force}, need >= 0.`]);
        else this.change({ force });
      },
    });
    this.fields.push((/** @type {Settings} */ s) => (number.value = s.force === null ? "" : s.force));
    return [html("div", { class: "field" },
      html("span", { class: "name", title: "compressed at the start" }, "F_n at start (N)"),
      html("span"), number)];
  }

  #more() {
    const { contacts } = this.data.description;
    const end = html("input", {
      ...{ type: "number", step: "any", name: "t-end", "aria-label": "end time, s" },
      onchange: () => {
        if (+end.value > 0) this.change({ end: +end.value });
        else this.#say([`end time: got ${end.value || "nothing"}, need a number > 0.`]);
      },
    });
    this.fields.push((/** @type {Settings} */ s) => (end.value = String(s.end)));
    const rows = [html("div", { class: "field" }, html("span", { class: "name" }, "end time (s)"),
      html("span"), end)];
    if (contacts.length > 1) {
      const names = contacts.map((/** @type {any} */ c, /** @type {number} */ i) =>
        html("option", { value: i }, c.name));
      const select = html("select", { onchange: () => this.change({ contact: +select.value }) }, names);
      this.fields.push((/** @type {Settings} */ s) => (select.value = String(s.contact)));
      rows.push(html("label", { class: "row" }, "contact of the map and the problem ", select));
    }
    const button = (/** @type {string} */ text, /** @type {() => void} */ onclick) =>
      html("button", { type: "button", onclick }, text);
    const close = button("Close the contact", () => {
      const values = this.engine.closed(this.settings.values, this.settings.contact);
      if (values) this.change({ values });
      else this.#say(["No coordinate closes this contact from here."]);
    });
    rows.push(html("div", { class: "row" }, close, button("Reset", () => this.set(this.first)),
      this.link ? button("Copy link", () => this.#copy()) : null));
    return html("details", { open: true }, html("summary", {}, "Run"), ...rows);
  }

  #presets() {
    const { presets } = this.data;
    if (!presets.length) return null;
    const look = html("p", { class: "note", role: "status" });
    const options = presets.map((p, i) => html("option", { value: i }, p.name));
    const select = html("select", {
      onchange: () => {
        const preset = presets[+select.value];
        look.textContent = preset ? preset.look : "";
        if (preset) this.set(defaults(this.data.description, { ...this.data.initial, ...preset.settings }));
      },
    }, html("option", { value: "" }, "choose …"), options);
    this.fields.push((/** @type {Settings} */ s) => {
      const same = presets.findIndex((p) => {
        const own = defaults(this.data.description, { ...this.data.initial, ...p.settings });
        const [a, b] = [s, own].map(({ values, force }) => JSON.stringify([values, force]));
        return a === b;
      });
      select.value = same < 0 ? "" : String(same);
      look.textContent = same < 0 ? "" : presets[same].look;
    });
    return html("div", { class: "presets" }, html("label", {}, "from the paper ", select), look);
  }

  async #copy() {
    try {
      await navigator.clipboard.writeText(location.href);
      this.#say(["The link is in the clipboard."]);
    } catch {
      this.#say(["The address bar of the browser has the link; copy it from there."]);
    }
  }

  /** @param {string[]} sentences */
  #say(sentences) {
    this.notice.replaceChildren(...sentences.map((s) => html("p", { class: "fault" }, s)));
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

  /** @param {Settings} settings */
  set(settings) {
    this.change({ ...settings });
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
    this.#say(faults);
  }

  #refresh() {
    this.waiting = false;
    const { settings, engine } = this;
    for (const field of this.fields) field(settings);
    const problem = engine.problem(settings.values, settings.contact);
    const options = { end: settings.end, rtol: RTOL, maxSteps: MAX_STEPS, maxEvents: MAX_EVENTS };
    this.problem.update(settings, problem);
    this.map.update(settings, problem);
    const runs = engine.motions.map((m) => m.run(settings.values, settings.force, options));
    this.motion.update(settings, runs);
    this.events.update(settings, runs);
    this.root.dataset.ready = "true";
  }
}

/** @param {string} title @param {any} element @param {boolean} [broad] */
function section(title, element, broad = false) {
  const id = `painleve-${Math.random().toString(36).slice(2)}`;
  return html("section", { "aria-labelledby": id, class: broad ? "broad" : null }, html("h2", { id }, title), element);
}

/**
 * Numbers of a slider's notches, in equal steps or by orders of magnitude.
 * @param {any} quantity
 */
export function sliderScale({ range: [low, high], logarithmic }) {
  const [from, to] = logarithmic ? [Math.log(low), Math.log(high)] : [low, high];
  return {
    value: (/** @type {number} */ notch) => {
      const value = from + ((to - from) * notch) / NOTCHES;
      return +(logarithmic ? Math.exp(value) : value).toPrecision(4);
    },
    notch: (/** @type {number} */ value) => {
      const at = logarithmic ? Math.log(value) : value;
      return Math.min(NOTCHES, Math.max(0, Math.round((NOTCHES * (at - from)) / (to - from))));
    },
  };
}
