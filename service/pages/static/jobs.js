// Gallery and list of jobs: live states, selection, and the form that queues scans.
import { postJson, uploadFile } from './api.js';
import { find, showError } from './dom.js';
import { Inspection } from './inspection.js';
import { followJobs } from './live.js';
import { showTimes, tellSize } from './times.js';

/** @param {FormData} form @param {string} scan its hash @returns {Promise<object>} what `/v1/jobs` is asked, its other files uploaded */
async function readOrder(form, scan) {
  const upload = async (kind, file) => (await uploadFile(kind, file)).sha256;
  const text = (name) => String(form.get(name) ?? '').trim();
  const file = (name) => (form.get(name)?.size ? form.get(name) : null);
  const wanted = { scan };
  if (file('body_file')) wanted.body = await upload('bodies', file('body_file'));
  else if (text('body')) wanted.body = text('body');
  if (file('labels')) wanted.labels = await upload('labels', file('labels'));
  for (const name of ['name', 'as', 'wearing', 'template']) if (text(name)) wanted[name] = text(name);
  const tags = text('tags').split(',').map((tag) => tag.trim()).filter(Boolean);
  if (tags.length) wanted.tags = tags;
  const settings = {};
  for (const name of ['fabric', 'quality', 'method', 'redrape', 'units', 'up']) if (text(name)) settings[name] = text(name);
  if (text('height')) settings.height = Number(text('height'));
  if (Object.keys(settings).length) wanted.settings = settings;
  return wanted;
}

/** Options that change what is detected in a scan. */
const SAID = ['as', 'body', 'units', 'up', 'height'];

/** Handle a dropped or chosen scan: it is uploaded and inspected at once, and queued on submission. */
function startForm() {
  const form = document.querySelector('#submit');
  if (!form) return;
  const drop = find('#drop'), input = find('#scan'), told = find('#told'), problem = find('#problem'), sent = find('#sent');
  const inspection = new Inspection(find('#understood'));
  /** @type {Promise<string>|null} the hash of the scan that is chosen, once it is uploaded */ let scan = null;

  const look = (sha256) => {
    const given = new FormData(form), said = SAID.map((name) => [name, String(given.get(name)).trim()]).filter(([, text]) => text);
    return inspection.ask(sha256, Object.fromEntries(said), !given.get('body_file').size && !given.get('labels').size);
  };
  const send = async (file) => {
    sent.hidden = false;
    try {
      return (await uploadFile('scans', file, (part) => { sent.value = part; })).sha256;
    } finally {
      sent.hidden = true;
    }
  };
  const take = () => {
    const file = input.files[0];
    inspection.clear();
    problem.replaceChildren();
    scan = null;
    if (!file) return;
    told.textContent = `${file.name}, ${tellSize(file.size)}`;
    const sending = scan = send(file);
    sending.then((sha256) => sending === scan && look(sha256), (error) => {
      if (sending !== scan) return;
      scan = null;
      showError(problem, error);
    });
  };
  input.addEventListener('change', take);
  for (const name of [...SAID, 'body_file', 'labels']) {
    form.elements[name].addEventListener('change', async () => { if (scan) look(await scan); });
  }
  for (const kind of ['dragenter', 'dragover']) {
    drop.addEventListener(kind, (event) => { event.preventDefault(); drop.classList.add('over'); });
  }
  drop.addEventListener('dragleave', () => drop.classList.remove('over'));
  drop.addEventListener('drop', (event) => {
    event.preventDefault();
    drop.classList.remove('over');
    if (event.dataTransfer.files.length) {
      input.files = event.dataTransfer.files;
      take();
    }
  });
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    const button = find('button[type=submit]', form);
    button.disabled = true;
    problem.replaceChildren();
    try {
      scan ??= send(input.files[0]);
      const { job } = await postJson('/v1/jobs', await readOrder(new FormData(form), await scan));
      location.assign(`/jobs/${job}`);
    } catch (error) {
      showError(problem, error);
      button.disabled = false;
    }
  });
}

showTimes();
startForm();
followJobs();
