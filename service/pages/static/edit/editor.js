/** The editor's page: loads the pattern, joins its parts, and draws once a frame what has changed. */

import { getText, putJson } from '../api.js';
import { find, make, showError } from '../dom.js';
import { Camera } from './camera.js';
import { COMMANDS, commandOf, nudge } from './commands.js';
import { joinDistances } from './distances.js';
import { Draping } from './draping.js';
import { Drawing } from './drawing.js';
import { toBoard } from './layout.js';
import { withNames } from './names.js';
import { panelOutline, patternFile, readPattern, writePattern } from './pattern_model.js';
import { Pointer } from './pointer.js';
import { Session } from './session.js';
import { Space } from './space.js';
import { SeamTable, describeDifferences, describeSelection } from './tables.js';

/** Pixels that an arrow key moves the view where nothing is selected. */
const PAN = 40;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Return the box of all panels on the board [mm]. */
function boxOf(session) {
  const all = session.pattern.panels.flatMap((panel) =>
    panelOutline(panel, 8).map((point) => toBoard(session.placeOf(panel.name), point)),
  );
  const [low, high] = [Math.min, Math.max].map((pick) => [0, 1].map((k) => pick(...all.map((point) => point[k]))));
  return { x: low[0], y: low[1], width: high[0] - low[0], height: high[1] - low[1] };
}

/** Call once a frame, however often it is asked for. */
function onceAFrame(work) {
  let waiting = null;
  return () => {
    waiting ??= requestAnimationFrame(() => {
      waiting = null;
      work();
    });
  };
}

/** Join session, drawing and tables; return what shows the present state at once. */
function joinViews(session, svg, camera, drawing) {
  const seams = new SeamTable(find('#seams'), find('#seams-summary'), session);
  const words = (place, lines, tag) => find(place).replaceChildren(...lines.map((line) => make(tag, {}, line)));
  const render = () => {
    drawing.render();
    seams.render();
    words('#selection', describeSelection(session), 'p');
    if (session.shown === null) words('#differences', describeDifferences(session.pattern, session.original), 'li');
    find('[data-command="undo"]').disabled = !session.canUndo;
    find('[data-command="redo"]').disabled = !session.canRedo;
    svg.dataset.tool = session.tool;
  };
  // A drag draws within the frame that moved it; all else at the next frame.
  const later = onceAFrame(render);
  session.addEventListener('pattern', () => (session.shown === null ? later() : render()));
  for (const name of ['selection', 'options', 'faults']) session.addEventListener(name, later);
  session.addEventListener('fit', () => camera.fit(boxOf(session)));
  session.addEventListener('said', ({ detail }) => {
    const said = find('#said');
    said.textContent = detail.text;
    said.className = detail.bad ? 'bad' : '';
  });
  return render;
}

function joinCommands(session, camera, svg) {
  const groups = new Map();
  for (const command of COMMANDS) {
    if (!groups.has(command.group))
      groups.set(command.group, make('div.group', { role: 'group', 'aria-label': command.group }));
    const title = `${command.help || command.label} (${command.keys[0]})`;
    groups
      .get(command.group)
      .append(
        make(
          'button',
          { type: 'button', 'data-command': command.name, title, onclick: () => command.run(session, camera, false) },
          command.label,
        ),
      );
    find('#shortcuts').append(
      make('dt', {}, command.keys.join(' ')),
      make('dd', {}, `${command.label}${command.help ? `: ${command.help}` : ''}`),
    );
  }
  find('#shortcuts').append(
    make('dt', {}, 'Arrows'),
    make('dd', {}, 'Move the selection by the step, with Shift by ten; move the view if nothing is selected'),
  );
  find('#commands').append(...groups.values());
  svg.addEventListener('keydown', (event) => {
    const arrow = ARROWS[event.key];
    const command = commandOf(event);
    if (arrow) {
      const by = session.options.step * (event.shiftKey ? 10 : 1);
      if (session.selection.length) nudge(session, [arrow[0] * by, arrow[1] * by]);
      else camera.pan(-PAN * arrow[0], PAN * arrow[1]);
    } else if (command) command.run(session, camera, event.shiftKey);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  // Elsewhere on the page keys without Ctrl are left to what has the focus.
  document.addEventListener('keydown', (event) => {
    const command = event.ctrlKey || event.metaKey ? commandOf(event) : null;
    if (!command || command.name === 'all' || event.target.matches('input, textarea, select')) return;
    event.preventDefault();
    command.run(session, camera, event.shiftKey);
  });
}

function joinOptions(session) {
  for (const input of document.querySelectorAll('[data-option]')) {
    const read = () => (input.type === 'checkbox' ? input.checked : Math.max(Number(input.value) || 0, 0));
    session.setOption(input.dataset.option, read());
    input.addEventListener('change', () => session.setOption(input.dataset.option, read()));
  }
  const tools = [...document.querySelectorAll('[data-tool][aria-pressed]')];
  for (const button of tools) {
    button.addEventListener('click', () => {
      for (const other of tools) other.setAttribute('aria-pressed', String(other === button));
      session.setTool(button.dataset.tool);
    });
  }
}

function joinFile(session, name) {
  find('#download').addEventListener('click', () => {
    const url = URL.createObjectURL(new Blob([writePattern(session.present)], { type: 'application/json' }));
    make('a', { href: url, download: `${name}.json` }).click();
    URL.revokeObjectURL(url);
    session.say('Downloaded.');
  });
  find('#save-template').addEventListener('click', async () => {
    const input = find('#template-name'),
      saved = find('#saved');
    try {
      await putJson(`/v1/templates/${encodeURIComponent(input.value)}`, patternFile(session.present));
      saved.replaceChildren(
        make(
          'p',
          {},
          'Saved as the template ',
          make('a', { href: `/templates/${encodeURIComponent(input.value)}/edit` }, input.value),
          '.',
        ),
      );
    } catch (error) {
      showError(saved, error);
    }
  });
}

async function open() {
  const { job, template } = find('#editor').dataset;
  const text = await getText(job ? `/v1/jobs/${job}/artifacts/pattern.json` : `/v1/templates/${template}`);
  const { panels, pieces } = JSON.parse(find('#editor').dataset.names);
  const session = new Session(withNames(readPattern(text), panels), pieces);
  const svg = find('#board'),
    camera = new Camera(svg),
    drawing = new Drawing(svg, session);
  joinCommands(session, camera, svg);
  joinOptions(session);
  joinFile(session, template || job);
  const render = joinViews(session, svg, camera, drawing);
  new Pointer(svg, session, camera, drawing);
  joinDistances(session);
  const aspect = () => camera.size.width / camera.size.height;
  session.arrange(aspect());
  render();
  camera.fit(boxOf(session));
  new ResizeObserver(() => {
    if (session.at === 0 && Math.abs(session.aspect / aspect() - 1) > 0.1) session.arrange(aspect());
    camera.fit(boxOf(session));
  }).observe(svg);
  find('#editor').session = session;
  session.say('Ready.');
  if (job) await new Draping(session, new Space(find('#draped'), session, drawing), job).begin();
}

open().catch((error) => showError(find('#said'), error));
