// The panel: what is known of the scene, and controls.

const $ = (id) => document.getElementById(id);
const short = (value) => String(Number(Number(value).toPrecision(4)));

/** Makes an element with text and children. */
export function element(name, text, ...children) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  made.append(...children);
  return made;
}

/** Errors and warnings, with their places. */
export function showMessages(messages, fault) {
  const all = fault ? [{ severity: "error", message: fault }, ...messages] : messages;
  $("errors").hidden = all.length === 0;
  $("messages").replaceChildren(...all.map(message));
}

function message({ severity, message, help, place, of }) {
  const where = of === "file" ? "in the file, " : "";
  const item = element("li", undefined, element("strong", `${where}${severity}: ${message}`));
  item.className = severity;
  if (place) {
    item.append(element("div", `${place.file}:${place.line}:${place.column}`));
    item.lastChild.className = "place";
    const at = [...place.text];
    const line = element("pre", at.slice(0, place.column - 1).join(""));
    line.append(element("mark", at.slice(place.column - 1).join("") || " "));
    item.append(line);
    if (place.label) item.append(element("div", place.label));
  }
  if (help) item.append(element("div", `help: ${help}`));
  return item;
}

/** A list of names and values; empty ones are left out. */
export function showPairs(list, pairs) {
  const full = pairs.filter(([, value]) => value !== null && value !== undefined && value !== "");
  list.replaceChildren(...full.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
}

/** What was clicked. */
export function showPicked(picked, set) {
  $("selection").hidden = !picked;
  if (!picked) return;
  $("object-actions").hidden = picked.parts.length === 0;
  $("handle-actions").hidden = !picked.handle;
  showParts(picked.parts, set);
  showPairs($("selected"), [
    ["Object", picked.object], ["Material", picked.material],
    ["At", picked.point.map(short).join(" ")], ["Distance", short(picked.depth)],
  ]);
}

/** Sliders of the lens. A slider that is being dragged stays as it is. */
export function showCamera(camera, fps) {
  if (!camera) return;
  const distance = Math.hypot(...camera.position.map((part, i) => part - camera.target[i])) || 1;
  const set = (id, value, text) => {
    if (document.activeElement !== $(id)) $(id).value = value;
    $(`${id}-value`).textContent = text;
  };
  set("fov", (2 * Math.atan(camera.fov) * 180) / Math.PI, `${short((2 * Math.atan(camera.fov) * 180) / Math.PI)}°`);
  set("radius", Math.sqrt(camera.radius / (distance * 0.1)), short(camera.radius));
  set("dof", 0.5 + Math.log10(camera.dof / distance) / 4, short(camera.dof));
  set("shutter", camera.shutter * fps, `${short(camera.shutter * fps)} frames`);
  return distance;
}

/** What the sliders of the lens mean. */
export function lens(id, value, { distance, fps }) {
  switch (id) {
    case "fov": return { fov: Math.tan((value * Math.PI) / 360) };
    case "radius": return { radius: value * value * distance * 0.1 };
    case "dof": return { dof: distance * 10 ** ((value - 0.5) * 4) };
    default: return { shutter: value / fps };
  }
}

/** How far the frame is that is rendered as the program does. */
export function showFinish(finish) {
  const isRendering = finish?.share !== undefined;
  $("finish").textContent = isRendering ? "Cancel" : "Render this frame";
  $("finish").dataset.cancels = isRendering ? "1" : "";
  $("progress").hidden = !isRendering;
  if (isRendering) $("progress").value = finish.share;
  const link = $("download");
  link.hidden = !finish?.name;
  if (finish?.name) [link.href, link.download, link.textContent] = ["finished", finish.name, `Save ${finish.name}`];
  return finish?.error ?? null;
}

/** Fields of the elements of the selected thing. Fields that are being changed stay as they are. */
function showParts(parts, set) {
  const wanted = JSON.stringify(parts.map((part) => [part.keyword, part.name, part.fields.map(keyOf)]));
  const container = $("parts");
  if (container.dataset.shape !== wanted) {
    container.dataset.shape = wanted;
    container.replaceChildren(...parts.map((part) => partOf(part, set)));
  }
  const inputs = container.querySelectorAll("input[data-key]");
  parts.flatMap((part) => part.fields).forEach((field, i) => {
    if (document.activeElement === inputs[i] || document.activeElement === inputs[i]?.slider) return;
    inputs[i].value = field.value;
    if (inputs[i].slider) inputs[i].slider.value = position(field.value);
  });
  container.querySelectorAll("h3").forEach((title, i) => {
    title.textContent = `${parts[i].keyword} ${parts[i].name}, line ${parts[i].line}`;
  });
}

const keyOf = (field) => [...field.blocks.map((block) => block.join(" ")), field.attribute].join(" / ");

function partOf(part, set) {
  const section = element("div", undefined, element("h3"));
  for (const field of part.fields) {
    const id = `field-${part.keyword}-${part.name}-${keyOf(field)}`;
    const label = element("label", [...field.blocks.map(([name, i]) => (i ? `${name} ${i + 1}` : name)), field.attribute].join(" "));
    label.htmlFor = id;
    const input = element("input");
    Object.assign(input, { type: "text", id, value: field.value, spellcheck: false });
    input.dataset.key = keyOf(field);
    const change = (value) => set({
      do: "set", keyword: part.keyword, name: part.name, blocks: field.blocks,
      attribute: field.attribute, value, vector: field.vector,
    });
    input.addEventListener("change", () => change(input.value));
    const row = element("div", undefined, label, input);
    row.className = "field";
    // Shares, such as colours of one number or roughness, have a slider too.
    if (field.numbers && !field.vector && Number(field.value) >= 0 && Number(field.value) <= 1) {
      const slider = element("input");
      Object.assign(slider, { type: "range", min: 0, max: 1, step: 0.01, value: position(field.value) });
      slider.setAttribute("aria-label", label.textContent);
      slider.addEventListener("input", () => change((input.value = slider.value)));
      input.slider = slider;
      row.append(slider);
    }
    section.append(row);
  }
  return section;
}

const position = (value) => Math.min(1, Math.max(0, Number(value) || 0));

/** How the text differs from the file. */
export function showText(text) {
  $("text").hidden = !text.changed && !text.undo && !text.redo && !text.conflict;
  $("undo").disabled = !text.undo;
  $("redo").disabled = !text.redo;
  $("undo").title = text.undo ? `Undo: ${text.undo}` : "";
  $("redo").title = text.redo ? `Redo: ${text.redo}` : "";
  $("save").disabled = !text.changed || !text.file || text.conflict;
  $("revert").disabled = !text.changed;
  $("conflict").hidden = !text.conflict;
  const lines = text.differences.flatMap((hunk) => [
    element("span", `line ${hunk.line}\n`),
    ...hunk.old.map((line) => element("del", `- ${line.trimEnd()}`)),
    ...hunk.new.map((line) => element("ins", `+ ${line.trimEnd()}`)),
  ]);
  if (lines.length !== $("differences").childElementCount || $("differences").dataset.text !== JSON.stringify(text.differences)) {
    $("differences").dataset.text = JSON.stringify(text.differences);
    $("differences").replaceChildren(...lines);
  }
}
