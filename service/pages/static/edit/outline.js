/** Outlines that are put together anew from parts of old ones; seams and notches follow their edges. */

import { norm, samplePoints, subtract } from './edge_geometry.js';
import { chordOf, getPanel, panelOutline, PatternError, withPanels } from './pattern_model.js';
import { contains } from './panel_operations.js';

/** Points nearer to each other than this are one [m]. */
const SAME = 1e-9;
/** Places of a line inside a panel that are checked. */
const PLACES = 16;

/**
 * Return a pattern with another outline of one panel.
 *
 * @param {string} name
 * @param {{start: [number, number], edge: object, old: number|null}[]} parts   `old`: the number that the edge had
 */
export function withOutline(pattern, name, parts) {
  const panel = getPanel(pattern, name);
  const numbers = new Map(parts.flatMap(({ old }, at) => (old === null ? [] : [[old, at]])));
  const renumber = (ref) => (ref.panel === name ? { panel: name, edge: numbers.get(ref.edge) } : ref);
  const changed = {
    ...panel,
    points: parts.map(({ start }) => start),
    edges: parts.map(({ edge }) => edge),
    notches: panel.notches.filter(([edge]) => numbers.has(edge)).map(([edge, at]) => [numbers.get(edge), at]),
  };
  const seams = pattern.seams
    .map((seam) => ({ ...seam, a: renumber(seam.a), b: renumber(seam.b) }))
    .filter(({ a, b }) => a.edge !== undefined && b.edge !== undefined);
  const { [name]: _place, ...layout } = pattern.layout; // a place that was chosen stays
  checkOutline(changed);
  return { ...withPanels(pattern, { [name]: changed }), seams, layout: _place ? { ...layout, [name]: _place } : layout };
}

/** Return the parts of a panel's outline from one control point to another, as `withOutline` takes them. */
export function partsBetween(panel, from, to) {
  const count = panel.points.length;
  return Array.from({ length: (to - from + count) % count || count }, (_, k) => {
    const old = (from + k) % count;
    return { start: panel.points[old], edge: panel.edges[old], old };
  });
}

/** Turn parts about a point [rad]; curves follow, for their handles are in their chords' frames. */
export function turnParts(parts, centre, angle) {
  return parts.map((part) => ({ ...part, start: turnPoint(part.start, centre, angle) }));
}

/** Turn a point about another [rad]. */
export function turnPoint(point, centre, angle) {
  const [x, y] = subtract(point, centre),
    [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [centre[0] + c * x - s * y, centre[1] + s * x + c * y];
}

/** Return a new straight edge. */
export const newLine = (title, contour = '') => ({
  kind: 'line',
  handles: [],
  label: '',
  contour,
  rest: {},
  ...(title ? { title } : {}),
});

/** Return the number of the control point at a place; refuse where there is none. */
export function pointAt(panel, place) {
  const at = panel.points.findIndex((point) => norm(subtract(point, place)) < SAME);
  if (at < 0) throw new PatternError('this change and its mirror image are at the same place; switch Keep symmetry off.');
  return at;
}

/** Refuse a straight line from one control point to another that leaves the panel. */
export function checkInside(panel, one, two) {
  const outline = panelOutline(panel, 32),
    [start, end] = [panel.points[one], panel.points[two]];
  for (let k = 1; k < PLACES; k += 1) {
    const place = [0, 1].map((axis) => start[axis] + (k / PLACES) * (end[axis] - start[axis]));
    if (!contains(outline, place))
      throw new PatternError('the straight line between both points leaves the panel; choose points with a line inside it.');
  }
}

/** Refuse an outline that crosses itself. */
function checkOutline(panel) {
  const sides = panel.edges.flatMap((edge, at) => {
    const points = samplePoints(edge, ...chordOf(panel, at), edge.handles.length ? 12 : 1);
    return points.slice(1).map((end, k) => [points[k], end]);
  });
  const across = ([a, b], p) => (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
  for (let i = 0; i < sides.length; i += 1)
    for (let j = i + 2; j < sides.length; j += 1) {
      if (i === 0 && j === sides.length - 1) continue;
      const [one, two] = [sides[i], sides[j]];
      if (across(one, two[0]) * across(one, two[1]) < -1e-15 && across(two, one[0]) * across(two, one[1]) < -1e-15)
        throw new PatternError(`the outline of panel '${panel.name}' would cross itself; choose a smaller value.`);
    }
}
