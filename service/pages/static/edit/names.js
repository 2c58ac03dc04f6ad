/**
 * Names of edges and points as the service found them in the pattern that was opened: each edge carries its own, so that
 * they stay with it when points are added or panels are cut. No name is made here.
 *
 * @typedef {{line: string, side: string, corner: string}} Title   of an edge, its side of the wearer, and the point where it begins
 */

import { getPanel } from './pattern_model.js';
import { sewnPoints } from './seams.js';

/** Return a pattern whose edges carry the names that the service found. */
export function withNames(pattern, found) {
  const panels = pattern.panels.map((panel) => {
    const names = found?.[panel.name];
    if (names?.lines.length !== panel.edges.length) return panel;
    const edges = panel.edges.map((edge, k) => ({
      ...edge,
      title: { line: names.lines[k], side: names.sides[k], corner: names.points[k] },
    }));
    return { ...panel, edges };
  });
  return { ...pattern, panels };
}

/** Return a panel's name as words. */
export const panelWords = (name) => name.replaceAll('_', ' ');

/** Return the name of an edge's line within its panel: `left side seam`; an empty text where it has none. */
export function lineOf(edge) {
  const { line = '', side = '' } = edge.title ?? {};
  return side && line ? `${side} ${line}` : line;
}

/** Return the name of an edge with its panel's: `front hem`. */
export function edgeWords(pattern, { panel: name, edge: at }) {
  const panel = getPanel(pattern, name),
    line = lineOf(panel.edges[at]);
  if (!line) return `${panelWords(name)} edge ${at + 1}`;
  const same = panel.edges.flatMap((edge, k) => (lineOf(edge) === line ? [k] : []));
  return `${panelWords(name)} ${line}${same.length > 1 ? `, part ${same.indexOf(at) + 1}` : ''}`;
}

/** Return the name of a control point with its panel's: `front left underarm point`. */
export function pointWords(pattern, { panel: name, point }) {
  const { title } = getPanel(pattern, name).edges[point];
  if (title?.corner) return `${panelWords(name)} ${title.corner}`;
  return `${panelWords(name)} point ${point + 1}${title?.line ? ` on the ${lineOf(getPanel(pattern, name).edges[point])}` : ''}`;
}

/** Return the named lines of each panel with their edges, in the order of the outlines. */
export function listLines(pattern) {
  return pattern.panels.flatMap((panel) => {
    const lines = new Map();
    panel.edges.forEach((edge, at) => {
      const line = lineOf(edge);
      if (line) lines.set(line, [...(lines.get(line) ?? []), { panel: panel.name, edge: at }]);
    });
    return [...lines].map(([line, edges]) => ({ words: `${panelWords(panel.name)} ${line}`, edges }));
  });
}

/** Return the edges of the line that an edge is part of, across the seams that it crosses: a whole neckline or hem. */
export function chainOf(pattern, ref) {
  const name = getPanel(pattern, ref.panel).edges[ref.edge].title?.line;
  const found = [ref],
    has = (one) => found.some((other) => other.panel === one.panel && other.edge === one.edge);
  if (!name) return found;
  for (let at = 0; at < found.length; at += 1) {
    const { panel, edge } = found[at],
      count = getPanel(pattern, panel).points.length;
    const ends = [edge, (edge + 1) % count].map((point) => ({ panel, point }));
    for (const end of ends.flatMap((point) => [point, ...sewnPoints(pattern, point)])) {
      const { points, edges } = getPanel(pattern, end.panel);
      for (const next of [end.point, (end.point - 1 + points.length) % points.length]) {
        const one = { panel: end.panel, edge: next };
        if (edges[next].title?.line === name && !has(one)) found.push(one);
      }
    }
  }
  return found;
}
