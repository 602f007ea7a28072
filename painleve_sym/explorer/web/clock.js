/** Playing time: seconds of motion and the far shorter impacts on one axis. */

/**
 * A map from the parts 0 to 1 of an animation to times and back. Of the animation the part
 * `magnify` belongs in equal shares to the steps of the integration, which are short where much
 * happens; the rest runs in proportion to the time.
 */
export class Clock {
  /** @param {number[]} times ends of the steps, increasing @param {number} magnify from 0 to 1 */
  constructor(times, magnify) {
    const end = times[times.length - 1] || 1;
    const last = times.length - 1 || 1;
    this.end = end;
    this.times = times;
    this.parts = times.map((t, i) => (1 - magnify) * (t / end) + magnify * (i / last));
  }

  /** The time at a part of the animation; s. @param {number} part */
  time(part) {
    return between(this.parts, this.times, part);
  }

  /** The part of the animation at a time. @param {number} time */
  part(time) {
    return between(this.times, this.parts, time);
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

/** @param {number[]} from @param {number[]} to @param {number} value */
function between(from, to, value) {
  let [low, high] = [0, from.length - 1];
  if (high < 1 || value <= from[0]) return to[0];
  if (value >= from[high]) return to[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (from[middle] <= value) low = middle;
    else high = middle;
  }
  const width = from[high] - from[low];
  return to[low] + (width > 0 ? (value - from[low]) / width : 0) * (to[high] - to[low]);
}
