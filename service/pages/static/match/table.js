// The table of pairs with a choice of counterpart for each piece, and the overlay of one pair.

import { draw, make } from '../dom.js';
import { boxOf, pathOf, place } from './geometry.js';
import { speak } from './rows.js';

const HEADS = ['', 'first', 'second', 'paired by', 'turning rad', 'area %', 'outline mm', ''];

/** @param {number} value @param {number} digits @returns {string} */
const show = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);

/**
 * Draw the table.
 * @param {HTMLElement} table @param {import('./pairing.js').Pairing} pairing
 * @param {{choose: (first: string, second: string) => void, look: (index: number) => void, seen: number}} does
 */
export function drawTable(table, pairing, does) {
  const focused = document.activeElement?.id;
  const rows = pairing.pairs.map((pair, index) => drawRow(pairing, pair.first, index, does));
  rows.push(...pairing.alone(0).map((name) => drawRow(pairing, name, -1, does)));
  const head = make('tr', {}, ...HEADS.map((name, n) => make(n > 3 && name ? 'th.number' : name ? 'th' : 'td', {}, name)));
  table.replaceChildren(make('thead', {}, head), make('tbody', {}, ...rows));
  if (focused?.startsWith('with-')) document.getElementById(focused)?.focus();
}

/** @param {import('./pairing.js').Pairing} pairing @param {string} name @param {number} index @param {any} does */
function drawRow(pairing, name, index, does) {
  const pair = pairing.pairs[index], places = Object.keys(pairing.outlines[0]);
  const options = ['', ...Object.keys(pairing.outlines[1])].map((other) => make('option',
    { value: other, selected: other === (pair?.second ?? '') }, speak(other) || 'no counterpart'));
  const choice = make('select', { id: `with-${places.indexOf(name)}`, 'aria-label': `Counterpart of ${name}`,
    onchange: (event) => does.choose(name, event.target.value) }, ...options);
  const swatch = draw('svg', { viewBox: '0 0 10 10', class: 'swatch', 'aria-hidden': 'true' },
    ...(pair ? [draw('rect', { width: 10, height: 10 })] : []));
  if (pair) swatch.style.setProperty('--pair', pairing.colour(index));
  const look = pair && make('button', { type: 'button', 'aria-pressed': String(does.seen === index),
    'aria-label': `Overlay of ${pair.first} and ${pair.second}`, onclick: () => does.look(index) }, 'Overlay');
  const numbers = pair ? [show(pair.turning, 4), show(pair.area_percent, 2), show(pair.outline_mm, 2)] : ['', '', ''];
  return make('tr', { 'data-first': name, 'data-second': pair?.second ?? '' },
    make('td', {}, swatch, pair ? ` ${index + 1}` : null), make('td', {}, speak(name)), make('td', {}, choice),
    make('td', { 'data-head': HEADS[3] }, pair?.paired_by ?? ''),
    ...numbers.map((text, n) => make('td.number', { 'data-head': HEADS[4 + n] }, text)), make('td', {}, look ?? null));
}

/**
 * Draw a pair upon each other, as the best fit lays them.
 * @param {HTMLElement} where @param {import('./pairing.js').Pairing} pairing @param {number} index
 */
export function drawOverlay(where, pairing, index) {
  const pair = pairing.pairs[index];
  if (!pair) {
    where.replaceChildren(make('p.soft', {}, 'No pair is chosen.'));
    return;
  }
  const first = place(pairing.outlines[0][pair.first], pair), second = pairing.outlines[1][pair.second];
  const { low, high, size } = boxOf([...first, ...second]), edge = 0.03 * Math.max(...size);
  const box = [low[0] - edge, -high[1] - edge, size[0] + 2 * edge, size[1] + 2 * edge].map((value) => (1e3 * value).toFixed(1));
  const svg = draw('svg', { viewBox: box.join(' '), class: 'overlay', role: 'img',
    'aria-label': `${pair.first} of the first pattern upon ${pair.second} of the second` },
  draw('path', { d: pathOf(second), class: 'under' }), draw('path', { d: pathOf(first), class: 'over' }));
  svg.style.setProperty('--pair', pairing.colour(index));
  where.replaceChildren(svg, make('p', {}, `${speak(pair.first)} (coloured, dashed) upon ${speak(pair.second)} (grey)`
    + `${pair.turned_over ? ', turned over' : ''}: the outlines are ${show(pair.outline_mm, 2)} mm apart (RMS), the first is `
    + `${show(Math.abs(pair.area_percent), 2)} % ${pair.area_percent < 0 ? 'smaller' : 'larger'}.`));
}
