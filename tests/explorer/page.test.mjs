/** Modules of the explorer under Node: settings, playing time, drawings, and the engine's numbers.
 *
 * EXPLORER_WEB is the folder of the modules. EXPLORER_CASES, where set, is a JSON file of cases whose
 * numbers the package computed. */

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

import "./dom.mjs";

const web = process.env.EXPLORER_WEB;
const own = (name) => import(pathToFileURL(path.join(web, name)).href);
const { defaults, fault, fromText, toText } = await own("settings.js");
const { Clock } = await own("clock.js");
const { Frame, pretty, short, span, symbols, ticks, whole, zeros } = await own("draw.js");
const { rangeAround } = await own("map.js");
const { Run, load, unpacked } = await own("engine.js");
const { eventsAboveTolerance } = await own("small_events.js");
const { linesOf, notes } = await own("problem.js");
const { sliderScale } = await own("controls.js");
const { afterImpact, eventWords, modeWords, remarks } = await own("motion.js");
const { Scene, magnification, windowOf } = await own("scene.js");

const positive = { lower: 0, upper: null, lower_closed: false, upper_closed: true };
const description = {
  states: [{ name: "theta", value: 1 }, { name: "theta_dot", value: 0.1 }],
  parameters: [{ name: "E", value: 2.09e11, ...positive, need: "a finite number with 0 < E" }],
  contacts: [{ name: "A" }, { name: "B" }],
  contact: 0,
  motions: [
    { rigid: [], choices: { reload: "elastic" } }, { rigid: [], choices: { reload: "virgin" } },
    { rigid: [0], choices: {} },
  ],
  over: ["theta", "theta_dot"],
};

test("settings survive the address bar, to the last bit", () => {
  const from = defaults(description);
  assert.equal(toText(from, from), "");
  const settings = {
    ...from,
    values: { theta: 0.1 + 0.2, theta_dot: -1 / 3, E: 2.09e17 },
    ...{ force: 350, end: 1e-3, over: ["theta", "E"], map: "outcomes", contact: 1 },
    ...{ reload: "virgin", magnify: 0.25, at: 0.125 },
  };
  const read = fromText(toText(settings, from), description, from);
  assert.deepEqual(read, { settings, faults: [] });
});

test("each entry of an address that cannot be taken is named, and the others are taken", () => {
  const from = defaults(description);
  const text = "theta=0.5&E=-1&theta_dot=&mu=1&map-over=theta,theta&at-contact=7&t-end=0&map-of=x" +
    "&magnify-time=1.5&play-at=-0.5&law-reload=none&initial-force=-3";
  const { settings, faults } = fromText(text, description, from);
  assert.equal(settings.values.theta, 0.5);
  assert.deepEqual({ ...settings, values: null }, { ...from, values: null });
  assert.equal(settings.values.E, 2.09e11);
  const named = ["E", "theta_dot", "mu", "map-over", "at-contact", "t-end", "map-of",
    "magnify-time", "play-at", "law-reload", "initial-force"];
  assert.deepEqual(faults.map((f) => /^address, ([\w-]+)=/.exec(f)[1]), named);
  assert.match(faults[1], /theta_dot: got nothing that is a number, need a finite number/);
  assert.match(faults[7], /need a number from 0 to 1\./);
});

test("numbers out of range are rejected in one sentence", () => {
  const [E] = description.parameters;
  assert.equal(fault(E, 1), "");
  assert.equal(fault(E, 0), "E: got 0, need a finite number with 0 < E.");
  assert.equal(fault(E, NaN), "E: got nothing that is a number, need a finite number with 0 < E.");
  assert.match(fault({ name: "theta" }, Infinity), /need a finite number/);
});

test("playing time and time are inverse, increasing, and magnify where steps are short", () => {
  const times = [0, 1, 1.0001, 1.0002, 1.0003, 2];
  for (const magnify of [0, 0.5, 1]) {
    const clock = new Clock(times, magnify);
    let last = -1;
    for (let part = 0; part <= 1; part += 1 / 64) {
      const t = clock.time(part);
      assert.ok(t > last);
      assert.ok(Math.abs(clock.part(t) - part) < 1e-12);
      last = t;
    }
    assert.equal(clock.time(0), 0);
    assert.equal(clock.time(1), 2);
  }
  assert.ok(Math.abs(new Clock(times, 0).slowing(0.5) - 1) < 1e-9);
  assert.ok(new Clock(times, 0.7).slowing(0.5) > 1000);
});

test("playing time has no corners where steps of different lengths meet", () => {
  const clock = new Clock([0, 1, 1.5, 1.7, 3, 3.1, 5], 0.8);
  const rate = (part, side) => (clock.time(part + side * 1e-7) - clock.time(part)) / (side * 1e-7);
  for (const part of clock.parts.slice(1, -1)) {
    assert.ok(Math.abs(rate(part, 1) - rate(part, -1)) < 1e-4 * rate(part, 1));
  }
  // Steps of no length, as of an impact at the start, take their share of the animation.
  const still = new Clock([0, 0, 0, 1], 0.6);
  assert.deepEqual([still.time(0.2), still.time(1)], [0, 1]);
  assert.ok(new Clock([0, 0, 1], 0).time(0.5) === 0.5);
});

test("lines of events say what they are, and which are left out", () => {
  assert.equal(eventWords(3), "events, numbered as below");
  assert.equal(eventWords(13), "events");
  assert.equal(eventWords(61), "events, the first 60 of 61");
});

test("indices of symbols are lowered in texts and drawings", () => {
  const [before, index, after] = symbols("F_n of left, μ = 1");
  assert.deepEqual([before, index.tag, index.children, after], ["F", "sub", ["n"], " of left, μ = 1"]);
  assert.deepEqual(symbols("two feet, left_foot"), ["two feet, left_foot"]);
  const axes = new Frame([0, 1], [0, 1]).axes("x\u0307_A (m/s)", "a_n").all();
  const own = axes.filter((e) => e.tag === "tspan").map((e) => [e.children[0], e.attributes.dy]);
  assert.deepEqual(own, [["A", "2.5"], [" (m/s)", "-2.5"], ["n", "2.5"]]);
});

test("numbers are written short or whole", () => {
  assert.equal(short(0.00040886242), "4.0886·10⁻⁴");
  assert.equal(short(-1.5), "−1.5");
  assert.equal(short(20.9e13), "2.09·10¹⁴");
  assert.equal(short(0), "0");
  for (const value of [2.09e11, 0.1 + 0.2, -1e-9, 0, 123456.75]) {
    assert.equal(Number(whole(value)), value);
  }
  assert.deepEqual(ticks(-1, 1, 4).map((t) => +t.toFixed(9)), [-1, -0.5, 0, 0.5, 1]);
  assert.deepEqual(ticks(1, 1), []);
  const [low, high] = span([5, NaN, 7]);
  assert.ok(low < 0 && high > 7);
  assert.deepEqual(["theta_dot", "x_A_dot", "mu", "e_energetic"].map(pretty),
    ["θ\u0307", "x\u0307_A", "μ", "e_energetic"]);
});

test("an axis leaves room around its point, but not beyond a bound", () => {
  const angle = { range: [-5, 5] };
  assert.deepEqual(rangeAround(angle, 1), [-5, 5]);
  assert.deepEqual(rangeAround(angle, 5), [-5, 6]);
  assert.deepEqual(rangeAround(angle, -7), [-8, 5]);
  const friction = { range: [0, 2], lower: 0 };
  assert.deepEqual(rangeAround(friction, 0), [0, 2]);
  assert.deepEqual(rangeAround(friction, 2), [0, 2.2]);
  assert.deepEqual(rangeAround({ range: [0.05, 1], lower: 0, upper: 1 }, 1), [0.05, 1]);
});

test("a start that is not at rest on its contact is said so", () => {
  const contact = { gap: "gap", gap_rate: "rate" };
  const said = (gap, rate, slip = 1) => notes({ inside: "", state: { gap, rate }, slip }, contact).join(" ");
  assert.equal(said(0, 0), "");
  assert.equal(said(0, -2), "It approaches with 2 m/s: an impact.");
  assert.equal(said(0, 2), "It is leaving with 2 m/s.");
  assert.equal(said(0.1, -2), "The contact is open, gap 0.1 m; here it is taken as closed.");
  assert.equal(said(-0.1, 0), "The contact is compressed by 0.1 m.");
  assert.equal(said(0, 0, 0), "At rest sticking is possible, and slip to either side.");
  const rest = { inside: "", state: { gap: 0, rate: 0 }, A_neg: 1, A_pos: 0 };
  assert.equal(notes({ ...rest, slip: -1, B: 0 }, contact).join(" "), "It lies on the border of two cases: B = 0.");
  assert.equal(notes({ ...rest, slip: 1, B: 2 }, contact).join(" "), "It lies on the border of two cases: A = 0.");
});

test("modes are words, and those of the glossary are marked", () => {
  const plain = (mode) => modeWords(mode, (text) => text).flat(Infinity).join("");
  assert.equal(plain("slip_neg/compression"), "slip to the left, compression");
  assert.equal(plain("slip_pos"), "slip to the right");
  assert.equal(plain("A: flight_indented, B: stick/reload"), "A: flight, indented; B: stick, reload");
  const marked = modeWords("A: stick, B: flight", (text, word) => `<${word}>`).flat(Infinity).join("");
  assert.equal(marked, "A: <stick>; B: <flight>");
});

test("what a run ended with is said: the law, the bound, the energy, limits of the page", () => {
  const names = { rigid: [], choices: { reload: "virgin" } };
  const motion = { names, engine: { bound: () => "the rod lies flat at theta = 0" } };
  const tolerances = { rtol: 1e-11, openFrom: 1e-8 };
  const end = { stop: { name: "t_end", sentence: "" }, time: 0.5, residual: 2e-13, state: {} };
  const said = (part, events = []) =>
    remarks({ motion, fault: "", values: {}, events, end: { ...end, ...part } }, tolerances);
  assert.deepEqual(said({}), { faults: [], notes: ["compliant: the energy balance closes to 2·10⁻¹³."] });
  assert.equal(said({ residual: 0.9e-8 }).faults.length, 0);
  assert.deepEqual(said({ residual: 1.1e-8 }).notes, []);
  assert.equal(said({ residual: 0.013 }).faults[0], "compliant: The energy balance is off by 1.3 % of " +
    "its largest term, more than rtol 1e-11 explains: works and energies are not exact, and states may not be.");
  assert.equal(said({ residual: Infinity }).faults[0], "compliant: The energies are not finite.");
  assert.equal(said({ stop: { name: "left_domain" } }).notes[0],
    "compliant: the motion ends at t = 0.5 s: the rod lies flat at theta = 0.");
  assert.match(said({ stop: { name: "event_limit" } }).faults[0], /follows no more events\. Fix: end earlier/);
  assert.match(said({ stop: { name: "jam", sentence: "no exit" } }).faults[0], /t = 0\.5 s: no exit\./);
  const reload = (gain) => ({ kind: "reload", before: { contact_dissipation: gain }, after: { contact_dissipation: 0 } });
  assert.match(said({}, [reload(1e-5), reload(2e-5)]).notes[0],
    /^compliant: 2 reloads create 3·10⁻⁵ J by the reload rule virgin, which is thermodynamically inadm/);
  assert.equal(said({}, [reload(0)]).notes.length, 1);
  assert.deepEqual(remarks({ motion, fault: "no start", end: null }, tolerances).faults, ["compliant: no start."]);
});

test("deflections are drawn larger, by a round number, with the contact where it is", () => {
  const scene = (_, state) => ({
    kinds: ["stick"], points: [[[0, 0.1 + state.w], [1, 0]]],
    contacts: [{ name: "A", point: [0, 0.1 + state.w], normal: [0, 1], speed: 0 }],
  });
  const engine = { scene, description: { scene: { deflections: ["w"] } } };
  // 8 % of the length 1 is 80 times 0.001: 50 is the round number below.
  assert.equal(magnification(engine, {}, [{ w: 0 }, { w: 0.001 }]), 50);
  assert.equal(magnification(engine, {}, [{ w: 0.5 }]), 1);
  assert.equal(magnification(engine, {}, [{ w: 0 }]), 1);
  const box = windowOf(engine, {}, [{ w: 0.001 }], 50);
  // Drawn at 0.101, its place; the other end moves with it.
  assert.ok(Math.abs(box.low - (0 - 0.05 + 0.001 - box.room)) < 1e-12);
  const straight = { scene, description: { scene: { deflections: [] } } };
  assert.equal(magnification(straight, {}, [{ w: 0.001 }]), 1);
});

test("a picture stands upright, with forces along normal and tangent, and belts along theirs", () => {
  const engine = {
    surfaces: () => [],
    scene: () => ({
      kinds: ["stick", "pin"], points: [[[0, 1], [2, 3]], [[2, 3]]],
      contacts: [{ name: "A", point: [0, 1], normal: [0, 1], speed: -2 }],
    }),
    description: { scene: { deflections: [] }, contacts: [{ name: "A" }] },
  };
  const drawing = new Scene(engine, "compliant", (text) => text);
  const box = { left: -1, right: 3, low: 0, high: 4, room: 1 };
  const moment = { state: {}, outputs: { normal_force: 10, tangential_force: -10 } };
  drawing.update({}, moment, box, 10, 1, "slip");
  const { attributes } = drawing.figure;
  assert.equal(attributes.viewBox, "-1 -4 4 4");
  const paths = Object.fromEntries(drawing.figure.all().map((e) => [e.attributes.class, e.attributes.d]));
  assert.equal(paths["body stick"], "M0 -1L2 -3");
  // The tangent is the normal turned clockwise: a negative force points to the left.
  const ends = (d) => /^M(\S+) (\S+)L(\S+) (\S+?)M/.exec(d).slice(1).map(Number);
  const near = (own, wanted) => wanted.forEach((w, i) => assert.ok(Math.abs(own[i] - w) < 1e-9, own));
  near(ends(paths["arrow normal"]), [0, -1, 0, -1.9]);
  near(ends(paths["arrow tangential"]), [0, -1, -0.9, -1]);
  const [from, y, to, y_2] = ends(paths["arrow belt"]);
  assert.ok(to < from && y === y_2 && y > -1, "to the left, below the surface");
  const titles = drawing.figure.all().filter((e) => e.tag === "title").map((e) => e.children[0]);
  assert.deepEqual(titles, ["the surface moves with −2 m/s", "a fixed joint", "normal force 10 N",
    "tangential force −10 N"]);
  // A tenth of the force has two thirds of the arrow.
  drawing.update({}, { ...moment, outputs: { normal_force: 1, tangential_force: 0 } }, box, 10, 1, "");
  const weak = drawing.figure.all().find((e) => e.attributes.class === "arrow normal");
  near(ends(weak.attributes.d), [0, -1, 0, -1.6]);
  assert.ok(!drawing.figure.all().some((e) => e.attributes.class === "arrow tangential"));
  drawing.update({}, null, box, 10, 1, "");
  assert.equal(drawing.figure.attributes.hidden, true);
});

test("zeros of a field lie on its curve", () => {
  const radius = (i, j) => Math.hypot(i - 10, j - 10) - 6;
  const pieces = zeros(radius, 21, 21);
  assert.ok(pieces.length > 30);
  for (const [i, j] of pieces.flat()) assert.ok(Math.abs(radius(i, j)) < 0.05);
  assert.deepEqual(zeros(() => NaN, 5, 5), []);
});

test("sliders cover their range and find their own values", () => {
  const moduli = sliderScale({ range: [2.09e9, 2.09e19], logarithmic: true });
  assert.equal(moduli.value(0), 2.09e9);
  assert.equal(moduli.value(1000), 2.09e19);
  const angles = sliderScale({ range: [-1, 3], logarithmic: false });
  for (let notch = 0; notch <= 1000; notch++) {
    assert.equal(angles.notch(angles.value(notch)), notch);
    assert.equal(moduli.notch(moduli.value(notch)), notch);
  }
  assert.equal(angles.notch(99), 1000);
});

test("the lines of the contact problem are those that the slip allows", () => {
  const problem = { A_neg: -1, A_pos: 2, A_stick: 1, B: 3, B_stick: 4 };
  const names = (slip, bilateral) => linesOf({ ...problem, slip }, bilateral).map((l) => l.name);
  assert.deepEqual(names(-1, false), ["slip to the left"]);
  assert.deepEqual(names(0, false), ["slip to the left", "slip to the right", "sticking"]);
  assert.deepEqual(names(1, true), ["slip to the right", "slip to the right, pulled"]);
  const [, pull] = linesOf({ ...problem, slip: 1 }, true);
  assert.deepEqual([pull.slope, pull.side], [-1, -1]);
});

test("an event is listed where the rate of its contact is above the tolerance before or after it", () => {
  const kinds = { touchdown: "gap_rate", reload: "gap_rate", slip_stop: "slip_velocity", impact: null };
  const names = { events: Object.entries(kinds).map(([name, rate]) => ({ name, rate })) };
  const contacts = ["A", "B"].map((name) => ({ name, gap_rate: `n_${name}`, slip: `t_${name}` }));
  const event = (kind, contact, time) => ({ kind, contact, time });
  const events = [
    event("touchdown", "A", 1), event("slip_stop", "A", 1), event("reload", "A", 3), event("reload", "B", 3),
    event("impact", "A", 4), event("reload", "A", 4), event("slip_stop", "A", 5), event("slip_stop", "B", 6),
  ];
  const state = (t) => ({ n_A: t < 2 ? -2 : 1.9e-11, n_B: 2.1e-11, t_A: 0.9e-11, t_B: t < 5.9 ? 1 : 0 });
  const run = {
    motion: { names, description: { contacts } }, rtol: 1e-11, end: { time: 8 }, events,
    scales: { n_A: 2, n_B: 2, t_A: 1, t_B: 1 }, at: (t) => ({ state: state(t) }),
  };
  const listed = () => eventsAboveTolerance(run).map((e) => `${e.kind} ${e.contact} ${e.time}`);
  // Between 1 and 3 s the gap of A changes by 2 m/s at the first of the three times.
  assert.deepEqual(listed(), ["touchdown A 1", "reload A 3", "reload B 3", "impact A 4", "slip_stop B 6"]);
  run.scales.n_B = 3;
  run.scales.t_A = 0.5;
  assert.deepEqual(listed(), ["touchdown A 1", "slip_stop A 1", "reload A 3", "impact A 4", "slip_stop A 5", "slip_stop B 6"]);
  // The events of one contact do not name it.
  run.motion.description.contacts = [{ ...contacts[0], name: "tip" }];
  run.events = [event("reload", "", 3), event("reload", "", 1), event("reload", "", 5)];
  run.events.sort((a, b) => a.time - b.time);
  assert.deepEqual(listed(), ["reload  1", "reload  3"]);
});

test("what counts as 0 of a speed or force is the tolerance of the run on its size", () => {
  const event = (v, force) => ({ before: { v: 0 }, after: { v }, outputs: { normal_force: force, tangential_force: 1, gap: 99 } });
  const own = Object.assign(new Run({}, {}, "no start", 0, 0.25), {
    events: [event(-3, 5), event(1, 2)], scales: { v: 0.5 }, end: { state: { v: 2 }, outputs: { normal_force: -7, tangential_force: 0, gap: 99 } },
  });
  assert.deepEqual(["v", "normal_force", "tangential_force"].map((n) => own.tolerance(n)), [0.75, 1.75, 1.75]);
  own.scales.v = 4;
  assert.equal(own.tolerance("v"), 1);
});

// ---- numbers of the package ----

const close = (own, expected, where, part = 1e-12) => {
  const size = Math.max(1, Math.abs(expected));
  assert.ok(Math.abs(own - expected) <= part * size, `${where}: ${own} is not ${expected}`);
};

const file = process.env.EXPLORER_CASES;
for (const wanted of file ? JSON.parse(fs.readFileSync(file, "utf8")) : []) {
  test(`numbers of ${wanted.name} are the package's`, async () => {
    const engine = await load(await unpacked(wanted.module), wanted.description);
    const { values, force, options } = wanted;
    const problem = engine.problem(values, wanted.contact);
    for (const [name, value] of Object.entries(wanted.problem)) close(problem[name], value, name);
    assert.equal(problem.word.name, wanted.case);
    const forces = problem.solutions.map((s) => s.normal).sort((a, b) => a - b);
    assert.equal(forces.length, wanted.forces.length);
    wanted.forces.forEach((f, i) => close(forces[i] / (f || 1), f ? 1 : 0, `solution ${i}`));
    const motions = engine.shown(wanted);
    // The last bits of a power differ between C libraries, and a run keeps its tolerance.
    const { rtol } = options;
    assert.equal(motions.length, wanted.runs.length);
    for (const [i, run] of wanted.runs.entries()) {
      const own = motions[i].run(values, force, options);
      assert.equal(own.fault, "");
      assert.equal(own.end.stop.name, run.stop);
      close(own.end.residual, run.residual, "energy residual", rtol);
      assert.deepEqual(own.events.map((e) => e.kind), run.events.map((e) => e.kind));
      assert.deepEqual(own.events.map((e) => e.contact), run.events.map((e) => e.contact));
      assert.deepEqual(own.eventsAboveTolerance.map((e) => own.events.indexOf(e)), run.listed);
      for (const [k, event] of run.events.entries()) {
        close(own.events[k].time, event.time, `time of event ${k}`, rtol);
        // Where compression just reaches its former maximum, the speed has half of the digits.
        const half = event.kind === "yield" ? Math.sqrt(Number.EPSILON) : rtol;
        for (const [s, value] of Object.entries(event.state)) {
          close(own.events[k].after[s], value, `${s} of event ${k}`, half);
        }
      }
      for (const moment of run.moments) {
        const at = own.at(moment.time);
        for (const [s, value] of Object.entries(moment.state)) close(at.state[s], value, s, rtol);
        for (const [s, value] of Object.entries(moment.outputs)) {
          close(at.outputs[s] / wanted.force_scale, value / wanted.force_scale, s, rtol);
        }
      }
      if (run.after) {
        const { state } = afterImpact(own);
        for (const [s, value] of Object.entries(run.after)) close(state[s], value, `${s} after`);
      }
    }
    for (const map of wanted.maps) {
      const { over, ranges, points, slip } = map;
      const grid = engine.map(values, over[0], ranges[0], points, over[1], ranges[1], points,
        wanted.contact, slip);
      const others = map.cases.flat().map((own, k) => [k, own, grid.cases[k], grid.push[k], grid.B[k], grid.pull[k]]);
      assert.deepEqual(others.filter(([, own, here]) => own !== here), []);
    }
    // Running a map of outcomes leaves the shown motion as it was.
    const shown = engine.motions[0].run(values, force, options);
    const before = JSON.stringify(shown.at(shown.end.time / 2));
    const [a, b] = [0, 1].map((k) => engine.index(engine.description.over[k]));
    const line = [b, [values[engine.description.over[1]], 1], 3];
    engine.motions[0].outcomes(values, force, line, [a, values[engine.description.over[0]]],
      { end: options.end, rtol: 1e-6, maxSteps: 2000 }, ["slip_stop", "separation"]);
    assert.equal(JSON.stringify(shown.at(shown.end.time / 2)), before);
    // A start outside of the domain, or of the law, is the sentence of the package.
    for (const { change, force, motion, message } of wanted.refused) {
      const { fault: sentence } = motions[motion].run({ ...values, ...change }, force, options);
      const [, meaning] = /need .* \((the .*)\)\.$/.exec(message) ?? [];
      if (meaning) assert.equal(sentence, `the start is outside the model: ${meaning}`);
      else if (message.includes("need both 0")) {
        assert.equal(sentence.slice(0, 60), message.split(": ").slice(1).join(": ").slice(0, 60));
      } else assert.ok(message.endsWith(`: ${sentence}.`), `${sentence}, not ${message}`);
    }
  });
}
