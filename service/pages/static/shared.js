// A shared result: its garment in 3D.
import { getBytes } from './api.js';
import { find, showError } from './dom.js';
import { readShown } from './shown.js';
import { Viewer } from './viewer.js';

const CLOTH = 0x6694bd;

/** Show the garment's mesh in its own colours where it has any. */
async function start() {
  const place = find('#shared'), card = find('#space').closest('section');
  for (const picture of document.querySelectorAll('img.figure')) picture.addEventListener('error', () => picture.closest('section').remove());
  if (card.hidden) return;
  let viewer;
  try {
    viewer = new Viewer(find('#space'));
  } catch {
    card.hidden = true;  // no WebGL: the picture stands for it
    return;
  }
  const { meshes } = readShown(await getBytes(place.dataset.view));
  for (const [name, mesh] of meshes) viewer.add(name, mesh.positions, mesh.faces, { colour: CLOTH, isCloth: true, colours: mesh.colours });
  viewer.frame();
  find('#loading').textContent = '';
  place.dataset.ready = '1';
}

start().catch((error) => {
  find('#loading').textContent = '';
  showError(find('#problem'), error);
});
