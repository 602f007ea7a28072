/** The rigid contact problem at the start: lines a = A F + B, and every solution marked. */

import { Frame, WIDTH, HEIGHT, html, short, span, svg, symbols } from "./draw.js";

/** A in 1/kg or B in m/s² that is zero, to rounding. */
const BORDER = 1e-12;
const NUMBERS = ["no", "one", "two", "three", "four", "five", "six"];

/**
 * The lines of a problem: name, slope, offset, and the sign of the forces they are for.
 * @param {any} problem @param {boolean} bilateral
 */
export function linesOf(problem, bilateral) {
  const { A_neg, A_pos, A_stick, B_stick, B, slip } = problem;
  /** @type {{name: string, slope: number, offset: number, side: number, style: string}[]} */
  const lines = [];
  for (const s of [-1, 1]) {
    if (s * slip < 0) continue;
    const way = s < 0 ? "left" : "right";
    const [push, pull] = s < 0 ? [A_neg, A_pos] : [A_pos, A_neg];
    lines.push({ name: `slip to the ${way}`, slope: push, offset: B, side: 1, style: `slip-${way}` });
    if (bilateral) {
      const name = `slip to the ${way}, pulled`;
      lines.push({ name, slope: pull, offset: B, side: -1, style: `slip-${way}` });
    }
  }
  if (slip === 0) {
    for (const side of bilateral ? [1, -1] : [1]) {
      lines.push({ name: "sticking", slope: A_stick, offset: B_stick, side, style: "stick" });
    }
  }
  return lines;
}

/**
 * Sentences on a start to which the problem does not apply as it stands.
 * @param {any} problem @param {any} contact
 */
export function notes({ inside, state, slip, A_neg, A_pos, B }, contact) {
  const [gap, rate] = [state[contact.gap], state[contact.gap_rate]];
  const sentences = inside ? [`${inside}.`] : [];
  if (gap > 0) sentences.push(`The contact is open, gap ${short(gap)} m; here it is taken as closed.`);
  if (gap < 0) sentences.push(`The contact is compressed by ${short(-gap)} m.`);
  if (gap <= 0 && rate < 0) sentences.push(`It approaches with ${short(-rate)} m/s: an impact.`);
  if (gap <= 0 && rate > 0) sentences.push(`It is leaving with ${short(rate)} m/s.`);
  const A = slip > 0 ? A_pos : A_neg;
  const zero = ["A", "B"].filter((_, i) => Math.abs([A, B][i]) < BORDER);
  if (slip && zero.length) sentences.push(`It lies on the border of two cases: ${zero.join(" = ")} = 0.`);
  if (slip === 0) sentences.push("At rest sticking is possible, and slip to either side.");
  return sentences;
}

export class ProblemView {
  /** @param {import("./engine.js").Engine} engine @param {import("./draw.js").Term} term */
  constructor(engine, term) {
    this.engine = engine;
    this.term = term;
    this.figure = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
    this.words = html("p", { class: "verdict", role: "status" });
    this.numbers = html("dl", { class: "numbers" });
    this.list = html("ul", { class: "solutions" });
    this.legend = html("ul", { class: "legend" });
    this.open = html("p", { class: "note" });
    this.element = html("div", {},
      this.words, this.figure, this.legend, this.list, this.numbers, this.open);
  }

  /** @param {any} settings @param {any} problem */
  update(settings, problem) {
    const contact = this.engine.description.contacts[settings.contact];
    const { solutions, word } = problem;
    const count = solutions.length;
    const counted = `: ${NUMBERS[count]} solution${count > 1 ? "s" : ""}`;
    // The case of a guide counts them by its name.
    this.words.replaceChildren(this.term(word.name), word.name.includes("solution") ? "" : counted);
    this.words.dataset.case = word.name;
    this.#draw(problem, contact.bilateral);
    this.list.replaceChildren(
      ...solutions.map((/** @type {any} */ s) => {
        const at = html("data", { value: s.normal }, short(s.normal));
        return html("li", {}, `${s.mode === "liftoff" ? "no force" : s.mode}: `, symbols("F_n = "), at,
          symbols(` N, F_t = ${short(s.tangential)} N`));
      }),
    );
    const slides = problem.slip > 0 ? problem.A_pos : problem.A_neg;
    const rows = [
      ["A", slides, "1/kg"],
      ["B", problem.B, "m/s²"],
      ["A′", problem.A_stick, "1/kg"],
      ["B′", problem.B_stick, "m/s²"],
      ["v_t", problem.slipVelocity, "m/s"],
      ["μ", problem.mu, ""],
    ];
    this.numbers.replaceChildren(
      ...rows.map(([name, value, unit]) => {
        const number = html("data", { value, "data-name": name }, short(/** @type {any} */ (value)));
        return html("div", {}, html("dt", {}, this.term(name)), html("dd", {}, number, ` ${unit}`));
      }),
    );
    this.open.textContent = [`Rigid: ${word.sentence}.`, ...notes(problem, contact)].join(" ");
  }

  /** @param {any} problem @param {boolean} bilateral */
  #draw(problem, bilateral) {
    const forces = problem.solutions.map((/** @type {any} */ s) => s.normal);
    const lines = linesOf(problem, bilateral);
    // Without a solution to a force at which the line has left B visibly.
    const { slope, offset } = lines[0];
    const size = Math.max(...forces.map(Math.abs), 0) || Math.abs(offset / slope) || 1;
    const x = [bilateral ? -1.5 * size : -0.08 * size, 1.6 * size];
    const ends = lines.flatMap((l) => [l.offset, l.slope * l.side * 1.6 * size + l.offset]);
    const frame = new Frame(x, span(ends));
    const zero = frame.path([[x[0], 0], [x[1], 0]]);
    const up = frame.path([[0, frame.y[0]], [0, frame.y[1]]]);
    this.figure.replaceChildren(
      frame.axes("normal force F_n (N)", "normal acceleration a_n (m/s²)"),
      svg("path", { d: zero + up, class: "thin" }),
      svg("path", {
        d: bilateral ? zero : frame.path([[0, frame.y[1]], [0, 0], [x[1], 0]]),
        class: "possible",
      }),
      ...lines.map((l) => {
        const far = l.side > 0 ? x[1] : x[0];
        const d = frame.path([[0, l.offset], [far, l.slope * far + l.offset]]);
        return svg("path", { d, class: `line ${l.style}` }, svg("title", {}, l.name));
      }),
      ...problem.solutions.map((/** @type {any} */ s) => {
        const a = s.mode === "liftoff" ? problem.B : 0;
        return svg("circle", { cx: frame.left(s.normal), cy: frame.top(a), r: 6, class: "solution" });
      }),
    );
    this.legend.replaceChildren(
      ...lines.map((l) => html("li", {},
        html("span", { class: `swatch line ${l.style}`, "aria-hidden": "true" }), l.name)),
      html("li", {}, html("span", { class: "swatch line possible", "aria-hidden": "true" }),
        "what a contact can do"),
    );
    const at = problem.solutions.map((/** @type {any} */ s) => `${short(s.normal)} N`).join(" and ");
    this.figure.setAttribute(
      "aria-label",
      `Normal acceleration over normal force. ${lines.map((l) => l.name).join(", ")}. ` +
        (at ? `Solutions at ${at}.` : "No line meets the forces that are possible."),
    );
  }
}
