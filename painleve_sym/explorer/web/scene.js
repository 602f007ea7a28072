/** The mechanism in the plane, drawn from its shapes with the forces of its contacts. */

import { html, short, svg, zeros } from "./draw.js";

/** Points along each side of the grid on which a surface is looked for. */
const GRID = 41;
/** Around the mechanism, in parts of its size: for the arrows. */
const ROOM = 0.3;
/** Part of the height of a picture that the largest force has. */
const ARROW = 0.35;
/** Smaller forces by this number of decades have arrows of no length. */
const DECADES = 3;

export class Scene {
  /**
   * @param {import("./engine.js").Engine} engine @param {number} which of its motions
   * @param {string} title
   */
  constructor(engine, which, title) {
    this.engine = engine;
    this.motion = engine.motions[which];
    this.figure = svg("svg", { class: "scene", role: "img", "aria-label": `mechanism, ${title}` });
    this.caption = html("figcaption", {}, title);
    this.mode = html("p", { class: "note" });
    this.element = html("figure", {}, this.caption, this.figure, this.mode);
  }

  /**
   * Returns the window that holds the mechanism at all these states.
   * @param {import("./engine.js").Engine} engine
   * @param {import("./engine.js").Values} values @param {any[]} states
   */
  static window(engine, values, states) {
    const places = states.flatMap((state) => engine.scene(values, state).points.flat());
    const [xs, ys] = [0, 1].map((k) => places.map((p) => p[k]).filter(Number.isFinite));
    if (!xs.length) return null;
    const [left, right] = [Math.min(...xs), Math.max(...xs)];
    const [low, high] = [Math.min(...ys), Math.max(...ys)];
    const room = ROOM * Math.max(right - left, high - low) || 1;
    const box = { left: left - room, low: low - room, right: right + room, high: high + room };
    // At least half as high as wide, so that two pictures side by side look alike.
    const missing = 0.6 * (box.right - box.left) - (box.high - box.low);
    if (missing > 0) box.high += missing;
    return box;
  }

  /**
   * Draws one moment.
   * @param {any} values @param {any} moment @param {any} box @param {number} largest force; N
   */
  update(values, moment, box, largest) {
    if (!moment || !box) {
      this.figure.replaceChildren();
      this.mode.textContent = moment ? moment.mode : "";
      return;
    }
    const { left, right, low, high } = box;
    const scene = this.engine.scene(values, moment.state);
    this.figure.setAttribute("viewBox", `${left} ${-high} ${right - left} ${high - low}`);
    const dot = 0.012 * (right - left);
    const parts = scene.points.map((points, i) => drawn(scene.kinds[i], points, dot));
    const length = (/** @type {number} */ force) => {
      const part = 1 + Math.log10(Math.abs(force) / largest) / DECADES;
      return part > 0 ? Math.sign(force) * part * ARROW * (high - low) : 0;
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
    this.figure.replaceChildren(...this.#surfaces(values, moment.state, box), ...parts, ...arrows);
    this.mode.textContent = moment.mode.replaceAll("_", " ");
  }

  /** @param {any} values @param {any} state @param {any} box */
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
  if (kind === "disc") {
    const r = Math.hypot(second[0] - x, second[1] - y);
    return svg("g", { class: "body" }, svg("circle", { cx: x, cy: -y, r }),
      svg("path", { d: `M${x} ${-y}L${second[0]} ${-second[1]}` }));
  }
  const path = points.map(([a, b]) => `${a} ${-b}`).join("L");
  return svg("path", { d: `M${path}${kind === "polygon" ? "Z" : ""}`, class: `body ${kind}` });
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
