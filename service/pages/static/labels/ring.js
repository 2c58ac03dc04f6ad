// A ring: the border of two parts, and how far each point near it lies from it along the surface.

import { distance } from './scan.js';

/** How far a ring can be moved [m], how far from a press one is looked for [m], and how wide it is at least: a wrist [m]. */
const REACH = 0.3, NEAR = 0.08, WIDE = 0.05;

/**
 * Find the border nearest to a point.
 * @param {import('./painting.js').Painting} painting @param {number} vertex
 * @returns {{low: number, high: number, away: Map<number, number>, offset: number, reach: number, points: number[]}|null}
 *   the parts below and above it; how far points are above it along the surface [m]; how far it was moved [m]
 */
export function findRing({ scan, label, neighbours, cubes }, vertex) {
  const { positions } = scan, { start, other } = neighbours, at = positions.subarray(3 * vertex, 3 * vertex + 3);
  const differs = (n) => {
    for (let k = start[n]; k < start[n + 1]; k += 1) if (label[other[k]] !== label[n]) return other[k];
    return -1;
  };
  const near = cubes.find(at, NEAR).filter((n) => differs(n) >= 0).sort((n, m) => distance(positions, n, at) - distance(positions, m, at));
  const walked = [], seen = new Set();
  for (const n of near) {
    if (seen.has(n)) continue;
    const parts = [label[n], label[differs(n)]], border = walkBorder(n, parts, label, neighbours);
    for (const m of border) seen.add(m);
    walked.push({ parts, border });
    if (widthOf(border, positions) >= WIDE) break;
  }
  if (!walked.length) return null;
  const { parts, border } = walked.find((one) => widthOf(one.border, positions) >= WIDE) ?? walked[0]; // islands of a few points come last
  const level = parts.map((part) => {
    const own = border.filter((n) => label[n] === part);
    return own.reduce((sum, n) => sum + positions[3 * n + 1], 0) / own.length;
  });
  const [low, high] = level[0] < level[1] ? parts : [parts[1], parts[0]];
  const away = measure(border, new Set(parts), scan, label, neighbours);
  for (const [n, far] of away) away.set(n, label[n] === low ? -far : far);
  return { low, high, away, offset: 0, reach: REACH, points: border };
}

/** @returns {number} how far apart points of a border are at most, roughly [m] */
function widthOf(border, positions) {
  const spans = [0, 1, 2].map((k) => {
    const values = border.map((n) => positions[3 * n + k]);
    return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b));
  });
  return Math.max(...spans);
}

/** @returns {number[]} the points of either part that are connected with a point along the border of both */
function walkBorder(first, parts, label, { start, other }) {
  const isBorder = (n) => {
    if (!parts.includes(label[n])) return false;
    for (let k = start[n]; k < start[n + 1]; k += 1) if (label[other[k]] !== label[n] && parts.includes(label[other[k]])) return true;
    return false;
  };
  const seen = new Set([first]), ahead = [first];
  while (ahead.length) {
    const n = ahead.pop();
    for (let k = start[n]; k < start[n + 1]; k += 1) {
      if (!seen.has(other[k]) && isBorder(other[k])) seen.add(other[k]), ahead.push(other[k]);
    }
  }
  return [...seen];
}

/** @returns {Map<number, number>} how far points of both parts are from the border along edges [m], up to `REACH` */
function measure(border, parts, { positions }, label, { start, other }) {
  const away = new Map(), queue = [];
  const length = (n, m) => distance(positions, n, positions.subarray(3 * m, 3 * m + 3));
  const inBorder = new Set(border);
  for (const n of border) { // the border runs through the middle of the edges between both parts
    let half = Infinity;
    for (let k = start[n]; k < start[n + 1]; k += 1) if (inBorder.has(other[k]) && label[other[k]] !== label[n]) half = Math.min(half, length(n, other[k]) / 2);
    push(queue, half, n);
  }
  while (queue.length) {
    const [far, n] = pop(queue);
    if (far > REACH || away.has(n)) continue;
    away.set(n, far);
    for (let k = start[n]; k < start[n + 1]; k += 1) {
      const m = other[k];
      if (label[m] === label[n] && parts.has(label[m]) && !away.has(m)) push(queue, far + length(n, m), m);
    }
  }
  return away;
}

/** Put a point into a heap, the nearest first. @param {[number, number][]} heap */
function push(heap, far, n) {
  let at = heap.push([far, n]) - 1;
  for (let above = (at - 1) >> 1; at > 0 && heap[above][0] > heap[at][0]; above = (at - 1) >> 1) {
    [heap[above], heap[at]] = [heap[at], heap[above]];
    at = above;
  }
}

/** @param {[number, number][]} heap @returns {[number, number]} the nearest, taken out of it */
function pop(heap) {
  const first = heap[0], last = heap.pop();
  if (!heap.length) return first;
  heap[0] = last;
  for (let at = 0; ;) {
    const [left, right] = [2 * at + 1, 2 * at + 2];
    let least = at;
    if (left < heap.length && heap[left][0] < heap[least][0]) least = left;
    if (right < heap.length && heap[right][0] < heap[least][0]) least = right;
    if (least === at) return first;
    [heap[at], heap[least]] = [heap[least], heap[at]];
    at = least;
  }
}
