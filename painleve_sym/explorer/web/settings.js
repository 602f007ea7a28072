/** Everything that a page shows, as plain data, and its text in the address bar. */

/** @typedef {import("./engine.js").Description} Description */
/** @typedef {import("./engine.js").Values} Values */
/** @typedef {{values: Values, force: number | null, end: number, over: string[],
 *   map: "contact" | "outcomes", contact: number, reload: string, magnify: number, at: number}} Settings */

/** Keys of the address bar besides names of states and parameters, which have no hyphen. */
const KEYS = {
  force: "initial-force",
  end: "t-end",
  over: "map-over",
  map: "map-of",
  contact: "at-contact",
  reload: "law-reload",
  magnify: "magnify-time",
  at: "play-at",
};

/** @param {Description} description */
const quantities = (description) => [...description.states, ...description.parameters];

/**
 * Returns the settings of a page before anybody changes them.
 * @param {Description} description @param {Partial<Settings>} [initial]
 * @returns {Settings}
 */
export function defaults(description, initial = {}) {
  const values = Object.fromEntries(quantities(description).map((q) => [q.name, q.value]));
  const rigid = description.motions.every((m) => m.rigid.length);
  const [reload = ""] = reloads(description);
  return {
    ...{ force: null, end: rigid ? 1 : 0.01, over: [...description.over] },
    ...{ map: "contact", contact: description.contact, reload, magnify: 0.7, at: 0, ...initial },
    values: { ...values, ...initial.values },
  };
}

/** The reload rules of the motions with a law, each once. @param {Description} description */
export const reloads = ({ motions }) =>
  [...new Set(motions.map((m) => m.choices.reload).filter(Boolean))];

/**
 * Returns a sentence where a number cannot be taken, else an empty text.
 * @param {any} quantity @param {number} value
 */
export function fault(quantity, value) {
  const { lower, upper, lower_closed, upper_closed, need } = quantity;
  const above = lower == null || (lower_closed ? value >= lower : value > lower);
  const below = upper == null || (upper_closed ? value <= upper : value < upper);
  if (Number.isFinite(value) && above && below) return "";
  const got = Number.isNaN(value) ? "nothing that is a number" : value;
  return `${quantity.name}: got ${got}, need ${need || "a finite number"}.`;
}

/**
 * Returns the text of what differs from the defaults.
 * @param {Settings} settings @param {Settings} from
 */
export function toText(settings, from) {
  const text = new URLSearchParams();
  for (const [name, value] of Object.entries(settings.values)) {
    if (value !== from.values[name]) text.set(name, String(value));
  }
  for (const [field, key] of Object.entries(KEYS)) {
    const [own, other] = [settings, from].map((s) => String(/** @type {any} */ (s)[field]));
    if (own !== other) text.set(key, own);
  }
  // Commas need no escape, and a link is easier to read with them.
  return text.toString().replaceAll("%2C", ",");
}

/**
 * Returns the settings of a text, and a sentence for each entry that cannot be taken.
 * @param {string} text @param {Description} description @param {Settings} from
 * @returns {{settings: Settings, faults: string[]}}
 */
export function fromText(text, description, from) {
  const settings = { ...from, values: { ...from.values } };
  const faults = [];
  const known = Object.fromEntries(quantities(description).map((q) => [q.name, q]));
  /** @type {Object<string, (text: string) => void>} */
  const readers = {
    [KEYS.force]: (t) => (settings.force = t === "null" ? null : number(t, 0)),
    [KEYS.end]: (t) => (settings.end = number(t, 1e-12)),
    [KEYS.over]: (t) => (settings.over = axes(t, known)),
    [KEYS.map]: (t) => (settings.map = oneOf(t, ["contact", "outcomes"])),
    [KEYS.contact]: (t) => (settings.contact = number(t, 0, description.contacts.length - 1)),
    [KEYS.reload]: (t) => (settings.reload = oneOf(t, reloads(description))),
    [KEYS.magnify]: (t) => (settings.magnify = number(t, 0, 1)),
    [KEYS.at]: (t) => (settings.at = number(t, 0, 1)),
  };
  for (const [name, own] of new URLSearchParams(text)) {
    try {
      if (name in known) {
        const problem = fault(known[name], own.trim() ? Number(own) : NaN);
        if (problem) throw new Error(problem);
        settings.values[name] = Number(own);
      } else if (name in readers) {
        readers[name](own);
      } else {
        throw new Error("there is no such name here.");
      }
    } catch (error) {
      faults.push(`address, ${name}=${own}: ${/** @type {Error} */ (error).message}`);
    }
  }
  return { settings, faults };
}

/** @param {string} text @param {number} least @param {number} [most] */
function number(text, least, most = Infinity) {
  const value = Number(text);
  if (text.trim() && value >= least && value <= most && Number.isFinite(value)) return value;
  throw new Error(`need a number from ${least} to ${most}.`);
}

/** @param {string} text @param {any[]} words */
function oneOf(text, words) {
  if (words.includes(text)) return /** @type {any} */ (text);
  throw new Error(`need one of ${words.join(", ")}.`);
}

/** @param {string} text @param {Object<string, any>} known */
function axes(text, known) {
  const names = text.split(",");
  if (names.length === 2 && names[0] !== names[1] && names.every((n) => n in known)) return names;
  throw new Error("need two different names of states or parameters.");
}
