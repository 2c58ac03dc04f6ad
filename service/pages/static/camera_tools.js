// Buttons that look from the sides, and the turntable, which rests where the visitor wants no motion.
import { find } from './dom.js';

/** Angles of the sides, around the upright axis [rad]. */
const SIDES = { front: 0, left: Math.PI / 2, back: Math.PI, right: -Math.PI / 2 };

/**
 * Listen to the buttons of a page's 3D views.
 * @param {import('./viewer.js').Viewer} viewer the view that turns
 * @param {(angle: number) => void} look frames what is shown from an angle [rad]
 */
export function startCamera(viewer, look) {
  const turntable = find('#turntable'), still = matchMedia('(prefers-reduced-motion: reduce)');
  const spin = (isOn) => {
    turntable.setAttribute('aria-pressed', String(isOn));
    viewer.spin(isOn);
  };
  const obey = () => {
    turntable.hidden = still.matches;
    if (still.matches) spin(false);
  };
  turntable.addEventListener('click', () => spin(!viewer.isSpinning));
  still.addEventListener('change', obey);
  obey();
  for (const button of document.querySelectorAll('[data-side]')) {
    button.addEventListener('click', () => {
      spin(false);
      look(SIDES[button.dataset.side]);
    });
  }
}
