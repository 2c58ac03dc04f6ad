/** The tables beside the board: the selection as text, the seams with their lengths, the difference to the opened pattern. */

import { make } from '../dom.js';
import { isStraight, norm, subtract } from './edge_geometry.js';
import { edgesBetween } from './curve_operations.js';
import { describeImages } from './drawing.js';
import { chainOf, edgeWords, panelWords, pointWords } from './names.js';
import { edgeLength, getPanel, panelArea, panelOutline } from './pattern_model.js';
import { seamLengths, seamOf, sewnPoints } from './seams.js';
import { kindOf } from './session.js';

/** A mismatch below this is none [m]: half of the last digit that is shown. */
const EQUAL = 5e-5;
const mm = (metres) => (Math.round(1e4 * metres) / 10 + 0).toFixed(1); // + 0: no "-0.0"

/** Fill the table of seams; rows are kept, texts are changed. */
export class SeamTable {
  constructor(body, summary, session) {
    Object.assign(this, { body, summary, session, rows: [], seams: null });
  }

  render() {
    const { pattern } = this.session;
    if (pattern.seams !== this.seams) this.rebuild(pattern);
    this.seams = pattern.seams;
    let worst = 0;
    for (const { index, a, b, ratio, mismatch } of seamLengths(pattern)) {
      const { cells, row } = this.rows[index],
        { gathered } = pattern.seams[index];
      const words = [mm(a), mm(b), gathered ? `×${ratio.toFixed(2)}` : mm(mismatch)];
      cells.forEach((cell, k) => {
        if (cell.textContent !== words[k]) cell.textContent = words[k];
      });
      row.classList.toggle('apart', Math.abs(mismatch) >= EQUAL);
      row.dataset.mismatch = String(mismatch);
      worst = Math.max(worst, Math.abs(mismatch));
    }
    this.summary.textContent =
      worst < EQUAL
        ? 'Both sides of every seam are equally long.'
        : `The sides of a seam differ by up to ${mm(worst)} mm.`;
    this.summary.className = worst < EQUAL ? 'good' : 'bad';
  }

  rebuild(pattern) {
    this.rows = pattern.seams.map((seam) => {
      const cells = [0, 1, 2].map(() => make('td.number'));
      const select = () => this.session.select([{ ...seam.a }, { ...seam.b }]);
      const button = make(
        'button.words',
        { type: 'button', onclick: select },
        `${edgeWords(pattern, seam.a)} – ${edgeWords(pattern, seam.b)}`,
      );
      return { cells, row: make('tr', {}, make('th', { scope: 'row' }, button), ...cells) };
    });
    this.body.replaceChildren(...this.rows.map(({ row }) => row));
  }
}

/** Return the selection as text, one line each. */
export function describeSelection(session) {
  const { pattern, selection } = session;
  if (!selection.length)
    return ['Nothing is selected. Click a point, an edge or a panel, draw a box, or press N on the board.'];
  const points = session.selected('point');
  if (selection.length === 2 && points.length === 2) return describePair(pattern, ...points);
  if (selection.length > 1)
    return [`${selection.length} selected: ${points.length} points, ${selection.length - points.length} others.`];
  const [item] = selection,
    panel = getPanel(pattern, item.panel);
  if (kindOf(item) === 'point') {
    const [x, y] = panel.points[item.point],
      images = describeImages(session.present, item);
    const sewn = sewnPoints(pattern, item).map((point) => pointWords(pattern, point));
    return [
      `${capital(pointWords(pattern, item))}: x ${mm(x)}, y ${mm(y)} mm.`,
      images.length ? `Mirror image: ${images.join(', ')}.` : 'It has no mirror image.',
      sewn.length ? `Sewn to ${sewn.join(', ')}.` : 'It is not sewn.',
    ];
  }
  if (kindOf(item) === 'edge') {
    const edge = panel.edges[item.edge],
      sewn = seamOf(pattern, item);
    const length = edgeLength(pattern, item);
    return [
      `${capital(edgeWords(pattern, item))}: ${isStraight(edge) ? 'straight' : edge.kind}, ${mm(length)} mm long.`,
      sewn
        ? `Sewn to ${edgeWords(pattern, sewn.other)}, ${mm(edgeLength(pattern, sewn.other))} mm.`
        : 'It is not sewn.',
      ...describeChain(pattern, item),
    ];
  }
  if (kindOf(item) === 'handle') return [`Handle ${item.handle + 1} of edge ${item.edge + 1} of ${panel.name}.`];
  return [`Panel ${panelWords(panel.name)}: ${panel.points.length} points, ${(1e4 * panelArea(panel)).toFixed(0)} cm².`];
}

const capital = (words) => words.charAt(0).toUpperCase() + words.slice(1);

/** Return the length of the whole line of an edge, and of what it is sewn to. */
export function measureChain(pattern, item) {
  const edges = chainOf(pattern, item),
    sewn = edges.map((edge) => seamOf(pattern, edge)?.other ?? null);
  const sum = (refs) => refs.reduce((total, ref) => total + edgeLength(pattern, ref), 0);
  return {
    panels: [...new Set(edges.map(({ panel }) => panel))],
    count: edges.length,
    length: sum(edges),
    other: sewn.every(Boolean) ? sum(sewn) : null,
  };
}

function describeChain(pattern, item) {
  const { line } = getPanel(pattern, item.panel).edges[item.edge].title ?? {};
  if (!line) return [];
  const { panels, count, length, other } = measureChain(pattern, item);
  const own = count > 1 ? [`Whole ${line}, on ${panels.map(panelWords).join(', ')}: ${mm(length)} mm.`] : [];
  if (other === null) return own;
  const ease = length - other;
  const words = Math.abs(ease) < EQUAL ? 'equally long' : `${mm(Math.abs(ease))} mm ${ease > 0 ? 'shorter' : 'longer'}`;
  return [...own, `What it is sewn to: ${mm(other)} mm, ${words}.`];
}

function describePair(pattern, one, two) {
  if (one.panel !== two.panel) return ['Two points of different panels.'];
  const panel = getPanel(pattern, one.panel);
  const straight = norm(subtract(panel.points[one.point], panel.points[two.point]));
  const along = edgesBetween(pattern, one, two).reduce(
    (sum, edge) => sum + edgeLength(pattern, { panel: one.panel, edge }),
    0,
  );
  return [
    `${capital(pointWords(pattern, one))} and ${pointWords(pattern, two)}: ${mm(straight)} mm apart, ${mm(along)} mm along the outline.`,
  ];
}

/** Return the distance of each panel's outline from the opened pattern's [m]; null for panels it did not have. */
export function findDifferences(pattern, original) {
  return pattern.panels.map((panel) => {
    const before = getPanel(original, panel.name);
    if (before === panel) return { panel: panel.name, furthest: 0 };
    return {
      panel: panel.name,
      furthest: before
        ? Math.max(stray(panelOutline(panel), panelOutline(before)), stray(panelOutline(before), panelOutline(panel)))
        : null,
    };
  });
}

/** Return the largest distance of a polygon's corners from another polygon. */
function stray(polygon, other) {
  return Math.max(
    ...polygon.map((point) =>
      Math.min(
        ...other.map((start, k) => {
          const way = subtract(other[(k + 1) % other.length], start),
            offset = subtract(point, start);
          const t = Math.min(
            Math.max((offset[0] * way[0] + offset[1] * way[1]) / (way[0] ** 2 + way[1] ** 2 || 1), 0),
            1,
          );
          return Math.hypot(offset[0] - t * way[0], offset[1] - t * way[1]);
        }),
      ),
    ),
  );
}

/** Return the differences as text. */
export function describeDifferences(pattern, original) {
  return findDifferences(pattern, original).map(({ panel, furthest }) => {
    const words = panelWords(panel);
    if (furthest === null) return `${words}: new`;
    return furthest < EQUAL ? `${words}: the same` : `${words}: up to ${mm(furthest)} mm`;
  });
}
