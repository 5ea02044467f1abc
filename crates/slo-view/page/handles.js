// Handles over the picture that move, turn and scale what is selected. Each drag is one change of the text.

import { Eye, add, cross, dot, round, stepped, subtract, times, unit } from "./space.js";

const SVG = "http://www.w3.org/2000/svg";
/** Length of a handle, in pixels of the window. */
const LENGTH = 90;
const NAMES = ["x", "y", "z"];
const MODES = { move: "Move", rotate: "Turn", scale: "Scale" };
const SCENE_AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
/** A press that moves less than so many pixels is a click. */
const CLICK = 4;
/** Degrees, and shares, of a step that snaps. */
const SNAP_DEGREES = 15;
const SNAP_SCALE = 0.1;

function make(name, attributes, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

export class Handles {
  #shown = null;
  #mode = "move";
  #own = false;
  #drag = null;
  #number = Date.now();

  /** `send` gets commands, `clicked` and `focused` places of the picture, `snaps` says whether steps are round without a key. */
  constructor(svg, screen, { send, snaps, changed, clicked, focused }) {
    Object.assign(this, { svg, screen, send, snaps, changed, clicked, focused });
    this.shapes = new Map();
    this.label = make("text", { class: "number", "aria-hidden": "true" });
    svg.append(this.label);
  }

  /** Takes what is selected, the camera, and vertices of what is selected, if they are shown. */
  show(picked, camera, vertices) {
    const handle = vertices ? vertices.handle : picked?.handle;
    const name = picked?.object;
    const { chosen = [] } = vertices ?? {};
    const what = chosen.length === 1 ? `vertex ${chosen[0]}` : `${chosen.length} vertices`;
    const label = vertices ? `${what} of ${name}` : name;
    if (this.#drag && this.#drag.label !== label) this.#drag = null;
    this.#shown = handle && camera ? { name, label, handle, camera, vertices: Boolean(vertices) } : null;
    this.draw();
  }

  set(mode, own = this.#own) {
    [this.#mode, this.#own] = [mode, own];
    this.#drag = null;
    this.changed(mode, own);
    this.draw();
  }

  /** What handles do; vertices are only moved. */
  get mode() {
    return this.#shown?.vertices ? "move" : this.#mode;
  }

  #eye() {
    const { canvas } = this.screen;
    return new Eye(this.#shown.camera, canvas.width / canvas.height);
  }

  #axes() {
    return this.#own || this.mode === "scale" ? this.#shown.handle.axes : SCENE_AXES;
  }

  /** Where a point of space is on the stage, in pixels. */
  #on(eye, point) {
    const at = eye.project(point);
    return at && this.screen.onStage(at);
  }

  draw() {
    const keep = new Set();
    this.svg.classList.toggle("empty", !this.#shown);
    if (this.#shown) {
      const eye = this.#eye();
      const { handle } = this.#shown;
      const center = this.#on(eye, handle.at);
      const pixel = (2 * eye.fov * eye.depth(handle.at)) / this.screen.height();
      if (center && pixel > 0) {
        const far = pixel * LENGTH;
        this.#axes().forEach((axis, i) => {
          const line = this.mode === "rotate" ? this.#ring(eye, axis, far) : this.#line(eye, axis, far, center);
          if (line) keep.add(this.#place(NAMES[i], line));
        });
        if (this.mode !== "rotate") {
          const box = `M${center[0] - 7} ${center[1] - 7}h14v14h-14z`;
          keep.add(this.#place("all", { path: box, end: null, square: true }));
        }
        this.#write(center);
      }
    }
    for (const [name, shape] of this.shapes) {
      if (!keep.has(name)) {
        // It is forgotten first: if it has the focus, its removal draws the handles once more.
        this.shapes.delete(name);
        shape.remove();
      }
    }
    if (!this.#shown) this.label.textContent = "";
  }

  #line(eye, axis, far, center) {
    const end = this.#on(eye, add(this.#shown.handle.at, times(axis, far)));
    if (!end || Math.hypot(end[0] - center[0], end[1] - center[1]) < 8) return null;
    return { path: `M${center.join(" ")}L${end.join(" ")}`, end };
  }

  #ring(eye, axis, far) {
    const side = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const other = cross(axis, side);
    const points = [];
    for (let i = 0; i <= 48; i += 1) {
      const angle = (i / 48) * 2 * Math.PI;
      const way = add(times(side, Math.cos(angle) * far), times(other, Math.sin(angle) * far));
      const at = this.#on(eye, add(this.#shown.handle.at, way));
      if (!at) return null;
      points.push(at.map((part) => part.toFixed(1)).join(" "));
    }
    return { path: `M${points.join("L")}`, end: null };
  }

  /** Puts a handle somewhere; makes it if there is none. */
  #place(name, { path, end, square }) {
    let group = this.shapes.get(name);
    if (!group) {
      group = make("g", { class: `handle ${name}`, tabindex: "0", role: "slider", "data-handle": name },
        make("path", { class: "wide" }), make("path", { class: "thin" }), make("circle", { r: 6 }));
      this.#listen(group, name);
      this.shapes.set(name, group);
      // Tab reaches them in the same order, whichever of them was made last.
      const order = [...NAMES, "all"];
      const later = order.slice(order.indexOf(name) + 1).map((next) => this.shapes.get(next)).find(Boolean);
      this.svg.insertBefore(group, later ?? this.label);
    }
    const [wide, thin, tip] = group.children;
    wide.setAttribute("d", path);
    thin.setAttribute("d", path);
    group.classList.toggle("square", Boolean(square));
    tip.style.display = end ? "" : "none";
    if (end) [tip.cx.baseVal.value, tip.cy.baseVal.value] = end;
    const way = name === "all" ? (this.mode === "scale" ? "all axes" : "the plane of the picture") : name;
    group.setAttribute("aria-label", `${MODES[this.mode]} ${this.#shown.label}, ${way}`);
    const value = this.#drag?.handle === name ? this.#drag : null;
    group.setAttribute("aria-valuenow", value ? value.value : 0);
    group.setAttribute("aria-valuetext", value?.text ?? "at rest");
    return name;
  }

  #write(center) {
    this.label.textContent = this.#drag?.text ?? "";
    this.label.setAttribute("x", center[0] + 14);
    this.label.setAttribute("y", center[1] - 14);
  }

  #listen(group, name) {
    group.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      group.focus({ preventScroll: true });
      group.setPointerCapture(event.pointerId);
      this.#begin(name);
      this.#drag.from = this.screen.locateFreely(event);
      event.preventDefault();
      event.stopPropagation();
    });
    group.addEventListener("pointermove", (event) => {
      if (!this.#drag?.from || this.#drag.handle !== name) return;
      this.#drag.far += Math.abs(event.movementX) + Math.abs(event.movementY);
      if (this.#drag.far >= CLICK || this.#drag.text) this.#follow(event);
    });
    group.addEventListener("pointerup", (event) => {
      // A click that moves nothing is one of what is behind the handle.
      const at = this.#drag?.from && !this.#drag.text && this.screen.locate(event);
      this.#end();
      if (at) this.clicked(at);
    });
    group.addEventListener("pointercancel", () => this.#end());
    group.addEventListener("dblclick", (event) => {
      const at = this.screen.locate(event);
      if (at) this.focused(at);
    });
    group.addEventListener("blur", () => this.#end());
    group.addEventListener("keydown", (event) => this.#key(event, name));
  }

  #begin(name) {
    this.#number += 1;
    const { handle, name: thing, label, vertices } = this.#shown;
    this.#drag = {
      number: this.#number, name: thing, label, vertices, handle: name, start: handle, eye: this.#eye(), axes: this.#axes(),
      from: null, far: 0, value: 0, plane: [0, 0], text: "",
    };
  }

  #end() {
    this.#drag = null;
    this.draw();
  }

  /** The smallest step that can be seen, and the step that snaps. */
  #steps() {
    const { eye, start } = this.#drag;
    const pixel = (2 * eye.fov * eye.depth(start.at)) / this.screen.height();
    return { fine: round(pixel), snap: round(pixel * LENGTH * 0.4) };
  }

  #follow(event) {
    const drag = this.#drag;
    const { eye, start, axes, handle } = drag;
    const [from, to] = [eye.ray(drag.from), eye.ray(this.screen.locateFreely(event))];
    const snaps = event.ctrlKey !== this.snaps();
    const { fine, snap } = this.#steps();
    const axis = axes[NAMES.indexOf(handle)];
    if (this.mode === "rotate") {
      const [a, b] = [from, to].map((ray) => eye.meets(axis, start.at, ray)).map((at) => at && subtract(at, start.at));
      let degrees;
      if (a && b) {
        degrees = (Math.atan2(dot(cross(a, b), axis), dot(a, b)) * 180) / Math.PI;
        // Beyond half a turn, the angle goes on.
        degrees += 360 * Math.round((drag.value - degrees) / 360);
      } else {
        degrees = (this.screen.locateFreely(event)[0] - drag.from[0]) * 360;
      }
      this.#give(stepped(degrees, snaps ? SNAP_DEGREES : 0.5));
    } else if (handle === "all") {
      const [a, b] = [from, to].map((ray) => eye.meets(eye.forward, start.at, ray));
      if (!a || !b) return;
      const way = subtract(b, a);
      if (this.mode === "scale") {
        const far = (dot(way, eye.right) + dot(way, eye.up)) / (fine * LENGTH);
        this.#give(stepped(Math.exp(far * 0.5), snaps ? SNAP_SCALE : 0.01));
      } else {
        this.#giveWay(way.map((part) => stepped(part, snaps ? snap : fine)));
      }
    } else {
      const [a, b] = [from, to].map((ray) => eye.along(axis, start.at, ray));
      if (a === null || b === null) return;
      if (this.mode === "scale") this.#give(stepped(Math.max(0.01, b / (a || 1)), snaps ? SNAP_SCALE : 0.01));
      else this.#give(stepped(b - a, snaps ? snap : fine));
    }
  }

  /** Gives the handle that is held a value: a way, degrees or a factor. */
  #give(value) {
    const drag = this.#drag;
    const { axes, handle } = drag;
    const i = NAMES.indexOf(handle);
    drag.value = value;
    const command = { drag: drag.number, name: drag.name };
    const signed = `${value < 0 ? "" : "+"}${value}`;
    if (this.mode === "rotate") {
      drag.text = `${handle} ${signed}°`;
      this.send({ do: "rotate", ...command, axis: axes[i], degrees: value });
    } else if (this.mode === "scale") {
      const factor = Math.max(0.01, value);
      drag.text = `${handle === "all" ? "" : `${handle} `}× ${factor}`;
      this.send({ do: "scale", ...command, by: NAMES.map((name) => (name === handle || handle === "all" ? factor : 1)) });
    } else {
      drag.text = `${handle} ${signed}`;
      this.send({ do: "move", ...command, vertices: drag.vertices, by: times(axes[i], value) });
    }
    this.draw();
  }

  #giveWay(way) {
    const drag = this.#drag;
    drag.text = way.map((part) => `${part < 0 ? "" : "+"}${part}`).join("  ");
    this.send({ do: "move", drag: drag.number, name: drag.name, vertices: drag.vertices, by: way });
    this.draw();
  }

  #key(event, name) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (event.key === "Escape" && this.#drag) {
      this.#giveNothing();
      this.#end();
    } else if (event.key === "Enter" && this.#drag) {
      this.#end();
    } else if (sign) {
      if (this.#drag?.handle !== name) this.#begin(name);
      this.#nudge(event.key, sign, event.shiftKey);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  /** A step by the arrows; with Shift, a large one. */
  #nudge(key, sign, far) {
    const drag = this.#drag;
    const { snap } = this.#steps();
    if (this.mode === "rotate") {
      this.#give(stepped(drag.value + sign * (far ? SNAP_DEGREES : 1), 0.5));
    } else if (this.mode === "scale") {
      this.#give(stepped((drag.value || 1) * (1 + sign * (far ? 0.1 : 0.01)), 0.01));
    } else if (drag.handle === "all") {
      drag.plane[key === "ArrowUp" || key === "ArrowDown" ? 1 : 0] += sign * snap * (far ? 1 : 0.1);
      const way = add(times(drag.eye.right, drag.plane[0]), times(drag.eye.up, drag.plane[1]));
      this.#giveWay(way.map((part) => stepped(part, snap * 0.01)));
    } else {
      this.#give(stepped(drag.value + sign * snap * (far ? 1 : 0.1), snap * 0.1));
    }
  }

  /** Returns to where the thing was taken hold of. */
  #giveNothing() {
    if (this.mode === "move") this.#giveWay([0, 0, 0]);
    else this.#give(this.mode === "scale" ? 1 : 0);
  }
}
