// The page of a person's labels.

import { getBytes, postJson, uploadFile } from '../api.js';
import { find, make, showError } from '../dom.js';
import { findEnclosed } from './lasso.js';
import { mirror } from './mirror.js';
import { writeNpy } from './npy.js';
import { Painting } from './painting.js';
import { readScan } from './scan.js';
import { LabelView } from './view.js';

const root = find('#labels'), problem = find('#problem'), said = find('#said');
const { job } = root.dataset, told = JSON.parse(root.dataset.told);
const words = new Map(told.parts.map(({ value, word }) => [value, word]));

/** How far a press of a button moves a ring [m]. */
const RING_STEP = 0.005;

/** How far the pointer moves from one corner of an outline to the next [px]. */
const CORNER_STEP = 3;

/** Run a function, and show its error if it fails. @param {() => unknown} work */
async function attempt(work) {
  try {
    problem.replaceChildren();
    return await work();
  } catch (error) {
    showError(problem, error);
  }
}

const chosen = (name) => find(`input[name="${name}"]:checked`, root).value;
const say = (text) => { said.textContent = text; };
const radius = () => Number(find('#radius').value) / 1000;

/** Show the parts' colours where they are chosen. */
for (const { value, colour } of told.parts) {
  const [r, g, b] = colour.map((part) => Math.round(255 * part));
  find(`.swatch[data-part="${value}"]`).style.background = `rgb(${r} ${g} ${b})`;
}
const [unsure, sure] = [told.unsure, told.sure].map((rgb) => `rgb(${rgb.map((part) => Math.round(255 * part)).join(' ')})`);
find('.bar').style.background = `linear-gradient(to right, ${unsure}, ${sure})`;

/** @param {Painting} painting @param {LabelView} view */
function connect(painting, view) {
  const { canvas } = view, count = (n) => n.toLocaleString('en');
  const use = { brush, fill, ring };
  let isPainting = false;
  /** @type {[number, number][]|null} the corners of the outline that is drawn [px] */
  let outline = null;

  function show() {
    view.show();
    const { changed } = painting;
    find('#changed').textContent = changed ? `${count(changed)} of ${count(painting.scan.count)} points are changed.` : 'Nothing is changed.';
    const { all, unsure } = painting.count();
    for (const { value } of told.parts) {
      find(`[data-count="${value}"]`).textContent = count(all[value]);
      find(`[data-unsure="${value}"]`).textContent = unsure[value] ? `${count(unsure[value])} unsure` : '';
    }
    if (painting.scan.confidence) find('#unsure').textContent = `${count(unsure.reduce((sum, n) => sum + n))} points have a confidence of 0.5 or less.`;
    find('#mirror-last').disabled = !painting.chosen;
    find('#undo').disabled = !painting.done.length;
    find('#redo').disabled = !painting.undone.length;
    find('#again').disabled = !changed;
    find('#up').disabled = find('#down').disabled = !painting.ring;
  }

  function brush(hit) {
    painting.brush(hit.at, hit.vertex, radius(), Number(chosen('part')));
  }

  function fill(hit) {
    painting.begin();
    const old = words.get(painting.label[hit.vertex]);
    painting.fill(hit.vertex, Number(chosen('part')));
    painting.end();
    say(`The filled points were ${old} and are now ${words.get(Number(chosen('part')))}.`);
  }

  function ring(hit) {
    const found = painting.chooseRing(hit.vertex);
    say(found ? `The border of ${words.get(found.high)} above and ${words.get(found.low)} below is chosen; move it up or down.`
      : 'There is no border within 8 cm; press nearer to one.');
    show();
  }

  function moveRing(by) {
    if (!painting.ring) return;
    painting.moveRing(by);
    const { offset, high, low } = painting.ring, mm = Math.round(1000 * offset);
    say(`The border of ${words.get(high)} and ${words.get(low)} is ${mm ? `${Math.abs(mm)} mm ${mm > 0 ? 'above' : 'below'} where it was` : 'where it was'}.`);
    show();
  }

  /** Add a corner to the outline. @param {PointerEvent} event */
  function draw(event) {
    const box = canvas.getBoundingClientRect(), at = [event.clientX - box.left, event.clientY - box.top], last = outline.at(-1);
    if (!last || Math.hypot(at[0] - last[0], at[1] - last[1]) >= CORNER_STEP) outline.push(at);
    showOutline();
  }

  function showOutline() {
    for (const line of find('#outline').children) line.setAttribute('points', (outline ?? []).join(' '));
  }

  /** Paint what the outline encloses. */
  function enclose() {
    const points = findEnclosed(outline, painting.scan, view.screen), word = words.get(Number(chosen('part')));
    outline = null;
    showOutline();
    painting.enclose(points, Number(chosen('part')));
    say(points.length ? `The ${count(points.length)} visible points of the outline are ${word}.` : 'There is no point in the outline.');
  }

  /** Copy labels to the other side. @param {{from: 1|-1}|{chosen: ArrayLike<number>}} source */
  function copyAcross(source) {
    const { points, values, missing } = mirror(painting, told.plane, source), before = painting.label.slice();
    painting.assign(points, values);
    const changed = points.filter((n) => painting.label[n] !== before[n]).length;
    say(`${count(changed)} points on the other side are changed.${source.from && missing ? ` ${count(missing)} have no counterpart within 4 cm and stay as they were.` : ''}`);
  }

  /** Use the tool at a place on the screen. @param {{clientX: number, clientY: number}} place */
  function work(place) {
    const hit = view.pick(place);
    if (hit) use[chosen('tool')]?.(hit);
    return hit;
  }

  canvas.addEventListener('pointerdown', (event) => {
    if (event.button || chosen('tool') === 'look' || !event.isPrimary) return;
    canvas.focus();
    if (chosen('tool') === 'lasso') {
      outline = [];
      canvas.setPointerCapture(event.pointerId);
      draw(event);
      return;
    }
    if (chosen('tool') === 'brush') {
      painting.begin();
      isPainting = true;
      canvas.setPointerCapture(event.pointerId);
    }
    work(event);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (outline && event.isPrimary) draw(event);
    if (chosen('tool') !== 'brush') return;
    const hit = isPainting ? work(event) : view.pick(event);
    view.setBrush(hit?.at ?? null, radius());
  });
  const stop = () => {
    if (isPainting) painting.end();
    isPainting = false;
  };
  const drop = () => {
    outline = null;
    showOutline();
  };
  canvas.addEventListener('pointerdown', (event) => { if (outline && !event.isPrimary) drop(); }); // a second finger moves the view
  canvas.addEventListener('pointerup', (event) => {
    stop();
    if (outline && event.isPrimary) enclose();
  });
  canvas.addEventListener('pointercancel', () => {
    stop();
    drop();
  });
  canvas.addEventListener('pointerleave', () => view.setBrush(null, radius()));
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('focus', () => { root.dataset.focused = 'true'; });
  canvas.addEventListener('blur', () => { delete root.dataset.focused; });

  const keys = {
    ' ': () => {
      if (chosen('tool') === 'lasso') return say('An outline is drawn with the pointer; brush, fill and ring work at the cross.');
      if (chosen('tool') === 'brush') painting.begin();
      if (!work(view.middle)) say('There is nothing at the cross.');
      if (chosen('tool') === 'brush') painting.end();
    },
    PageUp: () => moveRing(RING_STEP), PageDown: () => moveRing(-RING_STEP),
  };
  canvas.addEventListener('keydown', (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  const choose = (name, value) => {
    const input = find(`input[name="${name}"][value="${value}"]`, root);
    input.checked = true;
    input.dispatchEvent(new Event('change', { bubbles: true }));
  };
  const widen = (by) => {
    find('#radius').value = String(Number(find('#radius').value) + by);
    find('#radius').dispatchEvent(new Event('input'));
  };
  const letters = { l: () => choose('tool', 'look'), b: () => choose('tool', 'brush'), f: () => choose('tool', 'fill'), r: () => choose('tool', 'ring'), o: () => choose('tool', 'lasso'),
    '[': () => widen(-5), ']': () => widen(5) };
  told.parts.forEach(({ value }, n) => { letters[n + 1] = () => choose('part', value); });
  // Keys work wherever the page has the focus, but where text is entered.
  document.addEventListener('keydown', (event) => {
    if (event.target.matches('input:not([type=radio], [type=range]), textarea, select')) return;
    const key = event.key.toLowerCase(), isCommand = event.ctrlKey || event.metaKey;
    if (isCommand && (key === 'z' || key === 'y')) {
      if (key === 'y' || event.shiftKey) painting.redo();
      else painting.undo();
    } else if (!isCommand && !event.altKey && letters[key]) letters[key]();
    else return;
    event.preventDefault();
  });

  root.addEventListener('change', (event) => {
    if (event.target.name === 'colours') {
      view.style = event.target.value;
      find('.scale').hidden = view.style !== 'confidence';
      view.show();
    }
    if (event.target.name === 'tool') setTool();
  });
  function setTool() {
    const tool = chosen('tool');
    root.dataset.tool = tool;
    view.setLooking(tool === 'look');
    view.setBrush(null, radius());
    for (const own of root.querySelectorAll('.own')) own.hidden = own.dataset.tool !== tool;
  }
  find('#radius').addEventListener('input', () => { find('#radius-mm').textContent = `${find('#radius').value} mm`; });
  for (const button of root.querySelectorAll('[data-view]')) {
    button.addEventListener('click', () => view.viewer.face(Number(button.dataset.view) * Math.PI / 180));
  }
  find('#undo').addEventListener('click', () => painting.undo());
  find('#redo').addEventListener('click', () => painting.redo());
  find('#mirror-last').addEventListener('click', () => copyAcross({ chosen: painting.chosen }));
  find('#mirror-left').addEventListener('click', () => copyAcross({ from: 1 }));
  find('#mirror-right').addEventListener('click', () => copyAcross({ from: -1 }));
  find('#mirror').hidden = !told.plane;
  find('#up').addEventListener('click', () => moveRing(RING_STEP));
  find('#down').addEventListener('click', () => moveRing(-RING_STEP));
  find('#again').addEventListener('click', () => attempt(() => runAgain(painting)));
  painting.addEventListener('change', show);
  setTool();
  show();
}

/** Submit the labels, and show the job that labels the scan with them. @param {Painting} painting */
async function runAgain(painting) {
  const file = new File([writeNpy(painting.label)], 'points.npy');
  const { sha256 } = await uploadFile('labels', file);
  const made = await postJson(`/v1/jobs/${job}/labels`, { points: sha256 });
  find('#made').replaceChildren(make('p', {}, made.is_new ? 'A new job labels the scan with these corrections: ' : 'There is a job with these labels: ',
    make('a', { href: `/jobs/${made.job}` }, made.job)));
}

await attempt(async () => {
  const scan = readScan(await getBytes(`/v1/jobs/${job}/artifacts/segmented.ply`));
  const painting = new Painting(scan), view = new LabelView(find('#scene'), painting, told);
  if (!scan.confidence) find('input[value="confidence"]', root).disabled = true;
  connect(painting, view);
  Object.assign(root, { painting, view }); // for the browser's console
  say(`${scan.count.toLocaleString('en')} points${scan.faces.length ? '' : ' of a cloud'}.`);
  root.dataset.ready = 'true';
});
if (!root.dataset.ready) say('The scan is not shown. garmentq segment writes its labels as a file that other programs can correct.');
