// Vertices of the selected mesh: shown over the picture, chosen by click or by keys.

import { Eye } from "./space.js";

const SVG = "http://www.w3.org/2000/svg";
/** How long the mouse or the camera must rest before the vertices near it are asked for, in milliseconds. */
const REST = 150;

export class Vertices {
  #shown = null;
  #camera = "";
  #near = [0.5, 0.5];
  #rest = null;
  /** The vertex that Tab reaches. */
  #current = null;

  /** `request` sends commands. */
  constructor(svg, screen, request) {
    Object.assign(this, { svg, screen, request });
    this.shapes = new Map();
    screen.canvas.addEventListener("pointermove", (event) => {
      const at = event.buttons === 0 && screen.locate(event);
      if (!at || !this.#shown) return;
      this.#near = at;
      if (!this.#shown.vertices.all) this.#later();
    });
  }

  /** Whether vertices are shown. */
  get isOn() {
    return this.#shown !== null;
  }

  toggle() {
    if (this.isOn) this.request({ do: "vertices", shown: false });
    else this.#ask();
  }

  /** Takes the vertices, the number of all of them, and the camera. */
  show(vertices, count, camera, name) {
    const button = document.getElementById("vertices-button");
    button.hidden = !count;
    button.setAttribute("aria-pressed", String(Boolean(vertices)));
    const note = document.getElementById("vertices-note");
    note.hidden = !vertices;
    if (vertices) {
      const chosen = vertices.chosen.length ? `, ${vertices.chosen.length} chosen` : "";
      note.textContent = `${vertices.shown.length} of ${count} vertices are shown${chosen}. Click one; with Shift, several.`;
    }
    this.#shown = vertices && camera ? { vertices, camera, name } : null;
    // Others are in front when the camera has moved.
    const seen = JSON.stringify(camera);
    if (this.#shown && this.#camera !== seen && this.#camera) this.#later();
    this.#camera = seen;
    this.draw();
  }

  draw() {
    const keep = new Set();
    this.svg.classList.toggle("empty", !this.#shown);
    if (this.#shown) {
      const { vertices, camera } = this.#shown;
      const { canvas } = this.screen;
      const eye = new Eye(camera, canvas.width / canvas.height);
      const chosen = new Set(vertices.chosen);
      for (const [index, ...at] of vertices.shown) {
        const place = eye.project(at);
        if (!place) continue;
        keep.add(index);
        this.#place(index, at, this.screen.onStage(place), chosen.has(index));
      }
    }
    for (const [index, shape] of this.shapes) {
      if (!keep.has(index)) {
        this.shapes.delete(index);
        shape.remove();
      }
    }
    if (!keep.has(this.#current)) this.#current = [...keep][0] ?? null;
    for (const [index, shape] of this.shapes) shape.setAttribute("tabindex", index === this.#current ? "0" : "-1");
  }

  #place(index, at, [x, y], isChosen) {
    let shape = this.shapes.get(index);
    if (!shape) {
      shape = document.createElementNS(SVG, "circle");
      for (const [key, value] of [["r", 4], ["class", "vertex"], ["role", "button"], ["data-vertex", index]]) shape.setAttribute(key, value);
      shape.addEventListener("click", (event) => this.#choose(index, event.shiftKey));
      shape.addEventListener("keydown", (event) => this.#key(event, index));
      this.shapes.set(index, shape);
      this.svg.append(shape);
    }
    [shape.cx.baseVal.value, shape.cy.baseVal.value] = [x, y];
    shape.classList.toggle("chosen", isChosen);
    shape.setAttribute("aria-pressed", String(isChosen));
    const numbers = at.map((part) => Number(part.toPrecision(4))).join(" ");
    shape.setAttribute("aria-label", `vertex ${index} of ${this.#shown.name}, at ${numbers}`);
  }

  #choose(index, beside) {
    this.#current = index;
    this.request({ do: "vertex", vertex: index, beside });
  }

  #key(event, index) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const way = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (event.key === "Enter" || event.key === " ") this.#choose(index, event.shiftKey);
    else if (way) this.#go(index, way);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Goes to the nearest vertex in a direction of the picture. */
  #go(index, [dx, dy]) {
    const at = (shape) => [shape.cx.baseVal.value, shape.cy.baseVal.value];
    const [x, y] = at(this.shapes.get(index));
    let best = null;
    for (const [other, shape] of this.shapes) {
      const [a, b] = at(shape);
      const ahead = (a - x) * dx + (b - y) * dy;
      const aside = Math.abs((a - x) * dy) + Math.abs((b - y) * dx);
      if (other === index || ahead <= 0.5) continue;
      const far = ahead + 2 * aside;
      if (!best || far < best.far) best = { far, other, shape };
    }
    if (!best) return;
    this.#current = best.other;
    for (const [other, shape] of this.shapes) shape.setAttribute("tabindex", other === best.other ? "0" : "-1");
    best.shape.focus();
  }

  #later() {
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => this.isOn && this.#ask(), REST);
  }

  #ask() {
    return this.request({ do: "vertices", shown: true, near: this.#near });
  }
}
