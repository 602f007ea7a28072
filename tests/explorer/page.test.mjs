/** Modules of the explorer under Node: settings, playing time, drawings, and the engine's numbers.
 *
 * EXPLORER_WEB is the folder of the modules. EXPLORER_CASES, where set, is a JSON file of cases whose
 * numbers the package computed. */

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

const web = process.env.EXPLORER_WEB;
const own = (name) => import(pathToFileURL(path.join(web, name)).href);
const { defaults, fault, fromText, toText } = await own("settings.js");
const { Clock } = await own("clock.js");
const { short, span, ticks, whole, zeros } = await own("draw.js");
const { caseOf } = await own("map.js");
const { load, unpacked } = await own("engine.js");
const { linesOf } = await own("problem.js");
const { sliderScale } = await own("page.js");
const { afterImpact } = await own("motion.js");

const positive = { lower: 0, upper: null, lower_closed: false, upper_closed: true };
const description = {
  states: [{ name: "theta", value: 1 }, { name: "theta_dot", value: 0.1 }],
  parameters: [{ name: "E", value: 2.09e11, ...positive, need: "a finite number with 0 < E" }],
  contacts: [{ name: "A" }, { name: "B" }],
  motions: [{ rigid: false }],
  over: ["theta", "theta_dot"],
};

test("settings survive the address bar, to the last bit", () => {
  const from = defaults(description);
  assert.equal(toText(from, from), "");
  const settings = {
    ...from,
    values: { theta: 0.1 + 0.2, theta_dot: -1 / 3, E: 2.09e17 },
    ...{ force: 350, end: 1e-3, over: ["theta", "E"], map: "outcomes", contact: 1 },
    ...{ magnify: 0.25, at: 0.125 },
  };
  const read = fromText(toText(settings, from), description, from);
  assert.deepEqual(read, { settings, faults: [] });
});

test("each entry of an address that cannot be taken is named, and the others are taken", () => {
  const from = defaults(description);
  const text = "theta=0.5&E=-1&theta_dot=&mu=1&map-over=theta,theta&at-contact=7&t-end=0&map-of=x";
  const { settings, faults } = fromText(text, description, from);
  assert.equal(settings.values.theta, 0.5);
  assert.deepEqual({ ...settings, values: null }, { ...from, values: null });
  assert.equal(settings.values.E, 2.09e11);
  assert.equal(faults.length, 7);
  for (const name of ["E", "theta_dot", "mu", "map-over", "at-contact", "t-end", "map-of"]) {
    assert.ok(faults.some((f) => f.startsWith(`address, ${name}=`)), name);
  }
});

test("numbers out of range are rejected in one sentence", () => {
  const [E] = description.parameters;
  assert.equal(fault(E, 1), "");
  assert.equal(fault(E, 0), "E: got 0, need a finite number with 0 < E.");
  assert.match(fault(E, NaN), /got NaN/);
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

// ---- numbers of the package ----

const close = (own, expected, where) => {
  const size = Math.max(1, Math.abs(expected));
  assert.ok(Math.abs(own - expected) <= 1e-12 * size, `${where}: ${own} is not ${expected}`);
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
    for (const [i, run] of wanted.runs.entries()) {
      const own = engine.motions[i].run(values, force, options);
      assert.equal(own.fault, "");
      assert.equal(own.end.stop.name, run.stop);
      assert.deepEqual(own.events.map((e) => e.kind), run.events.map((e) => e.kind));
      assert.deepEqual(own.events.map((e) => e.contact), run.events.map((e) => e.contact));
      for (const [k, event] of run.events.entries()) {
        close(own.events[k].time, event.time, `time of event ${k}`);
        for (const [s, value] of Object.entries(event.state)) {
          close(own.events[k].after[s], value, `${s} of event ${k}`);
        }
      }
      for (const moment of run.moments) {
        const at = own.at(moment.time);
        for (const [s, value] of Object.entries(moment.state)) close(at.state[s], value, s);
        for (const [s, value] of Object.entries(moment.outputs)) {
          close(at.outputs[s] / wanted.force_scale, value / wanted.force_scale, s);
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
      const bilateral = engine.description.contacts[wanted.contact].bilateral;
      const cases = Array.from(grid.push, (A, k) => caseOf(A, grid.B[k], bilateral ? grid.pull[k] : null));
      const others = map.cases.flat().map((own, k) => [k, own, cases[k], grid.push[k], grid.B[k], grid.pull[k]]);
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
    // A start outside of the domain, or of the law, is a sentence.
    if (wanted.outside) {
      const { fault: sentence } = engine.motions[0].run({ ...values, ...wanted.outside }, null, options);
      assert.match(sentence, /outside the domain/);
    }
  });
}
