/**
 * Draping of the edited pattern: it is checked, submitted as a version of the result, followed, and shown.
 *
 * A version names its predecessor and never replaces it, so versions of two users coexist.
 */

import { followJob, getJson, getText, postJson, uploadFile } from '../api.js';
import { find, make, showError } from '../dom.js';
import { patternFile, readPattern, writePattern } from './pattern_model.js';

export class Draping {
  /**
   * @param {import('./session.js').Session} session @param {import('./space.js').Space} space
   * @param {string} job   the version that was opened
   */
  constructor(session, space, job) {
    Object.assign(this, { session, space, job, running: null });
    find('#drape').addEventListener('click', () => this.drape());
    find('#cancel-drape').addEventListener('click', () => this.running && postJson(`/v1/jobs/${this.running}/cancel`));
  }

  /** Show the versions and the present drape, and compare with the pattern that was recovered. */
  async begin() {
    const versions = await this.listVersions();
    this.first = versions[0].job;
    if (this.first !== this.job)
      this.session.compare(readPattern(await getText(`/v1/jobs/${this.first}/artifacts/pattern.json`)));
    await this.space.show(this.job, this.first);
  }

  async listVersions() {
    const { versions } = await getJson(`/v1/jobs/${this.job}/versions`);
    const items = versions.map((version) => {
      const here = version.job === this.job;
      const made = new Date(1e3 * version.created).toLocaleString();
      const from = version.predecessor ? `, from ${version.predecessor}` : ', recovered';
      return make(
        'li',
        { 'data-version': version.job, 'aria-current': here ? 'true' : null },
        make('a', { href: `/results/${version.job}/edit` }, version.name),
        ` ${version.job}: ${version.state}`,
        version.verdict ? `, ${version.verdict}` : null,
        make('span.soft', {}, `${from}, ${made}${here ? ' (this one)' : ''}`),
      );
    });
    find('#versions').replaceChildren(...items);
    return versions;
  }

  /** Check the pattern, drape it as a new version, and show the outcome. */
  async drape() {
    const button = find('#drape'),
      told = find('#draping');
    button.disabled = true;
    find('#verdicts').replaceChildren();
    try {
      if (await this.examine()) await this.run(told);
    } catch (error) {
      showError(told, error);
    }
    button.disabled = false;
    find('#cancel-drape').hidden = true;
    this.running = null;
  }

  /** Return whether the service accepts the pattern; faults are listed, and marked at their places. */
  async examine() {
    const { is_sound: sound, findings } = await postJson('/v1/patterns/check', patternFile(this.session.present));
    const items = findings.map(({ severity, message, places }) => {
      const show = () => this.session.select(places.map(itemOf).filter(Boolean));
      const words = places.length ? make('button.words', { type: 'button', onclick: show }, message) : message;
      return make('li', { class: severity === 'error' ? 'bad' : 'doubt' }, words);
    });
    find('#findings').replaceChildren(...(items.length ? [make('ul', {}, ...items)] : []));
    this.session.setFaults(
      findings
        .filter(({ severity }) => severity === 'error')
        .flatMap(({ places }) => places.map(itemOf))
        .filter(Boolean),
    );
    if (!sound) {
      find('#draping').textContent = 'This pattern cannot be draped; its faults are marked on the board.';
      this.session.say('This pattern cannot be draped; its faults are marked on the board.', true);
    }
    return sound;
  }

  async run(told) {
    const pattern = this.session.present,
      file = new File([writePattern(pattern)], 'pattern.json', { type: 'application/json' });
    told.textContent = 'Sending the pattern.';
    const { sha256 } = await uploadFile('patterns', file);
    const order = { kind: 'edit', result: this.job, files: { pattern: sha256 } };
    const name = find('#version-name').value.trim();
    const { job } = await postJson('/v1/jobs', name ? { ...order, name } : order);
    this.running = job;
    find('#cancel-drape').hidden = false;
    const bar = make('progress', { max: 1, value: 0, 'aria-label': 'Draping' }),
      words = make('span', {}, ' waiting for a worker');
    told.replaceChildren(bar, words);
    const state = await followJob(job, ({ kind, data }) => {
      if (kind === 'progress') bar.value = data.fraction;
      words.textContent =
        kind === 'progress'
          ? ` ${[data.stage, data.message].filter(Boolean).join(': ')}`
          : ` ${kind.replaceAll('_', ' ')}`;
    });
    const found = await getJson(`/v1/jobs/${job}`);
    if (state !== 'succeeded') {
      told.replaceChildren(
        make(
          'p.error',
          { role: 'alert' },
          `${state}: ${found.error?.message ?? 'the drape was stopped.'} `,
          make('a', { href: `/jobs/${job}` }, 'The job'),
        ),
      );
      return;
    }
    this.job = job;
    told.replaceChildren(
      make('p', {}, `Draped as version ${job}: `, make('a', { href: `/results/${job}` }, 'its result'), '.'),
    );
    const rows = found.gates.map(({ name: gate, verdict, message }) =>
      make(
        'tr',
        {},
        make('th', { scope: 'row' }, gate),
        make('td', {}, make('span.tag', {}, verdict)),
        make('td', {}, message),
      ),
    );
    find('#verdicts').replaceChildren(
      make('div.wide', { tabindex: 0, role: 'region', 'aria-label': 'Checks' }, make('table', {}, ...rows)),
    );
    await this.listVersions();
    await this.space.show(job, this.first);
    this.session.say(`Draped and saved as version ${job}.`);
  }
}

/** Return what can be selected at a place that the service names; null where it names a panel that is not there. */
function itemOf({ panel, edge, vertex }) {
  if (vertex !== null && vertex !== undefined) return { panel, point: vertex };
  if (edge !== null && edge !== undefined) return { panel, edge };
  return panel ? { panel } : null;
}
