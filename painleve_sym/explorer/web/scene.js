/** The mechanism in the plane, drawn from its shapes with the forces of its contacts. */

import { html, short, svg, zeros } from "./draw.js";

/** Points along each side of the grid on which a surface is looked for. */
const GRID = 41;
/** Around the mechanism, in parts of its size: for the arrows. */
const ROOM = 0.4;
/** Part of that room that the arrow of the largest force has. */
const ARROW = 0.9;
/** Smaller forces by this number of decades have arrows of no length. */
const DECADES = 3;
/** Part of the mechanism's size that its largest deflection has in a drawing. */
const BENT = 0.08;

/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Values} Values */
/** @typedef {{left: number, right: number, low: number, high: number, room: number}} Box */

/**
 * Returns the places of a state, its deflections drawn that many times, the contact where it is.
 * @param {Engine} engine @param {Values} values @param {Values} state @param {number} times
 */
function places(engine, values, state, times) {
  const { deflections = [] } = engine.description.scene ?? {};
  const own = engine.scene(values, state);
  if (times === 1) return own;
  const more = Object.fromEntries(deflections.map((name) => [name, times * state[name]]));
  const drawn = engine.scene(values, { ...state, ...more });
  const [from, to] = [drawn, own].map((s) => s.contacts[0]?.point ?? [0, 0]);
  const moved = (/** @type {number[]} */ p) => p.map((v, k) => v + to[k] - from[k]);
  return { ...own, points: drawn.points.map((shape) => shape.map(moved)) };
}

/** @param {number[][]} points */
function around(points) {
  const [xs, ys] = [0, 1].map((k) => points.map((p) => p[k]).filter(Number.isFinite));
  const ends = { left: Math.min(...xs), right: Math.max(...xs) };
  return { ...ends, low: Math.min(...ys), high: Math.max(...ys) };
}

/**
 * Returns how many times the deflections at these states are drawn: a round number, or 1.
 * @param {Engine} engine @param {Values} values @param {Values[]} states
 */
export function magnification(engine, values, states) {
  const { deflections } = /** @type {any} */ (engine.description.scene);
  if (!deflections.length) return 1;
  const straight = Object.fromEntries(deflections.map((/** @type {string} */ name) => [name, 0]));
  let [largest, size] = [0, 0];
  for (const state of states) {
    const [bent, still] = [state, { ...state, ...straight }].map((s) =>
      engine.scene(values, s).points.flat());
    const { left, right, low, high } = around(still);
    size = Math.max(size, right - left, high - low);
    const away = bent.map((p, i) => Math.hypot(p[0] - still[i][0], p[1] - still[i][1]));
    largest = Math.max(largest, ...away);
  }
  const times = (BENT * size) / largest;
  if (!(times > 1) || !Number.isFinite(times)) return 1;
  const power = 10 ** Math.floor(Math.log10(times));
  return power * (/** @type {number} */ ([5, 2, 1].find((m) => m * power <= times)));
}

/**
 * Returns the window that holds the mechanism at all these states.
 * @param {Engine} engine @param {Values} values @param {Values[]} states @param {number} times
 */
export function windowOf(engine, values, states, times) {
  const points = states.flatMap((state) => {
    const { points: own, contacts } = places(engine, values, state, times);
    return [...own.flat(), ...contacts.map((c) => c.point)];
  });
  if (!points.length) return null;
  const { left, right, low, high } = around(points);
  const room = ROOM * Math.max(right - left, high - low) || 1;
  const box = { left: left - room, low: low - room, right: right + room, high: high + room, room };
  // Neither flat nor upright, so that pictures of all mechanisms are of a similar size.
  const [width, height] = [box.right - box.left, box.high - box.low];
  box.high += Math.max(0, 0.6 * width - height);
  box.left -= Math.max(0, height - width) / 2;
  box.right += Math.max(0, height - width) / 2;
  return box;
}

export class Scene {
  /** @param {Engine} engine @param {string} title @param {import("./draw.js").Term} term */
  constructor(engine, title, term) {
    this.engine = engine;
    this.figure = svg("svg", { class: "scene", role: "img", "aria-label": `mechanism, ${title}` });
    this.mode = html("p", { class: "note" });
    this.element = html("figure", {}, html("figcaption", {}, term(title)), this.figure, this.mode);
  }

  /**
   * Draws one moment.
   * @param {Values} values @param {any} moment @param {Box | null} box
   * @param {number} largest force; N @param {number} times that deflections are drawn
   * @param {any} mode words of the mode
   */
  update(values, moment, box, largest, times, mode) {
    this.mode.replaceChildren(moment ? mode : "not computed");
    this.figure.toggleAttribute("hidden", !moment);
    if (!moment || !box) return;
    const { left, right, low, high } = box;
    const scene = places(this.engine, values, moment.state, times);
    this.figure.setAttribute("viewBox", `${left} ${-high} ${right - left} ${high - low}`);
    const dot = 0.012 * (right - left);
    const length = (/** @type {number} */ force) => {
      const part = 1 + Math.log10(Math.abs(force) / largest) / DECADES;
      return part > 0 ? Math.sign(force) * part * ARROW * box.room : 0;
    };
    const arrows = scene.contacts.flatMap((/** @type {any} */ c) => {
      const several = this.engine.description.contacts.length > 1 ? `_${c.name}` : "";
      const [n_x, n_y] = c.normal;
      return ["normal", "tangential"].map((kind, i) => {
        const force = moment.outputs[`${kind}_force${several}`];
        const size = length(force);
        // F_t acts along the normal turned clockwise by a right angle.
        const along = i ? [size * n_y, -size * n_x] : [size * n_x, size * n_y];
        return arrow(c.point, along, kind, `${kind} force ${short(force)} N`);
      });
    });
    this.figure.replaceChildren(
      ...this.#surfaces(values, moment.state, box),
      ...scene.contacts.map((/** @type {any} */ c) => belt(c, 6 * dot)),
      ...scene.points.map((points, i) => drawn(scene.kinds[i], points, dot)),
      ...arrows,
    );
  }

  /** @param {Values} values @param {Values} state @param {Box} box */
  #surfaces(values, state, { left, right, low, high }) {
    const fields = this.engine.surfaces(values, state, [left, right], [low, high], GRID);
    return fields.map((/** @type {Float64Array} */ field) => {
      const pieces = zeros((i, j) => field[i * GRID + j], GRID, GRID).map((piece) => {
        const ends = piece.map(([i, j]) => [
          left + ((right - left) * i) / (GRID - 1),
          -(low + ((high - low) * j) / (GRID - 1)),
        ]);
        return `M${ends[0].join(" ")}L${ends[1].join(" ")}`;
      });
      return svg("path", { d: pieces.join(""), class: "ground" });
    });
  }
}

/** @param {string} kind @param {number[][]} points @param {number} dot */
function drawn(kind, points, dot) {
  const [[x, y], second] = points;
  if (kind === "dot") return svg("circle", { cx: x, cy: -y, r: dot, class: "dot" });
  if (kind === "pin") {
    const d = `M${x} ${-y}l${2 * dot} ${3 * dot}h${-4 * dot}Z`;
    return svg("g", { class: "body pin" }, svg("path", { d }), svg("circle", { cx: x, cy: -y, r: dot }),
      svg("title", {}, "a fixed joint"));
  }
  if (kind === "disc") {
    const r = Math.hypot(second[0] - x, second[1] - y);
    return svg("g", { class: "body" }, svg("circle", { cx: x, cy: -y, r }),
      svg("path", { d: `M${x} ${-y}L${second[0]} ${-second[1]}` }));
  }
  const path = points.map(([a, b]) => `${a} ${-b}`).join("L");
  return svg("path", { d: `M${path}${kind === "polygon" ? "Z" : ""}`, class: `body ${kind}` });
}

/** An arrow below a surface that moves. @param {any} contact @param {number} size */
function belt({ point: [x, y], normal: [n_x, n_y], speed }, size) {
  const way = Math.sign(speed) * size;
  const from = [x - 0.5 * size * n_x - way * n_y, y - 0.5 * size * n_y + way * n_x];
  return arrow(from, [2 * way * n_y, -2 * way * n_x], "belt", `the surface moves with ${short(speed)} m/s`);
}

/** @param {number[]} at @param {number[]} by @param {string} kind @param {string} title */
function arrow([x, y], [dx, dy], kind, title) {
  const size = Math.hypot(dx, dy);
  if (!(size > 0)) return svg("g");
  const [ux, uy] = [dx / size, dy / size];
  const head = 0.22 * size;
  const [tipX, tipY] = [x + dx, y + dy];
  const side = (/** @type {number} */ s) =>
    `${tipX - head * (ux + s * 0.5 * uy)} ${-(tipY - head * (uy - s * 0.5 * ux))}`;
  const d = `M${x} ${-y}L${tipX} ${-tipY}M${side(1)}L${tipX} ${-tipY}L${side(-1)}`;
  return svg("path", { d, class: `arrow ${kind}` }, svg("title", {}, title));
}
