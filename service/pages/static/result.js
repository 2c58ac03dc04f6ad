// A result: its meshes in 3D beside its pattern, each pointing into the other.
import { followJob, getBytes, getJson, postJson } from './api.js';
import { startCamera } from './camera_tools.js';
import { find, make, showError } from './dom.js';
import { readFrames } from './frames.js';
import { computeStrain, flatten, lift, locate, measureEdge, spreadToNodes } from './garment.js';
import { PatternView } from './pattern_view.js';
import { offerRefinement } from './refine.js';
import { offerShares } from './share.js';
import { readShown } from './shown.js';
import { Viewer, colourOf, linearOf, paint } from './viewer.js';

const COLOURS = { detail: 0x6694bd, simulation: 0x7aa894, redrape: 0xb89e75, graded: 0x9a8fc0, dressed: 0x6694bd, under: 0xb89e75, 'upper/dressed': 0x7aa894, 'outer/dressed': 0xb89e75, garment: 0x6694bd, body: 0xe6d9cc, scan: 0x9ea8b3, person: 0x9ea8b3 };

/** Ends of the colours where the values themselves do not tell: the report's least range [m], 10 % of stretch, 3 kPa. */
const LEAST = { distance: 0.005, inferred: 1, strain: 0.1, pressure: 3000 };
const UNITS = { distance: (value) => `${(1000 * value).toFixed(1)} mm`, inferred: () => 'inferred', strain: (value) => `${(100 * value).toFixed(0)} % longer`, pressure: (value) => `${(value / 1000).toFixed(1)} kPa` };

const place = find('#result');
const job = place.getAttribute('data-job');
/** Address below which meshes and pattern are sent. */
const base = place.getAttribute('data-base');
const files = new Set(place.getAttribute('data-files').split(' '));
const boxes = [...document.querySelectorAll('input[data-mesh]')];
/** Names of what is no cloth of this pattern: wearers, scans, a garment below. */
const BESIDE = new Set(boxes.filter((box) => 'beside' in box.dataset).map((box) => box.dataset.mesh));
/** @type {Map<string, import('./shown.js').ShownMesh>} */ const meshes = new Map();
/** @type {Viewer|null} */ let viewer = null;
/** @type {PatternView|null} */ let pattern = null;
/** @type {import('./garment.js').Garment|null} */ let garment = null;
/** Edges that are measured, each with the part that is: [edge, from, to]. */ let measured = [];

/** @param {string} name @returns {Promise<ArrayBuffer>} */
const load = (name) => getBytes(`/v1/jobs/${job}/artifacts/${name}`);

/** Where each scan lies, which is asked for when it is to be shown. */
const SCANS = { scan: `${base}/scan.bin`, person: `/results/${place.getAttribute('data-person')}/scan.bin` };

/** @returns {string|null} the cloth that is pointed at and measured: the first that is shown */
function shownCloth() {
  return boxes.find((box) => box.checked && !BESIDE.has(box.dataset.mesh) && meshes.has(box.dataset.mesh))?.dataset.mesh ?? null;
}

/** Give a mesh to the view when it is first shown. @param {string} name @returns {Promise<void>} */
async function showMesh(name) {
  if (!meshes.has(name) && SCANS[name]) meshes.set(name, readShown(await getBytes(SCANS[name])).meshes.get('scan'));
  const mesh = meshes.get(name);
  if (!mesh || viewer.meshes.has(name)) return;
  const isCloth = !BESIDE.has(name);
  viewer.add(name, mesh.positions, mesh.faces, { colour: COLOURS[name.split('_')[0]], isCloth, colours: isCloth ? null : mesh.colours });
}

/** What the page may lack, such as pictures, exports or the 3D view. @param {string} selector @param {(element: any) => void} use */
function ifThere(selector, use) {
  const element = document.querySelector(selector);
  if (element) use(element);
}

/** Show the stored pictures where there is no WebGL. */
function showPictures() {
  ifThere('#pictures', (pictures) => { pictures.hidden = false; });
  ifThere('#space', (space) => { space.closest('section').hidden = true; });
}

/** Make the 3D view; false where the browser has none. */
function startViewer() {
  try {
    viewer = new Viewer(find('#space'));
    return true;
  } catch {
    showPictures();
    return false;
  }
}

/** @param {string} style @param {string} name @returns {Float32Array|null} the numbers that colour a mesh */
function valuesOf(style, name) {
  const mesh = meshes.get(name);
  if (style !== 'strain' || mesh.values.strain) return mesh.values[style] ?? null;
  return garment ? spreadToNodes(garment, computeStrain(garment, mesh.positions), mesh.positions.length / 3) : null;
}

/** @returns {Uint8Array|null} the colours that the scan shows at the garment's vertices: those of the detail mesh, which lies on it */
const texture = () => meshes.get('detail')?.colours ?? null;

/** @param {string} style @returns {boolean} whether the result has what colours its cloth so */
function isColouredBy(style) {
  if (style === 'texture') return Boolean(texture());
  return !(style in LEAST) || [...meshes.keys()].some((name) => !BESIDE.has(name) && (style === 'strain' && garment ? true : valuesOf(style, name)?.some(Boolean)));
}

/** Colour the cloth as chosen, with what the colours mean. */
function colourCloth() {
  const style = find('#style').value, shown = shownCloth();
  const values = style in LEAST && shown ? valuesOf(style, shown) : null;
  let end = LEAST[style] ?? 1;
  if (values) end = Math.max(end, Float32Array.from(values).sort()[Math.floor(0.99 * (values.length - 1))]);
  const colours = style === 'texture' ? linearOf(texture()) : null;
  viewer.colour(style, (name) => colours ?? (valuesOf(style, name) && paint(valuesOf(style, name), end)));
  find('#colours').hidden = !values;
  if (values) find('#end').textContent = UNITS[style](end);
  find('#unseen').hidden = style !== 'texture';
}

/** Draw the bar of colours once. */
function drawBar() {
  const bar = find('#bar'), context = bar.getContext('2d');
  for (let x = 0; x < bar.width; x += 1) {
    context.fillStyle = `rgb(${colourOf(x / bar.width).map((part) => Math.round(255 * part)).join(' ')})`;
    context.fillRect(x, 0, 1, bar.height);
  }
}

/** Leave out the colours that this result has nothing for, and say why there is no texture. */
function trimStyles() {
  for (const option of [...find('#style').options]) if (!isColouredBy(option.value)) option.remove();
  find('#uncoloured').hidden = Boolean(texture()) || find('#style').closest('label').hidden;
}

/** Listen to what is above the 3D view. */
function startTools() {
  for (const box of boxes) {
    box.addEventListener('change', async () => {
      const name = box.dataset.mesh, told = find('#loading');
      told.textContent = meshes.has(name) ? '' : 'Loading…';
      try {
        await showMesh(name);
        told.textContent = '';
      } catch (error) {
        showError(told, error);
        return;
      }
      viewer.show(name, box.checked);
      if (!BESIDE.has(name)) colourCloth();
      tellMeasured();
    });
  }
  find('#style').addEventListener('change', colourCloth);
  find('#wireframe').addEventListener('change', (event) => viewer.setWireframe(event.target.checked));
  startCamera(viewer, (angle) => viewer.frame(angle));
}

/** Point from the pattern into space, and back. */
function startPointing() {
  const pointed = find('#pointed');
  pattern.svg.addEventListener('pointermove', (event) => {
    const at = pattern.find(event), cloth = shownCloth();
    const found = at && locate(garment, at.panel, at.x, at.y);
    pattern.setMark(null);
    if (!viewer || !found || !cloth) {
      viewer?.setMark(null);
      return;
    }
    const point = lift(garment, meshes.get(cloth).positions, found);
    viewer.setMark(point);
    place.dataset.marked = JSON.stringify(point);
    if (!event.target.matches('.hold')) pointed.textContent = `${garment.panels[at.panel].name}, ${Math.round(1000 * point[1])} mm above the ground`;
  });
  pattern.svg.addEventListener('pointerleave', () => viewer?.setMark(null));
  viewer?.renderer.domElement.addEventListener('pointermove', (event) => {
    if (event.buttons) return;
    const cloth = shownCloth(), hit = cloth && viewer.pick(cloth, event);
    viewer.setMark(hit ? hit.point : null);
    if (!hit) {
      pattern.setMark(null);
      return;
    }
    const panel = garment.panelOfUv[garment.uvFaces[3 * hit.face]], flat = flatten(garment, hit);
    pattern.setMark(panel, flat);
    place.dataset.flat = JSON.stringify([panel, ...flat]);
    pointed.textContent = garment.panels[panel].name;
  });
}

/** @param {import('./garment.js').Edge} edge @returns {Float32Array} its points on the cloth that is shown [m] */
function curveOf(edge, from, to) {
  const { positions } = meshes.get(shownCloth());
  return Float32Array.from(edge.uv.slice(Math.min(from, to), Math.max(from, to) + 1)
    .reduce((points, vertex) => points.concat(Array.from(positions.subarray(3 * garment.uvNode[vertex], 3 * garment.uvNode[vertex] + 3))), []));
}

/** Light edges, and the seams' other sides, in both views. @param {import('./garment.js').Edge[]} edges */
function light(edges) {
  const lit = new Set(edges.flatMap((edge) => pattern.seamOf.get(edge)?.pair ?? [edge]));
  pattern.light(lit);
  if (viewer && shownCloth()) viewer.setLines([...lit].map((edge) => ({ points: curveOf(edge, 0, edge.uv.length - 1), colour: 0xd9480f })));
}

/** Say how long what is measured is, in the pattern and on the cloth that is shown. */
function tellMeasured() {
  const cloth = shownCloth(), told = document.querySelector('#measured');
  if (!told) return;
  if (!garment || !measured.length || !cloth) {
    told.replaceChildren();
    return;
  }
  const { positions } = meshes.get(cloth), mm = (length) => (1000 * length).toFixed(1);
  let flatSum = 0, wornSum = 0;
  const rows = measured.map(([edge, from, to]) => {
    const { flat, worn } = measureEdge(garment, edge, from, to, positions);
    flatSum += flat;
    wornSum += worn;
    const isPart = Math.abs(to - from) < edge.uv.length - 1;
    return make('tr', {}, make('th', { scope: 'row' }, `${edge.panel}, edge ${edge.index}${isPart ? ', a part' : ''}`), make('td.number', {}, mm(flat)), make('td.number', {}, mm(worn)));
  });
  if (rows.length > 1) rows.push(make('tr', {}, make('th', { scope: 'row' }, 'together'), make('td.number', {}, mm(flatSum)), make('td.number', {}, mm(wornSum))));
  const head = make('tr', {}, make('th', { scope: 'col' }, 'Edge'), make('th.number', { scope: 'col' }, 'pattern, mm'), make('th.number', { scope: 'col' }, `${cloth}, mm`));
  told.replaceChildren(make('table', {}, head, ...rows));
  light(measured.map(([edge]) => edge));
}

/** Measure along edges: click, or shift-click for several; drag along an edge for a part of it. */
function startMeasuring() {
  for (const [edge, { hold }] of pattern.edges) {
    let from = -1;
    const name = hold.getAttribute('aria-label');
    const choose = (event, first, last) => {
      measured = event.shiftKey ? [...measured.filter(([one]) => one !== edge), [edge, first, last]] : [[edge, first, last]];
      pattern.showSection(edge, first, last);
      tellMeasured();
    };
    hold.addEventListener('pointerenter', () => {
      light([edge, ...measured.map(([one]) => one)]);
      const seam = pattern.seamOf.get(edge), other = seam?.pair.find((one) => one !== edge);
      find('#pointed').textContent = other ? `${name}; sewn to ${other.panel}, edge ${other.index}` : name;
    });
    hold.addEventListener('pointerleave', () => light(measured.map(([one]) => one)));
    hold.addEventListener('pointerdown', (event) => {
      from = pattern.nearest(edge, event);
      hold.setPointerCapture(event.pointerId);
    });
    hold.addEventListener('pointerup', (event) => {
      const to = pattern.nearest(edge, event);
      if (from === to) choose(event, 0, edge.uv.length - 1);
      else choose(event, from, to);
    });
    hold.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      choose(event, 0, edge.uv.length - 1);
    });
    hold.addEventListener('focus', () => light([edge, ...measured.map(([one]) => one)]));
  }
}

/** Play an animation from its point caches. */
async function startPlayer() {
  const frames = readFrames(await load('garment.pc2'));
  await Promise.all(['garment', 'body'].map(showMesh));
  const bodies = files.has('body.pc2') ? readFrames(await load('body.pc2')) : null;
  const { fps } = await getJson(`/v1/jobs/${job}/artifacts/frames.json`);
  const slider = find('#frame'), button = find('#play'), time = find('#time');
  slider.max = String(frames.length - 1);
  const show = () => {
    const frame = Number(slider.value);
    viewer.move('garment', frames[frame]);
    if (bodies && meshes.has('body')) viewer.move('body', bodies[frame]);
    time.textContent = `${(frame / fps).toFixed(2)} s`;
  };
  let isPlaying = false, begun = 0;
  const step = (now) => {
    if (!isPlaying) return;
    slider.value = String(Math.floor(((now - begun) / 1000) * fps) % frames.length);
    show();
    requestAnimationFrame(step);
  };
  button.addEventListener('click', () => {
    isPlaying = !isPlaying;
    button.setAttribute('aria-pressed', String(isPlaying));
    button.textContent = isPlaying ? 'Pause' : 'Play';
    begun = performance.now() - (1000 * Number(slider.value)) / fps;
    requestAnimationFrame(step);
  });
  slider.addEventListener('input', show);
  show();
}

/** Ask for exports, and offer their files. */
function startExports() {
  for (const button of document.querySelectorAll('[data-export]')) {
    button.addEventListener('click', async () => {
      const format = button.textContent, told = find('#exported');
      button.disabled = true;
      told.textContent = `${format}: queued…`;
      try {
        const asked = await postJson('/v1/jobs', { kind: 'export', result: job, options: { format: button.dataset.export } });
        const state = await followJob(asked.job, (event) => { told.textContent = `${format}: ${event.kind}…`; });
        const { files: made } = await getJson(`/v1/jobs/${asked.job}/artifacts`);
        told.replaceChildren(make('p', {}, state === 'succeeded' ? `${format}: ` : `${format}: ${state}; `,
          ...(state === 'succeeded' ? [] : [make('a', { href: `/jobs/${asked.job}` }, 'why')]),
          ...made.flatMap(({ name }) => [make('a', { href: `/v1/jobs/${asked.job}/artifacts/${encodeURI(name)}`, download: '' }, name), ' '])));
      } catch (error) {
        showError(told, error);
      }
      button.disabled = false;
    });
  }
}

/** Let the browser draw what is there. */
const drawn = () => new Promise((done) => { requestAnimationFrame(() => setTimeout(done)); });

/** Show what is checked, then the pattern; other meshes when they are asked for. */
async function start() {
  startExports();
  const asked = place.hasAttribute('data-packed') ? getBytes(`${base}/view.bin`) : null;
  const isSolid = boxes.length > 0 && startViewer();
  if (!boxes.length) showPictures();
  const shown = asked && readShown(await asked);
  shown?.meshes.forEach((mesh, name) => meshes.set(name, mesh));
  garment = shown?.garment ?? null;
  if (isSolid) {
    await Promise.all(boxes.filter((box) => box.checked).map((box) => showMesh(box.dataset.mesh)));
    viewer.frame();
    place.dataset.shown = '1';
    await drawn();
  }
  if (garment) {
    pattern = new PatternView(find('#flat'), garment);
    startPointing();
    startMeasuring();
  }
  if (isSolid) {
    drawBar();
    trimStyles();
    startTools();
    if (files.has('garment.pc2')) await startPlayer();
  }
  ifThere('#loading', (told) => { told.textContent = ''; });
  place.dataset.ready = '1';
}

offerRefinement(job);
offerShares(job);
start().catch((error) => {
  ifThere('#loading', (told) => { told.textContent = ''; });
  showError(find('#problem'), error);
});
