// The form that queues scans: one file is inspected and queued, several are a batch.
import { postJson, uploadFile } from './api.js';
import { Batch } from './batch.js';
import { dropFiles } from './dropped.js';
import { find, showError } from './dom.js';
import { Inspection } from './inspection.js';
import { DETECTED_BY, readDetected, readOrder } from './order.js';
import { tellSize } from './times.js';

/** Handle dropped or chosen files: each is uploaded and inspected at once, and queued on submission. */
export function startForm() {
  const form = document.querySelector('#submit');
  if (!form) return;
  const input = find('#scan'), folder = find('#folder'), told = find('#told'), problem = find('#problem'), sent = find('#sent');
  const button = find('button[type=submit]', form);
  const inspection = new Inspection(find('#understood')), batch = new Batch(form);
  /** @type {Promise<string>|null} the hash of the one scan that is chosen, once it is uploaded */ let scan = null;
  /** @type {File[]} the chosen files */ let files = [];

  const look = (sha256) => {
    const values = new FormData(form);
    return inspection.ask(sha256, readDetected(values), !values.get('body_file').size && !values.get('labels').size);
  };
  const send = async (file) => {
    sent.hidden = false;
    try {
      return (await uploadFile('scans', file, (part) => { sent.value = part; })).sha256;
    } finally {
      sent.hidden = true;
    }
  };
  const take = (chosen) => {
    files = [...chosen];
    inspection.clear();
    problem.replaceChildren();
    scan = null;
    batch.take(files.length > 1 ? files : []);
    find('#name-option').hidden = files.length > 1;
    button.textContent = files.length > 1 ? 'Queue all' : 'Queue the job';
    if (!files.length) return;
    told.textContent = files.length > 1 ? `${files.length} files` : `${files[0].name}, ${tellSize(files[0].size)}`;
    if (files.length > 1) return;
    const sending = scan = send(files[0]);
    sending.then((sha256) => sending === scan && look(sha256), (error) => {
      if (sending !== scan) return;
      scan = null;
      showError(problem, error);
    });
  };
  input.addEventListener('change', () => take(input.files));
  folder.addEventListener('change', () => take([...folder.files].sort((a, b) => a.webkitRelativePath.localeCompare(b.webkitRelativePath))));
  find('#folder-button').addEventListener('click', () => folder.click());
  for (const name of [...DETECTED_BY, 'body_file', 'labels']) {
    form.elements[name].addEventListener('change', async () => {
      if (scan) look(await scan);
      else batch.inspectAgain();
    });
  }
  dropFiles(find('#drop'), take);
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    if (!files.length) {
      showError(problem, 'Choose a scan first.');
      return;
    }
    button.disabled = true;
    problem.replaceChildren();
    try {
      if (files.length > 1) await batch.queue();
      else {
        scan ??= send(files[0]);
        const { job } = await postJson('/v1/jobs', { ...await readOrder(new FormData(form)), scan: await scan });
        location.assign(`/jobs/${job}`);
      }
    } catch (error) {
      showError(problem, error);
    }
    button.disabled = false;
  });
}
