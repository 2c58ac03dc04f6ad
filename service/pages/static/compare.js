// Two results in 3D, whose cameras move together.
import { getBytes } from './api.js';
import { startCamera } from './camera_tools.js';
import { find, make, showError } from './dom.js';
import { readShown } from './shown.js';
import { showTimes } from './times.js';
import { Viewer } from './viewer.js';

const COLOURS = [0x6694bd, 0x7aa894], SKIN = 0xe6d9cc;

/** @param {string} name @returns {boolean} whether a mesh is a wearer */
const isBody = (name) => name.startsWith('body');

/**
 * Show the first cloth of a result on its wearer.
 * @param {Element} place @param {number} colour @returns {Promise<Viewer>}
 */
async function open(place, colour) {
  const viewer = new Viewer(place);
  const { meshes } = readShown(await getBytes(place.getAttribute('data-view')));
  const cloth = [...meshes.keys()].filter((name) => !isBody(name) && name !== 'under');
  const shown = cloth.some((name) => name.includes('/')) ? cloth.filter((name) => name.includes('/')) : cloth.slice(0, 1);
  for (const [name, { positions, faces }] of meshes) {
    if (name === 'body') viewer.add(name, positions, faces, { colour: SKIN });
    else if (shown.includes(name)) viewer.add(name, positions, faces, { colour, isCloth: true });
  }
  return viewer;
}

/** Let each view look as the other does. @param {Viewer[]} viewers */
function tie([first, second]) {
  let isBusy = false;
  for (const [one, other] of [[first, second], [second, first]]) {
    one.controls.addEventListener('change', () => {
      if (isBusy) return;
      isBusy = true;
      other.follow(one);
      isBusy = false;
    });
  }
}

/** Show what the page has: two views, one, or none without WebGL. */
async function start() {
  const spaces = [...document.querySelectorAll('.space')], place = find('#compare');
  let viewers;
  try {
    viewers = await Promise.all(spaces.map((space, n) => open(space, COLOURS[n])));
  } catch (error) {
    for (const space of spaces) space.replaceWith(make('p.soft', {}, 'There is no 3D view in this browser.'));
    if (error.code) throw error;
    viewers = [];
  }
  if (viewers.length) {
    if (viewers.length === 2) tie(viewers);
    const look = (angle) => {
      const far = Math.max(...viewers.map((viewer) => viewer.frame(angle)));
      for (const viewer of viewers) viewer.frame(angle, far);
    };
    find('#camera').hidden = false;
    startCamera(viewers[0], look);
    find('#bodies').addEventListener('change', (event) => {
      for (const viewer of viewers) if (viewer.meshes.has('body')) viewer.show('body', event.target.checked);
    });
    look(0);
    new ResizeObserver(() => { if (viewers.every((viewer) => viewer.isFramed)) look(viewers[0].azimuth); }).observe(spaces[0]);
    place.viewers = viewers;
  }
  place.dataset.ready = '1';
}

start().catch((error) => showError(find('#problem'), error));
showTimes();
