/** Playing time: seconds of motion and the far shorter impacts on one axis. */
import { roundest } from "./draw.js";

/**
 * A map from the parts 0 to 1 of an animation to times and back. Of the animation the part
 * `magnify` belongs in equal shares to the steps of the integration, which are short where much
 * happens; the rest runs in proportion to the time. Between the ends of the steps it is a monotone
 * cubic (Fritsch and Carlson 1980), so that curves over it have no corners of its own.
 */
export class Clock {
  /** @param {number[]} times ends of the steps, increasing @param {number} magnify from 0 to 1 */
  constructor(times, magnify) {
    const end = times[times.length - 1] || 1;
    const last = times.length - 1 || 1;
    const parts = times.map((t, i) => (1 - magnify) * (t / end) + magnify * (i / last));
    const kept = parts.flatMap((part, i) => (!i || part > parts[i - 1] ? [i] : []));
    this.end = end;
    this.parts = kept.map((i) => parts[i]);
    this.times = kept.map((i) => times[i]);
    this.slopes = slopes(this.parts, this.times);
  }

  /** The time at a part of the animation; s. @param {number} part */
  time(part) {
    const { parts, times } = this;
    const last = parts.length - 1;
    if (last < 1 || part <= parts[0]) return times[0];
    return part >= parts[last] ? times[last] : this.#within(interval(parts, part), part);
  }

  /** @param {number} i @param {number} part */
  #within(i, part) {
    const { parts, times, slopes } = this;
    const width = parts[i + 1] - parts[i];
    const [s, rise] = [(part - parts[i]) / width, times[i + 1] - times[i]];
    const [m, n] = [slopes[i] * width, slopes[i + 1] * width];
    return times[i] + s * (m + s * (3 * rise - 2 * m - n + s * (m + n - 2 * rise)));
  }

  /** The part of the animation at a time. @param {number} time */
  part(time) {
    const { parts, times } = this;
    const last = parts.length - 1;
    if (last < 1 || time <= times[0]) return parts[0];
    if (time >= times[last]) return parts[last];
    const i = interval(times, time);
    let [low, high] = [parts[i], parts[i + 1]];
    for (let k = 0; k < 52; k++) {
      const middle = (low + high) / 2;
      if (this.#within(i, middle) <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  /** Round times near even parts of the animation, and the part of each. @param {number} [count] */
  marks(count = 4) {
    const reach = 0.36 / count;
    const times = Array.from({ length: count }, (_, i) => (i + 1) / count).map((part) =>
      roundest(this.time(part - reach), this.time(Math.min(1, part + reach))));
    return [...new Set([0, ...times])].map((time) => ({ at: this.part(time), time }));
  }

  /** How much slower than in proportion to the time it runs there. @param {number} part */
  slowing(part) {
    const step = 1e-3;
    const low = Math.max(0, part - step);
    const high = Math.min(1, part + step);
    const passed = this.time(high) - this.time(low);
    return passed > 0 ? (this.end * (high - low)) / passed : Infinity;
  }
}

/** Slopes of the monotone cubic at its knots. @param {number[]} x @param {number[]} y */
function slopes(x, y) {
  const rates = y.slice(1).map((v, i) => (v - y[i]) / (x[i + 1] - x[i]));
  return y.map((_, i) => {
    const [before, after] = [rates[i - 1] ?? rates[i], rates[i] ?? rates[i - 1]];
    // The harmonic mean: none of two rates is exceeded threefold.
    return before > 0 && after > 0 ? 2 / (1 / before + 1 / after) : 0;
  });
}

/** The interval of increasing numbers that holds a value. @param {number[]} from @param {number} value */
function interval(from, value) {
  let [low, high] = [0, from.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (from[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}
