/**
 * The drape in space, beside the scan: a point under the pointer on the board is marked on the cloth, and the reverse.
 *
 * The cloth is that of the version that was draped last; what was edited since shows when it is draped.
 */

import { getBytes, getJson } from '../api.js';
import { draw, make } from '../dom.js';
import { flatten, lift, locate } from '../garment.js';
import { readShown } from '../shown.js';
import { Viewer } from '../viewer.js';
import { toBoard } from './layout.js';

/** Which mesh of a result is the drape of its pattern: the first that is there. */
const CLOTHS = ['edited', 'redrape', 'dressed', 'simulation', 'graded', 'detail'];
const COLOURS = { cloth: 0x6694bd, before: 0xb89e75, body: 0xe6d9cc, scan: 0x9ea8b3 };
/** What can be shown, in words; the scan stands beside the cloth. */
const LAYERS = { cloth: 'Cloth', before: 'Cloth before', body: 'Body', scan: 'Scan' };
/** Free space between the cloth and the scan [m]. */
const GAP = 0.15;

export class Space {
  /** @param {HTMLElement} place @param {import('./session.js').Session} session @param {import('./drawing.js').Drawing} drawing */
  constructor(place, session, drawing) {
    Object.assign(this, { place, session, drawing, garment: null, cloth: null, viewer: null });
    session.addEventListener('hover', () => this.mark());
  }

  /** Begin the 3D view; false where the browser has none. */
  begin() {
    if (this.viewer) return true;
    this.place.hidden = false;
    const canvas = make('div.canvas');
    this.layers = make('div.row.layers', { role: 'group', 'aria-label': 'What is shown in 3D' });
    this.place.replaceChildren(this.layers, canvas);
    try {
      this.viewer = new Viewer(canvas);
    } catch {
      this.place.replaceChildren(
        make('p.soft', {}, 'This browser has no WebGL, so there is no 3D view; the report has pictures.'),
      );
      return false;
    }
    this.viewer.renderer.domElement.addEventListener('pointermove', (event) => this.markBack(event));
    return true;
  }

  /**
   * Show a version's drape, with the scan and the drape that it was made from.
   *
   * @param {string} job   the version @param {string} first   the result that was recovered
   */
  async show(job, first) {
    if (!this.begin()) return;
    const scan = (await hasScan(first)) && (await load(`/results/${first}/scan.bin`)).meshes.get('scan');
    const { meshes, garment } = await load(`/results/${job}/view.bin`);
    const cloth = meshes.get(CLOTHS.find((name) => meshes.has(name)));
    const body = meshes.get('body');
    this.garment = garment;
    const before = this.cloth;
    this.cloth = cloth;
    this.clear();
    if (body) this.viewer.add('body', body.positions, body.faces, { colour: COLOURS.body });
    if (cloth) this.viewer.add('cloth', cloth.positions, cloth.faces, { colour: COLOURS.cloth, isCloth: true });
    if (before) this.viewer.add('before', before.positions, before.faces, { colour: COLOURS.before, isVisible: false });
    if (scan) this.viewer.add('scan', beside(scan.positions, body ?? cloth), scan.faces, { colour: COLOURS.scan });
    this.offer();
    // Cloth and scan fill the view; the wearer's head and feet may lie outside.
    if (body && cloth) this.viewer.show('body', false);
    this.viewer.frame();
    if (body) this.viewer.show('body', true);
    this.place.dataset.job = job;
  }

  clear() {
    for (const mesh of this.viewer.meshes.values()) {
      this.viewer.scene.remove(mesh);
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    this.viewer.meshes.clear();
  }

  /** Offer what there is to be shown or hidden. */
  offer() {
    const boxes = [...this.viewer.meshes.entries()].map(([name, mesh]) => {
      const box = make('input', { type: 'checkbox', checked: mesh.visible, 'data-layer': name });
      box.addEventListener('change', () => this.viewer.show(name, box.checked));
      return make('label', {}, box, ` ${LAYERS[name]}`);
    });
    this.layers.replaceChildren(...boxes);
  }

  /** Mark on the cloth what the pointer is over on the board: the nearest place of the draped mesh. */
  mark() {
    const { hover } = this.session;
    if (!this.viewer || !this.garment || !this.cloth) return;
    const panel = hover ? this.garment.panels.findIndex(({ name }) => name === hover.panel) : -1;
    const found = panel < 0 ? null : (locate(this.garment, panel, ...hover.place) ?? this.nearest(panel, hover.place));
    const point = found ? lift(this.garment, this.cloth.positions, found) : null;
    this.viewer.setMark(point);
    this.place.dataset.marked = point ? JSON.stringify(point) : '';
  }

  /** Return the corner of a panel's flat mesh that is nearest to a place. */
  nearest(panel, [x, y]) {
    const { uv, uvFaces, panelOfUv } = this.garment;
    let best = null,
      least = Infinity;
    uvFaces.forEach((vertex, at) => {
      const far = Math.hypot(uv[2 * vertex] - x, uv[2 * vertex + 1] - y);
      if (panelOfUv[vertex] !== panel || far >= least) return;
      least = far;
      best = { face: Math.floor(at / 3), weights: [0, 1, 2].map((corner) => Number(corner === at % 3)) };
    });
    return best;
  }

  /** Mark on the board what the pointer is over in space. */
  markBack(event) {
    if (event.buttons || !this.garment) return;
    const hit = this.viewer.pick('cloth', event);
    this.viewer.setMark(hit ? hit.point : null);
    if (!hit) {
      this.drawing.mark();
      return;
    }
    const panel = this.garment.panels[this.garment.panelOfUv[this.garment.uvFaces[3 * hit.face]]].name;
    const [x, y] = toBoard(this.session.placeOf(panel), flatten(this.garment, hit));
    this.drawing.mark(draw('path', { class: 'dot pointed', d: `M ${x} ${y} h 0.001` }));
  }
}

/** Return packed meshes and flat pattern of a result; none where it has none, or only larger ones than are packed. */
async function load(path) {
  try {
    return readShown(await getBytes(path));
  } catch (error) {
    if (error.status !== 404) throw error;
    return { meshes: new Map(), garment: null };
  }
}

async function hasScan(job) {
  const { files } = await getJson(`/v1/jobs/${job}/artifacts`);
  return files.some(({ name }) => name === 'scan.ply');
}

/** Return positions moved to the right of a mesh. */
function beside(positions, other) {
  const range = (values) => {
    let low = Infinity,
      high = -Infinity;
    for (let k = 0; k < values.length; k += 3) {
      low = Math.min(low, values[k]);
      high = Math.max(high, values[k]);
    }
    return [low, high];
  };
  if (!other) return positions;
  const shift = range(other.positions)[1] + GAP - range(positions)[0];
  return positions.map((value, k) => (k % 3 ? value : value + shift));
}
