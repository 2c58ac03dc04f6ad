// The scan in 3D, coloured by part or by confidence, and what the pointer is on.

import { BufferAttribute, BufferGeometry, Color, DoubleSide, Matrix4, MeshLambertMaterial, Points, PointsMaterial, Raycaster, SRGBColorSpace,
  Vector2 } from '../vendor/three-0.187.0.js';
import { Viewer } from '../viewer.js';

/** Size of a cloud's points, of a ring's, and how near a ray must pass a point to be on it [m]. */
const POINT = 0.007, RING_POINT = 0.014, ON_POINT = 0.008;

/** How near to a moved ring the points lie that show it [m]. */
const RING_WIDTH = 0.004;

const RING_COLOUR = 0xe6007e;

/** The view of a scan. */
export class LabelView {
  /** @param {HTMLElement} place @param {import('./painting.js').Painting} painting @param {any} told colours of parts and confidence */
  constructor(place, painting, told) {
    this.painting = painting;
    this.colours = new Map(told.parts.map(({ value, colour }) => [value, linear(colour)]));
    this.ends = [linear(told.unsure), linear(told.sure)];
    this.style = 'parts';
    this.viewer = new Viewer(place);
    this.viewer.scene.background = new Color(getComputedStyle(place).backgroundColor);
    const { scan } = painting;
    if (scan.faces.length) {
      this.viewer.add('scan', scan.positions, scan.faces);
      this.object = this.viewer.meshes.get('scan');
      this.object.material.dispose();
      this.object.material = new MeshLambertMaterial({ side: DoubleSide, vertexColors: true });
    } else {
      this.object = new Points(geometryOf(scan.positions), new PointsMaterial({ size: POINT, vertexColors: true }));
      this.viewer.meshes.set('scan', this.object);
      this.viewer.scene.add(this.object);
    }
    this.object.geometry.setAttribute('color', new BufferAttribute(new Float32Array(3 * scan.count), 3));
    Object.assign(this.viewer.mark.material, { transparent: true, opacity: 0.35 });
    this.viewer.frame();
    this.show();
  }

  get canvas() { return this.viewer.renderer.domElement; }

  /** Colour all points anew, before the browser's next picture. */
  show() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.#colour();
    });
  }

  #colour() {
    const { scan, label, ring } = this.painting, colour = this.object.geometry.attributes.color;
    for (let n = 0; n < scan.count; n += 1) {
      const own = this.style === 'confidence' && scan.confidence ? this.#sureness(n) : this.colours.get(label[n]);
      colour.array.set(own ?? [0.5, 0.5, 0.5], 3 * n);
    }
    colour.needsUpdate = true;
    this.#drawRing(ring);
    this.viewer.draw();
  }

  /** @param {number} n @returns {number[]} the colour of a point's confidence; painted ones are sure */
  #sureness(n) {
    const { scan, label } = this.painting;
    const sure = label[n] === scan.label[n] ? Math.min(Math.max(2 * scan.confidence[n] - 1, 0), 1) : 1;
    return this.ends[0].map((low, k) => low + sure * (this.ends[1][k] - low));
  }

  /** @param {any} ring */
  #drawRing(ring) {
    if (this.ring) {
      this.viewer.scene.remove(this.ring);
      this.ring.geometry.dispose();
      this.ring = null;
    }
    if (!ring) return;
    const near = [...ring.away].filter(([, away]) => Math.abs(away - ring.offset) < RING_WIDTH + 0.003).map(([n]) => n);
    const positions = Float32Array.from(near.flatMap((n) => [...this.painting.scan.positions.subarray(3 * n, 3 * n + 3)]));
    this.ring = new Points(geometryOf(positions), new PointsMaterial({ size: RING_POINT, color: RING_COLOUR, depthTest: false }));
    this.viewer.scene.add(this.ring);
  }

  /**
   * Find what a place on the screen shows.
   * @param {{clientX: number, clientY: number}} event
   * @returns {{at: number[], vertex: number}|null} the place [m], and the point nearest to it
   */
  pick(event) {
    if (this.painting.scan.faces.length) {
      const hit = this.viewer.pick('scan', event);
      if (!hit) return null;
      const best = hit.weights.indexOf(Math.max(...hit.weights));
      return { at: hit.point, vertex: this.painting.scan.faces[3 * hit.face + best] };
    }
    const box = this.canvas.getBoundingClientRect(), ray = new Raycaster();
    ray.params.Points.threshold = ON_POINT;
    ray.setFromCamera(new Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height),
      this.viewer.camera);
    const [hit] = ray.intersectObject(this.object);
    return hit ? { at: [...this.painting.scan.positions.subarray(3 * hit.index, 3 * hit.index + 3)], vertex: hit.index } : null;
  }

  /** @returns {import('./lasso.js').Screen} how the view shows places */
  get screen() {
    const { camera, place: { clientWidth: width, clientHeight: height } } = this.viewer;
    camera.updateMatrixWorld();
    const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
    return { width, height, matrix, size: POINT * camera.projectionMatrix.elements[5] * height / 2 };
  }

  /** @returns {{clientX: number, clientY: number}} the middle of the view on the screen */
  get middle() {
    const box = this.canvas.getBoundingClientRect();
    return { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
  }

  /** Show how far the brush reaches. @param {number[]|null} at @param {number} radius [m] */
  setBrush(at, radius) {
    this.viewer.mark.geometry.computeBoundingSphere();
    this.viewer.mark.scale.setScalar(radius / this.viewer.mark.geometry.boundingSphere.radius);
    this.viewer.setMark(at);
  }

  /** Let the left button, or one finger, turn the view, or leave it to a tool. @param {boolean} isLooking */
  setLooking(isLooking) {
    const { controls } = this.viewer;
    controls.mouseButtons = { LEFT: isLooking ? 0 : null, MIDDLE: 1, RIGHT: isLooking ? 2 : 0 };
    controls.touches = { ONE: isLooking ? 0 : null, TWO: isLooking ? 2 : 3 };
  }
}

/** @param {number[]} rgb in 0..1 as in a picture @returns {number[]} as light adds up */
const linear = (rgb) => new Color().setRGB(...rgb, SRGBColorSpace).toArray();

/** @param {Float32Array} positions @returns {BufferGeometry} */
function geometryOf(positions) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  return geometry;
}
