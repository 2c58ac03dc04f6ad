// What the service detects in a scan, before a job is created.
import { getJson } from './api.js';
import { find, make, showError } from './dom.js';

const KINDS = { person: 'a whole person', garment: 'a garment' };

/** Result of a job for each. */
const MADE = {
  person: 'One job segments the person; each garment gets its pattern, fabric and meshes in a job of its own.',
  garment: 'One job: the garment\'s pattern, fabric and meshes.',
};

const count = (n) => n.toLocaleString('en');
const metres = (lengths) => `${lengths.map((length) => length.toFixed(2)).join(' × ')} m`;

/** @param {any} found what the service answered @returns {string[][]} names and texts */
export function tellInspection(found) {
  const { scan, body } = found, openings = Object.entries(found.contours_m ?? {});
  const dropped = scan.file_count > scan.vertex_count ? `, of ${count(scan.file_count)} in the file` : '';
  const colours = scan.has_colours ? 'colours' : 'no colours', labels = scan.has_labels ? 'labels' : 'no labels';
  return [
    ['Detected as', KINDS[found.as] + (found.is_sure ? '' : ', by its height')],
    ['Size', `${metres(scan.extent_m)}, ${scan.up} of the file is up, its unit is ${scan.units}`],
    ['Surface', scan.is_cloud ? `a cloud of ${count(scan.vertex_count)} points${dropped}`
      : `${count(scan.vertex_count)} points${dropped}, ${count(scan.face_count)} faces`],
    ['Attributes', `${colours}, ${labels}`],
    body && ['Wearer', `${body.height_m.toFixed(2)} m tall`],
    found.category && ['Garment', found.category],
    openings.length && ['Openings', openings.map(([name, length]) => `${name} ${length.toFixed(2)} m`).join(', ')],
    scan.notes.length && ['Repaired', scan.notes.join(' ')],
    found.remarks.length && ['Doubtful', found.remarks.join(' ')],
    ['Result', MADE[found.as]],
  ].filter(Boolean);
}

/** Shows what is detected in the scan that was uploaded last. */
export class Inspection {
  /** @param {HTMLElement} place */
  constructor(place) {
    this.place = place;
    this.stop = new AbortController();
  }

  /** Show nothing. */
  clear() {
    this.stop.abort();
    this.place.hidden = true;
    find('table', this.place).replaceChildren();
  }

  /**
   * Inspect a scan, first the file alone, then with its wearer; a later call ends this one.
   * @param {string} sha256 of the scan @param {Record<string, string>} said what the order says: as, body, units, up, height
   * @param {boolean} isWhole whether to look for the wearer: not where the body or labels are a file
   */
  async ask(sha256, said, isWhole) {
    this.stop.abort();
    const { signal } = this.stop = new AbortController();
    const told = find('#looking', this.place);
    this.place.hidden = false;
    const read = (quick) => getJson(`/v1/scans/${sha256}/inspection?${new URLSearchParams({ ...said, quick })}`, signal);
    try {
      told.textContent = 'Reading the scan…';
      const first = await read(true);
      this.show(first);
      if (!isWhole) told.textContent = 'The job will check the body and the labels.';
      else if (first.needs) showError(told, first.needs);
      else {
        told.textContent = 'Fitting the wearer; the job can be queued meanwhile.';
        this.show(await read(false));
        told.textContent = '';
      }
    } catch (error) {
      if (!signal.aborted) showError(told, error);
    }
  }

  /** @param {any} found */
  show(found) {
    const rows = tellInspection(found).map(([name, text]) => make('tr', {}, make('th', { scope: 'row' }, name), make('td', {}, text)));
    find('table', this.place).replaceChildren(...rows);
    this.place.dataset.sure = found.is_sure ? '1' : '';
  }
}
