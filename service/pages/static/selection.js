// Choosing cards or rows, and actions on all that are chosen.
import { addTag, deleteJson, getJson, patchJson, postJson } from './api.js';
import { chooseInDialog } from './dialog.js';
import { find, make } from './dom.js';
import { renewItems } from './live.js';
import { speakOfControls } from './words.js';

/** How long to wait where the service asks for fewer requests [ms]. */
const PAUSE_MS = 2000;

/** Interval at which exports are polled [ms]. */
const EXPORT_PERIOD_MS = 1000;

/** Largest number of jobs in one request. */
const MOST_JOBS = 1000;

/** Lowest and highest priority of a job. */
const PRIORITIES = [-100, 100];

const OPEN = new Set(['waiting', 'queued', 'running']);

/** Names of the chosen families by the ids of their first jobs; those of other pages of the filter, too. */
const chosen = new Map();

/** Let families be chosen by their boxes, a range by Shift, all of the filter by a button. */
export function startSelection() {
  const jobs = document.querySelector('#jobs'), bar = document.querySelector('#selection');
  if (!bar) return;
  let last = null;
  document.addEventListener('click', (event) => {
    const box = event.target instanceof HTMLInputElement && event.target.matches('[data-pick]') ? event.target : null;
    if (!box) return;
    const boxes = [...document.querySelectorAll('#jobs [data-pick]')];
    const from = event.shiftKey && last?.isConnected ? boxes.indexOf(last) : boxes.indexOf(box), to = boxes.indexOf(box);
    for (const one of boxes.slice(Math.min(from, to), Math.max(from, to) + 1)) choose(one, box.checked);
    last = box;
    showBar();
  });
  for (const box of jobs?.querySelectorAll('[data-pick]') ?? []) choose(box, box.checked);  // a page that was left and opened again
  bar.addEventListener('click', (event) => {
    const action = event.target instanceof Element ? event.target.closest('[data-action]')?.getAttribute('data-action') : null;
    if (action) act(action);
  });
  document.querySelector('#export-all')?.addEventListener('click', async () => exportAll(await readFound()));
  showBar();
}

/** @param {any} box @param {boolean} isChosen */
function choose(box, isChosen) {
  const item = box.closest('[data-job]');
  box.checked = isChosen;
  item.classList.toggle('picked', isChosen);
  if (isChosen) chosen.set(item.getAttribute('data-job'), item.getAttribute('data-name'));
  else chosen.delete(item.getAttribute('data-job'));
}

/** Show the boxes and the bar as the selection is. */
function showBar() {
  for (const box of document.querySelectorAll('#jobs [data-pick]')) {
    const item = box.closest('[data-job]'), isChosen = chosen.has(item.getAttribute('data-job'));
    /** @type {any} */ (box).checked = isChosen;
    item.classList.toggle('picked', isChosen);
  }
  find('#selection').hidden = !chosen.size;
  find('#selected').textContent = chosen.size ? `${chosen.size} selected` : '';
  find('[data-action=rename]').disabled = chosen.size !== 1;
}

/** @returns {Promise<[string, string][]>} ids and names of all families that the page's filter finds */
async function readFound() {
  const { families } = await getJson(`/selection${location.search}`);
  return families.map((one) => [one.job, one.name]);
}

/** Do what a button of the bar says. @param {string} action */
async function act(action) {
  const families = [...chosen];
  if (action === 'none') chosen.clear();
  if (action === 'all') for (const [job, name] of await readFound()) chosen.set(job, name);
  if (action === 'cancel') await runEach(families, 'stopped', (job) => postJson(`/v1/jobs/${job}/cancel`));
  if (action === 'retry') await runEach(families, 'queued again', (job) => postJson(`/v1/jobs/${job}/retry`));
  if (action === 'export') await exportAll(families);
  if (action === 'rename') await rename(families[0]);
  if (action === 'tag') await tagEach(families);
  if (action === 'priority') await order(families);
  if (action === 'delete') await remove(families);
  showBar();
}

/** @param {[string, string]} family */
async function rename([job, name]) {
  const done = await chooseInDialog({ title: 'Rename', text: '', button: 'Rename', label: 'Name', value: name });
  if (!done?.text || done.text === name) return;
  await runEach([[job, name]], 'renamed', () => patchJson(`/v1/jobs/${job}`, { name: done.text }));
  chosen.set(job, done.text);
}

/** @param {[string, string][]} families */
async function tagEach(families) {
  const text = families.length === 1 ? `"${families[0][1]}" gets it.` : `All ${families.length} get it.`;
  const done = await chooseInDialog({ title: 'Add a tag', text, button: 'Add', label: 'Tag', value: '' });
  if (!done?.text) return;
  await runEach(families, 'tagged', (job) => addTag(job, done.text));
}

/** Change the priority of families; the field begins with theirs if all have the same. @param {[string, string][]} families */
async function order(families) {
  const { jobs } = await postJson('/v1/jobs/states', { jobs: families.slice(0, MOST_JOBS).map(([job]) => job) });
  const own = new Set(jobs.map((job) => job.priority)), [low, high] = PRIORITIES;
  const text = `From ${low} to ${high}; among waiting jobs of the same sort the largest goes first. It applies to all jobs of a person or garment.`;
  const done = await chooseInDialog({ title: 'Change the priority', text, button: 'Change', label: 'Priority', value: own.size === 1 ? String([...own][0]) : '',
    range: [low, high] });
  if (done) await runEach(families, 'changed', (job) => patchJson(`/v1/jobs/${job}`, { priority: Number(done.text) }));
}

/** @param {[string, string][]} families */
async function remove(families) {
  const what = families.length === 1 ? `"${families[0][1]}"` : `${families.length} persons or garments`;
  const text = `Their scans' results, garments, exports and edits are deleted with them. This cannot be undone.`;
  const done = await chooseInDialog({ title: `Delete ${what}?`, text, button: `Delete ${families.length}`, isDanger: true });
  if (!done) return;
  await runEach(families, 'deleted', async (job) => { await deleteJson(`/v1/jobs/${job}`); chosen.delete(job); });
}

/** Export the garments of some families, and list their files. @param {[string, string][]} families */
async function exportAll(families) {
  const text = `A file for each recovered garment of ${families.length === 1 ? `"${families[0][1]}"` : `${families.length} families`}.`;
  const done = await chooseInDialog({ title: 'Export', text, button: 'Export', hasFormat: true });
  if (!done) return;
  const names = new Map(families), garments = [];
  for (let at = 0; at < families.length; at += MOST_JOBS) {
    const ids = families.slice(at, at + MOST_JOBS).map(([job]) => job);
    const { jobs } = await postJson('/v1/jobs/states', { jobs: ids, below: true });
    garments.push(...jobs.filter((job) => job.kind === 'recover' && job.state === 'succeeded'));
  }
  const name = (job) => (job.parent ? `${names.get(job.family) ?? ''} ${job.name}` : job.name);
  const made = new Map();
  await runEach(garments.map((job) => [job.job, name(job)]), 'exports queued', async (job, title) => {
    const order = { kind: 'export', result: job, options: { format: done.format }, name: title };
    made.set((await postJson('/v1/jobs', order)).job, title);
  });
  await showExports(made);
}

/** List exports with a link to the files of each as soon as it has ended. @param {Map<string, string>} made names by ids */
async function showExports(made) {
  const { place, list } = openOutcome(), left = new Set(made.keys()), links = [];
  place.textContent = made.size ? `0 of ${made.size} exports ready` : 'No recovered garment is among them.';
  while (left.size) {
    const { jobs } = await postJson('/v1/jobs/states', { jobs: [...left].slice(0, MOST_JOBS) });
    for (const job of jobs.filter((one) => !OPEN.has(one.state))) {
      left.delete(job.job);
      const link = make('a', { href: `/v1/jobs/${job.job}/result.zip`, download: '' }, made.get(job.job));
      if (job.state === 'succeeded') links.push(link);
      list.append(make('li', {}, job.state === 'succeeded' ? link : `${made.get(job.job)}: ${speakOfControls(job.error?.message ?? job.state)}`));
    }
    place.replaceChildren(`${made.size - left.size} of ${made.size} exports ready `);
    if (left.size) await new Promise((resolve) => setTimeout(resolve, EXPORT_PERIOD_MS));
  }
  if (links.length > 1) {
    const all = async () => {
      for (const link of links) {
        link.click();
        await new Promise((resolve) => setTimeout(resolve, EXPORT_PERIOD_MS));
      }
    };
    place.append(make('button', { type: 'button', onclick: all }, `Download all ${links.length}`));
  }
}

/** @returns {{place: HTMLElement, list: HTMLElement}} where the outcome of an action is written, emptied */
function openOutcome() {
  const outcome = find('#outcome'), place = find('p', outcome), list = find('ul', outcome);
  outcome.hidden = false;
  list.replaceChildren();
  return { place, list };
}

/**
 * Do something with each family, one after the other, and say how many were done and why others were not.
 * @param {[string, string][]} families @param {string} word what was done
 * @param {(job: string, name: string) => Promise<any>} change
 */
async function runEach(families, word, change) {
  const { place, list } = openOutcome();
  let done = 0, failed = 0;
  for (const [job, name] of families) {
    try {
      await change(job, name).catch(async (error) => {
        if (error.status !== 429) throw error;
        await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
        await change(job, name);
      });
      done += 1;
    } catch (error) {
      failed += 1;
      list.append(make('li', {}, `${name}: `, make('span.bad', {}, speakOfControls(String(error?.message ?? error)))));
    }
    place.textContent = `${done} of ${families.length} ${word}${failed ? `, ${failed} not` : ''}`;
  }
  await renewItems();
  showBar();
}
