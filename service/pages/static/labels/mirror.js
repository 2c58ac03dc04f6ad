// Copies of labels to the other side of the wearer.

import { distance } from './scan.js';

/** Radii in which a mirrored point's counterpart is looked for [m]: the last is the farthest, less than an arm is thick. */
const RADII = [0.01, 0.02, 0.04];

/** @typedef {{point: number[], normal: number[]}} Plane the sagittal plane: a point of it [m], and the way to the wearer's left */

/**
 * Find the labels that points get from their counterparts on the other side.
 * @param {import('./painting.js').Painting} painting @param {Plane} plane
 * @param {{from: 1|-1}|{chosen: ArrayLike<number>}} source all points of the wearer's left (1) or right (-1), or some points, which keep their labels
 * @returns {{points: number[], values: number[], missing: number}} `missing` points of a side have no counterpart
 */
export function mirror(painting, plane, source) {
  const { scan, label } = painting, chosen = source.chosen ? new Set(source.chosen) : null;
  const points = [], values = [];
  let missing = 0;
  for (let n = 0; n < scan.count; n += 1) {
    const at = scan.positions.subarray(3 * n, 3 * n + 3), away = awayFrom(plane, at);
    if (chosen ? chosen.has(n) : away * source.from >= 0) continue;
    const found = findCounterpart(painting, plane, n, at, away);
    if (found < 0) missing += 1;
    else if (!chosen || chosen.has(found)) points.push(n), values.push(label[found]);
  }
  return { points, values, missing };
}

/** @returns {number} how far a place is to the left of the plane [m] */
const awayFrom = ({ point, normal }, at) => normal.reduce((sum, part, k) => sum + part * (at[k] - point[k]), 0);

/** @returns {number} the point nearest to the mirror image of another one that faces as that does; -1: none is near */
function findCounterpart({ scan, cubes, normals }, { normal }, n, at, away) {
  const image = [0, 1, 2].map((k) => at[k] - 2 * away * normal[k]);
  const own = normals?.subarray(3 * n, 3 * n + 3), across = own ? own[0] * normal[0] + own[1] * normal[1] + own[2] * normal[2] : 0;
  const facing = own ? [0, 1, 2].map((k) => own[k] - 2 * across * normal[k]) : [];
  const fits = (m) => !own || facing[0] * normals[3 * m] + facing[1] * normals[3 * m + 1] + facing[2] * normals[3 * m + 2] > 0;
  for (const radius of RADII) {
    let best = -1, least = Infinity;
    for (const m of cubes.find(image, radius)) {
      const far = distance(scan.positions, m, image);
      if (far < least && fits(m)) best = m, least = far;
    }
    if (best >= 0) return best;
  }
  return -1;
}
