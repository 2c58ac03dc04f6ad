/** The visible part of the board: the SVG's viewBox, moved and zoomed. */

/** Least and most of the board across the view [mm]. */
const LEAST = 20,
  MOST = 20000;

export class Camera {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.svg = svg;
    this.box = { x: 0, y: 0, width: 1000, height: 1000 };
  }

  /** Return the size of the view [px]. */
  get size() {
    return { width: this.svg.clientWidth || 1, height: this.svg.clientHeight || 1 };
  }

  /** Return how many mm of the board a pixel is. */
  get scale() {
    return Math.max(this.box.width / this.size.width, this.box.height / this.size.height);
  }

  /** Show all of a box [mm]. */
  fit({ x, y, width, height }, margin = 1.06) {
    const size = this.size;
    const scale = Math.max(width / size.width, height / size.height) * margin;
    const [w, h] = [scale * size.width, scale * size.height];
    this.set({ x: x + (width - w) / 2, y: y + (height - h) / 2, width: w, height: h });
  }

  /** Return the place of the board [mm] under a place of the window [px]. */
  toBoard(clientX, clientY) {
    const frame = this.svg.getBoundingClientRect(),
      size = this.size,
      scale = this.scale;
    const left = this.box.x + (this.box.width - scale * size.width) / 2,
      top = this.box.y + (this.box.height - scale * size.height) / 2;
    return [left + (clientX - frame.left) * scale, top + (clientY - frame.top) * scale];
  }

  /** Zoom by a factor (above 1: nearer) around a place of the board. */
  zoom(factor, [x, y] = [this.box.x + this.box.width / 2, this.box.y + this.box.height / 2]) {
    const width = Math.min(Math.max(this.box.width / factor, LEAST), MOST),
      share = width / this.box.width;
    this.set({
      x: x - (x - this.box.x) * share,
      y: y - (y - this.box.y) * share,
      width,
      height: this.box.height * share,
    });
  }

  /** Move the view by pixels. */
  pan(dx, dy) {
    const { scale } = this;
    this.set({ ...this.box, x: this.box.x - dx * scale, y: this.box.y - dy * scale });
  }

  set(box) {
    this.box = box;
    this.svg.style.setProperty('--mm', this.scale.toFixed(4)); // letters keep their size at any zoom
    this.svg.setAttribute('viewBox', `${box.x} ${box.y} ${box.width} ${box.height}`);
  }
}
