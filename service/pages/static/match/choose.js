// Which two patterns are compared: jobs, templates, or files.

import { getJson, uploadFile } from '../api.js';
import { find, make, showError } from '../dom.js';

/** Kinds of job that have a pattern, and how many of the newest are listed. */
const KINDS = ['recover', 'dress', 'refit', 'edit'], MOST = 200;

/** Fill both lists; a file that is chosen is uploaded and stands in its list. @param {Element} problem shows errors */
export async function offerPatterns(problem) {
  const form = find('#choose');
  const [{ jobs }, { templates }] = await Promise.all([
    getJson(`/v1/jobs?state=succeeded&limit=${MOST}`), getJson('/v1/templates')]);
  for (const side of ['a', 'b']) {
    const list = find(`#${side}`), wanted = form.dataset[side];
    const own = jobs.filter((job) => KINDS.includes(job.kind)).map((job) => make('option', { value: job.job },
      `${job.name} (${[job.garment, job.kind === 'recover' ? null : job.kind, job.job].filter(Boolean).join(', ')})`));
    const shipped = templates.map((template) => make('option', { value: template.name }, template.name));
    list.replaceChildren(make('optgroup', { label: 'Jobs' }, ...own), make('optgroup', { label: 'Templates' }, ...shipped));
    if (wanted && ![...list.options].some((option) => option.value === wanted)) {
      list.prepend(make('option', { value: wanted }, wanted.length === 64 ? `uploaded file ${wanted.slice(0, 12)}` : wanted));
    }
    if (wanted) list.value = wanted;
    find(`#${side}-file`).addEventListener('change', (event) => upload(event.target, list, problem));
  }
}

/** @param {HTMLInputElement} input @param {HTMLSelectElement} list @param {Element} problem */
async function upload(input, list, problem) {
  const file = input.files?.[0];
  if (!file) return;
  try {
    problem.replaceChildren();
    const { sha256, name } = await uploadFile('patterns', file);
    list.prepend(make('option', { value: sha256 }, name));
    list.value = sha256;
  } catch (error) {
    showError(problem, error);
  }
}
