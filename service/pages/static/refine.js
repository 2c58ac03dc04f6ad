// The button of a preview that queues the recovery of its files at standard quality.
import { postJson } from './api.js';
import { find, showError } from './dom.js';

/** Queue the refinement of a preview on a click, and open its page. @param {string} job the preview's id */
export function offerRefinement(job) {
  const button = document.querySelector('#refine');
  button?.addEventListener('click', async () => {
    button.disabled = true;
    try {
      const refined = await postJson(`/v1/jobs/${job}/refine`);
      location.assign(`/jobs/${refined.job}`);
    } catch (error) {
      button.disabled = false;
      showError(find('#problem'), error);
    }
  });
}
