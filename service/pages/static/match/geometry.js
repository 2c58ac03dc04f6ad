// Outlines of pieces: boxes, shelves and paths. Points are [x, y] in metres, y up; a drawing is in millimetres, y down.

/** @typedef {[number, number]} Point */

/** @param {Point[]} outline @returns {{low: Point, high: Point, size: Point, middle: Point}} the box around it */
export function boxOf(outline) {
  const low = /** @type {Point} */ ([Infinity, Infinity]);
  const high = /** @type {Point} */ ([-Infinity, -Infinity]);
  for (const point of outline) {
    for (const k of [0, 1]) {
      low[k] = Math.min(low[k], point[k]);
      high[k] = Math.max(high[k], point[k]);
    }
  }
  return { low, high, size: [high[0] - low[0], high[1] - low[1]],
    middle: [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2] };
}

/**
 * Put boxes on shelves one after the other, so that none overlaps another.
 * @param {Point[]} sizes @param {number} gap @param {number} width where a shelf ends
 * @returns {{places: Point[], size: Point}} the middle of each box from the upper left corner, y down, and the whole
 */
export function layOut(sizes, gap, width) {
  const places = [];
  let x = gap, y = gap, shelf = 0, widest = 0;
  for (const [wide, high] of sizes) {
    if (x > gap && x + wide + gap > width) {
      y += shelf + gap;
      x = gap;
      shelf = 0;
    }
    places.push(/** @type {Point} */ ([x + wide / 2, y + high / 2]));
    x += wide + gap;
    widest = Math.max(widest, x);
    shelf = Math.max(shelf, high);
  }
  return { places, size: [widest, y + shelf + gap] };
}

/** @param {Point[]} points @returns {string} a closed path in millimetres */
export function pathOf(points) {
  return 'M' + points.map(([x, y]) => `${(1e3 * x).toFixed(2)} ${(-1e3 * y).toFixed(2)}`).join('L') + 'Z';
}

/**
 * @param {Point[]} points
 * @param {{turned_over: boolean, angle: number, shift: Point}} fit how the first of a pair lies best on the second
 * @returns {Point[]} the points there
 */
export function place(points, fit) {
  const [cos, sin] = [Math.cos(fit.angle), Math.sin(fit.angle)];
  return points.map(([x, y]) => {
    const over = fit.turned_over ? -x : x;
    return [cos * over - sin * y + fit.shift[0], sin * over + cos * y + fit.shift[1]];
  });
}
