// The page of the queue: read again while it is open.
import { showTimes } from './times.js';

/** Interval at which the page is read again [ms]. */
const PERIOD_MS = 5000;

showTimes();
for (;;) {
  await new Promise((resolve) => setTimeout(resolve, PERIOD_MS));
  const place = document.querySelector('#queue');
  if (document.hidden || place.contains(document.activeElement)) continue;
  const answer = await fetch(location.href, { credentials: 'same-origin' }).catch(() => null);
  if (!answer?.ok) continue;
  const fresh = new DOMParser().parseFromString(await answer.text(), 'text/html').querySelector('#queue');
  if (!fresh) break;
  place.replaceChildren(...document.adoptNode(fresh).childNodes);
  showTimes(place);
}
