// The flat pattern as SVG, in mm: panels side by side, edges that can be pointed at, seams in pairs.
import { draw } from './dom.js';

/** Space between panels [mm], and how many widths of a sheet are tried to fill the drawing's place. */
const GAP = 40;
const SHEETS = 40;

/** How many colours the seams have in turn; the style has one for each. */
const SEAMS = 8;

/** Largest size of a panel's name [mm], and the width of a letter over its size. */
const LETTERS = 30;
const LETTER_WIDTH = 0.58;

/** A drawing of a garment's pattern. */
export class PatternView {
  /** @param {HTMLElement} place @param {import('./garment.js').Garment} garment */
  constructor(place, garment) {
    this.garment = garment;
    this.offsets = layOut(garment, place.clientWidth || 1, place.clientHeight || 1);
    this.svg = draw('svg', { role: 'group', 'aria-label': 'Pattern: point at a panel to find it on the garment' });
    this.seamOf = new Map();
    garment.seams.forEach((pair, n) => pair.forEach((edge) => this.seamOf.set(edge, { n, pair })));
    this.edges = new Map();
    garment.panels.forEach((panel, n) => this.svg.append(this.drawPanel(panel, n)));
    this.mark = draw('circle', { class: 'mark', r: 9, visibility: 'hidden' });
    this.section = draw('path', { class: 'section' });
    this.svg.append(this.section, this.mark);
    place.append(this.svg);
    const box = this.bounds;
    this.svg.setAttribute('viewBox', `${-GAP} ${-GAP} ${box[0] + 2 * GAP} ${box[1] + 2 * GAP}`);
  }

  /** @returns {number[]} width and height of the drawing [mm] */
  get bounds() {
    const points = Array.from(this.garment.panelOfUv, (_, vertex) => this.place(vertex));
    return [0, 1].map((axis) => points.reduce((most, point) => Math.max(most, point[axis]), 0));
  }

  /** @returns {number[]} where a point of the flat mesh is drawn [mm]; the drawing's y runs downwards */
  place(vertex) {
    const { uv, panelOfUv } = this.garment, [x, y] = this.offsets[panelOfUv[vertex]];
    return [1000 * uv[2 * vertex] + x, y - 1000 * uv[2 * vertex + 1]];
  }

  drawPanel(panel, n) {
    const group = draw('g', { 'data-panel': panel.name });
    const outline = panel.edges.flatMap((edge) => Array.from(edge.uv.slice(0, -1)));
    const points = outline.map((vertex) => this.place(vertex));
    const surface = draw('path', { class: 'panel', d: `M${points.map((point) => point.join(' ')).join('L')}Z`, 'data-n': n });
    const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
    const [left, right] = [Math.min(...xs), Math.max(...xs)], name = panel.name.replaceAll('_', ' ');
    const size = Math.min(LETTERS, (0.8 * (right - left)) / (LETTER_WIDTH * name.length));
    const text = draw('text', { class: 'panel-name', x: (left + right) / 2, y: (Math.min(...ys) + Math.max(...ys)) / 2, 'font-size': size });
    text.textContent = name;
    group.append(surface, text);
    for (const edge of panel.edges) group.append(this.drawEdge(edge));
    return group;
  }

  drawEdge(edge) {
    const d = 'M' + Array.from(edge.uv, (vertex) => this.place(vertex).join(' ')).join('L');
    const seam = this.seamOf.get(edge);
    const name = `${edge.panel}, edge ${edge.index}${edge.label ? `, ${edge.label}` : ''}${edge.contour ? `, ${edge.contour}` : ''}`;
    const line = draw('path', { class: seam ? `edge seam-${seam.n % SEAMS}` : 'edge', d });
    const hold = draw('path', { class: 'hold', d, tabindex: 0, role: 'button', 'aria-label': name, 'data-edge': `${edge.panel}.${edge.index}` });
    this.edges.set(edge, { line, hold });
    return draw('g', {}, line, hold);
  }

  /** @returns {number[]} the point of the drawing under the pointer [mm] */
  toDrawing(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [at.x, at.y];
  }

  /** @returns {{panel: number, x: number, y: number}|null} the panel under the pointer, and the point of it [m] */
  find(event) {
    const n = event.target.closest?.('[data-panel]')?.querySelector('.panel')?.getAttribute('data-n');
    if (n === null || n === undefined) return null;
    const [x, y] = this.toDrawing(event), offset = this.offsets[Number(n)];
    return { panel: Number(n), x: (x - offset[0]) / 1000, y: (offset[1] - y) / 1000 };
  }

  /** @returns {number} the place in an edge's uv vertices that is nearest to the pointer */
  nearest(edge, event) {
    const [x, y] = this.toDrawing(event);
    let best = 0, least = Infinity;
    edge.uv.forEach((vertex, n) => {
      const [px, py] = this.place(vertex), distance = Math.hypot(px - x, py - y);
      if (distance < least) [best, least] = [n, distance];
    });
    return best;
  }

  /** @param {number|null} panel @param {number[]} [point] [m] */
  setMark(panel, point) {
    this.mark.setAttribute('visibility', panel === null ? 'hidden' : 'visible');
    if (panel === null) return;
    this.mark.setAttribute('cx', String(1000 * point[0] + this.offsets[panel][0]));
    this.mark.setAttribute('cy', String(this.offsets[panel][1] - 1000 * point[1]));
  }

  /** @param {Set<object>} edges that are lit */
  light(edges) {
    for (const [edge, { line }] of this.edges) line.classList.toggle('lit', edges.has(edge));
  }

  /** @param {object|null} edge @param {number} [from] @param {number} [to] the part of it that is measured */
  showSection(edge, from, to) {
    const part = edge ? Array.from(edge.uv.slice(Math.min(from, to), Math.max(from, to) + 1), (vertex) => this.place(vertex).join(' ')) : [];
    this.section.setAttribute('d', part.length ? `M${part.join('L')}` : '');
  }
}

/**
 * Lay panels side by side in shelves, the highest first, so that they are drawn as large as their place allows.
 * @param {import('./garment.js').Garment} garment @param {number} wide @param {number} high size of the place [px]
 * @returns {number[][]} what is added to x, and from what y is taken, of each panel [mm]
 */
function layOut(garment, wide, high) {
  const boxes = garment.panels.map(() => [Infinity, Infinity, -Infinity, -Infinity]);
  for (let vertex = 0; vertex < garment.panelOfUv.length; vertex += 1) {
    const box = boxes[garment.panelOfUv[vertex]], x = 1000 * garment.uv[2 * vertex], y = 1000 * garment.uv[2 * vertex + 1];
    box[0] = Math.min(box[0], x);
    box[1] = Math.min(box[1], y);
    box[2] = Math.max(box[2], x);
    box[3] = Math.max(box[3], y);
  }
  const widths = boxes.map((box) => box[2] - box[0]), least = Math.max(...widths);
  const most = widths.reduce((sum, width) => sum + width + GAP, 0);
  const tried = Array.from({ length: SHEETS }, (_, n) => fillShelves(boxes, least + ((most - least) * n) / (SHEETS - 1)));
  const scaleOf = ({ size }) => Math.min(wide / (size[0] + 2 * GAP), high / (size[1] + 2 * GAP));
  return tried.reduce((best, one) => (scaleOf(one) > scaleOf(best) ? one : best)).offsets;
}

/** @param {number[][]} boxes of the panels @param {number} width of the sheet [mm] @returns {{offsets: number[][], size: number[]}} */
function fillShelves(boxes, width) {
  const order = boxes.map((_, n) => n).sort((a, b) => boxes[b][3] - boxes[b][1] - (boxes[a][3] - boxes[a][1]) || a - b);
  const offsets = [], size = [0, 0];
  let x = 0, y = 0, high = 0;
  for (const n of order) {
    const [left, bottom, right, top] = boxes[n];
    if (x > 0 && x + right - left > width) [x, y, high] = [0, y + high + GAP, 0];
    offsets[n] = [x - left, y + top];
    size[0] = Math.max(size[0], x + right - left);
    x += right - left + GAP;
    high = Math.max(high, top - bottom);
    size[1] = Math.max(size[1], y + high);
  }
  return { offsets, size };
}
