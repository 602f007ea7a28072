/** Drawings of the explorer under Node, read as a person reads them: by the numbers beside their axes. */

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

import { axesOf, curveOf, numberIn, pixelsOf, text } from "./dom.mjs";

const own = (name) => import(pathToFileURL(path.join(process.env.EXPLORER_WEB, name)).href);
const { Frame, short, svg } = await own("draw.js");
const { MapView, RUNS } = await own("map.js");
const { EventView, MotionView } = await own("motion.js");
const { ProblemView } = await own("problem.js");
const { Scene } = await own("scene.js");
const { Controls } = await own("controls.js");

const near = (value, wanted, size = 1, where = "") =>
  assert.ok(Math.abs(value - wanted) <= size, `${where}: ${value} is not ${wanted}`);
const plain = (own) => own;

/** The colours of a style: each name has one of its own. */
const COLOURS = ["--slip", "--liftoff", "--none", "--two", "--outside", "--opens", "--parts", "--stops", "--slides",
  "--leaves", "--other-1", "--other-2", "--other-3"];
const hex = (name) => `#${(0x101010 * (1 + COLOURS.indexOf(name))).toString(16).padStart(6, "0")}`;
globalThis.getComputedStyle = () => ({ getPropertyValue: hex });
globalThis.matchMedia = () => ({ matches: false });

// ---- axes ----

test("a larger number stands higher, and farther to the right, where the ticks say", () => {
  for (const [low, high] of [[0, 1], [-3, 7], [1e-9, 4e-9], [-2e12, -1e12], [0.05, 1.9]]) {
    const frame = new Frame([low, high], [2 * low, 3 * high]);
    const figure = svg("svg", {}, frame.axes("x", "y"));
    const axes = axesOf(figure);
    assert.ok(axes.ticks.x.length > 1 && axes.ticks.y.length > 1);
    for (const ticks of [axes.ticks.x, axes.ticks.y.map(([top, v]) => [-top, v])]) {
      ticks.slice(1).forEach(([at, value], i) => assert.ok(at > ticks[i][0] && value > ticks[i][1]));
    }
    for (const part of [0.1, 0.4, 0.95]) {
      const [x, y] = [low + part * (high - low), 2 * low + part * (3 * high - 2 * low)];
      near(axes.x(frame.left(x)), x, 2e-3 * (high - low), "x");
      near(axes.y(frame.top(y)), y, 2e-3 * (3 * high - 2 * low), "y");
      const back = frame.at(frame.left(x), frame.top(y));
      near(back[0], x, 1e-9 * Math.abs(high - low));
      near(back[1], y, 1e-9 * Math.abs(3 * high - 2 * low));
    }
    assert.ok(frame.top(3 * high) < frame.top(2 * low) && frame.left(high) > frame.left(low));
  }
});

test("a curve is drawn through its points, with a gap where there is none", () => {
  const frame = new Frame([0, 10], [-5, 5]);
  const points = [[0, -4], [2, 3], [4, NaN], [6, 1], [10, 5]];
  const line = svg("path", { d: frame.path(points) });
  const figure = svg("svg", {}, frame.axes("x", "y"), line);
  const pieces = curveOf(figure, line);
  assert.deepEqual(pieces.map((p) => p.length), [2, 2]);
  [[0, -4], [2, 3], [6, 1], [10, 5]].forEach(([x, y], i) => {
    near(pieces.flat()[i][0], x, 0.01);
    near(pieces.flat()[i][1], y, 0.01);
  });
});

test("written numbers are the numbers", () => {
  for (const value of [0, 1.5, -0.25, 1e5, 3.2e-7, -4.25e11, 1e-9, 99999]) {
    assert.equal(numberIn(short(value)), value);
  }
});

// ---- the map ----

const quantity = (name, range, more = {}) => ({ name, unit: "1", range, value: 0, ...more });

/** A map over u from 0 to 10 and v from -4 to 4: none where u > 7 and v > 2, several where v < -1. */
function mapEngine() {
  const word = (u, v) => (u > 7 && v > 2 ? "inconsistent" : v < -1 ? "indeterminate" : "slip");
  const grid = (x, y, count, value) => {
    const step = ([low, high], i) => low + ((high - low) * i) / (count - 1);
    return Array.from({ length: count * count }, (_, k) => value(step(x, Math.floor(k / count)), step(y, k % count)));
  };
  return {
    word,
    description: {
      states: [quantity("u", [0, 10]), quantity("v", [-4, 4])], parameters: [], domain: ["it is thin at 0"],
      contacts: [{ name: "A", bilateral: false }],
    },
    index: (name) => ["u", "v"].indexOf(name),
    map: (values, a, x, count, b, y) => ({
      cases: grid(x, y, count, word), push: grid(x, y, count, (u) => u - 2.5), B: grid(x, y, count, (_, v) => v - 1.5),
      pull: grid(x, y, count, () => 1),
    }),
    shown() {
      return [this.motion];
    },
    motion: {
      names: { rigid: [], law: "hertz" }, set() {},
      outcomes: (values, force, [, [low, high], count], [, u]) =>
        Array.from({ length: count }, (_, j) => (low + ((high - low) * j) / (count - 1) > u / 5 ? "slip_stop" : "open")),
    },
  };
}

function mapView(settings = {}, change = () => {}) {
  const engine = mapEngine();
  const view = new MapView(engine, change, {}, plain);
  const all = { over: ["u", "v"], values: { u: 5, v: 0 }, contact: 0, map: "contact", end: 1, force: null, ...settings };
  view.update(all, { slip: -1, word: { name: "slip" } });
  return { engine, view };
}

/** The colour of a map where its axes say that the numbers are. */
function colourAt(view, u, v) {
  const { x, y, ticks } = axesOf(view.figure);
  const { picture } = view;
  const [left, top, width, height] = ["x", "y", "width", "height"].map((n) => +picture.attributes[n]);
  const image = pixelsOf(picture);
  // The place of the numbers, by the inverse of what the ticks say.
  const place = (scale, [first], value) => first[0] + (value - scale(first[0])) / (scale(first[0] + 1) - scale(first[0]));
  const [i, j] = [(place(x, ticks.x, u) - left) / width, (place(y, ticks.y, v) - top) / height];
  const [column, row] = [Math.floor(i * image.width), Math.floor(j * image.height)];
  return `#${[...image.data.slice(4 * (row * image.width + column)).slice(0, 3)]
    .map((c) => c.toString(16).padStart(2, "0")).join("")}`;
}

test("each place of a map has the colour of its case, and the legend its name and share", () => {
  const { engine, view } = mapView();
  const colours = { slip: "--slip", inconsistent: "--none", indeterminate: "--two" };
  for (const u of [0.5, 3, 6.8, 7.2, 9.5]) {
    for (const v of [-3.5, -1.1, -0.9, 1.8, 2.2, 3.7]) {
      assert.equal(colourAt(view, u, v), hex(colours[engine.word(u, v)]), `u = ${u}, v = ${v}`);
    }
  }
  const entries = view.legend.children.map((li) => [text(li), li.children[0].style.background]);
  const shares = { "slip: one solution": 0.55, "no solution": 0.075, "several solutions": 0.375 };
  for (const [name, share] of Object.entries(shares)) {
    const [written, colour] = entries.find(([own]) => own.startsWith(`${name} (`));
    near(numberIn(/\((\S+) %\)/.exec(written)[1]), 100 * share, 2, name);
    const key = { "slip: one solution": "slip", "no solution": "inconsistent", "several solutions": "indeterminate" }[name];
    assert.equal(colour, `var(${colours[key]})`);
  }
  assert.deepEqual(entries.slice(-2).map(([own]) => own), ["A = 0", "B = 0"]);
});

test("curves of a map stand where their quantity is zero", () => {
  const { view } = mapView();
  const [A, B] = [0, 1].map((i) => curveOf(view.figure, view.lines.classed(`zero-${i}`)[0]).flat());
  assert.ok(A.length > 100 && B.length > 100);
  for (const [u] of A) near(u, 2.5, 0.02, "A = 0");
  for (const [, v] of B) near(v, 1.5, 0.02, "B = 0");
});

test("the point of a map stands at the start, and its words have the numbers", () => {
  const { view } = mapView({ values: { u: 2, v: 3 } });
  const [, left, top] = /translate\((\S+) (\S+)\)/.exec(view.point.attributes.transform).map(Number);
  const { x, y } = axesOf(view.figure);
  near(x(left), 2, 0.01);
  near(y(top), 3, 0.01);
  const { attributes } = view.point;
  assert.equal(attributes["aria-valuetext"], "u = 2, v = 3: slip");
  assert.deepEqual([attributes["aria-valuemin"], attributes["aria-valuenow"], attributes["aria-valuemax"]], ["0", "2", "10"].map(Number));
});

test("arrow keys move the start by a hundredth of the map, with Shift by a tenth", () => {
  const moves = { ArrowRight: [0.1, 0], ArrowLeft: [-0.1, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] };
  for (const [key, by] of Object.entries(moves)) {
    for (const [shiftKey, times] of [[false, 1], [true, 10]]) {
      let taken = null;
      const { view } = mapView({}, (part) => (taken = part.values));
      view.point.listeners.keydown({ key, shiftKey, preventDefault() {} });
      near(taken.u, 5 + times * by[0], 1e-9, `${key} u`);
      near(taken.v, 0 + times * by[1], 1e-9, `${key} v`);
    }
  }
  // It stays on the map.
  let taken = null;
  const { view } = mapView({ values: { u: 9.99, v: 0 } }, (part) => (taken = part.values));
  const [, high] = view.frame.x;
  view.point.listeners.keydown({ key: "ArrowRight", shiftKey: true, preventDefault() {} });
  assert.equal(taken.u, +high.toPrecision(5));
});

test("the start is where the pointer is, by the numbers of the axes", () => {
  let taken = null;
  const { view } = mapView({}, (part) => (taken = part.values));
  const { x, y } = axesOf(view.figure);
  view.figure.listeners.pointermove({ clientX: 90, clientY: 50 });
  assert.equal(taken, null, "not held");
  for (const [left, top] of [[100, 40], [300, 200], [200, 120]]) {
    view.figure.listeners.pointerdown({ clientX: left, clientY: top, pointerId: 1, preventDefault() {} });
    near(taken.u, x(left), 0.02);
    near(taken.v, y(top), 0.02);
  }
  view.figure.listeners.pointerup({});
  view.figure.listeners.pointermove({ clientX: 90, clientY: 50 });
  near(taken.u, x(200), 0.02);
});

test("a map of outcomes has each outcome at its start, and says how many motions it is of", async () => {
  const { view } = mapView({ map: "outcomes" });
  for (let i = 0; i < 200 && !view.note.dataset.seconds; i++) await new Promise((resolve) => setTimeout(resolve, 5));
  for (const [u, v, colour] of [[1, 3, "--stops"], [1, -2, "--opens"], [9, 1, "--opens"], [9, 3, "--stops"]]) {
    assert.equal(colourAt(view, u, v), hex(colour), `u = ${u}, v = ${v}`);
  }
  assert.match(view.note.textContent, new RegExp(`^${RUNS * RUNS} motions with the law hertz until t = 1 s`));
});

// ---- a motion ----

/** A run of 2 s whose force grows to 12 N at 0.5 s and falls, and which stops to slip at 1.5 s. */
function run(kind = "compliant") {
  const names = { rigid: kind === "rigid" ? [0] : [], law: kind, choices: {} };
  const force = (t) => (t < 0.5 ? 24 * t : 16 - 8 * t);
  const outputs = (t) => ({ normal_force: force(t), tangential_force: -0.5 * force(t) });
  const state = (t) => ({ x: t, y: 1 + t, x_dot: 1 - t, y_dot: 3 * t });
  const event = (kind, time) => ({
    kind, time, sentence: `${kind} happens`, contact: "", mode_after: "stick", outputs: outputs(time),
    before: state(time), after: state(time),
  });
  const events = [event("max_compression", 0.5), event("separation", 1.5)];
  return {
    motion: { names, outputNames: ["normal_force", "tangential_force"], engine: {} }, fault: "", values: {},
    times: Array.from({ length: 21 }, (_, i) => i / 10),
    events, eventsAboveTolerance: events, tolerance: () => 0,
    end: { time: 2, residual: 0, stop: { name: "t_end", sentence: "the end time was reached" }, mode: "flight", state: state(2), outputs: outputs(2) },
    at: (t) => ({ mode: "stick", state: state(t), outputs: outputs(t) }), force, state,
  };
}

const motionEngine = {
  states: ["x", "y", "x_dot", "y_dot"],
  description: {
    states: ["x", "y", "x_dot", "y_dot"].map((name) => ({ name, unit: name.endsWith("_dot") ? "m/s" : "m" })),
    motions: [{ rigid: [] }], contacts: [{ name: "A" }],
    scene: { deflections: [], declared: true, shapes: [{ kind: "line" }] },
  },
  scene: (_, { x, y }) => ({
    kinds: ["line"], points: [[[x, y], [x + 1, y + 2]]], contacts: [{ name: "A", point: [x, y], normal: [0, 1], speed: 0 }],
  }),
  surfaces: () => [],
};

function motionView(settings = {}, change = () => {}) {
  const view = new MotionView(motionEngine, change, plain, { rtol: 1e-11, openFrom: 1e-8 });
  const one = run();
  view.update({ values: {}, magnify: 0, at: 0, ...settings }, [one]);
  return { view, one };
}

test("forces over time are those of the run, by the numbers of the axes", () => {
  for (const magnify of [0, 0.6]) {
    const { view, one } = motionView({ magnify });
    const [normal, tangential] = ["normal", "tangential"].map((n) => curveOf(view.figure, view.figure.classed(n).at(0)).flat());
    const time = (at) => (magnify ? view.clock.time(at / 2) : at);
    assert.ok(normal.length > 400);
    for (const [k, [at, value]] of normal.entries()) {
      if (magnify && k % 20) continue;
      near(value, one.force(time(at)), magnify ? 0.3 : 0.1, "F_n");
    }
    if (!magnify) for (const [at, value] of tangential) near(value, -0.5 * one.force(at), 0.1, "F_t");
    assert.equal(Math.max(...normal.map((p) => p[1])) > 11.8, true);
    assert.match(view.figure.attributes["aria-label"], /^Forces over time until 2 s; the largest is 1[12](\.\d+)? N\.$/);
    assert.deepEqual(view.legend.children.map((li) => text(li)), ["Fn, compliant", "Ft, compliant", "events, numbered as below"]);
  }
});

test("lines of events stand at their times, with their words", () => {
  const { view, one } = motionView();
  const lines = view.figure.classed("event");
  assert.equal(lines.length, 2);
  lines.forEach((line, i) => {
    const [[bottom, top]] = curveOf(view.figure, line.tagged("path")[0]);
    near(bottom[0], one.events[i].time, 0.01);
    assert.ok(top[1] > bottom[1]);
    assert.equal(text(line.tagged("title")[0]), ["max compression at 0.5 s", "separation at 1.5 s"][i]);
    assert.equal(text(line.tagged("text")[0]), String(i + 1));
  });
});

test("the cursor, the clock and the picture are those of the moment", () => {
  const { view, one } = motionView();
  for (const part of [0, 0.25, 0.8]) {
    view.scrub.value = String(part);
    view.scrub.listeners.input();
    const t = 2 * part;
    assert.equal(view.time.textContent, `t = ${short(t)} s`);
    const left = +/^M(\S+) /.exec(view.cursor.attributes.d)[1];
    near(axesOf(view.figure).x(left), t, 0.01);
    const [body] = view.scenes[0].figure.classed("body");
    const [x, y] = [t, 1 + t];
    const drawn = /^M(\S+) (\S+)L(\S+) (\S+)$/.exec(body.attributes.d).slice(1).map(Number);
    [x, -y, x + 1, -(y + 2)].forEach((value, i) => near(drawn[i], value, 1e-9));
  }
  const { view: slow } = motionView({ magnify: 0.9 });
  slow.scrub.value = "0.5";
  slow.scrub.listeners.input();
  const said = /^t = (\S+) s(?:, (\S+) times slower)?$/.exec(slow.time.textContent);
  near(numberIn(said[1]), slow.clock.time(0.5), 1e-3);
});

test("words on slow motion have the ratio of times", () => {
  const { view } = motionView();
  const ends = [0, 1, 1.001, 1.002, 1.003, 1.004, 2];
  view.update({ values: {}, magnify: 0.9, at: 0 }, [{ ...run(), times: ends }]);
  const part = view.clock.part(1.002);
  view.scrub.value = String(part);
  view.scrub.listeners.input();
  const [, said] = /, (\S+) times slower$/.exec(view.time.textContent);
  const [before, after] = [view.clock.time(part - 1e-3), view.clock.time(part + 1e-3)];
  const ratio = (2e-3 * 2) / (after - before);
  near(numberIn(said), ratio, 0.06 * ratio);
});

test("an animation lasts eight seconds, from where it is paused", () => {
  const [frames, clock] = [[], { now: 1000 }];
  const before = performance.now;
  globalThis.requestAnimationFrame = (step) => frames.push(step);
  performance.now = () => clock.now;
  try {
    const kept = [];
    const { view } = motionView({}, (part) => kept.push(part.at));
    const pass = (seconds) => {
      for (let i = 0; i < Math.round(seconds * 20); i++) {
        clock.now += 50;
        frames.splice(0).forEach((step) => step(clock.now));
      }
    };
    view.button.listeners.click();
    assert.equal(view.button.textContent, "Pause");
    pass(2);
    near(+view.scrub.value, 0.25, 0.01, "after 2 s");
    assert.match(view.time.textContent, /^t = 0\.(5|49\d*) s/);
    view.button.listeners.click();
    assert.equal(view.button.textContent, "Play");
    pass(1);
    near(kept.at(-1), 0.25, 0.01, "paused");
    view.button.listeners.click();
    pass(5.9);
    assert.ok(+view.scrub.value < 1, "after 7.9 s");
    pass(0.3);
    assert.equal(+view.scrub.value, 1);
    assert.equal(view.button.textContent, "Play");
    // From its end it begins again.
    view.button.listeners.click();
    pass(4);
    near(+view.scrub.value, 0.5, 0.01, "again");
  } finally {
    performance.now = before;
  }
});

/** Rows of a table as lists of texts. */
const rowsOf = (table) => table.tagged("tr").map((row) => row.children.map((cell) => text(cell)));

test("the table of events has the time, the force and the velocities of each", () => {
  const view = new EventView(motionEngine, plain);
  const one = run();
  view.update({ values: one.state(0) }, [one]);
  const [velocities, events] = view.element.tagged("table").map(rowsOf);
  assert.deepEqual(velocities, [["", "x\u0307 (m/s)", "y\u0307 (m/s)"], ["before", "1", "0"],
    ["compliant: at separation, t = 1.5 s", "−0.5", "4.5"]]);
  assert.deepEqual(events[0], ["", "time (s)", "event", "mode after", "Fn (N)", "x\u0307 after (m/s)", "y\u0307 after (m/s)"]);
  assert.deepEqual(events.slice(1), [
    ["1", "0.5", "max compression", "stick", "12", "0.5", "1.5"], ["2", "1.5", "separation", "stick", "4", "−0.5", "4.5"],
    ["", "2", "end: t end", "flight", "0", "−1", "6"]]);
  const titles = view.element.tagged("abbr").map((e) => e.attributes.title);
  assert.deepEqual(titles, ["max_compression happens", "separation happens", "the end time was reached"]);
});

test("events below the tolerance are counted, not listed, and speeds and forces below it are 0", () => {
  const one = run();
  one.eventsAboveTolerance = [one.events[1]];
  one.tolerance = (name) => ({ normal_force: 4.5, x_dot: 0.4, y_dot: 4.4 })[name];
  const view = new MotionView(motionEngine, () => {}, plain, { rtol: 1e-11, openFrom: 1e-8 });
  view.update({ values: {}, magnify: 0, at: 0 }, [one]);
  const lines = view.figure.classed("event");
  assert.deepEqual(lines.map((line) => text(line.tagged("title")[0])), ["separation at 1.5 s"]);
  assert.deepEqual(view.legend.children.slice(2).map((li) => text(li)),
    ["events, numbered as below", "1 event below the tolerance"]);
  const tables = new EventView(motionEngine, plain);
  tables.update({ values: one.state(0) }, [one]);
  const [velocities, events] = tables.element.tagged("table");
  assert.equal(text(events.tagged("caption")[0]), "Events, compliant, without 1 event below the tolerance");
  assert.deepEqual(rowsOf(events).slice(1), [["1", "1.5", "separation", "stick", "0", "−0.5", "4.5"],
    ["", "2", "end: t end", "flight", "0", "−1", "6"]]);
  one.tolerance = () => 1;
  tables.update({ values: one.state(0) }, [one]);
  assert.deepEqual(rowsOf(tables.element.tagged("table")[0])[1], ["before", "0", "0"]);
});

// ---- the contact problem ----

test("lines and solutions of the contact problem stand at their numbers", () => {
  const engine = { description: { contacts: [{ name: "A", bilateral: false, gap: "gap", gap_rate: "rate" }] } };
  const view = new ProblemView(engine, plain);
  const problem = {
    A_neg: -0.5, A_pos: 2, A_stick: 1, B_stick: -3, B: 6, slip: -1, slipVelocity: -1.5, mu: 0.4, inside: "",
    state: { gap: 0, rate: 0 }, word: { name: "indeterminate", sentence: "several" },
    solutions: [{ mode: "liftoff", normal: 0, tangential: 0 }, { mode: "slip", normal: 12, tangential: 4.8 }],
  };
  view.update({ contact: 0 }, problem);
  const { x, y } = axesOf(view.figure);
  const circles = view.figure.classed("solution").map((c) => [x(+c.attributes.cx), y(+c.attributes.cy)]);
  [[0, 6], [12, 0]].forEach(([F, a], i) => {
    near(circles[i][0], F, 0.05);
    near(circles[i][1], a, 0.05);
  });
  const [[start, end]] = curveOf(view.figure, view.figure.classed("slip-left")[0]);
  near(start[1], 6, 0.05, "B");
  near((end[1] - start[1]) / (end[0] - start[0]), -0.5, 0.01, "A");
  const possible = curveOf(view.figure, view.figure.classed("possible")[0])[0];
  assert.ok(possible[0][1] > 5 && Math.abs(possible[1][1]) < 0.05 && possible[2][0] > 12, "a_n F_n = 0");
  const numbers = view.numbers.children.map((div) => div.children.map((c) => text(c)));
  assert.deepEqual(numbers, [["A", "−0.5 1/kg"], ["B", "6 m/s²"], ["A′", "1 1/kg"], ["B′", "−3 m/s²"],
    ["v_t", "−1.5 m/s"], ["μ", "0.4 "]]);
  assert.deepEqual(view.list.children.map((li) => text(li)), ["no force: Fn = 0 N, Ft = 0 N", "slip: Fn = 12 N, Ft = 4.8 N"]);
  assert.equal(text(view.words), "indeterminate: two solutions");
  view.update({ contact: 0 }, { ...problem, slip: 1 });
  assert.equal(text(view.numbers.children[0].children[1]), "2 1/kg");
});

// ---- the mechanism ----

test("shapes and the ground stand upright, up is up, at their places", () => {
  const box = { left: -2, right: 6, low: -1, high: 5, room: 1 };
  const points = [[[0, 1], [3, 1]], [[1, 2], [4, 3], [2, 5]], [[2, 4]], [[0, 3]]];
  const engine = {
    description: { scene: { deflections: [] }, contacts: [] },
    scene: () => ({ kinds: ["disc", "polygon", "dot", "pin"], points, contacts: [] }),
    // Zero along y = 1 + x/2.
    surfaces: (values, state, xs, ys, count) => [Float64Array.from({ length: count * count }, (_, k) => {
      const [i, j] = [Math.floor(k / count), k % count];
      return ys[0] + ((ys[1] - ys[0]) * j) / (count - 1) - 1 - (xs[0] + ((xs[1] - xs[0]) * i) / (count - 1)) / 2;
    })],
  };
  const scene = new Scene(engine, "rigid", plain);
  scene.update({}, { state: {}, outputs: {} }, box, 1, 1, "slip");
  const [left, top, width, height] = scene.figure.attributes.viewBox.split(" ").map(Number);
  // The window of the picture: its upper border is the highest place.
  assert.deepEqual([left, -top, left + width, -top - height], [box.left, box.high, box.right, box.low]);
  const [disc, dot, pin] = scene.figure.tagged("circle").map((c) => [+c.attributes.cx, -c.attributes.cy, +c.attributes.r]);
  assert.deepEqual(disc, [0, 1, 3]);
  assert.deepEqual(dot.slice(0, 2), [2, 4]);
  assert.deepEqual(pin.slice(0, 2), [0, 3]);
  const paths = scene.figure.tagged("path").map((p) => p.attributes.d);
  assert.equal(paths.find((d) => d.endsWith("Z") && !d.includes("l")), "M1 -2L4 -3L2 -5Z");
  assert.ok(paths.includes("M0 -1L3 -1"));
  const [ground] = scene.figure.classed("ground");
  const ends = [...ground.attributes.d.matchAll(/[ML](\S+?) (\S+?)(?=[ML]|$)/g)].map((m) => [+m[1], -m[2]]);
  assert.ok(ends.length > 30);
  for (const [x, y] of ends) near(y, 1 + x / 2, 1e-6, "ground");
});

// ---- the controls ----

test("a slider sets its quantity, and shows the number that is set", () => {
  let taken = null;
  const q = (name, more) => ({ name, unit: "m/s", meaning: `rate of ${name}`, range: [-2, 6], value: 1, leading: true, ...more });
  const description = {
    states: [q("u", {}), q("v", { range: [10, 20] })], parameters: [], contacts: [{ name: "A", friction: "mu" }],
    motions: [{ parameters: [], choices: {}, pressable: true, rigid: [] }],
  };
  const first = { values: { u: 1, v: 12 }, end: 0.5, force: null, reload: "elastic", contact: 0 };
  const controls = new Controls({ description }, [], first, (part) => (taken = part), []);
  controls.update(first);
  const inputs = (name) => controls.element.classed("field").map((f) => f.tagged("input"))
    .find((own) => own.some((i) => i.attributes.name === name));
  const [range, number] = inputs("v");
  assert.equal(number.value, "12");
  assert.equal(range.value, "200");
  assert.equal(range.attributes["aria-valuetext"], "12 m/s");
  range.value = "750";
  range.listeners.input();
  assert.deepEqual(taken.values, { u: 1, v: 17.5 });
  number.value = "13.25";
  number.listeners.change();
  assert.deepEqual(taken.values, { u: 1, v: 13.25 });
  const [force] = inputs("initial-force");
  force.value = "7";
  force.listeners.change();
  assert.equal(taken.force, 7);
  const [, end] = inputs("t-end");
  assert.equal(end.value, "0.5");
  end.value = "2";
  end.listeners.change();
  assert.equal(taken.end, 2);
});

test("times on a magnified axis are round, increase, and stand where they are", async () => {
  const { Clock } = await import(pathToFileURL(path.join(process.env.EXPLORER_WEB, "clock.js")).href);
  const times = [0, 1.2e-3, 1.25e-3, 1.3e-3, 1.74e-3, 1.9e-3, 2.2e-3, 0.01];
  for (const magnify of [0, 0.7, 1]) {
    const clock = new Clock(times, magnify);
    const marks = clock.marks();
    assert.ok(marks.length >= 4 && marks.length <= 5);
    for (const [i, { at, time }] of marks.entries()) {
      assert.ok(Math.abs(clock.time(at) - time) < 1e-12);
      assert.ok(String(+time.toPrecision(12)).replace(/[.0]/g, "").length <= 3, `${time}`);
      if (i) assert.ok(at > marks[i - 1].at);
    }
  }
});
