/**
 * Which panels are mirror images of each other, and which are their own: the same rule as `core/garment/symmetry.py`.
 *
 * A mirror maps control points by target[j] = R source[order[j]] + t, with R orthogonal and of determinant -1.
 *
 * @typedef {{source: number, target: number, order: number[], rotation: number[][]}} Mirror   indices of panels
 * @typedef {{panel: number, point: number, matrix: number[][]}} Member
 * @typedef {Member[]} Group   points that move together: each member moves by its matrix times the group's movement
 */

import { subtract } from './edge_geometry.js';
import { placePoint } from './rotation.js';

/** Largest RMS misfit of mirrored points, as a share of the panel's diagonal. */
const FLAT_TOLERANCE = 0.005;
/** Largest difference of mirrored handles, in chords. */
const HANDLE_TOLERANCE = 0.01;
/** Largest RMS distance in space of a placed panel's image from its partner, as a share of the diagonal. */
const PLACE_TOLERANCE = 0.25;
const IDENTITY = [
  [1, 0],
  [0, 1],
];

/** Return m v for a 2 x 2 matrix. */
export const turn = (m, v) => [m[0][0] * v[0] + m[0][1] * v[1], m[1][0] * v[0] + m[1][1] * v[1]];

const found = new WeakMap();

/**
 * Find the left-right symmetry of a pattern; kept with it, for states never change.
 *
 * @returns {Mirror[]}
 */
export function findMirrors(pattern) {
  if (!found.has(pattern)) found.set(pattern, searchMirrors(pattern));
  return found.get(pattern);
}

function searchMirrors(pattern) {
  const { panels } = pattern;
  const middle = findMiddle(panels);
  const sewn = new Set(pattern.seams.flatMap((seam) => [seam.a, seam.b].map((ref) => `${ref.panel}\n${ref.edge}`)));
  const mirrors = [],
    taken = new Set();
  for (let source = 0; source < panels.length; source += 1) {
    if (taken.has(source)) continue;
    let best = null;
    for (let target = source; target < panels.length; target += 1) {
      if (taken.has(target)) continue;
      for (const fit of fitMirrors(panels, sewn, source, target, middle)) {
        if (best === null || Number(fit.score.toFixed(9)) < Number(best.score.toFixed(9))) best = fit;
      }
    }
    if (best === null) continue;
    mirrors.push(best.mirror);
    taken.add(source).add(best.mirror.target);
  }
  return mirrors;
}

/** Return x of the plane that halves the placed panels, or null where nothing is placed. */
function findMiddle(panels) {
  const spread = [0, 1, 2].map((k) => {
    const values = panels.map((panel) => panel.translation[k]);
    return Math.max(...values) - Math.min(...values);
  });
  if (panels.length > 1 && Math.max(...spread) < 1e-6) return null;
  const x = panels.flatMap((panel) => panel.points.map((point) => placePoint(panel, point)[0]));
  return (Math.min(...x) + Math.max(...x)) / 2;
}

function fitMirrors(panels, sewn, source, target, middle) {
  const a = panels[source],
    b = panels[target],
    count = a.points.length;
  if (b.points.length !== count) return [];
  const [width, height] = [0, 1].map(
    (k) => Math.max(...a.points.map((p) => p[k])) - Math.min(...a.points.map((p) => p[k])),
  );
  const diagonal = Math.hypot(width, height);
  const fits = [];
  for (let shift = 0; shift < count; shift += 1) {
    const order = b.points.map((_, j) => (((shift - j) % count) + count) % count);
    if (!edgesAgree(sewn, a, b, order)) continue;
    const { rotation, error } = fitReflection(
      order.map((i) => a.points[i]),
      b.points,
    );
    if (error / diagonal > FLAT_TOLERANCE) continue;
    let score = error / diagonal;
    if (middle !== null) {
      let sum = 0;
      b.points.forEach((point, j) => {
        const image = placePoint(a, a.points[order[j]]),
          place = placePoint(b, point);
        sum += (2 * middle - image[0] - place[0]) ** 2 + (image[1] - place[1]) ** 2 + (image[2] - place[2]) ** 2;
      });
      score = Math.sqrt(sum / count) / diagonal;
      if (score > PLACE_TOLERANCE) continue;
    }
    fits.push({ score, mirror: { source, target, order, rotation } });
  }
  return fits;
}

/** Return the reflection [[c, s], [s, -c]] that brings points best onto their counterparts, and the RMS misfit. */
function fitReflection(from, onto) {
  const mean = (points) => [0, 1].map((k) => points.reduce((sum, point) => sum + point[k], 0) / points.length);
  const a = from.map((point) => subtract(point, mean(from))),
    b = onto.map((point) => subtract(point, mean(onto)));
  let c = 0,
    s = 0;
  a.forEach((p, k) => {
    c += b[k][0] * p[0] - b[k][1] * p[1];
    s += b[k][0] * p[1] + b[k][1] * p[0];
  });
  const angle = Math.atan2(s, c);
  const rotation = [
    [Math.cos(angle), Math.sin(angle)],
    [Math.sin(angle), -Math.cos(angle)],
  ];
  const square = a.reduce(
    (sum, p, k) => sum + subtract(b[k], turn(rotation, p)).reduce((total, v) => total + v * v, 0),
    0,
  );
  return { rotation, error: Math.sqrt(square / a.length) };
}

function edgesAgree(sewn, a, b, order) {
  const count = order.length;
  return b.edges.every((edge, i) => {
    const j = (order[i] - 1 + count) % count,
      image = a.edges[j];
    if (sewn.has(`${b.name}\n${i}`) !== sewn.has(`${a.name}\n${j}`)) return false;
    if (image.kind !== edge.kind || image.handles.length !== edge.handles.length) return false;
    return [...image.handles]
      .reverse()
      .every(
        ([u, v], k) =>
          Math.abs(1 - u - edge.handles[k][0]) < HANDLE_TOLERANCE &&
          Math.abs(v - edge.handles[k][1]) < HANDLE_TOLERANCE,
      );
  });
}

/**
 * Return the points of a pattern in groups that move together under given mirrors; without mirrors each is alone.
 *
 * @returns {Group[]} a group's first member is the one that the others follow
 */
export function moveTogether(pattern, mirrors) {
  const key = (panel, point) => `${panel}/${point}`;
  const groups = new Map();
  pattern.panels.forEach((panel, p) =>
    panel.points.forEach((_, i) => groups.set(key(p, i), [{ panel: p, point: i, matrix: IDENTITY }])),
  );
  for (const { source, target, order, rotation } of mirrors) {
    order.forEach((i, j) => {
      if (source === target && i === j) {
        // Points of the axis stay on it: (I + R) / 2 projects a movement on its direction.
        const matrix = [
          [(1 + rotation[0][0]) / 2, rotation[0][1] / 2],
          [rotation[1][0] / 2, (1 + rotation[1][1]) / 2],
        ];
        groups.set(key(target, j), [{ panel: target, point: j, matrix }]);
      } else if (source !== target || i < j) {
        groups.get(key(source, i)).push({ panel: target, point: j, matrix: rotation });
        groups.delete(key(target, j));
      }
    });
  }
  return [...groups.values()];
}

/** Return the edges that are an edge's images under mirrors (itself left out), each run the other way than it. */
export function imageEdges(pattern, mirrors, ref) {
  const images = [];
  const at = pattern.panels.findIndex((panel) => panel.name === ref.panel);
  for (const { source, target, order } of mirrors) {
    const count = order.length;
    // Edge i of the target is the image of edge order[i] - 1 of the source.
    const forward = order.findIndex((_, i) => (order[i] - 1 + count) % count === ref.edge);
    if (source === at) images.push({ panel: pattern.panels[target].name, edge: forward });
    else if (target === at)
      images.push({ panel: pattern.panels[source].name, edge: (order[ref.edge] - 1 + count) % count });
  }
  return images.filter((image) => image.panel !== ref.panel || image.edge !== ref.edge);
}

/** Return the points that are a control point's images under mirrors (itself left out). */
export function imagePoints(pattern, mirrors, { panel, point }) {
  const at = pattern.panels.findIndex((other) => other.name === panel);
  const images = [];
  for (const { source, target, order } of mirrors) {
    if (source === at) images.push({ panel: pattern.panels[target].name, point: order.indexOf(point) });
    else if (target === at) images.push({ panel: pattern.panels[source].name, point: order[point] });
  }
  return images.filter((image) => image.panel !== panel || image.point !== point);
}
