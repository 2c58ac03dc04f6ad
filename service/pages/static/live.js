// Live states in the gallery and in the list of jobs.
import { postJson } from './api.js';
import { showTimes } from './times.js';

/** Interval at which the states of open jobs are polled, all in one request [ms]. */
const PERIOD_MS = 1000;

/** Largest number of jobs in one request. */
const MOST_JOBS = 1000;

const OPEN = new Set(['waiting', 'queued', 'running']);

/** Each shown family as the service sent it, by its id: a change is seen by comparing. */
const sent = new Map();

/** @param {ParentNode} root @returns {Element[]} cards or rows, each with its job's id */
const listItems = (root) => [...(root.querySelector('#jobs')?.querySelectorAll(':scope > [data-job]') ?? [])];

/** Poll the states of the page's open jobs until none is left; where one ended, the page's items are replaced. */
export async function followJobs() {
  for (const item of listItems(document)) sent.set(item.getAttribute('data-job'), item.outerHTML);
  showTimes();
  for (;;) {
    const ids = [...new Set([...document.querySelectorAll('[data-live]')].map((one) => one.getAttribute('data-live')))];
    if (!ids.length) return;
    if (!document.hidden) {
      try {
        const { jobs } = await postJson('/v1/jobs/states', { jobs: ids.slice(0, MOST_JOBS) });
        for (const job of jobs) showState(job);
        showProgress(jobs);
        if (jobs.length < Math.min(ids.length, MOST_JOBS) || jobs.some(hasMoved)) await renewItems();
      } catch (error) {
        if (error.status && error.status < 500 && error.status !== 429) return;
      }
    }
    await new Promise((resolve) => setTimeout(resolve, PERIOD_MS));
  }
}

/** @param {any} job @returns {boolean} whether its state differs from the one that the page shows */
const hasMoved = (job) => document.querySelector(`[data-live="${job.job}"]`)?.getAttribute('data-now') !== job.state;

/** Show a job's state in words where it has any. @param {any} job */
function showState(job) {
  for (const place of document.querySelectorAll(`[data-live="${job.job}"] [data-state]`)) {
    const text = job.state === 'running' && job.stage ? `running: ${job.stage} ${Math.round(job.progress * 100)}%` : job.state;
    if (place.textContent !== text) place.textContent = text;
  }
}

/** Show the share of each open family's work that is done. @param {any[]} jobs */
function showProgress(jobs) {
  const open = new Map(jobs.filter((job) => OPEN.has(job.state)).map((job) => [job.job, job.overall ?? 0]));
  for (const bar of document.querySelectorAll('progress[data-progress]')) {
    const ids = bar.getAttribute('data-progress').split(' ');
    /** @type {HTMLProgressElement} */ (bar).value = ids.reduce((sum, id) => sum + (open.get(id) ?? 1), 0) / ids.length;
  }
}

/** Read the page again and replace the items that differ; what is chosen and where the page stands stay. */
export async function renewItems() {
  const answer = await fetch(location.href, { credentials: 'same-origin' });
  if (!answer.ok) return;
  const fresh = new DOMParser().parseFromString(await answer.text(), 'text/html');
  const place = document.querySelector('#jobs'), shown = new Map(listItems(document).map((item) => [item.getAttribute('data-job'), item]));
  const items = listItems(fresh).map((item) => {
    const id = item.getAttribute('data-job'), html = item.outerHTML, old = shown.get(id);
    if (old && sent.get(id) === html) return old;
    sent.set(id, html);
    const next = document.adoptNode(item);
    showTimes(next);
    const was = old?.querySelector('[data-pick]'), now = next.querySelector('[data-pick]');
    if (was?.checked && now) now.checked = true;
    next.classList.toggle('picked', Boolean(was?.checked));
    const folded = old?.querySelector('details'), unfolded = next.querySelector('details');
    if (folded?.open && unfolded) unfolded.open = true;
    return next;
  });
  const focused = document.activeElement?.closest('[data-job]')?.getAttribute('data-job');
  if (items.length) place.replaceChildren(...items);
  else location.reload();
  if (focused && !place.contains(document.activeElement)) place.querySelector(`[data-job="${focused}"] a`)?.focus({ preventScroll: true });
  for (const part of document.querySelectorAll('[data-renewed]')) {
    const next = fresh.getElementById(part.id);
    if (next) part.replaceChildren(...document.adoptNode(next).childNodes);
  }
}
