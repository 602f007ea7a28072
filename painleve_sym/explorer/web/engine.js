/** The WebAssembly module of a mechanism: motions, contact problem, maps. It holds every formula. */

import { eventsAboveTolerance } from "./small_events.js";

/** @typedef {{name: string, unit: string, meaning: string, value: number, range: number[],
 *   leading: boolean}} Quantity */
/** @typedef {{name: string, sentence: string}} Word */
/** @typedef {Word & {rate: "gap_rate" | "slip_velocity" | null}} Kind */
/** @typedef {{contact: string, memory: number, local_modes: string[]}} Part */
/** @typedef {{name: string, law: string, choices: Object<string, string>, engine: string,
 *   rigid: number[], pressable: boolean, states: string[], units: string[], parameters: string[],
 *   memory: string[], modes: string[], outputs: {name: string, unit: string}[], events: Kind[],
 *   parts: Part[]}} MotionNames */
/** @typedef {{mechanism: {name: string, title: string, source: string, sketch: string},
 *   states: Quantity[], parameters: any[], over: string[], contact: number, contacts: any[], cases: Word[],
 *   domain: string[], stops: Word[], motions: MotionNames[],
 *   scene: {shapes: {kind: string, points: number}[], declared: boolean, contacts: string[],
 *     grounds: string[], deflections: string[]} | null}} Description */
/** @typedef {Object<string, number>} Values */
/** @typedef {{time: number, kind: string, sentence: string, mode_before: string, mode_after: string,
 *   contact: string, before: Values, after: Values, outputs: Values}} Event */

/** Bits of a start that law, numbers and domain admit. */
const [LAW, FINITE, DOMAIN] = [1, 2, 4];

/** @param {number[]} numbers @param {string[]} names @returns {Values} */
const named = (numbers, names) => Object.fromEntries(names.map((name, i) => [name, numbers[i]]));

/**
 * Returns the engine of a module.
 * @param {Uint8Array} wasm @param {Description} description
 */
export async function load(wasm, description) {
  // Of bytes, the result has module and instance.
  const { instance } = /** @type {any} */ (await WebAssembly.instantiate(wasm, {}));
  return new Engine(instance.exports, description);
}

/**
 * Returns the bytes of base64 text that holds a gzip file.
 * @param {string} text
 */
export async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export class Engine {
  /** @param {any} functions @param {Description} description */
  constructor(functions, description) {
    functions._initialize?.();
    this.functions = functions;
    this.description = description;
    this.motions = description.motions.map((names) => new Motion(this, names));
    // The mechanism's own quantities have the same numbers in every motion.
    this.states = description.states.map((s) => s.name);
  }

  /**
   * The motions that a page shows: with the law by that reload rule, and rigid beside it.
   * @param {{reload: string}} settings
   */
  shown({ reload }) {
    return this.motions.filter((m) => (m.names.choices.reload ?? reload) === reload);
  }

  /** What is no longer so where a state leaves the domain. @param {Values} values */
  bound(values) {
    this.motions[0].set(values);
    const { domain } = this.description;
    const margins = Array.from(view(this.functions, this.functions.margins(), domain.length));
    return domain[margins.indexOf(Math.min(...margins))];
  }

  /** The number of a state or parameter in calls that change it. @param {string} name */
  index(name) {
    const state = this.states.indexOf(name);
    const { parameters } = this.motions[0].names;
    return state >= 0 ? state : this.states.length + parameters.indexOf(name);
  }

  /**
   * Returns the rigid contact problem of one contact, the others open.
   * @param {Values} values @param {number} contact
   */
  problem(values, contact) {
    const inside = this.motions[0].start(values, null);
    this.functions.contact_problem(contact);
    const at = view(this.functions, this.functions.contact_numbers_at(), 64);
    const [A_neg, A_pos, B, A_stick, B_stick, mu, given, count] = at;
    const state = this.motions[0].state();
    const slipVelocity = state[this.description.contacts[contact].slip];
    const solutions = Array.from({ length: count }, (_, i) => {
      const [normal, tangential, slip, mode] = at.slice(8 + 4 * i, 12 + 4 * i);
      return { normal, tangential, slip, mode: this.description.cases[mode].name };
    });
    return {
      ...{ A_neg, A_pos, B, A_stick, B_stick, mu, slipVelocity, solutions, state, inside },
      ...{ word: this.description.cases[given], slip: Math.sign(slipVelocity) },
    };
  }

  /**
   * Returns the values with a contact closed and at rest along its normal: one coordinate and its
   * velocity are solved for, those that move the gap, lengths before angles. Null where none does.
   * @param {Values} values @param {number} contact
   */
  closed(values, contact) {
    const names = this.description.contacts[contact];
    const at = (/** @type {Values} */ own, /** @type {string} */ name) => {
      this.motions[0].start(own, null);
      return this.motions[0].state()[name];
    };
    const coordinates = this.description.states.filter((q) => `${q.name}_dot` in values);
    for (const unit of ["m", "rad"]) {
      for (const { name } of coordinates.filter((q) => q.unit === unit)) {
        const rate = `${name}_dot`;
        const placed = root(values, name, (own) => at(own, names.gap));
        const still = placed && root(placed, rate, (own) => at(own, names.gap_rate));
        if (still) return still;
      }
    }
    return null;
  }

  /**
   * Returns the names of cases, A in push, B and A in pull on a grid, b fastest, for slips along s;
   * "outside" and nan outside.
   * @param {Values} values @param {string} a @param {number[]} rangeA @param {number} countA
   * @param {string} b @param {number[]} rangeB @param {number} countB
   * @param {number} contact @param {number} slip
   */
  map(values, a, rangeA, countA, b, rangeB, countB, contact, slip) {
    this.motions[0].set(values);
    const at = this.functions.contact_map(
      ...[this.index(a), rangeA[0], rangeA[1], countA, this.index(b), rangeB[0], rangeB[1], countB],
      ...[contact, slip],
    );
    const grid = view(this.functions, at, 4 * countA * countB);
    const part = (/** @type {number} */ k) => grid.filter((_, i) => i % 4 === k);
    const cases = Array.from(part(0), (given) => this.description.cases[given]?.name ?? "outside");
    return { cases, push: part(1), B: part(2), pull: part(3) };
  }

  #drawing() {
    const { scene } = this.description;
    if (!scene) throw new Error("this mechanism is not drawn");
    return scene;
  }

  /**
   * Returns the points of every shape; place, normal and surface speed of every contact with a place.
   * @param {Values} values @param {Values} state
   */
  scene(values, state) {
    const { shapes, contacts } = this.#drawing();
    this.motions[0].set({ ...values, ...state });
    const at = this.functions.scene();
    const count = 2 * shapes.reduce((sum, s) => sum + s.points, 0) + 5 * contacts.length;
    const numbers = Array.from(view(this.functions, at, count));
    const pair = () => numbers.splice(0, 2);
    return {
      kinds: shapes.map((s) => s.kind),
      points: shapes.map((s) => Array.from({ length: s.points }, pair)),
      contacts: contacts.map((name) => {
        return { name, point: pair(), normal: pair(), speed: numbers.splice(0, 1)[0] };
      }),
    };
  }

  /**
   * Returns the function of every surface that is ground on a grid, y fastest.
   * @param {Values} values @param {Values} state @param {number[]} xs @param {number[]} ys
   * @param {number} count of points along each side
   */
  surfaces(values, state, xs, ys, count) {
    const { grounds } = this.#drawing();
    this.motions[0].set({ ...values, ...state });
    const at = this.functions.surfaces(xs[0], xs[1], ys[0], ys[1], count);
    const grid = view(this.functions, at, count * count * grounds.length);
    return grounds.map((_, k) => grid.filter((_, i) => i % grounds.length === k));
  }
}

/** @param {any} functions @param {number} at @param {number} count */
function view(functions, at, count) {
  // A copy: growing memory detaches views.
  return Float64Array.from(new Float64Array(functions.memory.buffer, at, count));
}

/**
 * Returns the values with one of them such that a function is zero, by Newton's method with
 * differences; null where it does not get there.
 * @param {Values} values @param {string} name @param {(values: Values) => number} f
 */
function root(values, name, f) {
  let own = values;
  for (let i = 0; i < 50; i++) {
    const value = f(own);
    if (value === 0) return own;
    const step = 1e-6 * Math.max(1, Math.abs(own[name]));
    const moved = (/** @type {number} */ by) => ({ ...own, [name]: own[name] + by });
    const slope = (f(moved(step)) - f(moved(-step))) / (2 * step);
    const next = moved(-value / slope);
    if (!Number.isFinite(next[name])) return null;
    if (next[name] === own[name] || Math.abs(value) < 1e-14) return own;
    own = next;
  }
  return null;
}

/** Six digits, as messages of commands have them. @param {number} value */
function percentG(value) {
  const short = +value.toPrecision(6);
  return short && Math.abs(short) < 1e-4 ? short.toExponential() : String(short);
}

/** One motion: the mechanism with one law. */
export class Motion {
  /** @param {Engine} engine @param {MotionNames} names */
  constructor(engine, names) {
    const { functions, description } = engine;
    this.engine = engine;
    this.names = names;
    this.description = description;
    this.memory = functions.memory;
    const prefix = `${names.name}_`;
    /** @type {any} */
    this.functions = Object.fromEntries(
      Object.entries(functions)
        .filter(([name]) => name.startsWith(prefix))
        .map(([name, own]) => [name.slice(prefix.length), own]),
    );
    this.outputNames = names.outputs.map((o) => o.name);
    this.numbers = 16 + 2 * names.states.length + 2 * names.memory.length + 2;
    this.numbers += names.outputs.length;
  }

  /** @param {string} function_ @param {number} count */
  #view(function_, count) {
    return new Float64Array(this.memory.buffer, this.functions[function_](), count);
  }

  /** @param {number} count */
  #read(count) {
    return Array.from(this.#view("numbers_at", count));
  }

  /** Writes parameters and state, not completed. @param {Values} values */
  set(values) {
    const { parameters } = this.names;
    this.#view("parameters_at", parameters.length).set(parameters.map((name) => values[name]));
    const given = this.description.states.map((s) => values[s.name]);
    this.#view("state_at", given.length).set(given);
  }

  /** The state that `start` completed. */
  state() {
    const { states } = this.names;
    return named(Array.from(this.#view("state_at", states.length)), states);
  }

  /**
   * Writes the start, complete; returns the fault of one that is not admitted, or an empty text.
   * @param {Values} values @param {number | null} force
   */
  start(values, force) {
    this.set(values);
    const bits = this.functions.complete(force === null || !this.names.pressable ? -1 : force);
    if (!(bits & DOMAIN)) return `the start is outside the model: ${this.engine.bound(values)}`;
    if (!(bits & FINITE)) return "the stiffness that follows from the parameters is not finite";
    return bits & LAW ? "" : this.#refusal();
  }

  /** Why the law does not admit the start that was just written. */
  #refusal() {
    const { contacts } = this.description;
    const state = this.state();
    for (const i of this.names.rigid) {
      const { name, bilateral, gap, gap_rate } = contacts[i];
      const several = contacts.length > 1;
      const [distance, rate] = [`gap = ${percentG(state[gap])} m`, percentG(state[gap_rate])];
      if (bilateral && (state[gap] || state[gap_rate])) {
        return `${several ? `the bilateral contact '${name}'` : "a bilateral contact"} holds its ` +
          `point: got ${distance} and normal velocity ${rate} m/s, need both 0. ` +
          "Fix: start on the guide and along it";
      }
      if (!bilateral && state[gap] < 0) {
        return `${several ? `contact '${name}' starts` : "the start is"} inside the ground, ` +
          `${distance}, and a rigid contact has no compression. ` +
          "Fix: start with gap >= 0, or give a compliant law";
      }
    }
    return `initial_force: got a start with gap ${state[contacts[0].gap]}, need 0. ` +
      "Fix: give the force or the compression, not both";
  }

  /**
   * Follows the motion from a start.
   * @param {Values} values @param {number | null} force
   * @param {{end: number, rtol: number, maxSteps: number, maxEvents: number}} options
   * @returns {Run}
   */
  run(values, force, { end, rtol, maxSteps, maxEvents }) {
    const fault = this.start(values, force);
    if (fault) return new Run(this, values, fault, 0, rtol);
    const count = this.functions.follow(end, rtol, maxSteps, maxEvents, 0, 1);
    const full = count < 0 ? "the browser has no memory left for this motion" : "";
    return new Run(this, values, full, count, rtol);
  }

  /** The bits of kinds of events. @param {string[]} kinds */
  bits(kinds) {
    return this.names.events.reduce((sum, e, i) => sum | (kinds.includes(e.name) ? 1 << i : 0), 0);
  }

  /**
   * Returns the outcomes of starts along a line of a map, as words.
   * @param {Values} values @param {number | null} force @param {[number, number[], number]} line
   *   the number of a quantity, its range, and how often
   * @param {[number, number]} held the number of another quantity and its value
   * @param {{end: number, rtol: number, maxSteps: number}} options @param {string[]} until
   */
  outcomes(values, force, [a, range, count], [b, value], { end, rtol, maxSteps }, until) {
    this.set(values);
    const press = force === null || !this.names.pressable ? -1 : force;
    const at = this.functions.outcomes(
      ...[a, range[0], range[1], count, b, value, press, end, rtol, maxSteps, this.bits(until)],
    );
    return Array.from(view(this.engine.functions, at, count), (code) => this.#outcome(code));
  }

  /** @param {number} code */
  #outcome(code) {
    if (code < 0) return "outside";
    if (code >= 200) return this.description.stops[code - 200].name;
    if (code >= 100) return this.names.modes[code - 100] === "flight" ? "open" : "no event";
    return this.names.events[code].name;
  }

  /** @param {number} mode @param {number[]} memory */
  modeName(mode, memory) {
    const { modes, parts } = this.names;
    if (!parts.length) return modes[mode];
    return parts.map((p) => `${p.contact}: ${p.local_modes[memory[p.memory]]}`).join(", ");
  }

  /** @param {number} i @returns {Event} */
  event(i) {
    const { states, memory, events, modes } = this.names;
    this.functions.event(i);
    const numbers = this.#read(this.numbers);
    const [time, kind, before, after, contact] = numbers;
    const rest = numbers.slice(5 + 2 * states.length);
    const kept = rest.slice(this.outputNames.length, this.outputNames.length + memory.length);
    return {
      time,
      kind: events[kind].name,
      sentence: events[kind].sentence,
      mode_before: modes[before],
      mode_after: this.modeName(after, kept),
      contact: contact < 0 ? "" : this.description.contacts[contact].name,
      before: named(numbers.slice(5), states),
      after: named(numbers.slice(5 + states.length), states),
      outputs: named(rest, this.outputNames),
    };
  }

  /** The state, mode and outputs of the last run at a time; null outside. @param {number} t */
  at(t) {
    const { states, memory } = this.names;
    if (!this.functions.at_time(t)) return null;
    const numbers = this.#read(this.numbers);
    const rest = numbers.slice(2 + states.length);
    return {
      time: t,
      mode: this.modeName(numbers[1], rest.slice(0, memory.length)),
      state: named(numbers.slice(2), states),
      outputs: named(rest.slice(memory.length), this.outputNames),
    };
  }

  /** What the last run ended with, `follow` has just written it, and the change of its energy. */
  end() {
    const { states, memory } = this.names;
    const numbers = this.#read(this.numbers);
    const [time, stop, mode, steps] = numbers;
    const rest = numbers.slice(4 + states.length);
    return {
      time,
      steps,
      stop: this.description.stops[stop],
      mode: this.modeName(mode, rest.slice(0, memory.length)),
      state: named(numbers.slice(4), states),
      outputs: named(rest.slice(memory.length), this.outputNames),
      residual: this.functions.energy_residual(),
    };
  }

  /** Sizes of the states at the start that was written, below which only absolute errors count. */
  scales() {
    const { states } = this.names;
    this.functions.scales();
    return named(this.#read(states.length), states);
  }

  /** Times at which the steps of the last run begin. @param {number} count */
  stepTimes(count) {
    return Array.from({ length: count }, (_, i) => this.functions.step_time(i));
  }
}

/** A motion that was followed; it is that of its `Motion` until the next. */
export class Run {
  /**
   * @param {Motion} motion @param {Values} values @param {string} fault
   * @param {number} count of events @param {number} rtol
   */
  constructor(motion, values, fault, count, rtol) {
    this.motion = motion;
    this.rtol = rtol;
    this.values = values;
    this.fault = fault;
    /** @type {Event[]} */
    this.events = [];
    /** @type {Event[]} */
    this.eventsAboveTolerance = [];
    /** @type {Values} */
    this.scales = {};
    this.end = null;
    /** @type {number[]} */
    this.times = [0];
    if (fault) return;
    this.end = motion.end();
    this.times = [...motion.stepTimes(this.end.steps), this.end.time];
    this.events = Array.from({ length: count }, (_, i) => motion.event(i));
    this.scales = motion.scales();
    this.eventsAboveTolerance = eventsAboveTolerance(this);
  }

  /** What counts as 0 of a state or force: the tolerance of the run on its size. @param {string} name */
  tolerance(name) {
    const forces = name.includes("_force");
    const own = [this.end?.[forces ? "outputs" : "state"] ?? {}];
    own.push(...this.events.flatMap((e) => (forces ? [e.outputs] : [e.before, e.after])));
    // All forces of a motion have one size, that of the largest.
    const names = Object.keys(own[0]).filter((n) => (forces ? n.includes("_force") : n === name));
    let size = this.scales[name] ?? 0;
    for (const values of own) for (const n of names) size = Math.max(size, Math.abs(values[n]));
    return this.rtol * size;
  }

  /** State, mode and outputs at a time, or at the end where that is earlier. @param {number} t */
  at(t) {
    if (!this.end) return null;
    return t >= this.end.time ? this.end : this.motion.at(t);
  }
}
