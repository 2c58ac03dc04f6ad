// One job: its progress by Server-Sent Events, cancelling and trying again.
import { followJob, getJson, postJson } from './api.js';
import { find, make, showError } from './dom.js';
import { offerRefinement } from './refine.js';
import { showTimes, tellSeconds } from './times.js';

/** Lines of the log that are kept on the page; progress comes twice a second. */
const MOST_LINES = 500;

const place = find('#job');
const job = place.getAttribute('data-job');
const events = find('#events');

/** @param {{at: number, kind: string, data: any}} event @returns {string} */
function tell(event) {
  const { data } = event;
  if (event.kind === 'progress') return [data.stage, `${Math.round(data.fraction * 100)}%`, data.message].filter(Boolean).join(' ');
  const more = Object.entries(data).map(([name, value]) => `${name.replaceAll('_', ' ')}: ${value}`).join(', ');
  return more ? `${event.kind.replaceAll('_', ' ')} (${more})` : event.kind.replaceAll('_', ' ');
}

/** Show one event: in the log, and a stage's progress in the bar. */
function show(event) {
  const when = new Date(event.at * 1000).toLocaleTimeString();
  const last = events.lastElementChild;
  const key = event.kind === 'progress' ? `progress ${event.data.stage}` : '';
  const line = make('li', { 'data-key': key }, make('span.soft', {}, when), ` ${tell(event)}`);
  if (key && last?.getAttribute('data-key') === key) last.replaceWith(line);
  else events.append(line);
  while (events.childElementCount > MOST_LINES) events.firstElementChild.remove();
  if (event.kind === 'progress' && !place.getAttribute('data-ended')) {
    const { stage, fraction, message, overall, left_seconds: left } = event.data;
    find('#progress').value = overall ?? fraction;
    find('#stage').textContent = [stage, message].filter(Boolean).join(': ') + (left ? `, about ${tellSeconds(left)} to go` : '');
    find('#state [data-state]').textContent = `running: ${event.data.stage}`;
    if (event.data.stage !== 'check' && find('#understood').hidden) showUnderstood();
  }
}

/** Show what the first stage detected in the files, once it is known. */
async function showUnderstood() {
  const section = find('#understood');
  section.hidden = false;
  const fresh = new DOMParser().parseFromString(await (await fetch(location.href)).text(), 'text/html');
  const told = fresh.querySelector('#understood');
  if (told && !told.hidden) section.replaceWith(document.adoptNode(told));
  else section.hidden = true;
}

/** @param {string} what cancel or retry */
function change(what) {
  const button = document.querySelector(`#${what}`);
  button?.addEventListener('click', async () => {
    button.disabled = true;
    try {
      await postJson(`/v1/jobs/${job}/${what}`);
      location.reload();
    } catch (error) {
      button.disabled = false;
      showError(find('#problem'), error);
    }
  });
}

/** Queue the same scan in another outfit on a click, and open that job's page. */
function offerReadings() {
  for (const button of document.querySelectorAll('#worn [data-wearing]')) {
    button.addEventListener('click', async () => {
      button.disabled = true;
      try {
        const again = await postJson(`/v1/jobs/${job}/wearing`, { wearing: button.getAttribute('data-wearing') });
        location.assign(`/jobs/${again.job}`);
      } catch (error) {
        button.disabled = false;
        showError(find('#worn-problem'), error);
      }
    });
  }
}

showTimes();
offerReadings();
change('cancel');
change('retry');
offerRefinement(job);
try {
  if (place.getAttribute('data-ended')) {
    for (const event of (await getJson(`/v1/jobs/${job}/events`)).events) show(event);
  } else {
    if (await followJob(job, show)) location.reload();
  }
} catch (error) {
  showError(find('#problem'), error);
}
