/** Adding control points where they change nothing, and removing them without changing the edge's length. */

import {
  add,
  controlPolygon,
  isStraight,
  norm,
  placeOnChord,
  relativeToChord,
  splitEdge,
  subtract,
  unitCircle,
  unitLength,
  unitPoint,
} from './edge_geometry.js';
import { chordOf, edgeLength, getPanel, handlePoints, PatternError, withPanels } from './pattern_model.js';
import { findMirrors, imageEdges, imagePoints } from './symmetry.js';
import { seamOf, sewnPoints } from './seams.js';

/** Distance of possible control points along an edge [m]. */
const STEP = 0.02;
/** A curve's part is the other's continuation where it misses it by less than this [m]. */
const SAME = 1e-9;
/** Two places of one edge nearer than this share of it are one. */
const APART = 1e-6;

const spots = new WeakMap();

/** Return the shares of an edge's length, and its points there in its chord's frame; kept with the edge. */
function divide(edge, count) {
  if (spots.get(edge)?.length !== count - 1) {
    const shares = Array.from({ length: count - 1 }, (_, k) => (k + 1) / count);
    spots.set(
      edge,
      shares.map((fraction) => ({ fraction, unit: unitPoint(edge, fraction) })),
    );
  }
  return spots.get(edge);
}

/** Return all places at which a control point could be added: on every edge, evenly, about 20 mm apart. */
export function possiblePoints(pattern) {
  return pattern.panels.flatMap((panel) =>
    panel.edges.flatMap((edge, at) => {
      const count = Math.max(Math.round(edgeLength(pattern, { panel: panel.name, edge: at }) / STEP), 2);
      const parts = divide(edge, count),
        places = placeOnChord(
          parts.map(({ unit }) => unit),
          ...chordOf(panel, at),
        );
      return parts.map(({ fraction }, k) => ({ panel: panel.name, edge: at, fraction, place: places[k] }));
    }),
  );
}

/**
 * Add a control point at a share of an edge's length; its images and the edges sewn to it get theirs. Nothing changes shape.
 *
 * @param {{panel: string, edge: number, fraction: number}} at
 * @returns {{pattern: object, point: {panel: string, point: number}}}
 */
export function addPoint(pattern, at, keep) {
  if (!(at.fraction > APART && at.fraction < 1 - APART))
    throw new PatternError('a new control point must lie between the ends of an edge.');
  const cuts = spreadCuts(pattern, at, keep.symmetric ? findMirrors(pattern) : []);
  const { pattern: cut, numbers } = cutEdges(pattern, cuts);
  const first = numbers[at.panel][at.edge];
  const before = cuts
    .get(at.panel)
    .get(at.edge)
    .filter((fraction) => fraction < at.fraction - APART).length;
  return { pattern: cut, point: { panel: at.panel, point: first + before + 1 } };
}

/** Collect where edges are to be cut: at the place, at its images, and at what is sewn to any of them. */
function spreadCuts(pattern, at, mirrors) {
  const cuts = new Map(),
    queue = [at];
  while (queue.length) {
    const { panel, edge, fraction } = queue.pop();
    if (!cuts.has(panel)) cuts.set(panel, new Map());
    const places = cuts.get(panel).get(edge) ?? [];
    if (places.some((other) => Math.abs(other - fraction) < APART)) continue;
    cuts.get(panel).set(
      edge,
      [...places, fraction].sort((a, b) => a - b),
    );
    const sewn = seamOf(pattern, { panel, edge });
    if (sewn) queue.push({ ...sewn.other, fraction: sewn.seam.reversed ? 1 - fraction : fraction });
    for (const image of imageEdges(pattern, mirrors, { panel, edge })) queue.push({ ...image, fraction: 1 - fraction });
    if (isOwnImage(pattern, mirrors, { panel, edge })) queue.push({ panel, edge, fraction: 1 - fraction });
  }
  return cuts;
}

function isOwnImage(pattern, mirrors, { panel, edge }) {
  const index = pattern.panels.findIndex((other) => other.name === panel);
  return mirrors.some(
    ({ source, target, order }) =>
      source === index && target === index && (order[edge] - 1 + order.length) % order.length === edge,
  );
}

/** Cut edges at shares of their lengths; seams, notches and contours follow. `numbers`: where each old edge begins. */
export function cutEdges(pattern, cuts) {
  const numbers = {},
    changed = {};
  for (const panel of pattern.panels) {
    const points = [],
      edges = [],
      notches = [],
      starts = [];
    panel.edges.forEach((edge, at) => {
      const places = cuts.get(panel.name)?.get(at) ?? [],
        bounds = [0, ...places, 1];
      starts.push(edges.length);
      for (const [number, share] of panel.notches) {
        if (number !== at) continue;
        const part = Math.max(
            bounds.findLastIndex((bound) => bound <= share),
            0,
          ),
          k = Math.min(part, places.length);
        notches.push([edges.length + k, (share - bounds[k]) / (bounds[k + 1] - bounds[k])]);
      }
      let rest = edge,
        start = panel.points[at],
        done = 0;
      const end = chordOf(panel, at)[1];
      for (const place of places) {
        const { cut, first, second } = splitEdge(rest, (place - done) / (1 - done));
        points.push(start);
        edges.push(first);
        [start] = placeOnChord([cut], start, end);
        rest = second;
        done = place;
      }
      points.push(start);
      edges.push(rest);
    });
    numbers[panel.name] = starts;
    if (edges.length !== panel.edges.length) changed[panel.name] = { ...panel, points, edges, notches };
  }
  const parts = (ref) => (cuts.get(ref.panel)?.get(ref.edge)?.length ?? 0) + 1;
  const seams = pattern.seams.flatMap((seam) => {
    const count = parts(seam.a);
    if (count !== parts(seam.b)) throw new PatternError('both sides of a seam must be cut alike.');
    return Array.from({ length: count }, (_, k) => ({
      ...seam,
      a: { panel: seam.a.panel, edge: numbers[seam.a.panel][seam.a.edge] + k },
      b: { panel: seam.b.panel, edge: numbers[seam.b.panel][seam.b.edge] + (seam.reversed ? count - 1 - k : k) },
    }));
  });
  return { pattern: { ...withPanels(pattern, changed), seams }, numbers };
}

/**
 * Remove a control point: the edges on both sides become one curve of the same length; images and sewn points go too.
 *
 * Parts of one curve become that curve again. Otherwise it is the cubic with the tangents of both ends whose length is
 * that of both edges.
 */
export function removePoint(pattern, at, keep) {
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const gone = new Map(),
    queue = [at];
  while (queue.length) {
    const point = queue.pop();
    if (!gone.has(point.panel)) gone.set(point.panel, new Set());
    if (gone.get(point.panel).has(point.point)) continue;
    gone.get(point.panel).add(point.point);
    queue.push(...imagePoints(pattern, mirrors, point), ...partnersBetween(pattern, point));
  }
  const changed = {},
    numbers = {};
  for (const panel of pattern.panels) {
    const away = gone.get(panel.name) ?? new Set(),
      count = panel.points.length;
    if (count - away.size < 2 + (away.size ? 1 : 0))
      throw new PatternError(`panel '${panel.name}' needs at least three control points.`);
    numbers[panel.name] = mergeNumbers(count, away);
    if (!away.size) continue;
    let state = panel;
    for (const point of [...away].sort((a, b) => b - a)) state = mergeAt(pattern, state, point);
    changed[panel.name] = state;
  }
  const seen = new Set();
  const seams = pattern.seams.flatMap((seam) => {
    const a = { panel: seam.a.panel, edge: numbers[seam.a.panel][seam.a.edge] };
    const b = { panel: seam.b.panel, edge: numbers[seam.b.panel][seam.b.edge] };
    const key = `${a.panel}\n${a.edge}`;
    if (seen.has(key)) return [];
    seen.add(key);
    return [{ ...seam, a, b }];
  });
  return { ...withPanels(pattern, changed), seams };
}

/** Return the points sewn to one that go with it: both its edges are sewn, each to a neighbour of the other's partner. */
function partnersBetween(pattern, { panel: name, point }) {
  const count = getPanel(pattern, name).points.length,
    last = (point - 1 + count) % count;
  const one = seamOf(pattern, { panel: name, edge: last }),
    two = seamOf(pattern, { panel: name, edge: point });
  if (!one && !two) return [];
  const refuse = () => {
    throw new PatternError('seams begin or end at this point; it cannot be removed.');
  };
  if (!one || !two || one.other.panel !== two.other.panel || one.seam.gathered !== two.seam.gathered) return refuse();
  const others = getPanel(pattern, one.other.panel).points.length;
  const [low, high] = one.seam.reversed ? [two.other.edge, one.other.edge] : [one.other.edge, two.other.edge];
  if ((low + 1) % others !== high || one.seam.reversed !== two.seam.reversed) return refuse();
  if (sewnPoints(pattern, { panel: name, point }).length > 1) return refuse();
  return [{ panel: one.other.panel, point: high }];
}

/** Return the number that each edge has once points are gone: an edge that ends at one becomes the next. */
function mergeNumbers(count, away) {
  const starts = Array.from({ length: count }, (_, k) => k).filter((k) => !away.has(k));
  return Array.from({ length: count }, (_, edge) => {
    let start = edge;
    while (away.has(start)) start = (start - 1 + count) % count;
    return starts.indexOf(start);
  });
}

function mergeAt(pattern, panel, point) {
  const count = panel.points.length,
    last = (point - 1 + count) % count;
  const lengths = [last, point].map((edge) => {
    const [start, end] = chordOf(panel, edge);
    return norm(subtract(end, start)) * unitLength(panel.edges[edge]);
  });
  const total = lengths[0] + lengths[1],
    share = lengths[0] / total;
  const start = panel.points[last],
    end = panel.points[(point + 1) % count];
  const merged = mergeCurves(panel, last, point, start, end, total);
  const notches = panel.notches
    .map(([edge, at]) => {
      if (edge === last) return [edge, at * share];
      if (edge === point) return [last, share + at * (1 - share)];
      return [edge, at];
    })
    .map(([edge, at]) => [edge > point ? edge - 1 : edge, at]);
  const edges = panel.edges
    .map((edge, at) => (at === last ? { ...edge, ...merged } : edge))
    .filter((_, at) => at !== point);
  if (point === 0) {
    // The loop now begins at point 1; the merged edge is the last one.
    return { ...panel, points: panel.points.slice(1), edges, notches };
  }
  return { ...panel, points: panel.points.filter((_, at) => at !== point), edges, notches };
}

function mergeCurves(panel, one, two, start, end, total) {
  const first = panel.edges[one],
    second = panel.edges[two],
    middle = panel.points[two];
  const [cut] = relativeToChord([middle], start, end);
  const scale = norm(subtract(end, start));
  if (scale < 1e-9) throw new PatternError('without this point the panel would have an edge without length.');
  if (isStraight(first) && isStraight(second) && Math.abs(cut[1]) * scale < SAME && cut[0] > 0 && cut[0] < 1)
    return { kind: 'line', handles: [] };
  const again = first.kind === second.kind ? joinParts(panel, one, two, start, end) : null;
  if (again) {
    const { first: a, cut: at } = splitEdge(
      { ...first, ...again },
      splitShare(again, first, total, norm(subtract(middle, start))),
    );
    const near =
      norm(subtract(placeOnChord([at], start, end)[0], middle)) < SAME &&
      a.handles.every((handle, k) => norm(subtract(handle, first.handles[k])) * scale < 1e-7);
    if (near) return again;
  }
  return fitLength(panel, one, two, start, end, total / scale);
}

const splitShare = (whole, first, total, chord) => (chord * unitLength(first)) / total;

/** Return the curve whose parts two edges of one kind would be, before it is checked that they are. */
function joinParts(panel, one, two, start, end) {
  const first = panel.edges[one],
    second = panel.edges[two];
  if (first.kind === 'arc' && !isStraight(first) && !isStraight(second)) {
    const sweep = Math.abs(unitCircle(first).sweep) + Math.abs(unitCircle(second).sweep);
    return { kind: 'arc', handles: [[0.5, Math.sign(first.handles[0][1]) * 0.5 * Math.tan(sweep / 4)]] };
  }
  if (first.kind !== 'cubic' && first.kind !== 'quadratic') return null;
  const left = handlePoints(panel, one),
    right = handlePoints(panel, two),
    middle = panel.points[two];
  const before = norm(subtract(middle, left[left.length - 1])),
    after = norm(subtract(right[0], middle));
  const t = before / (before + after);
  if (!(t > 1e-6 && t < 1 - 1e-6)) return null;
  const handles = [add(start, subtract(left[0], start), 1 / t)];
  if (first.kind === 'cubic') handles.push(add(end, subtract(right[1], end), 1 / (1 - t)));
  return { kind: first.kind, handles: relativeToChord(handles, start, end) };
}

/** Return the cubic with the tangents of both ends and a given length (in chords); its handles are equally long. */
function fitLength(panel, one, two, start, end, goal) {
  const tangent = (edge, at, backward) => {
    const polygon = controlPolygon(edge);
    let [from, to] = backward ? [polygon[polygon.length - 1], polygon[polygon.length - 2]] : [polygon[0], polygon[1]];
    if (edge.kind === 'arc' && !isStraight(edge)) {
      const half = unitCircle(edge).sweep / -2;
      to = add(from, [backward ? -Math.cos(half) : Math.cos(half), Math.sin(half)]);
    }
    const [p, q] = relativeToChord(placeOnChord([from, to], ...chordOf(panel, at)), start, end);
    const way = subtract(q, p),
      size = norm(way);
    return [way[0] / size, way[1] / size];
  };
  const a = tangent(panel.edges[one], one, false),
    b = tangent(panel.edges[two], two, true);
  const curve = (reach) => ({ kind: 'cubic', handles: [add([0, 0], a, reach), add([1, 0], b, reach)] });
  let low = 1e-3,
    high = 1e-3;
  while (unitLength(curve(high)) < goal && high < 4) high *= 1.25;
  if (unitLength(curve(high)) < goal || unitLength(curve(low)) > goal)
    throw new PatternError('no smooth curve of the same length replaces this point; it shapes the panel.');
  for (let step = 0; step < 80; step += 1) {
    const middle = (low + high) / 2;
    if (unitLength(curve(middle)) < goal) low = middle;
    else high = middle;
  }
  return curve((low + high) / 2);
}
