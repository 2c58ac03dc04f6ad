// Several files: each has a row, is uploaded and inspected after the one before, and becomes a job of the batch.
import { addTag, getJson, postJson, uploadFile } from './api.js';
import { find, make } from './dom.js';
import { tellInspection } from './inspection.js';
import { readDetected, readOrder } from './order.js';
import { tellSize } from './times.js';
import { speakOfControls } from './words.js';

/** Largest number of letters of a tag. */
const TAG_LENGTH = 64;

/** One file of a batch. */
class Row {
  /** @param {File} file @param {boolean} isScan whether its name is that of a scan */
  constructor(file, isScan) {
    this.file = file;
    this.isScan = isScan;
    this.sha256 = '';
    this.job = '';
    this.told = make('span.told', {}, isScan ? 'waits' : 'left out: not a format of scans');
    this.bar = make('progress', { max: 1, value: 0, hidden: true, 'aria-label': `Upload of ${file.name}` });
    this.element = make('li', {}, make('span.name', {}, file.name), make('span.soft', {}, tellSize(file.size)), this.told, this.bar);
    if (!isScan) this.element.classList.add('soft');
  }

  /** @param {...(string|Node)} words */
  tell(...words) {
    this.told.className = 'told';
    this.told.replaceChildren(...words);
  }

  /** @param {any} error */
  tellError(error) {
    this.told.className = 'told bad';
    this.told.replaceChildren(speakOfControls(String(error?.message ?? error)), ...(error?.code ? [' ', make('code', {}, error.code)] : []));
  }
}

/** The files that are chosen together. */
export class Batch {
  /** @param {HTMLFormElement} form */
  constructor(form) {
    this.form = form;
    this.place = find('#batch', form);
    this.state = find('#batch-state', form);
    /** @type {Row[]} */ this.rows = [];
    this.run = 0;
    this.reading = Promise.resolve();
  }

  /** Show rows for some files, and begin to upload them. @param {File[]} files none: there is no batch */
  take(files) {
    const endings = find('#scan', this.form).accept.split(',');
    this.rows = files.map((file) => new Row(file, endings.some((one) => file.name.toLowerCase().endsWith(one))));
    find('.files', this.place).replaceChildren(...this.rows.map((row) => row.element));
    this.place.hidden = !files.length;
    this.state.textContent = '';
    const run = ++this.run;
    if (!files.length) return;
    const folder = files[0].webkitRelativePath?.split('/')[0], now = new Date();
    const local = new Date(now.getTime() - 60_000 * now.getTimezoneOffset()).toISOString().slice(0, 16).replace('T', ' ');
    this.form.elements.batch.value = (folder || `batch ${local}`).slice(0, TAG_LENGTH);
    this.reading = this.readAll(run);
  }

  /** Inspect again what is uploaded: an option has changed. */
  inspectAgain() {
    if (!this.rows.length) return;
    const run = ++this.run;
    this.reading = this.reading.then(() => this.readAll(run));
  }

  /** Upload and inspect the files one after the other; a later call ends this one. @param {number} run */
  async readAll(run) {
    for (const row of this.rows) {
      if (run !== this.run) return;
      if (row.isScan && !row.job) await this.read(row);
    }
  }

  /** Upload and inspect one file. @param {Row} row */
  async read(row) {
    row.refused = null;
    try {
      if (!row.sha256) {
        row.tell('is sent');
        row.bar.hidden = false;
        row.sha256 = (await uploadFile('scans', row.file, (part) => { row.bar.value = part; })).sha256;
        row.bar.hidden = true;
      }
      row.tell('is read');
      const options = new URLSearchParams({ ...readDetected(new FormData(this.form)), quick: 'true' });
      const found = await getJson(`/v1/scans/${row.sha256}/inspection?${options}`);
      const [[, what], [, size]] = tellInspection(found);
      row.tell(`${what}; ${size}`);
    } catch (error) {
      row.bar.hidden = true;
      row.refused = error;
      row.tellError(error);
    }
  }

  /** Queue a job for each file that can be read, with the form's options; the others stay with their reason. */
  async queue() {
    const values = new FormData(this.form);
    values.delete('name');
    const tag = String(values.get('batch')).trim();
    if (tag) values.set('tags', [values.get('tags'), tag].filter(Boolean).join(','));
    const order = await readOrder(values);
    this.state.textContent = 'The files are read and queued one after the other.';
    await this.reading;
    let count = 0, known = 0;
    for (const row of this.rows.filter((one) => one.isScan)) {
      if (row.job) {
        count += 1;
        continue;
      }
      if (row.refused) await this.read(row);
      if (row.refused) continue;
      try {
        const { job, is_new: isNew } = await postJson('/v1/jobs', { ...order, scan: row.sha256 });
        row.job = job;
        if (!isNew && tag) await addTag(job, tag);
        row.tell(make('a', { href: `/jobs/${job}` }, isNew ? 'queued' : 'known already'));
        count += 1;
        known += isNew ? 0 : 1;
      } catch (error) {
        row.tellError(error);
      }
    }
    const scans = this.rows.filter((one) => one.isScan).length;
    const link = make('a', { href: `/?${new URLSearchParams({ tag })}` }, 'Show the batch');
    this.state.replaceChildren(`${count} of ${scans} queued${known ? `, ${known} of them known before` : ''}. `, ...(count && tag ? [link] : []));
    if (count === scans && count && tag) location.assign(link.getAttribute('href'));
  }
}
