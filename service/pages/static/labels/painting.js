// Labels that are painted, filled, moved by their borders, and undone.

import { Cubes, findNeighbours, findNormals } from './scan.js';
import { findRing } from './ring.js';

/** Side of the cubes in which points are looked for [m]: some dozens of a scan's points. */
const CUBE = 0.03;

/** Confidence up to which a point counts as unsure. */
const UNSURE = 0.5;

/** @typedef {{points: Uint32Array, before: Uint8Array, after: Uint8Array, ring?: number}} Change */

/** Holds a label for each point of a scan, and notifies listeners of each change. */
export class Painting extends EventTarget {
  /** @param {import('./scan.js').Scan} scan */
  constructor(scan) {
    super();
    this.scan = scan;
    this.label = scan.label.slice();
    this.cubes = new Cubes(scan.positions, CUBE);
    this.neighbours = findNeighbours(scan, this.cubes);
    this.normals = findNormals(scan);
    /** @type {Change[]} */
    this.done = [];
    /** @type {Change[]} */
    this.undone = [];
    /** @type {Map<number, number>|null} what points of the stroke under way were before it */
    this.stroke = null;
    this.ring = null;
    /** @type {ArrayLike<number>|null} the points of the last change, or of the last outline */
    this.chosen = null;
  }

  /** @returns {number} how many points have another label than they came with */
  get changed() {
    return this.label.reduce((sum, value, n) => sum + (value === this.scan.label[n] ? 0 : 1), 0);
  }

  /** @returns {{all: Uint32Array, unsure: Uint32Array}} how many points have each label, and how many of these are unsure; painted ones are sure */
  count() {
    const { label, confidence } = this.scan, all = new Uint32Array(256), unsure = new Uint32Array(256);
    this.label.forEach((value, n) => {
      all[value] += 1;
      if (confidence && value === label[n] && confidence[n] <= UNSURE) unsure[value] += 1;
    });
    return { all, unsure };
  }

  /** Begin a stroke, which is undone as one change. */
  begin() {
    this.stroke = new Map();
    this.ring = null;
  }

  /** End it. */
  end() {
    const points = Uint32Array.from(this.stroke?.keys() ?? []).filter((n) => this.stroke.get(n) !== this.label[n]);
    const before = Uint8Array.from(points, (n) => this.stroke.get(n)), after = Uint8Array.from(points, (n) => this.label[n]);
    this.stroke = null;
    if (points.length) this.#keep({ points, before, after });
  }

  /**
   * Paint all points around a place that face the same way.
   * @param {number[]} at @param {number} vertex the nearest point @param {number} radius [m] @param {number} value
   */
  brush(at, vertex, radius, value) {
    const { normals } = this;
    const facing = (n) => !normals || [0, 1, 2].reduce((sum, k) => sum + normals[3 * n + k] * normals[3 * vertex + k], 0) > 0;
    this.#set(this.cubes.find(at, radius).filter(facing), value);
  }

  /** Give all points that are connected with a point, and have its label, another label. @param {number} vertex @param {number} value */
  fill(vertex, value) {
    const old = this.label[vertex], { start, other } = this.neighbours;
    if (old === value) return;
    const seen = new Set([vertex]), ahead = [vertex];
    while (ahead.length) {
      const n = ahead.pop();
      for (let k = start[n]; k < start[n + 1]; k += 1) {
        if (this.label[other[k]] === old && !seen.has(other[k])) seen.add(other[k]), ahead.push(other[k]);
      }
    }
    this.#set([...seen], value);
  }

  /** Give points a label each, as one change. @param {number[]} points @param {ArrayLike<number>} values */
  assign(points, values) {
    const chosen = this.chosen;
    this.begin();
    points.forEach((n, k) => {
      this.stroke.set(n, this.label[n]);
      this.label[n] = values[k];
    });
    this.end();
    this.chosen = chosen;
    this.#tell();
  }

  /** Give all points of an outline a label, and choose them. @param {number[]} points @param {number} value */
  enclose(points, value) {
    this.assign(points, new Uint8Array(points.length).fill(value));
    this.chosen = points.length ? points : null;
    this.#tell();
  }

  /** Choose the border of two parts that is nearest to a point. @param {number} vertex @returns {any} the ring, or null */
  chooseRing(vertex) {
    this.ring = findRing(this, vertex);
    return this.ring;
  }

  /** Move the chosen ring. @param {number} by [m], up where it is positive */
  moveRing(by) {
    const { ring } = this;
    if (!ring) return;
    const offset = Math.max(-ring.reach, Math.min(ring.reach, ring.offset + by));
    const points = [], after = [];
    ring.away.forEach((away, n) => {
      const value = away < offset ? ring.low : ring.high;
      if (value !== this.label[n]) points.push(n), after.push(value);
    });
    ring.offset = offset;
    if (!points.length) return;
    const change = { points: Uint32Array.from(points), before: Uint8Array.from(points, (n) => this.label[n]), after: Uint8Array.from(after) };
    change.points.forEach((n, k) => { this.label[n] = change.after[k]; });
    this.#keep(change);
  }

  undo() { this.#step(this.done, this.undone, 'before'); }

  redo() { this.#step(this.undone, this.done, 'after'); }

  /** @param {Change[]} from @param {Change[]} to @param {'before'|'after'} side */
  #step(from, to, side) {
    const change = from.pop();
    if (!change) return;
    change.points.forEach((n, k) => { this.label[n] = change[side][k]; });
    this.ring = this.chosen = null;
    to.push(change);
    this.#tell();
  }

  /** @param {number[]} points @param {number} value */
  #set(points, value) {
    for (const n of points) {
      if (!this.stroke.has(n)) this.stroke.set(n, this.label[n]);
      this.label[n] = value;
    }
    this.#tell();
  }

  /** @param {Change} change */
  #keep(change) {
    this.done.push(change);
    this.undone = [];
    this.chosen = change.points;
    this.#tell();
  }

  #tell() {
    this.dispatchEvent(new Event('change'));
  }
}
