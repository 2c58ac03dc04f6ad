// The matcher's page.

import { find, showError } from '../dom.js';
import { offerPatterns } from './choose.js';
import { Pairing } from './pairing.js';
import { Rows, speak } from './rows.js';
import { asCsv, asJson, asPairs, save } from './save.js';
import { drawOverlay, drawTable } from './table.js';

const problem = find('#problem'), { a, b } = find('#choose').dataset;

/** Run a function, and show its error if it fails. @param {() => unknown} work */
async function attempt(work) {
  try {
    problem.replaceChildren();
    await work();
  } catch (error) {
    showError(problem, error);
  }
}

/** Show two patterns. @param {string} first @param {string} second */
async function start(first, second) {
  const pairing = new Pairing(first, second);
  let seen = 0;
  const rows = new Rows(find('#rows'), pairing, update);
  const look = (index) => { seen = index; show(); };

  function update() {
    const [one, other] = rows.chosen;
    find('#pair').disabled = !one || !other;
    find('#part').disabled = ![0, 1].some((row) => rows.chosen[row] && pairing.find(row, rows.chosen[row]) >= 0);
    find('#left').disabled = find('#right').disabled = !one && !other;
  }

  function show() {
    seen = Math.min(seen, pairing.pairs.length - 1);
    rows.show();
    drawTable(find('#pairs'), pairing, { choose, look, seen });
    drawOverlay(find('#overlay'), pairing, seen);
    find('#summary').textContent = summarise(pairing);
    update();
  }

  const choose = (one, other) => attempt(() => (other ? pairTwo(one, other) : pairing.part(0, one)));
  const pairTwo = async (one, other) => {
    await pairing.pair(one, other);
    look(pairing.find(0, one));
  };
  const pairChosen = () => rows.chosen.every(Boolean) && attempt(() => pairTwo(rows.chosen[0], rows.chosen[1]));
  const partChosen = () => [0, 1].forEach((row) => rows.chosen[row] && pairing.part(row, rows.chosen[row]));

  await pairing.propose(new URLSearchParams(location.search).getAll('pair'));
  find('#working').hidden = true;
  find('#match').hidden = false;
  rows.layOut();
  show();
  pairing.addEventListener('change', () => {
    const given = pairing.pairs.filter((pair) => pair.paired_by === 'given').map((pair) => ['pair', `${pair.first}:${pair.second}`]);
    history.replaceState(null, '', `/match?${new URLSearchParams([['a', first], ['b', second], ...given])}`);
    show();
  });
  const clicks = {
    pair: pairChosen, part: partChosen, left: () => rows.turn(-15), right: () => rows.turn(15), reset: () => rows.reset(),
    propose: () => attempt(() => pairing.propose()),
    'save-csv': () => save('match.csv', asCsv(pairing), 'text/csv'),
    'save-json': () => save('match.json', asJson(pairing), 'application/json'),
    'save-pairs': () => save('pairs.json', asPairs(pairing), 'application/json'),
  };
  for (const [id, does] of Object.entries(clicks)) find(`#${id}`).addEventListener('click', does);
  find('#rows').addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === 'p' || event.key === 'P') pairChosen();
    if (event.key === 'u' || event.key === 'U') partChosen();
  });
  find('#match').dataset.ready = 'true';
}

/** @param {Pairing} pairing @returns {string} */
function summarise(pairing) {
  const count = pairing.pairs.length, mean = pairing.pairs.reduce((sum, pair) => sum + pair.turning, 0) / count;
  const alone = [0, 1].map((row) => pairing.alone(row)).map((names, row) => (names.length
    ? ` Only in the ${row ? 'second' : 'first'}: ${names.map(speak).join(', ')}.` : ''));
  return (count ? `${count} ${count === 1 ? 'pair' : 'pairs'}, mean turning distance ${mean.toFixed(4)} rad.` : 'No pairs.')
    + alone.join('');
}

find('#working').hidden = !(a && b);
await attempt(() => Promise.all([offerPatterns(problem), a && b ? start(a, b) : null]));
find('#working').hidden = true;
