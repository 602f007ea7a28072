/** Elements, numbers and axes: what all drawings share. */

/** @param {Element} made @param {Object<string, any>} attributes @param {any[]} children */
function filled(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) {
      made.setAttribute(name, value === true ? "" : String(value));
    }
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null));
  return made;
}

/**
 * Returns an HTML element; attributes that begin with on are listeners.
 * @param {string} tag @param {Object<string, any>} [attributes] @param {any[]} children
 * @returns {any}
 */
export const html = (tag, attributes = {}, ...children) =>
  filled(document.createElement(tag), attributes, children);

/** @param {string} tag @param {Object<string, any>} [attributes] @param {any[]} children
 * @returns {any} */
export const svg = (tag, attributes = {}, ...children) =>
  filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);

const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/**
 * Returns a number with that many digits; powers of ten beyond four places.
 * @param {number} value @param {number} [digits]
 */
export function short(value, digits = 5) {
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)));
  if (power >= -3 && power < Math.max(5, digits)) return minus(String(+value.toPrecision(digits)));
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const raised = [...exponent.replace("+", "")].map((c) => (c === "-" ? "⁻" : RAISED[+c])).join("");
  const factor = String(+mantissa);
  return minus(factor === "1" ? `10${raised}` : `${factor}·10${raised}`);
}

/** @param {string} text */
const minus = (text) => text.replace("-", "−");

/** A number with all its digits, in few characters. @param {number} value */
export function whole(value) {
  const size = Math.abs(value);
  return size >= 1e6 || (size < 1e-4 && size > 0) ? value.toExponential() : String(value);
}

/** A name of the package as text: theta_dot becomes θ̇. @param {string} name */
export function pretty(name) {
  const rate = name.endsWith("_dot");
  const [base, ...index] = (rate ? name.slice(0, -4) : name).split("_");
  const letter = GREEK[base] ?? base;
  const dotted = rate ? (letter.length === 1 ? `${letter}\u0307` : `${letter}˙`) : letter;
  return index.length ? `${dotted}_${index.join("_")}` : dotted;
}

/**
 * A text with the indices of its symbols lowered, such as that of F_n, as parts of an element.
 * @param {string} text @param {(index: string) => any} lowered
 */
const parts = (text, lowered) =>
  text.split(/(?<=(?<![\p{L}\d])\p{L}\p{M}*)_(\w+)/u).map((part, i) => (i % 2 ? lowered(part.replaceAll("_", " ")) : part));

/** A text with the indices of its symbols lowered. @param {string} text @returns {any[]} */
export const symbols = (text) => parts(text, (index) => html("sub", {}, index));

/** The same within a drawing. @param {string} text @returns {any[]} */
const drawnSymbols = (text) =>
  parts(text, (index) => svg("tspan", { dy: 2.5, "font-size": 8 }, index))
    .map((part, i) => (i && !(i % 2) && part ? svg("tspan", { dy: -2.5 }, part) : part));

/** A name of the package with its index lowered. @param {string} name */
export function typeset(name) {
  const [base, ...index] = pretty(name).split("_");
  return html("span", {}, base, index.length ? html("sub", {}, index.join(" ")) : null);
}

/** @typedef {(text: string, word?: string) => any} Term */

/**
 * Returns a function that marks words of the glossary, each with its meaning.
 * @param {Object<string, string>} words @returns {Term}
 */
export const terms = (words) => (text, word = text) =>
  words[word] ? html("abbr", { title: words[word] }, symbols(text)) : text;

/** @type {Object<string, string>} */
const GREEK = {
  ...{ alpha: "α", beta: "β", gamma: "γ", delta: "δ", theta: "θ", kappa: "κ", lambda: "λ" },
  ...{ mu: "μ", nu: "ν", rho: "ρ", phi: "φ", psi: "ψ", omega: "ω" },
};

/** @param {string} name @param {string} unit */
export const withUnit = (name, unit) =>
  unit === "1" || !unit ? pretty(name) : `${pretty(name)} (${unit})`;

/**
 * Returns round numbers within a range.
 * @param {number} low @param {number} high @param {number} [count]
 */
export function ticks(low, high, count = 5) {
  const rough = (high - low) / count;
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((m) => m * power >= rough) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

/** The number with the fewest digits within a positive range. @param {number} low @param {number} high */
export function roundest(low, high) {
  if (!(low > 0 && high >= low)) return 0;
  for (let power = 10 ** Math.ceil(Math.log10(high)); ; power /= 10) {
    for (const step of [power, power / 2, power / 5]) {
      const value = Math.ceil(low / step - 1e-9) * step;
      if (value <= high * (1 + 1e-12)) return value;
    }
  }
}

/** A range that holds all finite numbers, with some room. @param {number[]} values */
export function span(values) {
  const finite = values.filter(Number.isFinite);
  const low = Math.min(0, ...finite);
  const high = Math.max(0, ...finite);
  const room = 0.08 * (high - low) || 1;
  return [low - room, high + room];
}

/** The text of the last mark ends where the axis does. @param {number} at @param {number[]} range */
const anchor = (at, [low, high]) => (at > low + 0.97 * (high - low) ? "end" : "middle");

export const WIDTH = 360;
export const HEIGHT = 270;
const LEFT = 60;
const RIGHT = 10;
const TOP = 10;
const BOTTOM = 38;

/** Axes of a drawing, and the places of numbers in it. */
export class Frame {
  /** @param {number[]} x @param {number[]} y */
  constructor(x, y) {
    this.x = x;
    this.y = y;
  }

  /** @param {number} value */
  left(value) {
    const part = (value - this.x[0]) / (this.x[1] - this.x[0]);
    return LEFT + part * (WIDTH - LEFT - RIGHT);
  }

  /** @param {number} value */
  top(value) {
    const part = (value - this.y[0]) / (this.y[1] - this.y[0]);
    return HEIGHT - BOTTOM - part * (HEIGHT - TOP - BOTTOM);
  }

  /** The numbers at a place, within the ranges. @param {number} left @param {number} top */
  at(left, top) {
    const parts = [
      (left - LEFT) / (WIDTH - LEFT - RIGHT),
      (HEIGHT - BOTTOM - top) / (HEIGHT - TOP - BOTTOM),
    ];
    return [this.x, this.y].map(([low, high], i) => {
      return low + Math.min(1, Math.max(0, parts[i])) * (high - low);
    });
  }

  /** Attributes of the rectangle inside the axes. */
  get inside() {
    return { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM };
  }

  /** @param {number[][]} points */
  path(points) {
    let text = "";
    let open = false;
    for (const [x, y] of points) {
      if (!Number.isFinite(y)) {
        open = false;
        continue;
      }
      // Far outside of the frame a renderer loses the line.
      const top = Math.max(-1e4, Math.min(1e4, this.top(y)));
      text += `${open ? "L" : "M"}${this.left(x).toFixed(2)} ${top.toFixed(2)}`;
      open = true;
    }
    return text;
  }

  /**
   * Returns the axes.
   * @param {string} labelX @param {string} labelY
   * @param {{at: number, text: string}[]} [marksX] in place of round numbers
   */
  axes(labelX, labelY, marksX) {
    const { x, y, width, height } = this.inside;
    const marks = marksX ?? ticks(this.x[0], this.x[1]).map((at) => ({ at, text: short(at, 3) }));
    const bottom = y + height;
    return svg(
      "g",
      { class: "axes", "aria-hidden": "true" },
      svg("rect", { x, y, width, height, class: "box" }),
      marks.map(({ at, text }) => [
        svg("path", { d: `M${this.left(at)} ${bottom}v-4` }),
        svg("text", { x: this.left(at), y: bottom + 13, "text-anchor": anchor(at, this.x) }, text),
      ]),
      ticks(this.y[0], this.y[1]).map((at) => [
        svg("path", { d: `M${x} ${this.top(at)}h4` }),
        svg("text", { x: x - 4, y: this.top(at) + 3, "text-anchor": "end" }, short(at, 3)),
      ]),
      svg("text", { x: x + width / 2, y: HEIGHT - 6, "text-anchor": "middle" }, drawnSymbols(labelX)),
      svg(
        "text",
        { "text-anchor": "middle", transform: `translate(11 ${y + height / 2}) rotate(-90)` },
        drawnSymbols(labelY),
      ),
    );
  }
}

/**
 * Returns straight pieces of the curves on which a field on a grid is zero.
 * @param {(i: number, j: number) => number} field @param {number} countA @param {number} countB
 * @returns {number[][][]} ends of each piece in steps of the grid
 */
export function zeros(field, countA, countB) {
  const pieces = [];
  for (let i = 0; i + 1 < countA; i++) {
    for (let j = 0; j + 1 < countB; j++) {
      // Two triangles: a straight zero in each.
      for (const corners of [
        [[i, j], [i + 1, j], [i + 1, j + 1]],
        [[i, j], [i + 1, j + 1], [i, j + 1]],
      ]) {
        const ends = [];
        for (let k = 0; k < 3; k++) {
          const [p, q] = [corners[k], corners[(k + 1) % 3]];
          const [f, g] = [field(p[0], p[1]), field(q[0], q[1])];
          if (f < 0 === g < 0 || !Number.isFinite(f + g)) continue;
          const part = f / (f - g);
          ends.push([p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])]);
        }
        if (ends.length === 2) pieces.push(ends);
      }
    }
  }
  return pieces;
}
