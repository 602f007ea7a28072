/** Events of a motion that are rounding, by the rule of `painleve_sym.motion.small_events`. */

/** Of the time between two events, at which rates are looked at. */
const PARTS = [0.25, 0.5, 0.75];

/**
 * Returns the events without those whose rate stays below the tolerance on both sides.
 * @param {import("./engine.js").Run} run that its motion still holds
 */
export function eventsAboveTolerance(run) {
  const { names, description: { contacts } } = run.motion;
  const rates = Object.fromEntries(names.events.map((e) => [e.name, e.rate]));
  const small = new Set();
  for (const contact of contacts) {
    const mine = run.events.filter((e) => contacts.length === 1 || e.contact === contact.name);
    for (const [rate, state] of [["gap_rate", contact.gap_rate], ["slip_velocity", contact.slip]]) {
      const own = mine.filter((e) => rates[e.kind] === rate);
      const still = stillBetween(run, own.map((e) => e.time), state);
      own.forEach((e, i) => still[i] && still[i + 1] && small.add(e));
    }
  }
  return run.events.filter((e) => !small.has(e));
}

/**
 * Whether a rate stays below the tolerance between times, from start to end.
 * @param {import("./engine.js").Run} run @param {number[]} times @param {string} state
 */
function stillBetween(run, times, state) {
  const ends = [0, ...times, run.end?.time ?? 0];
  const limit = run.rtol * run.scales[state];
  return ends.slice(1).map((end, i) => PARTS.every((part) => {
    const moment = run.at(ends[i] + part * (end - ends[i]));
    return moment !== null && Math.abs(moment.state[state]) <= limit;
  }));
}
