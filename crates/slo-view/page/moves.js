// The mouse and the keys over the picture.

import { ask } from "./server.js";

/** A drag over the whole height of the picture turns by so many radians. */
const TURN = 3;
/** Steps of the keys: radians, and shares of the distance from what is looked at. */
const KEY_TURN = 0.1;
const KEY_STEP = 0.04;
/** A press that moves less than so many pixels is a click. */
const CLICK = 4;

const addPairs = (a, b) => ({ ...b, by: b.by.map((part, i) => part + a.by[i]) });
const multiply = (a, b) => ({ ...b, by: a.by * b.by });

export function follow(screen, moves, actions) {
  const { canvas, stage } = screen;
  const orbit = (yaw, pitch) => moves.send({ do: "orbit", by: [yaw, pitch] }, addPairs);
  const turn = (yaw, pitch) => moves.send({ do: "turn", by: [yaw, pitch] }, addPairs);
  const walk = (...by) => moves.send({ do: "walk", by }, addPairs);

  let press = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    press = { x: event.clientX, y: event.clientY, button: event.button, far: 0 };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!press) return;
    const [dx, dy] = [event.clientX - press.x, event.clientY - press.y];
    [press.x, press.y] = [event.clientX, event.clientY];
    press.far += Math.abs(dx) + Math.abs(dy);
    if (press.far < CLICK) return;
    const height = canvas.getBoundingClientRect().height;
    const [yaw, pitch] = [(dx / height) * TURN, (dy / height) * TURN];
    if (press.button === 2 || event.altKey) turn(yaw / 3, -pitch / 3);
    else if (press.button === 1 || event.shiftKey) walk(-dx / height, dy / height, 0);
    else orbit(yaw, pitch);
  });
  canvas.addEventListener("pointerup", (event) => {
    const was = press;
    press = null;
    const at = was && was.button === 0 && was.far < CLICK ? screen.locate(event) : null;
    if (at) actions.click(at);
  });
  canvas.addEventListener("pointercancel", () => (press = null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", (event) => {
    const at = screen.locate(event);
    if (at) actions.focus(at);
  });

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const box = stage.getBoundingClientRect();
    if (event.ctrlKey) {
      const zoom = screen.scale() * devicePixelRatio * 2 ** (-event.deltaY / 250);
      screen.setZoom(Math.min(64, Math.max(0.05, zoom)), { x: event.clientX - box.left, y: event.clientY - box.top });
    } else {
      const by = Math.min(4, Math.max(0.25, 2 ** (event.deltaY / 500)));
      moves.send({ do: "dolly", by }, multiply);
    }
  }, { passive: false });

  // What keys act on: where the mouse is over the picture, or else its middle.
  let pointer = null;
  canvas.addEventListener("pointermove", (event) => (pointer = screen.locate(event)));
  canvas.addEventListener("pointerleave", () => (pointer = null));
  const here = () => pointer ?? [0.5, 0.5];

  const keys = {
    Enter: () => actions.click(here()), f: () => actions.focus(here()), "?": () => actions.why(here()),
    m: () => actions.handles("move"), t: () => actions.handles("rotate"), c: () => actions.handles("scale"),
    o: actions.overlay, v: actions.vertices,
    w: () => walk(0, 0, KEY_STEP), s: () => walk(0, 0, -KEY_STEP),
    a: () => walk(-KEY_STEP, 0, 0), d: () => walk(KEY_STEP, 0, 0),
    e: () => walk(0, KEY_STEP, 0), q: () => walk(0, -KEY_STEP, 0),
    r: () => ask({ do: "reset" }),
    ",": () => actions.step(-1), ".": () => actions.step(1), " ": actions.play,
    "+": () => actions.expose(0.25), "=": () => actions.expose(0.25), "-": () => actions.expose(-0.25),
    0: () => screen.setZoom(0), 1: () => screen.setZoom(1),
  };
  const arrows = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const axes = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (arrows[key]) {
      const [x, y] = arrows[key].map((part) => part * KEY_TURN);
      if (event.shiftKey) turn(-x, y); else orbit(x, y);
    } else if (axes[key]) {
      along(axes[key].map((part) => (event.shiftKey ? -part : part)));
    } else if (keys[key]) {
      keys[key]();
    } else {
      return;
    }
    event.preventDefault();
  });
}

/** Looks along an axis. */
export function along(axis) {
  return ask({ do: "along", axis });
}
