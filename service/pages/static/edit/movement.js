/**
 * Moving control points and handles.
 *
 * @typedef {{panel: string, point: number}|{panel: string, edge: number, handle: number}} Item   what can be selected
 * @typedef {{item: Item, by: [number, number]}} Move   in the panel's own axes [m]
 * @typedef {{symmetric: boolean, sewn: boolean}} Keep   keep the symmetry; keep the seams' lengths
 */

import { add, relativeToChord, subtract } from './edge_geometry.js';
import { chordOf, getPanel, handlePoints, withPanels, withPoints } from './pattern_model.js';
import { findMirrors, imageEdges, moveTogether, turn } from './symmetry.js';
import { keepSeams } from './seams.js';

/**
 * Move selected points and handles; mirror images and what is sewn to them follow.
 *
 * A point moves by exactly what is asked; one on its panel's axis of symmetry by the part along the axis, and two images
 * of each other by the symmetric part of what is asked of both.
 *
 * @returns {import("./pattern_model.js").Pattern}
 */
export function moveItems(pattern, moves, keep) {
  const mirrors = keep.symmetric ? findMirrors(pattern) : [];
  const handles = moves.filter(({ item }) => item.handle !== undefined);
  const { moved, held } = movePoints(
    pattern,
    moves.filter(({ item }) => item.point !== undefined),
    mirrors,
  );
  const bent = handles.reduce((state, move) => moveHandle(state, move, mirrors), moved);
  const edges = handles.flatMap(({ item }) => [item, ...imageEdges(pattern, mirrors, item)]);
  if (!keep.sewn) return bent;
  // The ends of a bent edge stay, so that its partner gives way.
  const ends = edges.flatMap(({ panel, edge }) =>
    [edge, (edge + 1) % getPanel(pattern, panel).points.length].map((point) => ({ panel, point })),
  );
  return keepSeams(bent, { before: pattern, held: [...held, ...ends], mirrors });
}

function movePoints(pattern, moves, mirrors) {
  const changed = {},
    held = [];
  if (!moves.length) return { moved: pattern, held };
  for (const group of moveTogether(pattern, mirrors)) {
    const asked = [];
    for (const member of group) {
      const name = pattern.panels[member.panel].name;
      const move = moves.find(({ item }) => item.panel === name && item.point === member.point);
      // A reflection is its own inverse, and so is a projection on what it keeps.
      if (move) asked.push(turn(member.matrix, move.by));
    }
    if (!asked.length) continue;
    const mean = [0, 1].map((k) => asked.reduce((sum, by) => sum + by[k], 0) / asked.length);
    for (const { panel, point, matrix } of group) {
      const { name, points } = pattern.panels[panel];
      changed[name] ??= points.map((at) => at);
      changed[name][point] = add(points[point], turn(matrix, mean));
      held.push({ panel: name, point });
    }
  }
  return { moved: withPoints(pattern, changed), held };
}

function moveHandle(pattern, { item, by }, mirrors) {
  const panel = getPanel(pattern, item.panel);
  const place = add(handlePoints(panel, item.edge)[item.handle], by);
  const [unit] = relativeToChord([place], ...chordOf(panel, item.edge));
  const edge = panel.edges[item.edge],
    old = edge.handles[item.handle];
  const shift = edge.kind === 'arc' ? [0, unit[1] - old[1]] : subtract(unit, old);
  let state = shiftHandle(pattern, item, item.handle, shift);
  for (const image of imageEdges(pattern, mirrors, item)) {
    state = shiftHandle(state, image, edge.handles.length - 1 - item.handle, [-shift[0], shift[1]]);
  }
  const index = pattern.panels.indexOf(panel),
    count = panel.points.length;
  const own = mirrors.some(
    ({ source, target, order }) =>
      source === index && target === index && (order[item.edge] - 1 + count) % count === item.edge,
  );
  if (!own) return state;
  const other = edge.handles.length - 1 - item.handle;
  if (other === item.handle) return shiftHandle(pattern, item, other, [0, shift[1]]);
  return shiftHandle(state, item, other, [-shift[0], shift[1]]);
}

function shiftHandle(pattern, { panel: name, edge: at }, handle, shift) {
  const panel = getPanel(pattern, name);
  const edges = panel.edges.map((edge, k) =>
    k === at ? { ...edge, handles: edge.handles.map((old, h) => (h === handle ? add(old, shift) : old)) } : edge,
  );
  return withPanels(pattern, { [name]: { ...panel, edges } });
}
