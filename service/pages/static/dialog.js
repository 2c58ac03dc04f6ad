// The dialog in which an action is confirmed.
import { find } from './dom.js';

/**
 * Ask for a confirmation, with a text, a whole number of a range, or a format where the action needs one.
 * @param {{title: string, text: string, button: string, label?: string, value?: string, range?: [number, number], hasFormat?: boolean,
 *   isDanger?: boolean}} words
 * @returns {Promise<{text: string, format: string}|null>} null: it was closed
 */
export function chooseInDialog(words) {
  const dialog = find('#dialog'), field = find('#dialog-field', dialog), format = find('#dialog-format', dialog);
  const input = find('input', field), button = find('button[value=yes]', dialog);
  find('#dialog-title', dialog).textContent = words.title;
  find('#dialog-text', dialog).textContent = words.text;
  field.hidden = words.label === undefined;
  find('span', field).textContent = words.label ?? '';
  const [min, max] = words.range ?? ['', ''];
  Object.assign(input, { type: words.range ? 'number' : 'text', min, max, required: Boolean(words.range), value: words.value ?? '' });
  format.hidden = !words.hasFormat;
  button.textContent = words.button;
  button.classList.toggle('danger', Boolean(words.isDanger));
  dialog.returnValue = '';
  dialog.showModal();
  if (words.label !== undefined) input.select();
  else if (words.isDanger) find('button[value=""]', dialog).focus();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      resolve(dialog.returnValue === 'yes' ? { text: input.value.trim(), format: find('select', format).value } : null);
    }, { once: true });
  });
}
