/** Cutting a panel in two along a line, and joining two panels along a seam. */

import { add, norm, placeOnChord, samplePoints, subtract, unitPoint } from './edge_geometry.js';
import { chordOf, edgeLength, getPanel, panelOutline, PatternError } from './pattern_model.js';
import { addPoint } from './point_operations.js';
import { findMirrors, imageEdges, imagePoints } from './symmetry.js';
import { seamOf } from './seams.js';

/** Edges that differ by more than this [m] do not lie on each other; joined, their panels would gape or overlap. */
const JOIN_TOLERANCE = 1e-3;
/** How far the halves of a cut panel move apart on the board [m]. */
const APART = 0.015;

/**
 * Cut a panel along the straight line between two of its control points; a seam joins the halves.
 *
 * @returns {import("./pattern_model.js").Pattern}
 */
export function cutBetween(pattern, one, two, keep) {
  if (one.panel !== two.panel) throw new PatternError('select two points of one panel to cut between them.');
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const [a] = imagePoints(pattern, mirrors, one),
    [b] = imagePoints(pattern, mirrors, two);
  const cut = cutOne(pattern, one, two);
  return a && b && a.panel !== one.panel ? cutOne(cut, a, b) : cut;
}

function cutOne(pattern, one, two) {
  const panel = getPanel(pattern, one.panel),
    count = panel.points.length;
  const [low, high] = [one.point, two.point].sort((a, b) => a - b);
  if ((high - low < 2 && isLine(panel, low)) || (low === 0 && high === count - 1 && isLine(panel, high)))
    throw new PatternError('there is nothing to cut between two ends of a straight edge.');
  if (low === high) throw new PatternError('select two different points to cut between them.');
  const start = panel.points[low],
    end = panel.points[high];
  const outline = panelOutline(panel, 32);
  for (let k = 1; k < 16; k += 1) {
    if (!contains(outline, placeOnChord([[k / 16, 0]], start, end)[0]))
      throw new PatternError('the cut would leave the panel; choose two points with a straight line inside it.');
  }
  const names = freeNames(pattern, panel.name);
  const halves = [
    [low, high],
    [high, low + count],
  ].map(([from, to], k) => {
    const kept = Array.from({ length: to - from }, (_, step) => (from + step) % count);
    const notches = panel.notches.filter(([edge]) => kept.includes(edge)).map(([edge, at]) => [kept.indexOf(edge), at]);
    const cut = { kind: 'line', handles: [], label: '', contour: '', rest: {} };
    return {
      ...panel,
      name: names[k],
      notches,
      file: null,
      kept,
      points: [...kept, to % count].map((at) => panel.points[at]),
      edges: [...kept.map((at) => panel.edges[at]), cut],
    };
  });
  const renumber = (ref) => {
    if (ref.panel !== panel.name) return ref;
    const half = halves.find(({ kept }) => kept.includes(ref.edge));
    return { panel: half.name, edge: half.kept.indexOf(ref.edge) };
  };
  const seams = pattern.seams.map((seam) => ({ ...seam, a: renumber(seam.a), b: renumber(seam.b) }));
  const [first, second] = halves.map((half) => ({ panel: half.name, edge: half.edges.length - 1 }));
  seams.push({ a: first, b: second, reversed: true, gathered: false });
  const panels = pattern.panels.flatMap((other) =>
    other === panel ? halves.map(({ kept: _kept, ...half }) => half) : [other],
  );
  const { [panel.name]: place, ...layout } = pattern.layout;
  if (place)
    names.forEach((name, k) => {
      layout[name] = aside(place, start, end, k ? APART : -APART);
    });
  return { ...pattern, panels, seams, layout, text: null };
}

/** Return a place moved sideways of a line by a distance [m], so that both halves can be seen. */
function aside(place, start, end, by) {
  const way = subtract(end, start),
    size = norm(way);
  const [x, y] = [(by * -way[1]) / size, (by * way[0]) / size],
    [c, s] = [Math.cos(place.turn), Math.sin(place.turn)];
  return { ...place, x: place.x + c * x - s * y, y: place.y + s * x + c * y };
}

const isLine = (panel, edge) => panel.edges[edge].kind === 'line';

/**
 * Cut a panel along a drawn line [m, the panel's axes]; control points are added where it meets the outline.
 *
 * @param {number} near   a control point that the cut passes closer than this [m] is its end
 * @returns {import("./pattern_model.js").Pattern}
 */
export function cutAlong(pattern, name, [from, to], near, keep) {
  const places = crossings(getPanel(pattern, name), from, to);
  if (places.length !== 2)
    throw new PatternError(
      `the line meets the outline of panel '${name}' ${places.length} times; draw it across the panel, so that it meets it twice.`,
    );
  let state = pattern;
  const ends = places.map(({ place }) => {
    const panel = getPanel(state, name);
    const point = panel.points.findIndex((at) => norm(subtract(at, place)) < near);
    if (point >= 0) return panel.points[point];
    const [nearest] = crossings(panel, from, to).sort(
      (a, b) => norm(subtract(a.place, place)) - norm(subtract(b.place, place)),
    );
    const { edge } = nearest,
      apart = Math.abs(nearest.fraction - 0.5) * edgeLength(state, { panel: name, edge });
    // A cut that passes the middle of an edge is meant to halve it.
    const added = addPoint(state, { panel: name, edge, fraction: apart < near ? 0.5 : nearest.fraction }, keep);
    state = added.pattern;
    return getPanel(state, name).points[added.point.point];
  });
  const find = (place) => ({
    panel: name,
    point: getPanel(state, name).points.findIndex((at) => norm(subtract(at, place)) < 1e-9),
  });
  return cutBetween(state, find(ends[0]), find(ends[1]), keep);
}

/** Return where a straight line meets a panel's outline. */
function crossings(panel, from, to) {
  const way = subtract(to, from),
    size = norm(way);
  const offset = (place) => (way[0] * (place[1] - from[1]) - way[1] * (place[0] - from[0])) / size;
  const found = [];
  panel.edges.forEach((edge, at) => {
    const place = (fraction) => placeOnChord([unitPoint(edge, fraction)], ...chordOf(panel, at))[0];
    for (let k = 0; k < 32; k += 1) {
      let low = k / 32,
        high = (k + 1) / 32;
      const first = offset(place(low));
      if (first > 0 === offset(place(high)) > 0) continue;
      for (let step = 0; step < 50; step += 1) {
        const middle = (low + high) / 2;
        if (offset(place(middle)) > 0 === first > 0) low = middle;
        else high = middle;
      }
      const meets = place(low),
        along = subtract(meets, from);
      const share = (along[0] * way[0] + along[1] * way[1]) / (size * size);
      if (share >= 0 && share <= 1) found.push({ edge: at, fraction: low, place: meets });
    }
  });
  return found;
}

/** Return whether a point is inside a polygon. */
export function contains(polygon, [x, y]) {
  let inside = false;
  polygon.forEach(([ax, ay], k) => {
    const [bx, by] = polygon[(k + 1) % polygon.length];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}

function freeNames(pattern, name) {
  const taken = new Set(pattern.panels.map((panel) => panel.name)),
    names = [];
  for (let number = 1; names.length < 2; number += 1)
    if (!taken.has(`${name}_${number}`)) names.push(`${name}_${number}`);
  return names;
}

/**
 * Join the two panels of a seam into one; seams that continue it between the same panels go with it.
 *
 * The second panel moves onto the first, whose name, place and grainline the joined one has.
 *
 * @param {number} index   the seam's
 */
export function joinAlong(pattern, index, keep) {
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const { a } = pattern.seams[index];
  const [image] = imageEdges(pattern, mirrors, a);
  const other = image ? seamOf(pattern, image) : null;
  const chain = chainOf(pattern, index);
  const joined = joinOne(pattern, chain);
  if (
    !other ||
    chain.includes(other.index) ||
    pattern.seams[other.index].a.panel === pattern.seams[other.index].b.panel
  )
    return joined;
  const untouched = [other.seam.a.panel, other.seam.b.panel].every(
    (name) => name !== a.panel && name !== pattern.seams[index].b.panel,
  );
  if (!untouched) return joined;
  const again = joined.seams.findIndex(
    (seam) => seam.a.panel === other.seam.a.panel && seam.a.edge === other.seam.a.edge,
  );
  return joinOne(joined, chainOf(joined, again));
}

/** Return the seams that continue one between the same two panels, in the order of the first panel's edges. */
function chainOf(pattern, index) {
  const { a, b, reversed } = pattern.seams[index];
  if (a.panel === b.panel)
    throw new PatternError('this seam joins a panel with itself; select a seam between two panels.');
  if (!reversed)
    throw new PatternError('the sides of this seam have the same direction; its panels cannot be placed side by side.');
  const counts = [a, b].map((ref) => getPanel(pattern, ref.panel).points.length);
  const chain = [index];
  for (const step of [1, -1]) {
    let one = a.edge,
      two = b.edge;
    for (;;) {
      one = (one + step + counts[0]) % counts[0];
      two = (two - step + counts[1]) % counts[1];
      const next = seamOf(pattern, { panel: a.panel, edge: one });
      const meets = next && next.other.panel === b.panel && next.other.edge === two && next.seam.reversed;
      if (!meets || chain.includes(next.index) || !congruent(pattern, a.panel, b.panel, [...chain, next.index])) break;
      if (step > 0) chain.push(next.index);
      else chain.unshift(next.index);
    }
  }
  return chain;
}

/** Return both sides of a chain of seams as numbers of edges, in the order of the first panel's edges. */
function sides(pattern, name, chain) {
  const pairs = chain
    .map((index) => pattern.seams[index])
    .map(({ a, b }) => (a.panel === name ? [a.edge, b.edge] : [b.edge, a.edge]));
  const count = getPanel(pattern, name).points.length;
  const first = pairs.find(([edge]) => !pairs.some(([other]) => (other + 1) % count === edge)) ?? pairs[0];
  return pairs.sort(([p], [q]) => ((p - first[0] + count) % count) - ((q - first[0] + count) % count));
}

function congruent(pattern, one, two, chain) {
  return placeBeside(pattern, one, two, sides(pattern, one, chain)).misfit <= JOIN_TOLERANCE;
}

/** Return the motion that puts the second panel beside the first along paired edges, and their largest distance [m]. */
function placeBeside(pattern, one, two, pairs) {
  const [first, second] = [getPanel(pattern, one), getPanel(pattern, two)];
  const onto = pairs.flatMap(([edge]) => samplePoints(first.edges[edge], ...chordOf(first, edge), 16));
  const from = pairs.flatMap(([, edge]) => samplePoints(second.edges[edge], ...chordOf(second, edge), 16).reverse());
  const mean = (points) => [0, 1].map((k) => points.reduce((sum, point) => sum + point[k], 0) / points.length);
  const [a, b] = [mean(from), mean(onto)];
  let c = 0,
    s = 0;
  from.forEach((point, k) => {
    const p = subtract(point, a),
      q = subtract(onto[k], b);
    c += p[0] * q[0] + p[1] * q[1];
    s += p[0] * q[1] - p[1] * q[0];
  });
  const angle = Math.atan2(s, c);
  const move = (point) => {
    const [x, y] = subtract(point, a);
    return add(b, [x * Math.cos(angle) - y * Math.sin(angle), x * Math.sin(angle) + y * Math.cos(angle)]);
  };
  return { move, misfit: Math.max(...from.map((point, k) => norm(subtract(move(point), onto[k])))) };
}

function joinOne(pattern, chain) {
  const { a, b } = pattern.seams[chain[0]];
  const first = getPanel(pattern, a.panel),
    second = getPanel(pattern, b.panel);
  const pairs = sides(pattern, a.panel, chain);
  const { move, misfit } = placeBeside(pattern, a.panel, b.panel, pairs);
  if (misfit > JOIN_TOLERANCE)
    throw new PatternError(
      `the sides of this seam differ in shape by up to ${(misfit * 1e3).toFixed(1)} mm, so the panels cannot be joined along it.`,
    );
  const rest = (panel, gone, from) =>
    Array.from({ length: panel.edges.length - gone.length }, (_, k) => (from + k) % panel.edges.length);
  const keptFirst = rest(
    first,
    pairs.map(([edge]) => edge),
    pairs[pairs.length - 1][0] + 1,
  );
  const keptSecond = rest(
    second,
    pairs.map(([, edge]) => edge),
    pairs[0][1] + 1,
  );
  const shift = keptFirst.length;
  const renumber = ({ panel, edge }) => {
    if (panel === first.name) return { panel, edge: keptFirst.indexOf(edge) };
    return panel === second.name ? { panel: first.name, edge: shift + keptSecond.indexOf(edge) } : { panel, edge };
  };
  const renotch = (panel, kept, from) =>
    panel.notches.filter(([edge]) => kept.includes(edge)).map(([edge, at]) => [from + kept.indexOf(edge), at]);
  const joined = {
    ...first,
    file: null,
    points: [...keptFirst.map((at) => first.points[at]), ...keptSecond.map((at) => move(second.points[at]))],
    edges: [...keptFirst.map((at) => first.edges[at]), ...keptSecond.map((at) => second.edges[at])],
    notches: [...renotch(first, keptFirst, 0), ...renotch(second, keptSecond, shift)],
  };
  const seams = pattern.seams
    .filter((_, index) => !chain.includes(index))
    .map((seam) => ({ ...seam, a: renumber(seam.a), b: renumber(seam.b) }));
  const panels = pattern.panels.filter((panel) => panel !== second).map((panel) => (panel === first ? joined : panel));
  const { [second.name]: _gone, ...layout } = pattern.layout;
  return { ...pattern, panels, seams, layout, text: null };
}
