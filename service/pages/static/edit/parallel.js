/** Edges that are moved parallel to themselves by a distance. */

import { add, between, controlPolygon, isStraight, norm, placeOnChord, relativeToChord, samplePoints, subtract, unitCircle } from './edge_geometry.js';
import { chordOf, getPanel, PatternError, withPanels } from './pattern_model.js';
import { findMirrors, imageEdges } from './symmetry.js';
import { keepSeams } from './seams.js';

/** Least sine between an edge and its neighbour at which its end moves along the neighbour. */
const LEAST_SINE = 0.3;

/**
 * Move edges outward, square to themselves [m]; their images too. Ends of straight edges move along their neighbours,
 * others square to the edge. Arcs stay about their centres; other curves keep the tangents at their ends.
 *
 * @param {{panel: string, edge: number}[]} refs @param {number} distance   inward where it is negative
 * @returns {import("./pattern_model.js").Pattern}
 */
export function moveParallel(pattern, refs, distance, keep) {
  if (!refs.length) throw new PatternError('select one or more edges, or a line by its name.');
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const all = [];
  for (const ref of refs.flatMap((one) => [one, ...imageEdges(pattern, mirrors, one)]))
    if (!all.some((other) => other.panel === ref.panel && other.edge === ref.edge)) all.push(ref);
  const changed = {},
    held = [];
  for (const name of new Set(all.map(({ panel }) => panel))) {
    const moved = all.filter(({ panel }) => panel === name).map(({ edge }) => edge);
    const panel = getPanel(pattern, name),
      count = panel.points.length;
    changed[name] = moveEdges(panel, new Set(moved), distance);
    held.push(...moved.flatMap((edge) => [edge, (edge + 1) % count].map((point) => ({ panel: name, point }))));
  }
  const state = withPanels(pattern, changed);
  return keep.sewn ? keepSeams(state, { before: pattern, held, mirrors }) : state;
}

function moveEdges(panel, moved, distance) {
  const count = panel.points.length;
  const points = panel.points.map((place, at) => {
    const last = (at - 1 + count) % count,
      [before, after] = [moved.has(last), moved.has(at)];
    if (!before && !after) return place;
    const [into, out] = [endWay(panel, last, true), endWay(panel, at, false)];
    if (before && after) return add(place, corner(into, out), distance);
    const [own, other, edge] = before ? [into, out, last] : [out, into, at];
    const normal = [own[1], -own[0]],
      slope = other[0] * normal[0] + other[1] * normal[1];
    if (isStraight(panel.edges[edge]) && Math.abs(slope) > LEAST_SINE) return add(place, other, distance / slope);
    return add(place, normal, distance);
  });
  const edges = panel.edges.map((edge, at) => (moved.has(at) ? refit(panel, at, chordOf({ points }, at), distance) : edge));
  return { ...panel, points, edges };
}

/** Return the direction of the outline at an edge's end, or at its start. */
function endWay(panel, at, isEnd) {
  const edge = panel.edges[at],
    polygon = controlPolygon(edge);
  let unit = isEnd ? subtract(polygon.at(-1), polygon.at(-2)) : subtract(polygon[1], polygon[0]);
  if (edge.kind === 'arc') {
    const half = isStraight(edge) ? 0 : unitCircle(edge).sweep / -2;
    unit = [Math.cos(half), isEnd ? -Math.sin(half) : Math.sin(half)];
  }
  const [from, to] = placeOnChord([[0, 0], unit], ...chordOf(panel, at)),
    way = subtract(to, from),
    size = norm(way);
  return [way[0] / size, way[1] / size];
}

/** Return how far the corner of two edges moves where both move outward by 1. */
function corner(into, out) {
  const sum = [into[1] + out[1], -into[0] - out[0]];
  const square = (sum[0] ** 2 + sum[1] ** 2) / 2;
  return square < LEAST_SINE ? [into[1], -into[0]] : [sum[0] / square, sum[1] / square];
}

/** Return an edge between its moved ends: an arc of the same sweep; a Bezier curve with its tangents and its apex moved. */
function refit(panel, at, [start, end], distance) {
  const edge = panel.edges[at],
    ends = chordOf(panel, at);
  if (isStraight(edge) || edge.kind === 'arc') return edge;
  const polygon = placeOnChord(controlPolygon(edge), ...ends);
  if (edge.kind === 'quadratic') return { ...edge, handles: relativeToChord([movedHandle(polygon, distance)], start, end) };
  const [, middle] = samplePoints(edge, ...ends, 2);
  const [a, b] = [subtract(polygon[1], polygon[0]), subtract(polygon[3], polygon[2])];
  const way = add(subtract(polygon[3], polygon[0]), subtract(polygon[2], polygon[1])),
    size = norm(way);
  const goal = add(middle, [way[1] / size, -way[0] / size], distance);
  // The middle is (start + 3 h1 + 3 h2 + end) / 8; both handles change by one share of their lengths.
  const rest = subtract(goal, between(start, end, 0.5)),
    pull = [(3 / 8) * (a[0] - b[0]), (3 / 8) * (a[1] - b[1])];
  const square = pull[0] ** 2 + pull[1] ** 2;
  const share = square > 1e-12 ? (rest[0] * pull[0] + rest[1] * pull[1]) / square : 1;
  return { ...edge, handles: relativeToChord([add(start, a, Math.max(share, 0.05)), add(end, b, -Math.max(share, 0.05))], start, end) };
}

/** Return the handle of a quadratic curve whose two tangents are moved outward. */
function movedHandle([start, handle, end], distance) {
  const way = (from, to) => {
    const [x, y] = subtract(to, from),
      size = Math.hypot(x, y);
    return [x / size, y / size];
  };
  return add(handle, corner(way(start, handle), way(handle, end)), distance);
}
