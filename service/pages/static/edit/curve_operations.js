/** Straightening curves, and making corners smooth and back. */

import { add, between, norm, relativeToChord, subtract } from './edge_geometry.js';
import { chordOf, edgeLength, getPanel, handlePoints, PatternError, withPanels } from './pattern_model.js';
import { findMirrors, imagePoints } from './symmetry.js';
import { keepSeams } from './seams.js';

/** A handle nearer than this to its chord (in chords) draws a straight line. */
const STRAIGHT = 1e-9;
/** Share of the chord from a point to its handle in a smooth point: a cubic's thirds. */
const THIRD = 1 / 3;

/**
 * Return the edges that run between two control points of a panel, the shorter way round.
 *
 * @returns {number[]} in the order of the outline
 */
export function edgesBetween(pattern, { panel: name, point: from }, { point: to }) {
  const count = getPanel(pattern, name).points.length;
  const way = (start, end) => Array.from({ length: (end - start + count) % count }, (_, k) => (start + k) % count);
  const length = (edges) => edges.reduce((sum, edge) => sum + edgeLength(pattern, { panel: name, edge }), 0);
  const one = way(from, to),
    two = way(to, from);
  return length(one) <= length(two) ? one : two;
}

/**
 * Straighten the outline between two control points; points between keep their share of the length.
 *
 * @param {import("./movement.js").Keep} keep
 */
export function straighten(pattern, one, two, keep) {
  if (one.panel !== two.panel || one.point === two.point)
    throw new PatternError('select two points of one panel to straighten the outline between them.');
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  let state = straightenOne(pattern, one, two);
  const held = heldBy(pattern, one, two);
  const firsts = imagePoints(pattern, mirrors, one),
    seconds = imagePoints(pattern, mirrors, two);
  const pairs = [[firsts[0] ?? one, seconds[0] ?? two]].filter(([a, b]) => mirrors.length && a.panel === b.panel);
  for (const [a, b] of pairs) {
    if (sameWay(a, b, one, two)) continue;
    state = straightenOne(state, a, b);
    held.push(...heldBy(pattern, a, b));
  }
  return keep.sewn ? keepSeams(state, { before: pattern, held, mirrors }) : state;
}

const sameWay = (a, b, one, two) =>
  a.panel === one.panel && [a.point, b.point].sort().join() === [one.point, two.point].sort().join();

function heldBy(pattern, one, two) {
  const count = getPanel(pattern, one.panel).points.length;
  return edgesBetween(pattern, one, two).flatMap((edge) =>
    [edge, (edge + 1) % count].map((point) => ({ panel: one.panel, point })),
  );
}

function straightenOne(pattern, one, two) {
  const panel = getPanel(pattern, one.panel),
    count = panel.points.length;
  const way = edgesBetween(pattern, one, two);
  const start = panel.points[way[0]],
    end = panel.points[(way[way.length - 1] + 1) % count];
  const lengths = way.map((edge) => edgeLength(pattern, { panel: panel.name, edge }));
  const total = lengths.reduce((sum, length) => sum + length, 0);
  const points = [...panel.points],
    edges = [...panel.edges];
  let reached = 0;
  way.forEach((edge, k) => {
    edges[edge] = { ...edges[edge], kind: 'line', handles: [] };
    reached += lengths[k];
    if (k < way.length - 1) points[(edge + 1) % count] = between(start, end, reached / total);
  });
  return withPanels(pattern, { [panel.name]: { ...panel, points, edges } });
}

/** Return by how much a panel's outline turns at a control point [rad]. */
export function turnAt(panel, point) {
  const [before, after] = sidesOf(panel, point);
  const one = subtract(panel.points[point], before.near),
    two = subtract(after.near, panel.points[point]);
  return Math.abs(Math.atan2(one[0] * two[1] - one[1] * two[0], one[0] * two[0] + one[1] * two[1]));
}

/** Return both edges at a control point: their number, and the handle or end that each runs to from there. */
function sidesOf(panel, point) {
  const count = panel.points.length,
    last = (point - 1 + count) % count;
  const side = (edge, backward) => {
    const { kind } = panel.edges[edge];
    const cubic = asCubic(panel, edge);
    const near = kind === 'line' ? cubic[backward ? 0 : 3] : cubic[backward ? 2 : 1];
    return { edge, backward, cubic, near };
  };
  return [side(last, true), side(point, false)];
}

/** Return an edge as the four control points of a cubic [m]; an arc by the cubic with its end tangents and apex. */
function asCubic(panel, at) {
  const [start, end] = chordOf(panel, at),
    edge = panel.edges[at],
    handles = handlePoints(panel, at);
  if (edge.kind === 'cubic') return [start, ...handles, end];
  if (edge.kind === 'quadratic')
    return [start, between(start, handles[0], 2 / 3), between(end, handles[0], 2 / 3), end];
  if (edge.kind === 'line') return [start, between(start, end, THIRD), between(start, end, 1 - THIRD), end];
  // The apex of a cubic with handles at height h is 3/4 h; their spread follows from the arc's end tangents.
  const height = edge.handles[0][1],
    rise = (4 / 3) * height;
  const slope = (4 * height) / (1 - 4 * height * height);
  const run = Math.abs(1 - 4 * height * height) < 1e-9 ? 0 : rise / slope;
  const place = ([u, v]) => add(add(start, subtract(end, start), u), [-(end[1] - start[1]), end[0] - start[0]], v);
  return [start, place([run, rise]), place([1 - run, rise]), end];
}

/** Make a corner smooth: both edges leave it along the line between its neighbours on the outline. */
export function toCurve(pattern, at, keep) {
  return changePoints(pattern, at, keep, (panel, point) => {
    const [before, after] = sidesOf(panel, point),
      here = panel.points[point];
    const far = (side) => side.cubic[side.backward ? 0 : 3];
    const way = subtract(far(after), far(before)),
      size = norm(way);
    if (size < 1e-9) throw new PatternError('this point is the tip of a panel and cannot be made smooth.');
    return [before, after].map((side) => {
      const reach = norm(subtract(far(side), here)) * THIRD * (side.backward ? -1 : 1);
      return { ...side, handle: add(here, way, reach / size) };
    });
  });
}

/** Make a smooth point a corner: each edge leaves it straight towards its own other handle. */
export function toCorner(pattern, at, keep) {
  return changePoints(pattern, at, keep, (panel, point) =>
    sidesOf(panel, point).map((side) => {
      const other = side.cubic[side.backward ? 1 : 2];
      return { ...side, handle: between(panel.points[point], other, 0.5), corner: true };
    }),
  );
}

/** Set the handles that `bend` returns for both edges at a point and its images; an edge with two corners is straight. */
function changePoints(pattern, at, keep, bend) {
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const changed = {},
    held = [];
  for (const { panel: name, point } of [at, ...imagePoints(pattern, mirrors, at)]) {
    const panel = getPanel(pattern, name),
      count = panel.points.length;
    for (const side of bend(panel, point)) ((changed[name] ??= {})[side.edge] ??= []).push(side);
    held.push(...[point - 1, point, point + 1].map((k) => ({ panel: name, point: (k + count) % count })));
  }
  const panels = {};
  for (const [name, bent] of Object.entries(changed)) {
    const panel = getPanel(pattern, name);
    panels[name] = { ...panel, edges: panel.edges.map((edge, k) => (bent[k] ? bendEdge(edge, bent[k]) : edge)) };
  }
  const state = withPanels(pattern, panels);
  return keep.sewn ? keepSeams(state, { before: pattern, held, mirrors }) : state;
}

function bendEdge(edge, sides) {
  const { cubic } = sides[0],
    places = [cubic[1], cubic[2]];
  for (const { backward, handle } of sides) places[backward ? 1 : 0] = handle;
  const handles = relativeToChord(places, cubic[0], cubic[3]);
  const straight =
    handles.every(([, v]) => Math.abs(v) < STRAIGHT) || (sides.length === 2 && sides.every(({ corner }) => corner));
  return straight ? { ...edge, kind: 'line', handles: [] } : { ...edge, kind: 'cubic', handles };
}
