/**
 * Lengths of seams, what is sewn to what, and keeping the sides of seams as long as they were to each other.
 *
 * @typedef {import("./pattern_model.js").Pattern} Pattern
 * @typedef {{index: number, a: number, b: number, ratio: number, mismatch: number}} SeamLengths   metres
 */

import { norm, subtract, unitLength } from './edge_geometry.js';
import { edgeLength, getPanel, withPoints } from './pattern_model.js';
import { leastNorm } from './least_norm.js';
import { moveTogether, turn } from './symmetry.js';

/** Largest mismatch that ends the iteration [m]; a thousandth of what is promised (1e-6). */
const GOAL = 1e-9;
/** Most Gauss-Newton steps, and most halvings of one. */
const STEPS = 30,
  HALVINGS = 6;
/** Points that are sewn to moved ones may go this many times as far as those before all other points help. */
const FURTHEST = 4;

/** Return the lengths of both sides of every seam; a gathered seam has no mismatch. */
export function seamLengths(pattern) {
  return pattern.seams.map((seam, index) => {
    const a = edgeLength(pattern, seam.a),
      b = edgeLength(pattern, seam.b);
    return { index, a, b, ratio: a / b, mismatch: seam.gathered ? 0 : a - b };
  });
}

/** Return the control points that are sewn to one: across each seam that ends there, and across theirs. */
export function sewnPoints(pattern, point) {
  const key = ({ panel, point: at }) => `${panel}\n${at}`;
  const seen = new Map([[key(point), point]]),
    queue = [point];
  while (queue.length) {
    const next = queue.pop();
    for (const seam of pattern.seams) {
      for (const [one, other] of [
        [seam.a, seam.b],
        [seam.b, seam.a],
      ]) {
        if (one.panel !== next.panel) continue;
        const ends = edgeEnds(pattern, one),
          others = edgeEnds(pattern, other);
        for (const k of [0, 1]) {
          if (ends[k] !== next.point) continue;
          const partner = { panel: other.panel, point: others[seam.reversed ? 1 - k : k] };
          if (!seen.has(key(partner))) {
            seen.set(key(partner), partner);
            queue.push(partner);
          }
        }
      }
    }
  }
  seen.delete(key(point));
  return [...seen.values()];
}

/** Return the numbers of the control points at which an edge begins and ends. */
export function edgeEnds(pattern, ref) {
  return [ref.edge, (ref.edge + 1) % getPanel(pattern, ref.panel).points.length];
}

/** Return the edge that an edge is sewn to, the seam, and whether they run against each other; or null. */
export function seamOf(pattern, ref) {
  for (const [index, seam] of pattern.seams.entries()) {
    for (const [one, other] of [
      [seam.a, seam.b],
      [seam.b, seam.a],
    ]) {
      if (one.panel === ref.panel && one.edge === ref.edge) return { index, seam, other };
    }
  }
  return null;
}

/**
 * Move points as little as possible until every seam's sides differ by what they differed by before.
 *
 * Gauss-Newton with the least-norm step on l_a - q_s l_b = d_s, where q_s is a gathered seam's ratio before, else 1, and
 * d_s what was missing before (0 for seams that matched). At first only points that are sewn to moved ones are free, then
 * all but the moved ones.
 *
 * @param {Pattern} pattern   after an operation
 * @param {{before: Pattern, held: {panel: string, point: number}[], mirrors: object[]}} options   `before` null: every
 *   seam is to match; `held` stay; `mirrors` are kept
 * @returns {Pattern}
 */
export function keepSeams(pattern, { before, held, mirrors }) {
  if (!pattern.seams.length) return pattern;
  const targets = pattern.seams.map((seam) => {
    const like = before ?? pattern;
    const a = edgeLength(like, seam.a),
      b = edgeLength(like, seam.b);
    return seam.gathered ? { ratio: a / b, apart: 0 } : { ratio: 1, apart: before ? a - b : 0 };
  });
  const groups = moveTogether(pattern, mirrors);
  const still = new Set(held.map(({ panel, point }) => `${panel}\n${point}`));
  const sewn = new Set(
    held.flatMap((point) => sewnPoints(pattern, point)).map(({ panel, point }) => `${panel}\n${point}`),
  );
  const has = (group, names) =>
    group.some((member) => names.has(`${pattern.panels[member.panel].name}\n${member.point}`));
  const free = groups.filter((group) => !has(group, still));
  const near = free.filter((group) => has(group, sewn));
  const moved = before
    ? Math.max(0, ...held.map((at) => norm(subtract(pointOf(pattern, at), pointOf(before, at)))))
    : 0;
  if (near.length) {
    const tried = solve(pattern, targets, near);
    if (tried.worst < GOAL && tried.furthest <= FURTHEST * Math.max(moved, 1e-3)) return tried.pattern;
  }
  return solve(pattern, targets, free).pattern;
}

const pointOf = (pattern, { panel, point }) => getPanel(pattern, panel).points[point];

function solve(pattern, targets, groups) {
  const sides = pattern.seams.map((seam) => [seam.a, seam.b].map((ref) => sideOf(pattern, ref)));
  const basis = groups.flatMap(basisOf);
  const start = pattern.panels.map((panel) => panel.points);
  let points = start;
  let state = mismatch(points, sides, targets);
  for (let step = 0; step < STEPS && Math.max(...state.residual.map(Math.abs)) > GOAL && basis.length; step += 1) {
    const rows = state.slopes.map((slope) =>
      basis.map((vector) =>
        vector.reduce((sum, { panel, point, move }) => {
          const d = slope.get(panel * 4096 + point);
          return d ? sum + d[0] * move[0] + d[1] * move[1] : sum;
        }, 0),
      ),
    );
    const amount = leastNorm(
      rows,
      state.residual.map((value) => -value),
    );
    let share = 1,
      next = null;
    for (let halving = 0; halving < HALVINGS; halving += 1, share /= 2) {
      const tried = moveBy(points, basis, amount, share);
      const after = mismatch(tried, sides, targets);
      if (square(after.residual) < 0.99 * square(state.residual)) {
        next = { points: tried, state: after };
        break;
      }
    }
    if (next === null) break;
    ({ points, state } = next);
  }
  const changed = {};
  let furthest = 0;
  pattern.panels.forEach((panel, p) => {
    if (points[p] === start[p]) return;
    changed[panel.name] = points[p];
    points[p].forEach((point, i) => {
      furthest = Math.max(furthest, norm(subtract(point, start[p][i])));
    });
  });
  const moved = Object.keys(changed).length ? withPoints(pattern, changed) : pattern;
  return { pattern: moved, furthest, worst: Math.max(...state.residual.map(Math.abs)) };
}

const square = (values) => values.reduce((sum, value) => sum + value * value, 0);

function sideOf(pattern, ref) {
  const panel = pattern.panels.findIndex((other) => other.name === ref.panel);
  const [start, end] = edgeEnds(pattern, ref);
  return { panel, start, end, factor: unitLength(pattern.panels[panel].edges[ref.edge]) };
}

/** Return every seam's mismatch, and its derivative by the points that it depends on. */
function mismatch(points, sides, targets) {
  const residual = [],
    slopes = [];
  sides.forEach(([a, b], index) => {
    const { ratio, apart } = targets[index];
    const slope = new Map();
    let value = -apart;
    for (const [side, weight] of [
      [a, 1],
      [b, -ratio],
    ]) {
      const chord = subtract(points[side.panel][side.end], points[side.panel][side.start]);
      const length = norm(chord),
        pull = (weight * side.factor) / length;
      value += weight * side.factor * length;
      for (const [point, sign] of [
        [side.end, 1],
        [side.start, -1],
      ]) {
        const key = side.panel * 4096 + point,
          old = slope.get(key) ?? [0, 0];
        slope.set(key, [old[0] + sign * pull * chord[0], old[1] + sign * pull * chord[1]]);
      }
    }
    residual.push(value);
    slopes.push(slope);
  });
  return { residual, slopes };
}

/** Return an orthonormal basis of a group's movements, so that the least norm is that of all its points' movement. */
function basisOf(group) {
  const vectors = [
    [1, 0],
    [0, 1],
  ].map((way) => group.map((member) => ({ ...member, move: turn(member.matrix, way) })));
  const sizes = vectors.map((vector) =>
    Math.sqrt(vector.reduce((sum, { move }) => sum + move[0] ** 2 + move[1] ** 2, 0)),
  );
  if (group.length === 1 && Math.abs(group[0].matrix[0][0] + group[0].matrix[1][1] - 1) < 1e-9) {
    const best = sizes[0] > sizes[1] ? 0 : 1; // a point of the axis moves along it alone
    return [scaled(vectors[best], sizes[best])];
  }
  return vectors.map((vector, k) => scaled(vector, sizes[k]));
}

const scaled = (vector, size) => vector.map((part) => ({ ...part, move: [part.move[0] / size, part.move[1] / size] }));

function moveBy(points, basis, amount, share) {
  const moved = points.map((panel) => panel);
  basis.forEach((vector, k) => {
    for (const { panel, point, move } of vector) {
      if (moved[panel] === points[panel]) moved[panel] = points[panel].map((at) => [...at]);
      moved[panel][point][0] += share * amount[k] * move[0];
      moved[panel][point][1] += share * amount[k] * move[1];
    }
  });
  return moved;
}
