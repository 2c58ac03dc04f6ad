/** Slash and spread: a panel is cut from one point of its outline to another, its hinge, and the cut is opened. */

import { norm, subtract } from './edge_geometry.js';
import { checkInside, newLine, partsBetween, pointAt, turnParts, turnPoint, withOutline } from './outline.js';
import { getPanel, PatternError, polygonArea } from './pattern_model.js';
import { findMirrors, imagePoints } from './symmetry.js';
import { seamOf } from './seams.js';

/** Widest opening [rad]. */
const WIDEST = Math.PI / 2;

/**
 * Cut from one control point to another, and turn the smaller part about the second until the cut is open at the first.
 *
 * No edge changes its length, so seams stay as they were; a straight edge closes the opening, whose area is added.
 *
 * @param {{panel: string, point: number}} open @param {{panel: string, point: number}} hinge
 * @param {{angle: number}|{distance: number}} by   of the opening [rad], or between its ends [m]
 * @returns {import("./pattern_model.js").Pattern}
 */
export function spread(pattern, open, hinge, by, keep) {
  if (open.panel !== hinge.panel || open.point === hinge.point)
    throw new PatternError('select the point to open and then the hinge, both of one panel.');
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const [a] = imagePoints(pattern, mirrors, open),
    [b] = imagePoints(pattern, mirrors, hinge);
  const angle = angleOf(getPanel(pattern, open.panel), open.point, hinge.point, by);
  // A cut along the axis of symmetry turns both parts by half.
  const onAxis = !a && !b && mirrors.some(({ source, target }) => source === target && pattern.panels[source].name === open.panel);
  const done = spreadOne(pattern, open.panel, open.point, hinge.point, angle, onAxis);
  if (!a && !b) return done;
  const [one, two] = [a ?? open, b ?? hinge];
  const places = [one, two].map(({ panel, point }) => getPanel(pattern, panel).points[point]);
  const panel = getPanel(done, one.panel);
  return spreadOne(done, one.panel, pointAt(panel, places[0]), pointAt(panel, places[1]), angle, false);
}

function angleOf(panel, open, hinge, by) {
  const reach = norm(subtract(panel.points[open], panel.points[hinge]));
  const angle = by.angle ?? 2 * Math.asin(Math.min(Math.max(by.distance / (2 * reach), -1), 1));
  if (!(angle > 0 && angle <= WIDEST)) throw new PatternError('open the cut by more than 0 and at most 90 degrees.');
  return angle;
}

function spreadOne(pattern, name, open, hinge, angle, inHalves) {
  const panel = getPanel(pattern, name),
    count = panel.points.length;
  if ([1, count - 1].includes((open - hinge + count) % count))
    throw new PatternError('both points are ends of one edge; choose points with the panel between them.');
  checkInside(panel, open, hinge);
  const last = (open - 1 + count) % count;
  if (seamOf(pattern, { panel: name, edge: last }) && seamOf(pattern, { panel: name, edge: open }))
    throw new PatternError('both edges at the point to open are sewn; open the cut at a hem, a waist or a neckline.');
  const centre = panel.points[hinge];
  const before = partsBetween(panel, hinge, open),
    after = partsBetween(panel, open, hinge);
  const areaOf = (parts, end) => Math.abs(polygonArea([...parts.map(({ start }) => start), end]));
  const isFirst = areaOf(before, panel.points[open]) < areaOf(after, centre);
  const [back, forth] = inHalves ? [angle / 2, angle / 2] : isFirst ? [angle, 0] : [0, angle];
  const free = seamOf(pattern, { panel: name, edge: last }) ? panel.edges[open] : panel.edges[last];
  const mouth = {
    start: turnPoint(panel.points[open], centre, -back),
    edge: newLine(free.title && { ...free.title, corner: '' }, free.contour),
    old: null,
  };
  const parts = [...turnParts(before, centre, -back), mouth, ...turnParts(after, centre, forth)];
  return withOutline(pattern, name, parts);
}
