// Two rows of pieces: chosen by click or Enter, moved by dragging or arrows, turned by a handle or keys.

import { draw } from '../dom.js';
import { boxOf, layOut, pathOf } from './geometry.js';

/** Free space between pieces [m], where a row ends on a wide and on a narrow screen [m], and below which it is narrow [px]. */
const GAP = 0.06, WIDE = 2.8, NARROW = 1.3, NARROW_PX = 700;

/** @param {string} name of a panel @returns {string} the same in words */
export const speak = (name) => name.replaceAll('_', ' ');

/** @param {string} text @param {number} most letters of a line @returns {string[]} its lines; a longer word is a line of its own */
function breakWords(text, most) {
  const lines = [];
  for (const word of text.split(' ')) {
    if (lines.length && `${lines.at(-1)} ${word}`.length <= most) lines.push(`${lines.pop()} ${word}`);
    else lines.push(word);
  }
  return lines;
}

/** How far an arrow moves a piece [mm], and a key turns it [degrees]; with Shift the second. */
const STEPS_MM = [10, 1], STEPS_DEGREES = [5, 1];

/** Radius of the handle [mm], width of a letter over its height, and the shares of a piece's width and height that its text may take. */
const HANDLE = 22, LETTER = 0.6, FILLED = [0.8, 0.65];

/**
 * A piece as it lies on the page.
 * @typedef {{row: number, name: string, x: number, y: number, turn: number, home: [number, number], high: number,
 *   element: SVGElement, body: SVGElement}} Piece
 */

/** Draws both rows, and keeps where each piece lies and which are chosen. */
export class Rows {
  /** @param {HTMLElement} place @param {import('./pairing.js').Pairing} pairing @param {() => void} told of a choice */
  constructor(place, pairing, told) {
    this.place = place;
    this.pairing = pairing;
    this.told = told;
    /** @type {Piece[]} */
    this.pieces = [];
    /** @type {(string|null)[]} the chosen piece of each row */
    this.chosen = [null, null];
  }

  /** Lay all pieces out anew. */
  layOut() {
    const width = this.place.clientWidth < NARROW_PX ? NARROW : WIDE;
    const rows = this.pairing.outlines.map((outlines) => {
      const boxes = Object.values(outlines).map(boxOf);
      return { outlines, boxes, ...layOut(boxes.map((box) => box.size), GAP, Math.max(width, ...boxes.map((b) => b.size[0]))) };
    });
    const wide = 1e3 * Math.max(...rows.map((row) => row.size[0]));
    const high = 1e3 * (rows[0].size[1] + rows[1].size[1]);
    this.svg = draw('svg', { viewBox: `0 0 ${wide} ${high}`, class: 'pieces', role: 'group', preserveAspectRatio: 'xMinYMid meet', 'aria-label': 'Pieces of both patterns' });
    this.svg.append(draw('line', { x1: 0, x2: wide, y1: 1e3 * rows[0].size[1], y2: 1e3 * rows[0].size[1], class: 'between' }));
    this.letter = wide / (width === NARROW ? 26 : 70);
    this.pieces = [];
    rows.forEach((row, index) => this.#drawRow(row, index, index ? 1e3 * rows[0].size[1] : 0));
    this.handle = draw('g', { class: 'handle', visibility: 'hidden' }, draw('circle', { r: HANDLE }), draw('title'));
    this.handle.lastElementChild.textContent = 'Drag to turn the piece';
    this.handle.addEventListener('pointerdown', (event) => this.#turnByHand(event));
    this.svg.append(this.handle);
    this.place.replaceChildren(this.svg);
    this.show();
  }

  /** @param {any} row @param {number} index @param {number} top [mm] */
  #drawRow(row, index, top) {
    Object.entries(row.outlines).forEach(([name, outline], n) => {
      const { middle, size } = row.boxes[n];
      const shifted = outline.map(([x, y]) => /** @type {[number, number]} */ ([x - middle[0], y - middle[1]]));
      const home = /** @type {[number, number]} */ ([1e3 * row.places[n][0], top + 1e3 * row.places[n][1]]);
      const body = draw('path', { d: pathOf(shifted) });
      const lines = breakWords(speak(name), FILLED[0] * 1e3 * size[0] / (LETTER * this.letter)), longest = Math.max(...lines.map((line) => line.length));
      const letter = Math.min(this.letter, FILLED[0] * 1e3 * size[0] / (LETTER * longest), FILLED[1] * 1e3 * size[1] / (lines.length + 1));
      const first = (0.7 - (lines.length + 1) / 2) * letter;
      const label = draw('text', { 'font-size': letter, y: first + 1.1 * letter }, ...lines.map((_, k) => draw('tspan', { x: 0, dy: k ? 1.1 * letter : 0 })));
      lines.forEach((line, k) => { label.children[k].textContent = k ? ` ${line}` : line; });
      const number = draw('text', { 'font-size': letter, y: first, class: 'number' });
      const element = draw('g', { class: 'piece', tabindex: 0, role: 'button', 'data-row': index, 'data-name': name }, body,
        number, label);
      const piece = { row: index, name, x: home[0], y: home[1], turn: 0, home, high: 500 * size[1], element, body };
      element.addEventListener('pointerdown', (event) => this.#moveByHand(event, piece));
      element.addEventListener('keydown', (event) => this.#press(event, piece));
      this.pieces.push(piece);
      this.svg.append(element);
    });
  }

  /** Show where pieces lie, which are chosen, and the colour and number of each pair. */
  show() {
    for (const piece of this.pieces) {
      const index = this.pairing.find(piece.row, piece.name), pair = this.pairing.pairs[index];
      const isChosen = this.chosen[piece.row] === piece.name;
      const other = pair && (piece.row ? pair.first : pair.second);
      const colour = index < 0 ? null : this.pairing.colour(index);
      piece.element.setAttribute('transform', `translate(${piece.x.toFixed(2)} ${piece.y.toFixed(2)})`);
      piece.body.setAttribute('transform', `rotate(${piece.turn})`);
      piece.element.setAttribute('aria-pressed', String(isChosen));
      piece.element.setAttribute('data-turn', String(piece.turn));
      piece.element.setAttribute('data-pair', String(index));
      piece.element.setAttribute('aria-label', `${piece.row ? 'Second' : 'First'} pattern, ${piece.name}, `
        + (pair ? `pair ${index + 1} with ${other}` : 'without a counterpart'));
      piece.element.querySelector('.number').textContent = index < 0 ? '' : String(index + 1);
      piece.element.style.setProperty('--pair', colour ?? 'var(--soft)');
    }
    const last = this.pieces.find((piece) => piece.row === this.lastRow && this.chosen[piece.row] === piece.name);
    this.handle?.setAttribute('visibility', last ? 'visible' : 'hidden');
    if (last) {
      const turn = last.turn * Math.PI / 180, away = Math.max(0, last.high - HANDLE);
      this.handle.setAttribute('transform', `translate(${last.x + Math.sin(turn) * away} ${last.y - Math.cos(turn) * away})`);
    }
  }

  /** Choose a piece, or where it is chosen, no longer. @param {number} row @param {string} name */
  choose(row, name) {
    this.chosen[row] = this.chosen[row] === name ? null : name;
    this.lastRow = row;
    this.show();
    this.told();
  }

  /** Choose none. */
  clear() {
    this.chosen = [null, null];
    this.show();
    this.told();
  }

  /** Turn the chosen pieces. @param {number} degrees clockwise */
  turn(degrees) {
    this.#ofChosen((piece) => { piece.turn = (piece.turn + degrees + 360) % 360; });
  }

  /** Put the chosen pieces back where they lay; all where none is chosen. */
  reset() {
    const back = (piece) => { [piece.x, piece.y] = piece.home, piece.turn = 0; };
    if (this.chosen.some(Boolean)) this.#ofChosen(back);
    else this.pieces.forEach(back), this.show();
  }

  /** @param {(piece: Piece) => void} change */
  #ofChosen(change) {
    this.pieces.filter((piece) => this.chosen[piece.row] === piece.name).forEach(change);
    this.show();
  }

  /** @param {PointerEvent} event @returns {DOMPoint} where it is in the drawing [mm] */
  #where(event) {
    return new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
  }

  /** Follow a pointer until it is released. @param {PointerEvent} event @param {(at: DOMPoint) => void} moved */
  #follow(event, moved, ended = () => {}) {
    const target = /** @type {Element} */ (event.currentTarget), stop = new AbortController(), { signal } = stop;
    target.setPointerCapture(event.pointerId);
    target.addEventListener('pointermove', (next) => moved(this.#where(/** @type {PointerEvent} */ (next))), { signal });
    const end = () => { stop.abort(); ended(); };
    target.addEventListener('pointerup', end, { signal });
    target.addEventListener('pointercancel', end, { signal });
  }

  /** @param {PointerEvent} event @param {Piece} piece */
  #moveByHand(event, piece) {
    if (event.button) return;
    event.preventDefault();
    this.svg.insertBefore(piece.element, this.handle); // above all others; before the focus, which that would take away
    piece.element.focus();
    const start = this.#where(event), from = [piece.x, piece.y];
    let isMoved = false;
    this.#follow(event, (at) => {
      isMoved ||= Math.hypot(at.x - start.x, at.y - start.y) > 4;
      if (!isMoved) return;
      [piece.x, piece.y] = [from[0] + at.x - start.x, from[1] + at.y - start.y];
      this.show();
    }, () => isMoved || this.choose(piece.row, piece.name));
  }

  /** @param {PointerEvent} event */
  #turnByHand(event) {
    const piece = this.pieces.find((one) => one.row === this.lastRow && this.chosen[one.row] === one.name);
    if (!piece) return;
    event.preventDefault();
    this.#follow(event, (at) => {
      const angle = Math.atan2(at.x - piece.x, piece.y - at.y) * 180 / Math.PI;
      piece.turn = (Math.round(angle) + 360) % 360;
      this.show();
    });
  }

  /** @param {KeyboardEvent} event @param {Piece} piece */
  #press(event, piece) {
    const fine = event.shiftKey ? 1 : 0;
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const turn = { ',': -1, '<': -1, ';': -1, '.': 1, '>': 1, ':': 1 }[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === 'Enter' || event.key === ' ') this.choose(piece.row, piece.name);
    else if (event.key === 'Escape') this.clear();
    else if (move) piece.x += STEPS_MM[fine] * move[0], piece.y += STEPS_MM[fine] * move[1];
    else if (turn) piece.turn = (piece.turn + STEPS_DEGREES[fine] * turn + 360) % 360;
    else return;
    event.preventDefault();
    this.show();
  }
}
