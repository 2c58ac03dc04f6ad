/**
 * Darts: two neighbouring edges of a panel that are sewn to each other and meet at the apex.
 *
 * @typedef {{panel: string, first: number}} Dart   `first`: the edge that ends at the apex
 */

import { add, between, norm, splitEdge, subtract } from './edge_geometry.js';
import { checkInside, newLine, partsBetween, pointAt, turnParts, turnPoint, withOutline } from './outline.js';
import { edgeLength, getPanel, PatternError, polygonArea } from './pattern_model.js';
import { addPoint } from './point_operations.js';
import { findMirrors, imagePoints } from './symmetry.js';
import { keepSeams } from './seams.js';

/** Return the darts of a pattern. @returns {Dart[]} */
export function listDarts(pattern) {
  return pattern.seams.flatMap(({ a, b }) => {
    if (a.panel !== b.panel) return [];
    const count = getPanel(pattern, a.panel).points.length;
    if ((a.edge + 1) % count === b.edge) return [{ panel: a.panel, first: a.edge }];
    return (b.edge + 1) % count === a.edge ? [{ panel: a.panel, first: b.edge }] : [];
  });
}

/** Return the dart that an edge or point is part of, or null. */
export function dartOf(pattern, item) {
  return (
    listDarts(pattern).find(({ panel, first }) => {
      const count = getPanel(pattern, panel).points.length;
      if (panel !== item.panel) return false;
      if (item.edge !== undefined) return item.edge === first || item.edge === (first + 1) % count;
      return item.point === (first + 1) % count;
    }) ?? null
  );
}

/** Return the angle at a dart's apex [rad]. */
export function dartAngle(pattern, { panel: name, first }) {
  const { points } = getPanel(pattern, name),
    count = points.length;
  const [a, apex, c] = [0, 1, 2].map((k) => points[(first + k) % count]);
  const [one, two] = [subtract(a, apex), subtract(c, apex)];
  return Math.abs(Math.atan2(one[0] * two[1] - one[1] * two[0], one[0] * two[0] + one[1] * two[1]));
}

/**
 * Add a dart in an edge, square to it; its images get theirs. Both its legs are equally long.
 *
 * The edge loses the dart's width. Where it is sewn, points move as little as possible until its seam matches again.
 *
 * @param {{panel: string, edge: number, fraction: number}} at   the middle of its mouth
 * @param {{width: number, length: number}} size   [m]
 */
export function addDart(pattern, at, { width, length }, keep) {
  if (!(width > 0 && length > 0)) throw new PatternError('a dart needs a width and a length above 0.');
  const added = addPoint(pattern, at, keep);
  const mirrors = keep.symmetric ? findMirrors(added.pattern) : [];
  const all = [added.point, ...imagePoints(added.pattern, mirrors, added.point)];
  const spots = all.map(({ panel, point }) => ({ panel, place: getPanel(added.pattern, panel).points[point] }));
  const held = [];
  let state = added.pattern;
  for (const { panel, place } of spots) {
    const opened = openDart(state, panel, pointAt(getPanel(state, panel), place), width, length);
    state = opened.pattern;
    held.push(...opened.places.map((one) => ({ panel, place: one })));
  }
  if (!keep.sewn) return state;
  const fixed = held.map(({ panel, place }) => ({ panel, point: pointAt(getPanel(state, panel), place) }));
  return keepSeams(state, { before: null, held: fixed, mirrors: keep.symmetric ? findMirrors(state) : [] });
}

function openDart(pattern, name, point, width, length) {
  const panel = getPanel(pattern, name),
    count = panel.points.length,
    last = (point - 1 + count) % count;
  const [own, next] = [last, point].map((edge) => edgeLength(pattern, { panel: name, edge }));
  if (width / 2 >= Math.min(own, next)) throw new PatternError('the edge is too short for a dart of this width.');
  const parts = partsBetween(panel, point, point);
  const first = splitEdge(panel.edges[last], 1 - width / 2 / own),
    second = splitEdge(panel.edges[point], width / 2 / next);
  const on = ([u, v], edge) => {
    const [start, end] = [panel.points[edge], panel.points[(edge + 1) % count]],
      along = subtract(end, start);
    return [start[0] + u * along[0] - v * along[1], start[1] + u * along[1] + v * along[0]];
  };
  const [a, c] = [on(first.cut, last), on(second.cut, point)];
  const way = subtract(c, a),
    size = norm(way);
  // Inward is to the left of an outline that runs counter-clockwise.
  const apex = add(between(a, c, 0.5), [-way[1] / size, way[0] / size], length);
  const kept = parts.slice(1, -1);
  const legs = [a, apex].map((start) => ({ start, edge: newLine(), old: null }));
  const outline = [...legs, { start: c, edge: second.second, old: point }, ...kept, { ...parts.at(-1), edge: first.first }];
  const state = withOutline(pattern, name, outline);
  const seam = { a: { panel: name, edge: 0 }, b: { panel: name, edge: 1 }, reversed: true, gathered: false };
  return { pattern: { ...state, seams: [...state.seams, seam] }, places: [a, apex, c] };
}

/** Remove a dart and its images: the edge is closed at the middle of the mouth. */
export function removeDart(pattern, dart, keep) {
  return eachImage(pattern, dart, [], keep, (state, { panel: name, first }) => {
    const panel = getPanel(state, name),
      count = panel.points.length;
    const end = (first + 2) % count;
    const parts = partsBetween(panel, end, first);
    parts[0] = { ...parts[0], start: between(panel.points[first], panel.points[end], 0.5) };
    return withOutline(state, name, parts);
  });
}

/**
 * Turn what lies between a dart and another point of the outline about the dart's apex, so that the dart opens there.
 *
 * The dart keeps its angle, all other edges their lengths, and the panel its area.
 *
 * @param {Dart} dart @param {{panel: string, point: number}} target
 */
export function pivotDart(pattern, dart, target, keep) {
  if (dart.panel !== target.panel) throw new PatternError("select the dart's apex and a point of the same panel.");
  return eachImage(pattern, dart, [target], keep, (state, { panel, first }, [point]) => pivotOne(state, panel, first, point));
}

function pivotOne(pattern, name, first, target) {
  const panel = getPanel(pattern, name),
    count = panel.points.length;
  const at = (first + 1) % count,
    end = (first + 2) % count,
    apex = panel.points[at];
  if ([first, at, end].includes(target)) throw new PatternError('the dart is there already; select another point.');
  checkInside(panel, target, at);
  const angle = dartAngle(pattern, { panel: name, first });
  const after = partsBetween(panel, end, target),
    before = partsBetween(panel, target, first);
  const area = (parts, last) => Math.abs(polygonArea([apex, ...parts.map(({ start }) => start), last]));
  const turnsAfter = area(after, panel.points[target]) < area(before, panel.points[first]);
  // The interior is to the left, so the side after the dart closes it by turning clockwise, the other one against.
  const [forth, back] = turnsAfter ? [-angle, 0] : [0, angle];
  const legs = [panel.edges[first], panel.edges[at]];
  const reach = panel.points[target];
  const parts = [
    ...turnParts(after, apex, forth),
    { start: turnPoint(reach, apex, forth), edge: { ...newLine(), label: legs[0].label }, old: first },
    { start: apex, edge: { ...newLine(), label: legs[1].label }, old: at },
    ...turnParts(before, apex, back),
  ];
  return withOutline(pattern, name, parts);
}

/** Apply a change to a dart and to its mirror images; points are found again by their places. */
function eachImage(pattern, dart, points, keep, change) {
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const count = getPanel(pattern, dart.panel).points.length;
  const ends = [0, 1, 2].map((k) => ({ panel: dart.panel, point: (dart.first + k) % count }));
  const images = [...ends, ...points].map((point) => imagePoints(pattern, mirrors, point)[0] ?? point);
  const own = [...ends, ...points];
  const isOther = images.some((image, k) => image.panel !== own[k].panel || image.point !== own[k].point);
  // Over an axis of symmetry a dart is its own image; it turns one way only.
  const isSelf = images[1].panel === own[1].panel && images[1].point === own[1].point;
  const orders = isOther && !isSelf ? [own, [images[2], images[1], images[0], ...images.slice(3)]] : [own];
  const placed = orders.map((order) => order.map(({ panel, point }) => ({ panel, place: getPanel(pattern, panel).points[point] })));
  const done = placed.reduce((state, [start, , , ...others]) => {
    const panel = getPanel(state, start.panel);
    return change(state, { panel: start.panel, first: pointAt(panel, start.place) }, others.map(({ place }) => pointAt(panel, place)));
  }, pattern);
  return keep.sewn
    ? keepSeams(done, { before: null, held: [], mirrors: keep.symmetric ? findMirrors(done) : [] })
    : done;
}
