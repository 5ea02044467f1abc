// The page: joins the picture, the panel, the mouse and the keys.

import { Moves, ask, follow } from "./server.js";
import { Screen } from "./screen.js";
import { showFacts } from "./facts.js";
import { Handles } from "./handles.js";
import { Plan } from "./plan.js";
import { showWhy } from "./why.js";
import { Other } from "./other.js";
import { Vertices } from "./vertices.js";
import { along, follow as followHands } from "./moves.js";
import { lens, showCamera, showFinish, showMessages, showPicked, showText } from "./panel.js";

const $ = (id) => document.getElementById(id);
const screen = new Screen($("screen"), $("stage"));
const known = { stage: null, frames: [], distance: 1, fps: 25, exposure: 0, note: "" };
let playing = null;

function say(text) {
  if ($("status").textContent !== text) $("status").textContent = text;
}

/** How long a refusal stays, whatever else there is to say, in milliseconds. */
const REFUSAL = 4000;
/** Least time between two states of the scene, in milliseconds: while something is dragged, the picture goes first. */
const STATE = 60;

function answered(answer) {
  known.refused = answer?.refused ? { text: answer.refused, at: performance.now() } : null;
  if (answer?.refused) say(answer.refused);
  return answer;
}

const moves = new Moves(answered);
const request = async (command) => answered(await ask(command));
const other = new Other(request);
const plan = new Plan($("plan"), (command) => moves.send(command));
const handles = new Handles($("handles"), screen, {
  send: (command) => moves.send(command),
  snaps: () => $("snap").checked,
  clicked: (at) => actions.click(at),
  focused: (at) => actions.focus(at),
  changed: (mode, own) => {
    for (const button of document.querySelectorAll("[data-mode]")) {
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    }
    $("axes").value = own ? "own" : "scene";
  },
});
const vertices = new Vertices($("vertices"), screen, request);
screen.placed = () => {
  handles.draw();
  vertices.draw();
};

follow("picture", 0, {
  read: async (answer) => {
    const facts = JSON.parse(answer.headers.get("slo-facts"));
    return { number: facts.number, facts, file: await answer.blob() };
  },
  use: async ({ facts, file }) => {
    await screen.draw(facts, file);
    known.facts = facts;
    showFacts(facts, Number($("noise").value));
    // Tests and the curious can read what is on the screen.
    Object.assign(document.body.dataset, { picture: facts.picture, number: facts.number, ms: facts.ms, done: facts.done });
    played(facts);
  },
  lost,
});

follow("state", STATE, {
  read: (answer) => answer.json(),
  use: ({ scene, finish }) => {
    if (scene) show(scene);
    const failed = showFinish(finish);
    if (failed) say(failed);
  },
  lost,
});

function lost() {
  say("The program does not answer. Has it ended?");
}

function show(scene) {
  document.title = `${scene.name} - slo-rt`;
  $("name").textContent = scene.name;
  showMessages(scene.messages, scene.fault);
  const errors = scene.messages.filter(({ severity, of }) => severity === "error" && !of).length;
  known.errors = errors;
  if (scene.text.changed) known.note = "";
  const count = `${errors} error${errors > 1 ? "s" : ""}`;
  const refused = known.refused && performance.now() - known.refused.at < REFUSAL ? known.refused.text : null;
  if (refused) say(refused);
  else say(errors ? `${count}; the picture is the last good one` : scene.unwritten ?? (known.note || scene.missing || scene.overlay.fault || ""));
  known.object = scene.picked?.object;
  showPicked(scene.picked, (command) => moves.send(command));
  handles.show(scene.picked, scene.stage?.camera, scene.vertices);
  vertices.show(scene.vertices, scene.mesh, scene.stage?.camera, known.object);
  showWhy(scene.why);
  plan.show(scene.plan, scene.stage?.path, scene.stage?.camera);
  showFiles($("files"), scene.files ?? []);
  showFiles($("scenes"), scene.scenes ?? []);
  other.show(scene.other);
  showText(scene.text);
  if (document.activeElement !== $("overlay")) $("overlay").value = scene.overlay.shown;
  known.exposure = scene.exposure;
  if (document.activeElement !== $("exposure")) $("exposure").value = scene.exposure;
  $("exposure-value").textContent = scene.exposure;
  const select = $("accelerator");
  if (select.options.length === 1) select.append(...scene.accelerators.map((name) => new Option(name, name)));
  const { stage } = scene;
  if (!stage) return;
  known.stage = stage;
  showThings(stage.things, known.object);
  known.fps = stage.fps;
  known.distance = showCamera(stage.camera, stage.fps) ?? known.distance;
  if (document.activeElement !== $("share")) $("share").value = stage.share;
  if (document.activeElement !== select) select.value = stage.accelerator ?? "";
  const full = stage.segments.filter((segment) => segment.first <= segment.last);
  $("frame").min = Math.min(...full.map((segment) => segment.first));
  $("frame").max = Math.max(...full.map((segment) => segment.last));
  if (document.activeElement !== $("frame") || playing) $("frame").value = stage.frame;
  known.frames = full.map(({ first, last }) => [first, last]).sort(([a], [b]) => a - b);
  if (document.activeElement !== $("frame-number")) $("frame-number").value = stage.frame;
}

/** The list of objects and lamps. */
function showThings(things, selected) {
  const list = $("thing");
  if (list.dataset.things !== JSON.stringify(things)) {
    list.dataset.things = JSON.stringify(things);
    list.replaceChildren(new Option("choose", ""), ...things.map((name) => new Option(name, name)));
  }
  if (document.activeElement !== list) list.value = things.includes(selected) ? selected : "";
}

/** Files beside the scene, which a field offers. */
function showFiles(list, files) {
  if (list.dataset.files === JSON.stringify(files)) return;
  list.dataset.files = JSON.stringify(files);
  list.replaceChildren(...files.map((name) => new Option(name, name)));
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
  const wanted = first + ((playing.from - first + Math.max(1, passed)) % (last - first + 1));
  const frame = frameFrom(wanted, 1) ?? first;
  const answer = await request({ do: "frame", frame });
  if (playing) playing.picture = answer?.picture ?? -1;
}

/** The first frame that there is, from a number on, forwards or backwards; undefined if there is none. */
function frameFrom(number, by) {
  const ranges = by > 0 ? known.frames : known.frames.toReversed();
  const range = ranges.find(([first, last]) => (by > 0 ? last >= number : first <= number));
  return range && Math.min(Math.max(number, range[0]), range[1]);
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
  why: (at) => request({ do: "why", at }),
  handles: (mode) => handles.set(mode),
  vertices: () => vertices.toggle(),
  overlay: () => {
    const { options, selectedIndex } = $("overlay");
    $("overlay").selectedIndex = (selectedIndex + 1) % options.length;
    request({ do: "show", overlay: $("overlay").value });
  },
  step: (by) => {
    const next = (known.stage?.frame ?? 0) + by;
    // Behind the last one there is none, which the program says.
    request({ do: "frame", frame: frameFrom(next, by) ?? next });
  },
  play,
  expose: (by) => request({ do: "show", exposure: known.exposure + by }),
};
followHands(screen, moves, actions);

$("play").addEventListener("click", play);
$("frame").addEventListener("input", () => moves.send({ do: "frame", frame: Number($("frame").value) }));
$("frame-number").addEventListener("change", async () => {
  const answer = await request({ do: "frame", frame: Math.round(Number($("frame-number").value)) });
  if (answer?.refused) $("frame-number").value = known.stage?.frame ?? 0;
});
$("exposure").addEventListener("input", () => moves.send({ do: "show", exposure: Number($("exposure").value) }));
$("share").addEventListener("change", () => request({ do: "show", share: Number($("share").value) }));
$("accelerator").addEventListener("change", () => request({ do: "show", accelerator: $("accelerator").value }));
for (const id of ["fov", "radius", "dof", "shutter"]) {
  $(id).addEventListener("input", () => moves.send({ do: "lens", ...lens(id, Number($(id).value), known) }));
}
for (const button of document.querySelectorAll("[data-zoom]")) {
  button.addEventListener("click", () => screen.setZoom(Number(button.dataset.zoom)));
}
for (const button of document.querySelectorAll("[data-mode]")) {
  button.addEventListener("click", () => handles.set(button.dataset.mode));
}
$("vertices-button").addEventListener("click", () => vertices.toggle());
$("axes").addEventListener("change", () => handles.set(handles.mode, $("axes").value === "own"));
$("thing").addEventListener("change", () => $("thing").value && request({ do: "select", name: $("thing").value }));
$("overlay").addEventListener("change", () => request({ do: "show", overlay: $("overlay").value }));
$("plan-section").addEventListener("toggle", () => request({ do: "show", plan: $("plan-section").open }));
$("around").addEventListener("click", () => request({ do: "around", seconds: Number($("around-time").value) }));
$("new-kind").addEventListener("change", () => ($("new-file-row").hidden = $("new-kind").value !== "mesh"));
$("new").addEventListener("click", () => request({ do: "add", kind: $("new-kind").value, file: $("new-file").value }));
$("noise").addEventListener("input", () => known.facts && showFacts(known.facts, Number($("noise").value)));
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
const save = async (anyway = false) => {
  if (known.errors && !anyway) {
    $("save-question").textContent = `The text has ${known.errors} error${known.errors > 1 ? "s" : ""}. Save it anyway?`;
    $("save-dialog").showModal();
    return;
  }
  const answer = await request({ do: "save", anyway });
  if (answer && !answer.refused) say((known.note = "Saved"));
};
$("save-dialog").addEventListener("close", () => {
  if ($("save-dialog").returnValue === "save") save(true);
  $("save-dialog").returnValue = "";
});
$("save").addEventListener("click", () => save());
document.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey)) return;
  const key = event.key.toLowerCase();
  if (key === "s") save();
  // In a field, the browser undoes what was typed.
  else if (key === "z" && !event.target.matches("input[type=text]")) request({ do: event.shiftKey ? "redo" : "undo" });
  else return;
  event.preventDefault();
});
$("reset").addEventListener("click", () => request({ do: "reset" }));
$("finish").addEventListener("click", () => request({ do: $("finish").dataset.cancels ? "cancel" : "finish" }));
