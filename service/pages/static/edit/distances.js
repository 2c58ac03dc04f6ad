/** Typed distances: move the selection by a number with a unit; slash and spread, darts. */

import { find, make } from '../dom.js';
import { addDart, dartOf, pivotDart, removeDart } from './darts.js';
import { norm, subtract } from './edge_geometry.js';
import { moveItems } from './movement.js';
import { edgeWords, listLines, pointWords } from './names.js';
import { moveParallel } from './parallel.js';
import { edgeEnds } from './seams.js';
import { getPanel, PatternError } from './pattern_model.js';
import { spread } from './spreading.js';

/** Units that can be typed [m]. */
const UNITS = { '': 1e-3, mm: 1e-3, cm: 1e-2, m: 1, inch: 0.0254, in: 0.0254, '"': 0.0254 };
/** What a movement in a direction is called, and where it is negative. */
const WORDS = {
  down: ['lowered', 'raised'],
  up: ['raised', 'lowered'],
  out: ['moved outward', 'moved inward'],
  in: ['moved inward', 'moved outward'],
  along: ['moved along the edge', 'moved back along the edge'],
};

/** Return a typed length [m]: a number with a sign and `mm`, `cm`, `m`, `inch`; without a unit millimetres. */
export function readLength(text) {
  const found = /^\s*([+-]?(?:\d+[.,]?\d*|[.,]\d+))\s*(mm|cm|m|inch|in|")?\s*$/i.exec(text);
  if (!found) throw new PatternError('write a distance as 30, -30 mm, 2.5 cm or 1 inch.');
  return Number(found[1].replace(',', '.')) * UNITS[(found[2] ?? '').toLowerCase()];
}

/** Return a typed opening: an angle, `5°` or `5 deg` [rad], else a length [m]. */
export function readOpening(text) {
  const found = /^\s*(\d+(?:[.,]\d+)?)\s*(?:°|deg|degrees)\s*$/i.exec(text);
  return found ? { angle: (Number(found[1].replace(',', '.')) * Math.PI) / 180 } : { distance: readLength(text) };
}

/**
 * Move points or edges by a distance in a direction.
 *
 * @param {object[]} items   the selection @param {number} distance [m] @param {string} direction
 * @returns {import("./pattern_model.js").Pattern}
 */
export function moveBy(pattern, items, distance, direction, keep) {
  const edges = items.filter(({ edge, handle }) => edge !== undefined && handle === undefined);
  if (['out', 'in'].includes(direction) && edges.length)
    return moveParallel(pattern, edges, direction === 'in' ? -distance : distance, keep);
  const points = new Map();
  const put = (panel, point, edge) => points.set(`${panel}\n${point}`, { panel, point, edge });
  for (const { panel, point } of items.filter((item) => item.point !== undefined)) put(panel, point, point);
  for (const ref of edges) for (const point of edgeEnds(pattern, ref)) put(ref.panel, point, ref.edge);
  if (!points.size) throw new PatternError('select points or edges, or choose a line by its name.');
  const moves = [...points.values()].map(({ panel, point, edge }) => {
    const [x, y] = wayOf(getPanel(pattern, panel), edge, direction);
    return { item: { panel, point }, by: [distance * x, distance * y] };
  });
  return moveItems(pattern, moves, keep);
}

/** Return the direction of a movement in the panel's axes, of length 1. */
function wayOf(panel, edge, direction) {
  const grain = [-Math.sin(panel.grainline), Math.cos(panel.grainline)];
  if (direction === 'up') return grain;
  if (direction === 'down') return [-grain[0], -grain[1]];
  const way = subtract(panel.points[(edge + 1) % panel.points.length], panel.points[edge]),
    size = norm(way);
  const along = [way[0] / size, way[1] / size];
  if (direction === 'along') return along;
  return direction === 'out' ? [along[1], -along[0]] : [-along[1], along[0]];
}

const mm = (metres) => (1e3 * metres).toFixed(1);

/** Return what a movement did, as a sentence. */
export function describeMove(pattern, items, distance, direction) {
  const one = items[0];
  const whole = listLines(pattern).find(
    ({ edges }) =>
      edges.length === items.length &&
      edges.every((edge) => items.some((item) => item.panel === edge.panel && item.edge === edge.edge)),
  );
  const name = one.edge !== undefined ? edgeWords(pattern, one) : pointWords(pattern, one);
  const words = whole ? whole.words : items.length === 1 ? name : `${items.length} selected`;
  return `${words} ${WORDS[direction][distance < 0 ? 1 : 0]} by ${mm(Math.abs(distance))} mm.`;
}

/** Join the form of typed distances to the session. */
export function joinDistances(session) {
  const form = find('#distance'),
    line = find('#line');
  const value = (name) => find(`#${name}`).value;
  let lines = [],
    shown = '';
  const fill = () => {
    lines = listLines(session.pattern);
    const words = lines.map((one) => one.words).join('\n');
    if (words === shown) return;
    shown = words;
    line.replaceChildren(
      make('option', { value: '' }, 'as selected'),
      ...lines.map((one, k) => make('option', { value: String(k) }, one.words)),
    );
  };
  fill();
  session.addEventListener('pattern', fill);
  line.addEventListener('change', () => {
    if (line.value !== '') session.select(lines[Number(line.value)].edges);
  });
  session.addEventListener('selection', () => {
    const at = lines.findIndex(
      ({ edges }) => edges.length === session.selection.length && edges.every((edge) => session.isSelected(edge)),
    );
    line.value = at < 0 ? '' : String(at);
  });
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const direction = value('direction'),
      items = session.selection;
    session.change(
      (pattern) => moveBy(pattern, items, readLength(value('amount')), direction, session.keep),
      () => describeMove(session.present, items, readLength(value('amount')), direction),
    );
  });
  const work = { spread: spreadSelected, dart: addToSelected };
  for (const button of form.querySelectorAll('[data-sized]'))
    button.addEventListener('click', () => work[button.dataset.sized](session, value('amount'), value('depth')));
}

function spreadSelected(session, amount) {
  const points = session.selected('point');
  const done = session.change(
    (pattern) => {
      if (points.length !== 2) throw new PatternError('select the point to open and then the hinge.');
      return spread(pattern, ...points, readOpening(amount), session.keep);
    },
    `Opened by ${amount} at the first point; the second is the hinge.`,
  );
  if (done) session.select([]);
}

function addToSelected(session, amount, depth) {
  const edges = session.selected('edge');
  const done = session.change(
    (pattern) => {
      if (edges.length !== 1) throw new PatternError('select one edge to add a dart in its middle.');
      const size = { width: readLength(amount), length: readLength(depth) };
      return addDart(pattern, { ...edges[0], fraction: 0.5 }, size, session.keep);
    },
    `Added a dart, ${amount} wide and ${depth} long.`,
  );
  if (done) session.select([]);
}

/** Turn the selected dart to the other selected point. */
export function pivotSelected(session) {
  const done = session.change((pattern) => {
    const dart = session.selection.map((item) => dartOf(pattern, item)).find(Boolean);
    const [target] = session.selected('point').filter((item) => !dartOf(pattern, item));
    if (!dart || !target) throw new PatternError("select a dart's apex, and the point to which the dart is turned.");
    return pivotDart(pattern, dart, target, session.keep);
  }, 'The dart is turned about its apex; its angle is kept.');
  if (done) session.select([]);
}

/** Remove the selected dart. */
export function removeSelectedDart(session) {
  const done = session.change((pattern) => {
    const dart = session.selection.map((item) => dartOf(pattern, item)).find(Boolean);
    if (!dart) throw new PatternError("select a dart's apex or one of its legs.");
    return removeDart(pattern, dart, session.keep);
  }, 'Removed the dart.');
  if (done) session.select([]);
}
