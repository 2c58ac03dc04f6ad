// Buttons and forms of the pages of libraries and administration.
import { ask, postJson, putJson } from './api.js';
import { chooseInDialog } from './dialog.js';
import { find, make, showError } from './dom.js';
import { showTimes } from './times.js';

const outcome = find('#outcome');

/** Send what a button says, after a question where it has one. @param {HTMLElement} button */
async function send(button) {
  const [method, path] = button.dataset.send.split(' ');
  if (button.dataset.question) {
    const [title, ...rest] = button.dataset.question.split('? ');
    const words = { title: rest.length ? `${title}?` : title, text: rest.join('? '), isDanger: true };
    if (!await chooseInDialog({ ...words, button: button.textContent.replace('…', '') })) return;
  }
  const answer = await (await ask(path, { method })).json();
  if (method === 'DELETE') {
    if (button.dataset.after) location.assign(button.dataset.after);
    else location.reload();
    return;
  }
  const text = answer.error ? `Not accepted: ${answer.error}` : `Accepted with status ${answer.status}.`;
  outcome.replaceChildren(make(answer.error ? 'p.error' : 'p.card', {}, text));
}

/** Show what the service tells only once. @param {string} words @param {string} value */
function showOnce(words, value) {
  const field = /** @type {HTMLInputElement} */ (make('input', { readonly: true, value, 'aria-label': words }));
  const copy = make('button', { type: 'button', onclick: () => { field.select(); navigator.clipboard?.writeText(value); } }, 'Copy');
  const again = make('a.button', { href: location.pathname }, 'Done');
  outcome.replaceChildren(make('div.card.once', {}, make('p', {}, `${words} It is shown only now; store it.`),
    make('p.row', {}, field, copy, again)));
  field.select();
}

/** Read a file of fabrics: one, a list, or the list of the library. @param {File} file @returns {Promise<any[]>} */
async function readFabrics(file) {
  const found = JSON.parse(await file.text());
  return Array.isArray(found) ? found : found.materials ?? [found];
}

const FORMS = {
  fabrics: async (form) => {
    for (const fabric of await readFabrics(find('input[type=file]', form).files[0])) {
      await putJson(`/v1/materials/${encodeURIComponent(fabric.name)}`, fabric);
    }
    location.reload();
  },
  template: async (form) => {
    const path = `/v1/templates/${encodeURIComponent(form.elements.name.value.trim())}`;
    const headers = { 'Content-Type': 'application/octet-stream' };
    await ask(path, { method: 'PUT', body: find('input[type=file]', form).files[0], headers });
    location.reload();
  },
  key: async (form) => {
    const values = new FormData(form), days = String(values.get('days'));
    const key = { name: values.get('name'), scopes: values.getAll('scopes'), quota: Number(values.get('quota')), priority: Number(values.get('priority')) };
    const { token } = await postJson('/v1/keys', days ? { ...key, days: Number(days) } : key);
    showOnce(`The token of ${key.name}.`, token);
  },
  subject: async (form) => {
    const values = new FormData(form), fields = { name: values.get('name'), consent: values.get('consent'), note: values.get('note') };
    if (values.get('keep_days')) fields.keep_days = Number(values.get('keep_days'));
    for (const input of form.querySelectorAll('input[type=date]')) {
      if (input.value) fields[input.name] = new Date(`${input.value}T00:00`).getTime() / 1000;
    }
    const id = form.dataset.subject;
    const saved = await (id ? putJson(`/v1/subjects/${id}`, fields) : postJson('/v1/subjects', fields));
    location.assign(`/subjects/${saved.subject}`);
  },
  webhook: async (form) => {
    const values = new FormData(form);
    const { secret } = await postJson('/v1/webhooks', { url: values.get('url'), states: values.getAll('states') });
    showOnce('The secret that signs the messages.', secret);
  },
};

/** Show stored times as dates of this place. */
for (const input of document.querySelectorAll('input[data-seconds]')) {
  const seconds = Number(input.getAttribute('data-seconds')), when = new Date(1000 * seconds);
  if (seconds) /** @type {any} */ (input).value = new Date(when.getTime() - 60_000 * when.getTimezoneOffset()).toISOString().slice(0, 10);
}

for (const [name, handle] of Object.entries(FORMS)) {
  const form = document.querySelector(`form[data-${name}]`);
  form?.addEventListener('submit', async (event) => {
    event.preventDefault();
    const button = find('button[type=submit]', form);
    button.disabled = true;
    await handle(form).catch((error) => showError(outcome, error));
    button.disabled = false;
  });
}
document.addEventListener('click', (event) => {
  const button = event.target instanceof Element ? event.target.closest('[data-send]') : null;
  if (button instanceof HTMLElement) send(button).catch((error) => showError(outcome, error));
});
showTimes();
