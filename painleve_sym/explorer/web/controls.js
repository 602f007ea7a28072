/** The controls of a page: sliders and numbers, those that teach first before the others. */

import { html, pretty, short, symbols, typeset, whole } from "./draw.js";
import { defaults, fault, reloads } from "./settings.js";

/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {{name: string, look: string, settings: Partial<Settings>}} Preset */

/** Positions of a slider. */
const NOTCHES = 1000;
/** Digits of a number in its field; the address bar has all of them. */
const DIGITS = 8;
/** Orders of magnitude around the end time at first. */
const TIMES = 100;

export class Controls {
  /**
   * @param {import("./engine.js").Engine} engine @param {Preset[]} presets @param {Settings} first
   * @param {(part: Partial<Settings>) => void} change @param {any[]} buttons
   */
  constructor(engine, presets, first, change, buttons) {
    this.description = engine.description;
    this.change = change;
    this.first = first;
    this.settings = first;
    /** What brings a control up to date. @type {((settings: Settings) => void)[]} */
    this.fields = [];
    this.notice = html("div", { role: "alert", class: "fault" });
    this.status = html("p", { role: "status", class: "note" });
    const { states, parameters, contacts, motions } = this.description;
    const used = new Set(motions.flatMap((m) => m.parameters));
    const every = [...states, ...parameters.filter((p) => used.has(p.name))];
    const [few, more] = [true, false].map((own) => every.filter((q) => q.leading === own));
    const friction = new Set(contacts.map((/** @type {any} */ c) => c.friction));
    const kind = (/** @type {any} */ q) =>
      q.of === undefined ? "state" : q.of === "law" || friction.has(q.name) ? "contact" : "mechanism";
    const group = (/** @type {string} */ title, /** @type {string} */ of) => {
      const own = more.filter((q) => kind(q) === of).map((q) => this.#quantity(q));
      return own.length ? html("details", {}, html("summary", {}, title), own) : null;
    };
    this.drawer = html("button", {
      ...{ type: "button", class: "drawer", "aria-expanded": "false" },
      onclick: () => this.#open(!this.element.hasAttribute("data-open")),
    }, "All controls");
    this.element = html("aside", { class: "controls", "aria-label": "state and parameters" },
      this.drawer, this.notice, this.status, this.#presets(presets),
      few.map((q) => this.#quantity(q)), this.#end(), this.#force(), this.#reload(), this.#contact(),
      html("div", { class: "row" }, buttons),
      group("Other coordinates and velocities", "state"),
      group("Contact law", "contact"),
      group("Mechanism", "mechanism"));
    this.element.querySelector(".field").classList.add("chosen");
    for (const event of ["focusin", "pointerdown"]) {
      this.element.addEventListener(event, (/** @type {any} */ { target }) => this.#choose(target));
    }
  }

  /** On a narrow screen the drawer shows the field that was last used. @param {Element} target */
  #choose(target) {
    const field = target.closest(".field");
    if (!field) return;
    for (const other of this.element.querySelectorAll(".chosen")) other.classList.remove("chosen");
    field.classList.add("chosen");
  }

  /** @param {boolean} open */
  #open(open) {
    this.element.toggleAttribute("data-open", open);
    this.drawer.setAttribute("aria-expanded", String(open));
    this.drawer.textContent = open ? "Close" : "All controls";
  }

  /** @param {Settings} settings */
  update(settings) {
    this.settings = settings;
    for (const field of this.fields) field(settings);
  }

  /** Says what is wrong, or what was done. @param {string[]} faults @param {string} [done] */
  say(faults, done = "") {
    this.notice.replaceChildren(...faults.map((s) => html("p", {}, s)));
    this.status.textContent = done;
  }

  /** @param {any} q */
  #quantity(q) {
    const { name } = q;
    return this.#field(q, typeset(name), ({ values }) => values[name], (value) => {
      this.change({ values: { ...this.settings.values, [name]: value } });
    });
  }

  #end() {
    const [low, high] = [this.first.end / TIMES, this.first.end * TIMES];
    const q = { name: "t-end", unit: "s", meaning: "end of the motion", range: [low, high], logarithmic: true };
    const bound = { lower: 0, lower_closed: false, need: "a number > 0" };
    return this.#field({ ...q, ...bound }, html("span", {}, "t"), ({ end }) => end, (end) => this.change({ end }));
  }

  /**
   * A slider with its number.
   * @param {any} q @param {any} symbol @param {(settings: Settings) => number} value
   * @param {(value: number) => void} change
   */
  #field(q, symbol, value, change) {
    const { name, meaning } = q;
    const unit = q.unit === "1" ? "" : q.unit;
    const words = meaning.replace(/^rate of (\w+)$/, (/** @type {string} */ _, /** @type {string} */ of) => `rate of ${pretty(of)}`);
    const scale = sliderScale(q);
    const range = html("input", {
      ...{ type: "range", min: 0, max: NOTCHES, step: 1, "aria-label": `${meaning} (${name})` },
      oninput: () => take(scale.value(+range.value)),
    });
    const number = html("input", {
      ...{ type: "number", step: "any", name },
      "aria-label": `${meaning} (${name})${unit && `, ${unit}`}`,
      onchange: () => take(number.value === "" ? NaN : +number.value),
    });
    const take = (/** @type {number} */ taken) => {
      const problem = fault(q, taken);
      number.setAttribute("aria-invalid", String(Boolean(problem)));
      this.say(problem ? [problem] : []);
      if (!problem) change(taken);
    };
    this.fields.push((settings) => {
      const own = value(settings);
      const text = whole(+own.toPrecision(DIGITS));
      if (number.value !== text) number.value = text;
      number.title = `${pretty(name)} = ${own} ${unit}`;
      number.setAttribute("aria-invalid", "false");
      range.value = String(scale.notch(own));
      range.setAttribute("aria-valuetext", `${short(own)} ${unit}`);
    });
    const label = html("span", { class: "name" }, symbol, html("small", {}, " ", symbols(words), unit && `, ${unit}`));
    return html("div", { class: "field" }, label, range, number);
  }

  #force() {
    if (!this.description.motions[0].pressable) return null;
    const number = html("input", {
      ...{ type: "number", step: "any", min: 0, name: "initial-force", placeholder: "none" },
      "aria-label": "force at the start that compresses the contact, N; none where empty",
      onchange: () => {
        const force = number.value === "" ? null : +number.value;
        const problem = force === null || force >= 0 ? [] : [`initial force: got ${force}, need >= 0.`];
        this.say(problem);
        if (!problem.length) this.change({ force });
      },
    });
    this.fields.push(({ force }) => (number.value = force === null ? "" : force));
    return html("div", { class: "field short" },
      html("span", { class: "name" }, typeset("F_n"), html("small", {}, " compresses the contact at first, N")),
      number);
  }

  /**
   * A choice of one value among few; none where there is nothing to choose.
   * @param {string} text @param {[any, string][]} options @param {"reload" | "contact"} key
   */
  #select(text, options, key) {
    if (options.length < 2) return null;
    const select = html("select", {
      onchange: () => this.change({ [key]: options[select.selectedIndex][0] }),
    }, options.map(([value, name]) => html("option", { value }, name)));
    this.fields.push((settings) => (select.value = String(settings[key])));
    return html("label", { class: "row choice" }, text, select);
  }

  #reload() {
    const rules = reloads(this.description).map((rule) => /** @type {[any, string]} */ (
      [rule, rule === "virgin" ? "virgin (creates energy)" : rule]));
    return this.#select("reload", rules, "reload");
  }

  #contact() {
    const names = this.description.contacts.map((c, i) => /** @type {[any, string]} */ ([i, c.name]));
    return this.#select("contact of map and problem", names, "contact");
  }

  /** @param {Preset[]} presets */
  #presets(presets) {
    if (!presets.length) return null;
    const look = html("p", { class: "note", role: "status" });
    const settingsOf = (/** @type {Preset} */ { settings }) =>
      defaults(this.description, { ...this.first, force: null, ...settings });
    const select = html("select", {
      onchange: () => {
        const preset = presets[+select.value];
        if (preset && select.value) this.change(settingsOf(preset));
      },
    }, html("option", { value: "" }, "choose …"),
    presets.map((p, i) => html("option", { value: i }, p.name)));
    this.fields.push((s) => {
      const text = (/** @type {Settings} */ { values, force, reload }) =>
        JSON.stringify([values, force, reload]);
      const same = presets.findIndex((p) => text(settingsOf(p)) === text(s));
      select.value = same < 0 ? "" : String(same);
      look.textContent = same < 0 ? "" : presets[same].look;
    });
    return html("div", { class: "presets" }, html("label", { class: "row choice" }, "from the paper", select), look);
  }
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
