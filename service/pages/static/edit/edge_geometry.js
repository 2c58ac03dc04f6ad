/**
 * Points, lengths, parts and distances of one edge.
 *
 * An edge is drawn in the frame of its chord: start (0, 0), end (1, 0), across to the left. On a panel it is
 * c0 + along x + across R90 x with x = c1 - c0, so it follows its two control points by a similarity. The same functions
 * as `core/garment/curves.py` has, with the same results to rounding.
 *
 * @typedef {[number, number]} Point   metres, or units of a chord
 * @typedef {{kind: "line"|"quadratic"|"cubic"|"arc", handles: Point[], label: string, contour: string, rest: object}} Edge
 */

/** Parameter spans of the length table. */
const SPANS = 64;
/** An arc whose apex is nearer than this to its chord (in chords) is a line. */
const ARC_FLAT = 1e-9;
/** Nodes and weights of 5-point Gauss quadrature on [-1, 1]. */
const NODES = [-0.906179845938664, -0.5384693101056831, 0, 0.5384693101056831, 0.906179845938664];
const WEIGHTS = [0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665, 0.2369268850561891];

/** Return a + s b of two points. */
export const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1]];
/** Return a - b. */
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1]];
/** Return the length of a vector. */
export const norm = (a) => Math.hypot(a[0], a[1]);
/** Return the point at share t from a to b. */
export const between = (a, b, t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];

/** Map relative (along, across) coordinates onto a chord. */
export function placeOnChord(unit, start, end) {
  const along = subtract(end, start);
  return unit.map(([u, v]) => [start[0] + u * along[0] - v * along[1], start[1] + u * along[1] + v * along[0]]);
}

/** Invert `placeOnChord`. */
export function relativeToChord(points, start, end) {
  const along = subtract(end, start);
  const square = along[0] ** 2 + along[1] ** 2;
  return points.map((point) => {
    const offset = subtract(point, start);
    return [
      (offset[0] * along[0] + offset[1] * along[1]) / square,
      (offset[1] * along[0] - offset[0] * along[1]) / square,
    ];
  });
}

/** Return whether an edge is straight: a line, or a nearly straight arc. */
export function isStraight(edge) {
  return edge.kind === 'line' || (edge.kind === 'arc' && Math.abs(edge.handles[0][1]) < ARC_FLAT);
}

/** Return centre, radius, first angle and sweep [rad] of an arc in its chord's frame. */
export function unitCircle(edge) {
  const height = edge.handles[0][1];
  const size = Math.abs(height),
    sign = Math.sign(height);
  const radius = (0.25 + height * height) / (2 * size);
  const half = 2 * Math.atan2(size, 0.5);
  return { centre: [0.5, height - sign * radius], radius, first: sign * (Math.PI / 2 + half), sweep: -2 * sign * half };
}

/** Return the Bezier control points of an edge in its chord's frame; a line has two. */
export function controlPolygon(edge) {
  return [[0, 0], ...edge.handles, [1, 0]];
}

/** Evaluate a Bezier curve by de Casteljau. */
function bezier(control, parameter) {
  let points = control;
  while (points.length > 1) points = points.slice(1).map((point, k) => between(points[k], point, parameter));
  return points[0];
}

function hodograph(control) {
  const order = control.length - 1;
  return control.slice(1).map((point, k) => [order * (point[0] - control[k][0]), order * (point[1] - control[k][1])]);
}

/** Integrate a curve's speed from one parameter to another by 5-point Gauss. */
function speedIntegral(velocity, low, high) {
  const middle = (low + high) / 2,
    half = (high - low) / 2;
  let sum = 0;
  for (let k = 0; k < 5; k += 1) sum += WEIGHTS[k] * norm(bezier(velocity, middle + half * NODES[k]));
  return half * sum;
}

function lengthTable(velocity) {
  const table = [0];
  for (let k = 0; k < SPANS; k += 1) table.push(table[k] + speedIntegral(velocity, k / SPANS, (k + 1) / SPANS));
  return table;
}

/** Invert arc length: the Bezier parameter at a share of the length, by table and three Newton steps. */
function parameterAt(control, fraction) {
  const velocity = hodograph(control);
  const table = lengthTable(velocity);
  const goal = fraction * table[SPANS];
  let low = 0;
  while (low < SPANS - 1 && table[low + 1] < goal) low += 1;
  const wide = table[low + 1] - table[low];
  let parameter = (low + (wide > 0 ? (goal - table[low]) / wide : 0)) / SPANS;
  for (let step = 0; step < 3; step += 1) {
    const cell = Math.min(Math.max(Math.floor(parameter * SPANS), 0), SPANS - 1);
    const speed = norm(bezier(velocity, parameter));
    if (speed <= 1e-9) break;
    const miss = (goal - table[cell] - speedIntegral(velocity, cell / SPANS, parameter)) / speed;
    parameter = Math.min(Math.max(parameter + Math.min(Math.max(miss, -1 / SPANS), 1 / SPANS), 0), 1);
  }
  return parameter;
}

/** Return the point of an edge at a share of its length, in its chord's frame. */
export function unitPoint(edge, fraction) {
  if (fraction <= 0) return [0, 0];
  if (fraction >= 1) return [1, 0];
  if (isStraight(edge)) return [fraction, 0];
  if (edge.kind === 'arc') {
    const { centre, radius, first, sweep } = unitCircle(edge);
    const angle = first + sweep * fraction;
    return [centre[0] + radius * Math.cos(angle), centre[1] + radius * Math.sin(angle)];
  }
  const control = controlPolygon(edge);
  return bezier(control, parameterAt(control, fraction));
}

const lengths = new WeakMap();

/** Return the length of an edge in units of its chord; computed once for each edge, for edges never change. */
export function unitLength(edge) {
  if (!lengths.has(edge)) lengths.set(edge, computeLength(edge));
  return lengths.get(edge);
}

function computeLength(edge) {
  if (isStraight(edge)) return 1;
  if (edge.kind === 'arc') {
    const { radius, sweep } = unitCircle(edge);
    return Math.abs(radius * sweep);
  }
  return lengthTable(hodograph(controlPolygon(edge)))[SPANS];
}

/**
 * Cut an edge at a share of its length.
 *
 * @returns {{cut: Point, first: Edge, second: Edge}} the cut in the chord's frame and the parts, which draw the same curve
 */
export function splitEdge(edge, fraction) {
  const part = (kind, handles) => ({ ...edge, kind, handles });
  const rest = (kind, handles) => {
    const { title } = edge; // the name of the point at the start stays with the first part
    return { ...part(kind, handles), ...(title ? { title: { ...title, corner: '' } } : {}) };
  };
  if (isStraight(edge)) return { cut: [fraction, 0], first: part('line', []), second: rest('line', []) };
  if (edge.kind === 'arc') {
    const { sweep } = unitCircle(edge);
    const height = (share) => [[0.5, -0.5 * Math.tan((sweep * share) / 4)]];
    return {
      cut: unitPoint(edge, fraction),
      first: part('arc', height(fraction)),
      second: rest('arc', height(1 - fraction)),
    };
  }
  const { left, right } = cutBezier(controlPolygon(edge), parameterAt(controlPolygon(edge), fraction));
  const cut = left[left.length - 1];
  return {
    cut,
    first: part(edge.kind, relativeToChord(left.slice(1, -1), [0, 0], cut)),
    second: rest(edge.kind, relativeToChord(right.slice(1, -1), cut, [1, 0])),
  };
}

/** Cut a Bezier curve in two by de Casteljau. */
export function cutBezier(control, parameter) {
  const left = [control[0]],
    right = [control[control.length - 1]];
  let points = control;
  while (points.length > 1) {
    points = points.slice(1).map((point, k) => between(points[k], point, parameter));
    left.push(points[0]);
    right.unshift(points[points.length - 1]);
  }
  return { left, right };
}

/** Return the same curve run from its end to its start. */
export function reverseEdge(edge) {
  return { ...edge, handles: [...edge.handles].reverse().map(([u, v]) => [1 - u, -v]) };
}

/** Return the mirror image of a curve, still run from its start to its end. */
export function mirrorEdge(edge) {
  return { ...edge, handles: edge.handles.map(([u, v]) => [u, -v]) };
}

/** Return segments + 1 points of an edge between two places, evenly spaced by parameter (arcs: by angle). */
export function samplePoints(edge, start, end, segments) {
  const unit = [];
  for (let k = 0; k <= segments; k += 1) {
    const t = k / segments;
    unit.push(edge.kind === 'arc' || isStraight(edge) ? unitPoint(edge, t) : bezier(controlPolygon(edge), t));
  }
  return placeOnChord(unit, start, end);
}

/**
 * Find the point of an edge that is nearest to a place: the nearest of 48 samples, then a ternary search around it.
 *
 * @returns {{fraction: number, distance: number, point: Point}} fraction: share of the edge's length
 */
export function nearestOnEdge(edge, start, end, place) {
  const straight = isStraight(edge),
    control = controlPolygon(edge);
  const at = (t) =>
    placeOnChord([straight || edge.kind === 'arc' ? unitPoint(edge, t) : bezier(control, t)], start, end)[0];
  const miss = (t) => norm(subtract(at(t), place));
  const count = 48;
  let best = 0,
    least = Infinity;
  for (let k = 0; k <= count; k += 1) {
    const far = miss(k / count);
    if (far < least) [best, least] = [k, far];
  }
  let low = Math.max(best - 1, 0) / count,
    high = Math.min(best + 1, count) / count;
  for (let step = 0; step < 60; step += 1) {
    const one = low + (high - low) / 3,
      two = high - (high - low) / 3;
    if (miss(one) < miss(two)) high = two;
    else low = one;
  }
  const t = (low + high) / 2;
  let fraction = t;
  if (!straight && edge.kind !== 'arc') {
    const velocity = hodograph(control),
      table = lengthTable(velocity);
    const cell = Math.min(Math.floor(t * SPANS), SPANS - 1);
    fraction = (table[cell] + speedIntegral(velocity, cell / SPANS, t)) / table[SPANS];
  }
  return { fraction, distance: miss(t), point: at(t) };
}

/** Return the SVG path command of an edge whose start, handles and end are drawn at `drawn` [mm, y down]. */
export function pathCommand(edge, drawn) {
  const pair = (point) => `${point[0].toFixed(3)} ${point[1].toFixed(3)}`;
  const end = drawn[drawn.length - 1];
  if (isStraight(edge)) return `L ${pair(end)}`;
  if (edge.kind === 'quadratic') return `Q ${pair(drawn[1])} ${pair(end)}`;
  if (edge.kind === 'cubic') return `C ${pair(drawn[1])} ${pair(drawn[2])} ${pair(end)}`;
  const height = edge.handles[0][1];
  const radius = (norm(subtract(end, drawn[0])) * (0.25 + height * height)) / (2 * Math.abs(height));
  return `A ${radius.toFixed(4)} ${radius.toFixed(4)} 0 ${Math.abs(height) > 0.5 ? 1 : 0} ${height > 0 ? 1 : 0} ${pair(end)}`;
}
