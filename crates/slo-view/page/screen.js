// The picture: drawn as it comes, zoomed and panned.

export class Screen {
  constructor(canvas, stage) {
    this.canvas = canvas;
    this.stage = stage;
    this.zoom = 0; // 0: fits
    this.pan = { x: 0, y: 0 };
    /** Called when the picture is somewhere else on the stage. */
    this.placed = () => {};
    new ResizeObserver(() => this.place()).observe(stage);
  }

  /** Draws a picture from its file; `facts` has its size. */
  async draw(facts, file) {
    const image = await createImageBitmap(file);
    const { canvas } = this;
    const isNew = canvas.width !== facts.width || canvas.height !== facts.height;
    if (isNew) [canvas.width, canvas.height] = [facts.width, facts.height];
    const context = canvas.getContext("2d", { alpha: false });
    context.imageSmoothingEnabled = image.width !== facts.width;
    context.drawImage(image, 0, 0, facts.width, facts.height);
    image.close();
    if (isNew) this.place();
  }

  /** Sets the zoom, in pixels of the screen for a pixel; 0 fits the picture. `at` stays where it is. */
  setZoom(zoom, at) {
    const before = this.scale();
    this.zoom = zoom;
    const after = this.scale();
    if (at) {
      this.pan.x = at.x - (at.x - this.pan.x) * (after / before);
      this.pan.y = at.y - (at.y - this.pan.y) * (after / before);
    } else {
      this.pan = { x: 0, y: 0 };
    }
    this.place();
  }

  scale() {
    const { width, height } = this.stage.getBoundingClientRect();
    const fit = Math.min(width / this.canvas.width, height / this.canvas.height);
    return this.zoom === 0 ? fit : this.zoom / devicePixelRatio;
  }

  place() {
    const { width, height } = this.stage.getBoundingClientRect();
    const scale = this.scale();
    if (this.zoom === 0) {
      this.pan = { x: (width - this.canvas.width * scale) / 2, y: (height - this.canvas.height * scale) / 2 };
    }
    this.canvas.style.transform = `translate(${this.pan.x}px, ${this.pan.y}px) scale(${scale})`;
    this.canvas.classList.toggle("sharp", scale * devicePixelRatio >= 1.5);
    this.placed();
  }

  /** Height of the picture on the stage, in pixels of the window. */
  height() {
    return this.canvas.height * this.scale();
  }

  /** Where a place of the picture is on the stage, in pixels of the window. */
  onStage([u, v]) {
    const scale = this.scale();
    return [this.pan.x + u * this.canvas.width * scale, this.pan.y + v * this.canvas.height * scale];
  }

  /** Where a point of the window is in the picture; numbers outside of it are not from 0 to 1. */
  locateFreely(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  /** Where a point of the window is in the picture, from 0 to 1; null outside. */
  locate(event) {
    const at = this.locateFreely(event);
    return at.every((part) => part >= 0 && part <= 1) ? at : null;
  }
}
