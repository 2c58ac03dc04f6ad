// Files and folders that are dropped on a place.

/**
 * Hand over what is dropped on a place, the files of folders included.
 * @param {HTMLElement} place @param {(files: File[]) => void} take
 */
export function dropFiles(place, take) {
  for (const kind of ['dragenter', 'dragover']) {
    place.addEventListener(kind, (event) => { event.preventDefault(); place.classList.add('over'); });
  }
  place.addEventListener('dragleave', () => place.classList.remove('over'));
  place.addEventListener('drop', async (event) => {
    event.preventDefault();
    place.classList.remove('over');
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    const files = [...event.dataTransfer.files];
    take(entries.some((entry) => entry.isDirectory) ? (await Promise.all(entries.map(listFiles))).flat() : files);
  });
}

/** @param {any} entry a file or a folder @returns {Promise<File[]>} its files, by their paths */
export async function listFiles(entry) {
  if (entry.isFile) return [await new Promise((resolve, reject) => entry.file(resolve, reject))];
  const reader = entry.createReader(), found = [];
  for (;;) {
    const part = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!part.length) break;
    found.push(...part);
  }
  found.sort((a, b) => a.name.localeCompare(b.name));
  return (await Promise.all(found.map(listFiles))).flat();
}
