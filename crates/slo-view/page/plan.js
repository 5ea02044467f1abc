// The scene from above, with the camera's path. Its control points can be dragged.

import { add, subtract, times, unit } from "./space.js";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = 0.08;

function make(name, attributes, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** A point of a Bezier curve. */
function bezier(points, t) {
  let all = points;
  while (all.length > 1) all = all.slice(1).map((next, i) => add(times(all[i], 1 - t), times(next, t)));
  return all[0];
}

const curve = (points) => Array.from({ length: 65 }, (_, i) => bezier(points, i / 64));

export class Plan {
  #path = null;
  #held = null;
  #number = Date.now();

  /** `send` gets commands. */
  constructor(svg, send) {
    Object.assign(this, { svg, send });
    this.frame = null;
  }

  /** Shows boxes of objects and the path of a segment; `camera` is the view of the frame. */
  show(boxes, path, camera) {
    this.#path = path;
    if (!boxes || !path) return;
    // The frame stays while a point is dragged.
    if (!this.#held || !this.frame) this.frame = this.#around(boxes, path);
    const { scale } = this.frame;
    const children = boxes.map(({ name, min, max }) => make("rect", {
      x: min[0], y: -max[1], width: max[0] - min[0], height: max[1] - min[1], class: "thing",
    }, make("title", {}, name)));
    for (const [kind, points] of [["target", path.targets], ["position", path.positions]]) {
      if (points.length > 1) {
        children.push(make("polyline", { class: `cage ${kind}`, points: points.map(([x, y]) => `${x},${-y}`).join(" ") }));
        children.push(make("polyline", { class: `curve ${kind}`, points: curve(points).map(([x, y]) => `${x},${-y}`).join(" ") }));
      }
    }
    if (camera) {
      const forward = unit(subtract(camera.target, camera.position));
      const at = camera.position;
      const side = [-forward[1] * camera.fov, forward[0] * camera.fov, 0];
      const corners = [1, -1].map((sign) => add(at, times(add(forward, times(side, sign)), 40 * scale)));
      children.push(make("polygon", { class: "eye", points: [at, ...corners].map(([x, y]) => `${x},${-y}`).join(" ") }));
    }
    const kept = this.svg.querySelector(":focus")?.dataset;
    const focus = kept && `${kept.kind} ${kept.index}`;
    for (const [kind, points] of [["target", path.targets], ["position", path.positions]]) {
      points.forEach((point, index) => children.push(this.#point(kind, index, point)));
    }
    if (this.#held?.pointer) return this.#update();
    this.svg.replaceChildren(...children);
    const [x, y, width, height] = this.frame.box;
    this.svg.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
    if (focus) {
      const [kind, index] = focus.split(" ");
      this.svg.querySelector(`[data-kind="${kind}"][data-index="${index}"]`)?.focus();
    }
  }

  /** Moves what is there, so that the point that is dragged stays the same element. */
  #update() {
    for (const kind of ["target", "position"]) {
      const points = this.#path[`${kind}s`];
      const line = (name, all) => this.svg.querySelector(`.${name}.${kind}`)?.setAttribute("points", all.map(([x, y]) => `${x},${-y}`).join(" "));
      line("cage", points);
      line("curve", curve(points));
    }
  }

  #around(boxes, path) {
    const points = [...path.positions, ...path.targets, ...boxes.flatMap(({ min, max }) => [min, max])];
    const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => -y)];
    const least = [Math.min(...xs), Math.min(...ys)];
    const size = Math.max(Math.max(...xs) - least[0], Math.max(...ys) - least[1], 1e-6) * (1 + 2 * MARGIN);
    const middle = [(Math.max(...xs) + least[0]) / 2, (Math.max(...ys) + least[1]) / 2];
    const box = [middle[0] - size / 2, middle[1] - size / 2, size, size];
    return { box, scale: size / 400 };
  }

  #point(kind, index, [x, y, z]) {
    const shape = make("circle", {
      cx: x, cy: -y, r: 5 * this.frame.scale, class: `point ${kind}`, tabindex: "0", role: "button",
      "data-kind": kind, "data-index": index,
      "aria-label": `${kind} ${index + 1} of the camera, at ${[x, y, z].map((part) => Number(part.toPrecision(4))).join(" ")}; arrows move it, Page Up and Page Down raise and lower it`,
    }, make("title", {}, `${kind} ${index + 1}`));
    shape.addEventListener("pointerdown", (event) => {
      shape.setPointerCapture(event.pointerId);
      this.#hold(kind, index, true);
      event.preventDefault();
      shape.focus({ preventScroll: true });
    });
    shape.addEventListener("pointermove", (event) => {
      if (!this.#held?.pointer) return;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
      [shape.cx.baseVal.value, shape.cy.baseVal.value] = [at.x, at.y];
      this.#give([at.x, -at.y, this.#path[`${kind}s`][index][2]]);
    });
    const end = () => (this.#held = null);
    shape.addEventListener("pointerup", end);
    shape.addEventListener("pointercancel", end);
    shape.addEventListener("keydown", (event) => {
      const way = {
        ArrowRight: [1, 0, 0], ArrowLeft: [-1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
        PageUp: [0, 0, 1], PageDown: [0, 0, -1],
      }[event.key];
      if (!way) return;
      event.preventDefault();
      if (this.#held?.kind !== kind || this.#held?.index !== index) this.#hold(kind, index, false);
      const step = this.frame.scale * (event.shiftKey ? 40 : 4);
      this.#give(add(this.#path[`${kind}s`][index], times(way, step)));
    });
    return shape;
  }

  #hold(kind, index, pointer) {
    this.#number += 1;
    this.#held = { kind, index, pointer, number: this.#number };
  }

  #give(to) {
    const { kind, index, number } = this.#held;
    // As many digits as can be seen.
    const digits = Math.max(0, Math.ceil(-Math.log10(this.frame.scale)));
    const rounded = to.map((part) => Number(part.toFixed(Math.min(12, digits))));
    this.#path[`${kind}s`][index] = rounded;
    this.send({ do: "point", drag: number, segment: this.#path.segment, of: kind, index, to: rounded });
  }
}
