// Links that show one result to whoever has them: made, listed, revoked.
import { deleteJson, getJson, postJson } from './api.js';
import { find, make, showError } from './dom.js';

/** Offer the links of a result. @param {string} job */
export function offerShares(job) {
  const place = document.querySelector('#shares');
  if (!place) return;
  const list = find('ul', place), told = find('[role=status]', place), problem = find('.problem', place);
  const address = `/v1/jobs/${job}/shares`;

  /** Run what a control asks for, and show what went wrong. @param {() => Promise<void>} work */
  const attempt = async (work) => {
    problem.replaceChildren();
    try {
      await work();
    } catch (error) {
      showError(problem, error);
    }
  };

  const refresh = async () => {
    const { shares } = await getJson(address);
    list.replaceChildren(...shares.map((share) => make('li', {},
      `valid until ${new Date(1000 * share.expires).toLocaleString([], { dateStyle: 'medium', timeStyle: 'short' })}, opened ${share.opened} times `,
      make('button', { type: 'button', onclick: () => attempt(async () => {
        await deleteJson(`${address}/${share.share}`);
        told.textContent = 'The link is revoked.';
        await refresh();
      }) }, 'Revoke'))));
  };

  find('form', place).addEventListener('submit', (event) => {
    event.preventDefault();
    attempt(async () => {
      const share = await postJson(address, { days: Number(find('select', place).value) });
      const link = new URL(share.path, location.href).href;
      const field = make('input', { readonly: true, value: link, 'aria-label': 'Link', onfocus: (focused) => focused.target.select() });
      told.replaceChildren(field, ' Copy it now: it is not shown again.');
      field.focus();
      await refresh();
    });
  });
  place.addEventListener('toggle', () => { if (place.open) attempt(refresh); });
}
