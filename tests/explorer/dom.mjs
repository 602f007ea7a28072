/** As much of a document as the page's modules need, and what a reader sees in their drawings. */

/** An element with attributes, children and listeners; a canvas keeps its pixels. */
export class Element {
  constructor(tag) {
    Object.assign(this, { tag, attributes: {}, children: [], listeners: {}, style: {}, dataset: {} });
    this.classList = { add() {}, remove() {}, toggle() {} };
    this.value = "";
  }
  setAttribute(name, value) {
    this.attributes[name] = value;
    if (["value", "min", "max"].includes(name)) this[name] = value;
  }
  hasAttribute(name) {
    return name in this.attributes;
  }
  toggleAttribute(name, on) {
    this.attributes[name] = on;
  }
  append(...children) {
    this.children.push(...children);
  }
  replaceChildren(...children) {
    this.children = children;
  }
  addEventListener(name, listener) {
    this.listeners[name] = listener;
  }
  querySelector(selector) {
    return this.classed(selector.slice(1))[0] ?? null;
  }
  focus() {}
  setPointerCapture() {}
  getBoundingClientRect() {
    return { left: 0, top: 0, width: 360, height: 270 };
  }
  getContext() {
    return {
      createImageData: (width, height) => ({ width, height, data: new Uint8ClampedArray(4 * width * height) }),
      putImageData: (image) => (this.image = image),
    };
  }
  toDataURL() {
    pictures.push(this.image);
    return `picture ${pictures.length - 1}`;
  }
  set textContent(text) {
    this.children = [text];
  }
  get textContent() {
    return text(this);
  }
  all() {
    return [this, ...this.children.flatMap((c) => (c.all ? c.all() : []))];
  }
  /** Elements with a word among their classes. */
  classed(word) {
    return this.all().filter((e) => String(e.attributes.class ?? "").split(" ").includes(word));
  }
  tagged(tag) {
    return this.all().filter((e) => e.tag === tag);
  }
}

/** Pixels that canvases became, by the number in their address. */
const pictures = [];
/** The pixels of an image of a drawing. */
export const pixelsOf = (image) => pictures[+image.attributes.href.split(" ")[1]];

/** All text of an element. */
export const text = (element) =>
  typeof element === "object" ? element.children.map(text).join("") : String(element);

globalThis.document = {
  createElement: (tag) => new Element(tag), createElementNS: (_, tag) => new Element(tag),
};

const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
/** The number that a text of the page stands for, such as −4.1·10⁻³. */
export function numberIn(written) {
  const plain = written.replace(/−/g, "-").replace(/(·?)10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)/, (_, times, power) => {
    const digits = [...power].map((c) => (c === "⁻" ? "-" : RAISED.indexOf(c))).join("");
    return `${times ? "" : "1"}e${digits}`;
  });
  return Number(plain);
}

const places = (d) => [...d.matchAll(/([ML])(\S+?) (\S+?)(?=[MLhv]|$)/g)].map((m) => [m[1], +m[2], +m[3]]);

/**
 * How a reader reads numbers off the axes of a drawing: by the texts beside their ticks.
 * Functions from a place to the numbers there; the ticks stand in even steps.
 */
export function axesOf(figure) {
  const [axes] = figure.classed("axes");
  const ticks = { x: [], y: [] };
  axes.children.forEach((child, i) => {
    const d = child.tag === "path" ? child.attributes.d : "";
    const [place] = places(d);
    if (!place) return;
    const value = numberIn(text(axes.children[i + 1]));
    if (d.endsWith("v-4")) ticks.x.push([place[1], value]);
    else ticks.y.push([place[2], value]);
  });
  const scale = (pairs) => {
    const [first, last] = [pairs[0], pairs.at(-1)];
    const slope = (last[1] - first[1]) / (last[0] - first[0]);
    return (place) => first[1] + (place - first[0]) * slope;
  };
  return { x: scale(ticks.x), y: scale(ticks.y), ticks };
}

/** The points of a path of a drawing in the numbers of its axes, in pieces. */
export function curveOf(figure, path) {
  const { x, y } = axesOf(figure);
  const pieces = [];
  for (const [command, left, top] of places(path.attributes.d)) {
    if (command === "M") pieces.push([]);
    pieces.at(-1).push([x(left), y(top)]);
  }
  return pieces;
}
