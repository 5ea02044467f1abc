// The page: joins the picture, the panel, the mouse and the keys.

import { Moves, ask, follow } from "./server.js";
import { Screen, showFacts } from "./screen.js";
import { along, follow as followHands } from "./moves.js";
import { lens, showCamera, showFinish, showMessages, showPicked, showText } from "./panel.js";

const $ = (id) => document.getElementById(id);
const screen = new Screen($("screen"), $("stage"));
const known = { stage: null, distance: 1, fps: 25, exposure: 0, note: "" };
let playing = null;

function say(text) {
  if ($("status").textContent !== text) $("status").textContent = text;
}

function answered(answer) {
  if (answer?.refused) say(answer.refused);
  return answer;
}

const moves = new Moves(answered);
const request = async (command) => answered(await ask(command));

follow("picture", async (answer) => {
  const facts = await screen.draw(answer);
  showFacts(facts);
  // Tests and the curious can read what is on the screen.
  Object.assign(document.body.dataset, { picture: facts.picture, number: facts.number, ms: facts.ms, done: facts.done });
  played(facts);
  return facts.number;
}, lost);

follow("state", async (answer) => {
  const { number, scene, finish } = await answer.json();
  if (scene) show(scene);
  const failed = showFinish(finish);
  if (failed) say(failed);
  return number;
}, lost);

function lost() {
  say("The program does not answer. Has it ended?");
}

function show(scene) {
  document.title = `${scene.name} - slo-rt`;
  $("name").textContent = scene.name;
  showMessages(scene.messages, scene.fault);
  const errors = scene.messages.filter((message) => message.severity === "error").length;
  if (scene.text.changed) known.note = "";
  say(errors ? `${errors} error${errors > 1 ? "s" : ""}; the picture is the last good one` : scene.unwritten ?? known.note);
  known.object = scene.picked?.object;
  showPicked(scene.picked, (command) => moves.send(command));
  showText(scene.text);
  known.exposure = scene.exposure;
  if (document.activeElement !== $("exposure")) $("exposure").value = scene.exposure;
  $("exposure-value").textContent = scene.exposure;
  const select = $("accelerator");
  if (select.options.length === 1) select.append(...scene.accelerators.map((name) => new Option(name, name)));
  const { stage } = scene;
  if (!stage) return;
  known.stage = stage;
  known.fps = stage.fps;
  known.distance = showCamera(stage.camera, stage.fps) ?? known.distance;
  if (document.activeElement !== $("share")) $("share").value = stage.share;
  if (document.activeElement !== select) select.value = stage.accelerator ?? "";
  const full = stage.segments.filter((segment) => segment.first <= segment.last);
  $("frame").min = Math.min(...full.map((segment) => segment.first));
  $("frame").max = Math.max(...full.map((segment) => segment.last));
  if (document.activeElement !== $("frame") || playing) $("frame").value = stage.frame;
  $("frame-number").textContent = stage.frame;
}

/** Plays: as soon as a frame is seen, the one whose time has come is next. */
function play() {
  playing = playing ? null : { since: performance.now(), from: known.stage?.frame ?? 0, picture: -1 };
  $("play").setAttribute("aria-pressed", String(Boolean(playing)));
  $("play").textContent = playing ? "Stop" : "Play";
  next();
}

async function next() {
  if (!playing || !known.stage) return;
  const [first, last] = [Number($("frame").min), Number($("frame").max)];
  const passed = Math.round(((performance.now() - playing.since) / 1000) * known.fps);
  const frame = first + ((playing.from - first + Math.max(1, passed)) % (last - first + 1));
  const answer = await request({ do: "frame", frame });
  if (playing) playing.picture = answer?.picture ?? -1;
}

function played(facts) {
  if (playing && facts.picture >= playing.picture && playing.picture >= 0) {
    playing.picture = -1;
    next();
  }
}

const actions = {
  click: (at) => request({ do: $("tool").value, at }),
  focus: (at) => request({ do: "focus", at }),
  step: (by) => request({ do: "frame", frame: (known.stage?.frame ?? 0) + by }),
  play,
  expose: (by) => request({ do: "show", exposure: known.exposure + by }),
};
followHands(screen, moves, actions);

$("play").addEventListener("click", play);
$("frame").addEventListener("input", () => moves.send({ do: "frame", frame: Number($("frame").value) }));
$("exposure").addEventListener("input", () => moves.send({ do: "show", exposure: Number($("exposure").value) }));
$("share").addEventListener("change", () => request({ do: "show", share: Number($("share").value) }));
$("accelerator").addEventListener("change", () => request({ do: "show", accelerator: $("accelerator").value }));
for (const id of ["fov", "radius", "dof", "shutter"]) {
  $(id).addEventListener("input", () => moves.send({ do: "lens", ...lens(id, Number($(id).value), known) }));
}
for (const button of document.querySelectorAll("[data-zoom]")) {
  button.addEventListener("click", () => screen.setZoom(Number(button.dataset.zoom)));
}
for (const button of document.querySelectorAll("[data-axis]")) {
  button.addEventListener("click", () => along(button.dataset.axis.split(",").map(Number)));
}
for (const button of document.querySelectorAll("[data-object]")) {
  button.addEventListener("click", () => request({ do: button.dataset.object, name: known.object }));
}
for (const id of ["undo", "redo", "revert", "mine"]) {
  $(id).addEventListener("click", () => request({ do: id }));
}
$("theirs").addEventListener("click", () => request({ do: "revert" }));
const save = async () => {
  const answer = await request({ do: "save" });
  if (answer && !answer.refused) say((known.note = "Saved"));
};
$("save").addEventListener("click", save);
document.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text]")) return;
  const key = event.key.toLowerCase();
  if (key === "s") save();
  else if (key === "z") request({ do: event.shiftKey ? "redo" : "undo" });
  else return;
  event.preventDefault();
});
$("reset").addEventListener("click", () => request({ do: "reset" }));
$("finish").addEventListener("click", () => request({ do: $("finish").dataset.cancels ? "cancel" : "finish" }));
