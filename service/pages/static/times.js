// Times as the reader's own clock shows them, and sizes in words.

/** Turn every `<time>` below an element from UTC into the reader's time zone. @param {ParentNode} [root] */
export function showTimes(root = document) {
  for (const one of root.querySelectorAll('time[datetime]')) {
    const when = new Date(one.getAttribute('datetime'));
    one.textContent = when.toLocaleString([], { dateStyle: 'medium', timeStyle: 'short' });
    one.setAttribute('title', when.toLocaleString([], { dateStyle: 'full', timeStyle: 'long' }));
  }
}

/** @param {number} bytes @returns {string} */
export function tellSize(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${Math.round(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

/** @param {number} seconds @returns {string} */
export function tellSeconds(seconds) {
  return seconds < 90 ? `${Math.ceil(seconds)} s` : `${Math.round(seconds / 60)} min`;
}
