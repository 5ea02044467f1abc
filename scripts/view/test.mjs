// Uses the page of `slo-rt view` in a browser: looks, orbits, focuses, changes the text, saves it.
// Run by test.sh.

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const { chromium } = await import(process.env.PLAYWRIGHT);
const [program, ...options] = process.argv.slice(2);
const pictures = options[0] === "--pictures" ? resolve(options[1]) : null;
const latency = options[0] === "--latency";
const soak = options[0] === "--soak" ? Number(options[1]) : 0;

const SCENE = `# A ball on a floor, for a test
settings s { imageSamples 4 }
Camera c {
    fps 25
    Film f { width 160 height 90 prefix ball_ output PNG_IMAGE encoding SRGB }
    CamSegment only { # from the front
        videoStart 0 videoEnd 1
        addPosition { 0 -6 2 } addTarget { 0 0 0.5 } fovStart 0.4
    }
}
light_point lamp { color { 1 1 1 } position { 2 -4 5 } }
phong_info red { ambient { .1 0 0 } diffuse { .8 .2 .1 } } /* the ball */
material_phong red { phong_info red }
phong_info grey { diffuse { .5 .5 .5 } }
material_phong grey { phong_info grey }
sphere ball { center { 0 0 1 } radius 1 material red }
plane floor { normal { 0 0 1 } position { 0 0 0 } material grey }
`;

/** Starts the program; returns the address of its page. */
function start(scene, ...more) {
  const child = spawn(resolve(program), ["view", ...(scene ? [scene] : []), "-q", ...more]);
  const address = new Promise((done, failed) => {
    child.stdout.once("data", (data) => done(String(data).trim()));
    child.once("exit", () => failed(new Error("the program has ended")));
  });
  return { child, address };
}

const folder = mkdtempSync(join(tmpdir(), "slo-view-"));
const file = join(folder, "scene.txt");
writeFileSync(file, SCENE);
writeFileSync(join(folder, "flag.slo"), "slo_mesh 1 vertices { -1 0 0  1 0 0  1 0 2  -1 0 2 } faces { 0 1 2  0 2 3 }");
writeFileSync(join(folder, "other.txt"), `phong_info red { diffuse { 0 0 1 } }
material_phong red { phong_info red }
# a flag
mesh flag { filename flag.slo material red addKframe { time 0 key { pivot { 0 -2 0 } } } }
lamp_point bulb { power { 9 9 9 } position { 0 0 5 } }
`);
const { child, address } = start(file);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
});
const waits = { timeout: 60_000 };

/** The page, and everything that went wrong in it. */
async function open(url, size = { width: 1200, height: 760 }) {
  const page = await browser.newPage({ viewport: size });
  page.setDefaultTimeout(waits.timeout);
  page.wrong = [];
  page.on("pageerror", (error) => page.wrong.push(String(error)));
  page.on("console", (message) => message.type() === "error" && page.wrong.push(message.text()));
  page.on("request", (request) => {
    if (!request.url().startsWith(url) && !request.url().startsWith("blob:")) page.wrong.push(request.url());
  });
  await page.goto(url);
  return page;
}

/** Does something that changes the picture, and waits for the picture of it that is done. */
async function change(page, act) {
  const before = Number(await page.evaluate(() => document.body.dataset.picture ?? 0));
  await act();
  await page.waitForFunction(
    (before) => Number(document.body.dataset.picture) > before && document.body.dataset.done === "true", before, waits);
}

/** Red, green and blue of a place of the picture; both numbers run from 0 to 1. */
const pixel = (page, x, y) => page.evaluate(([x, y]) => {
  const canvas = document.getElementById("screen");
  const at = [Math.floor(x * canvas.width), Math.floor(y * canvas.height)];
  return [...canvas.getContext("2d").getImageData(...at, 1, 1).data].slice(0, 3);
}, [x, y]);

/** A point of the window, of a place of the picture. */
async function point(page, x, y) {
  const box = await page.locator("#screen").boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

const differences = (page) => page.locator("#differences").innerText();

const tests = {
  async "the picture is seen"(page) {
    await page.waitForFunction(() => document.body.dataset.done === "true", null, waits);
    const [red, green, blue] = await pixel(page, 0.5, 0.4);
    assert(red > 60 && red > 2 * green && red > 2 * blue, `the ball is red: ${[red, green, blue]}`);
    assert.match(await page.locator("#facts").innerText(), /160 x 90.*4 samples a pixel, all/s);
  },

  async "dragging orbits, and the text follows"(page) {
    await change(page, async () => {
      await page.mouse.move(...(await point(page, 0.3, 0.5)));
      await page.mouse.down();
      await page.mouse.move(...(await point(page, 0.6, 0.5)), { steps: 5 });
      await page.mouse.up();
    });
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("addPosition"), null, waits);
    const text = await differences(page);
    assert.match(text, /- {9}addPosition \{ 0 -6 2 \} addTarget \{ 0 0 0\.5 \} fovStart 0\.4/);
    assert.match(text, /\+ {9}addPosition \{ -[\d.]+ -?[\d.]+ 2 \} addTarget/);
    assert.equal(readFileSync(file, "utf8"), SCENE, "nothing is written before it is saved");
  },

  async "undo returns, and redo repeats"(page) {
    await change(page, () => page.keyboard.press("Control+z"));
    await page.waitForFunction(() => document.getElementById("differences").textContent === "", null, waits);
    await change(page, () => page.locator("#redo").click());
    await page.waitForFunction(() => document.getElementById("differences").textContent !== "", null, waits);
    await change(page, () => page.locator("#undo").click());
  },

  async "a click selects, a double click focuses"(page) {
    await page.mouse.click(...(await point(page, 0.5, 0.4)));
    await page.waitForFunction(() => document.getElementById("selected").textContent.includes("ball"), null, waits);
    assert.match(await page.locator("#parts").innerText(), /sphere ball, line 16.*phong_info red, line 12/s);
    await page.locator("#tool").selectOption("focus");
    await change(page, async () => page.mouse.click(...(await point(page, 0.5, 0.4))));
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("dofStart"), null, waits);
    const dof = Number((await differences(page)).match(/dofStart ([\d.]+)/)[1]);
    assert(dof > 4 && dof < 6.2, `the ball is about 5 away: ${dof}`);
    await page.locator("#tool").selectOption("pick");
    await change(page, () => page.locator("#undo").click());
  },

  async "a material is changed and saved, and nothing else of the text"(page) {
    const diffuse = page.locator('[id="field-phong_info-red-diffuse"]');
    await change(page, async () => {
      await diffuse.fill(".1 .2 .8");
      await diffuse.press("Enter");
    });
    const [red, , blue] = await pixel(page, 0.5, 0.4);
    assert(blue > red, "the ball is blue");
    await page.locator("#save").click();
    await page.waitForFunction(() => document.getElementById("status").textContent === "Saved", null, waits);
    assert.equal(readFileSync(file, "utf8"), SCENE.replace(".8 .2 .1", ".1 .2 .8"));
  },

  async "a handle is dragged, and takes the object along"(page) {
    await page.locator("#thing").selectOption("ball");
    const x = page.locator('[data-handle="x"]');
    await x.waitFor();
    const [tip] = [await x.locator("circle").boundingBox()];
    const [left, top] = [tip.x + tip.width / 2, tip.y + tip.height / 2];
    const before = await differences(page);
    await change(page, async () => {
      await page.mouse.move(left, top);
      await page.mouse.down();
      await page.mouse.move(left + 60, top, { steps: 6 });
      assert.match(await page.locator("#handles text").textContent(), /^x \+\d/);
      await page.mouse.up();
    });
    await page.waitForFunction((before) => document.getElementById("differences").innerText !== before, before, waits);
    const [, moved] = (await differences(page)).match(/\+ sphere ball \{ center \{ ([\d.]+) 0 1 \}/);
    assert(Number(moved) > 0.2 && Number(moved) < 4, `the ball is ${moved} to the right`);
    await change(page, () => page.keyboard.press("Control+z"));
    assert.equal(await differences(page), before, "the whole drag is one step");
  },

  async "handles obey the keys"(page) {
    await page.locator("#screen").focus();
    await page.keyboard.press("t");
    const z = page.locator('[data-handle="z"]');
    await z.focus();
    await change(page, () => page.keyboard.press("Shift+ArrowRight"));
    await change(page, () => page.keyboard.press("Shift+ArrowRight"));
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("turn_deg { 0 0 30 }"), null, waits);
    assert.equal(await z.getAttribute("aria-valuetext"), "z +30°");
    assert.equal(await z.getAttribute("aria-label"), "Turn ball, z");
    await change(page, () => page.keyboard.press("Escape"));
    await page.waitForFunction(() => !document.getElementById("differences").textContent.includes("turn_deg"), null, waits);
    await page.locator('[data-mode="scale"]').click();
    await page.locator('[data-handle="all"]').focus();
    await change(page, () => page.keyboard.press("Shift+ArrowUp"));
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("scale { 1.1 1.1 1.1 }"), null, waits);
    await change(page, () => page.locator("#undo").click());
    await page.locator('[data-mode="move"]').click();
    // What has the focus can go away.
    await z.focus();
    await page.evaluate(() => fetch("do", { method: "POST", body: JSON.stringify({ do: "pick", at: [0.5, 0.02] }) }));
    await page.waitForFunction(() => !document.querySelector("[data-handle]"), null, waits);
    await page.locator("#thing").selectOption("ball");
    await z.waitFor();
    assert.deepEqual(page.wrong, []);
  },

  async "a pixel says what it is made of"(page) {
    await page.locator("#tool").selectOption("why");
    await page.mouse.click(...(await point(page, 0.5, 0.4)));
    await page.waitForFunction(() => !document.getElementById("why").hidden, null, waits);
    const text = await page.locator("#why").innerText();
    assert.match(text, /Pixel\s+80, \d+ of frame 0/);
    assert.match(text, /By light.*lamp.*\d %/s);
    assert.match(text, /camera: ball \[red\]/);
    assert.match(text, /slo-rt why 80,\d+ \S+scene\.txt -f 0/);
    await page.locator("#tool").selectOption("pick");
  },

  async "overlays lie over the picture"(page) {
    const before = await pixel(page, 0.5, 0.4);
    for (const name of ["error", "samples", "cost"]) {
      await page.locator("#overlay").selectOption(name);
      await page.waitForFunction((name) => document.getElementById("legend-text").textContent.startsWith(
        { error: "error:", samples: "samples", cost: "steps" }[name]) && !document.getElementById("legend").hidden, name, waits);
    }
    assert.notDeepEqual(await pixel(page, 0.5, 0.4), before);
    await page.locator("#overlay").selectOption("");
    await page.waitForFunction(() => document.getElementById("legend").hidden && document.body.dataset.done === "true", null, waits);
    assert.deepEqual(await pixel(page, 0.5, 0.4), before);
  },

  async "the path is seen from above, and its points are moved"(page) {
    await page.locator("#plan-section summary").click();
    const camera = page.locator('#plan [data-kind="position"]');
    await camera.waitFor();
    assert.equal(await page.locator("#plan .thing").count(), 1, "the ball; the floor has no end");
    await camera.focus();
    await change(page, () => page.keyboard.press("Shift+ArrowRight"));
    await page.waitForFunction(() => /\+ +addPosition \{ [\d.]+ -6 2 \}/.test(document.getElementById("differences").textContent), null, waits);
    await change(page, () => page.locator("#undo").click());
    await change(page, () => page.locator("#around").click());
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("CamSegment orbit"), null, waits);
    assert.equal(await page.locator('#plan [data-kind="position"]').count(), 13);
    await change(page, () => page.locator("#undo").click());
    await page.locator("#plan-section summary").click();
  },

  async "something is added, and selected"(page) {
    await page.locator("#new-kind").selectOption("cone");
    await change(page, () => page.locator("#new").click());
    await page.waitForFunction(() => document.getElementById("selected").textContent.includes("cone"), null, waits);
    assert.match(await differences(page), /\+ cone cone \{ base \{.*\} apex \{.*\} radius [\d.]+ material \w+ \}/);
    await change(page, () => page.locator("#undo").click());
    await page.locator("#thing").selectOption("ball");
  },

  async "things of another scene are taken over"(page) {
    await page.locator("#other-file").fill("gone.txt");
    await page.locator("#other-open").click();
    await page.waitForFunction(() => document.getElementById("status").textContent === "there is no `gone.txt`", null, waits);
    await page.locator("#other-file").fill("other.txt");
    await page.keyboard.press("Enter");
    await page.getByLabel("bulb (lamp_point)").waitFor();
    const titles = await page.locator("#other legend").allInnerTexts();
    assert.deepEqual(titles, ["Objects", "Lamps", "Materials"]);
    await page.getByLabel("flag (mesh)").check();
    await change(page, () => page.locator("#other-take").click());
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("mesh flag"), null, waits);
    assert.match(await differences(page), /\+ # From other\.txt\s+\+ phong_info red_2 .*\s+\+ material_phong red_2 \{ phong_info red_2 \}\s+\+ # a flag\s+\+ mesh flag \{.* material red_2 /);
    assert.equal(await page.locator("#other-note").innerText(), "Added 1, and 2 more that it needs; red is now red_2");
    assert.equal(await page.getByLabel("flag (mesh)").isChecked(), false);
    await page.locator("#other-close").click();
    await page.waitForFunction(() => document.getElementById("other").hidden, null, waits);
  },

  async "vertices of a mesh are moved"(page) {
    await page.locator("#thing").selectOption("flag");
    await page.locator("#vertices-button").click();
    const corner = page.locator('[data-vertex="2"]');
    await corner.waitFor();
    assert.equal(await page.locator("[data-vertex]").count(), 4);
    await corner.click();
    await page.waitForFunction(() => document.querySelector('[data-vertex="2"]').getAttribute("aria-pressed") === "true", null, waits);
    const z = page.locator('[data-handle="z"]');
    assert.equal(await z.getAttribute("aria-label"), "Move vertex 2 of flag, z");
    assert.match(await corner.getAttribute("aria-label"), /^vertex 2 of flag, at 1 -2 2$/);
    await z.focus();
    await change(page, () => page.keyboard.press("Shift+ArrowUp"));
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("filename flag_2.slo"), null, waits);
    assert(!existsSync(join(folder, "flag_2.slo")), "nothing is written before it is saved");
    await page.waitForFunction(() => / -2 [2-9]\.\d/.test(document.querySelector('[data-vertex="2"]').getAttribute("aria-label")), null, waits);
    // The keys go from vertex to vertex.
    await corner.focus();
    await page.keyboard.press("ArrowLeft");
    assert.equal(await page.evaluate(() => document.activeElement.dataset.vertex), "3");
    await page.keyboard.press("Shift+Enter");
    await page.locator('[data-handle="x"][aria-label="Move 2 vertices of flag, x"]').waitFor();
    await change(page, () => page.locator("#undo").click());
    await page.waitForFunction(() => document.getElementById("differences").textContent.includes("filename flag.slo"), null, waits);
    await page.locator("#screen").focus();
    await page.keyboard.press("v");
    await page.waitForFunction(() => document.querySelectorAll("[data-vertex]").length === 0, null, waits);
    await change(page, () => page.locator("#undo").click());
    await page.locator("#thing").selectOption("ball");
  },

  async "a frame that is not there is refused"(page) {
    const shown = await page.locator("#frame-number").inputValue();
    await page.locator("#frame-number").fill("99");
    await page.locator("#frame-number").press("Enter");
    await page.waitForFunction(() => document.getElementById("status").textContent === "there is no frame 99: the scene has 0 to 25", null, waits);
    await page.waitForFunction((shown) => document.getElementById("frame-number").value === shown, shown, waits);
  },

  async "a text with errors is saved only on request"(page) {
    const radius = page.locator('[id="field-sphere-ball-radius"]');
    await radius.fill("x");
    await radius.press("Enter");
    await page.waitForFunction(() => document.getElementById("messages").textContent.includes("error"), null, waits);
    const saved = readFileSync(file, "utf8");
    await page.keyboard.press("Control+s");
    await page.locator("#save-dialog").waitFor();
    assert.match(await page.locator("#save-question").innerText(), /1 error/);
    await page.keyboard.press("Enter");
    assert.equal(readFileSync(file, "utf8"), saved, "the first button that Enter presses does not save");
    await change(page, () => page.locator("#undo").click());
    await page.waitForFunction(() => document.getElementById("errors").hidden, null, waits);
  },

  async "errors of the text stand beside the last good picture"(page) {
    const before = await pixel(page, 0.5, 0.4);
    writeFileSync(file, SCENE.replace("radius 1", "radius x"));
    await page.waitForFunction(() => document.getElementById("messages").textContent.includes("radius x"), null, waits);
    assert.match(await page.locator("#messages").innerText(), /scene\.txt:16:\d+/);
    assert.deepEqual(await pixel(page, 0.5, 0.4), before);
    await change(page, () => writeFileSync(file, SCENE));
    await page.waitForFunction(() => document.getElementById("errors").hidden, null, waits);
  },

  async "keys move the camera, and the panel is reached by them"(page) {
    await page.locator("#screen").focus();
    for (const key of ["w", "d", "q", "ArrowLeft", "z"]) await change(page, () => page.keyboard.press(key));
    await change(page, () => page.keyboard.press("r"));
    // The handles of what is selected come first.
    const reached = [];
    for (let i = 0; i < 6 && reached.at(-1) !== "play"; i += 1) {
      await page.keyboard.press("Tab");
      reached.push(await page.evaluate(() => document.activeElement.dataset.handle ?? document.activeElement.id));
    }
    assert.deepEqual(reached, ["x", "y", "z", "all", "play"].filter((name) => reached.includes(name)));
    assert(reached.includes("play") && reached.length > 2, `reached by Tab: ${reached}`);
    const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")]
      .filter((one) => !(one.labels?.length || one.textContent.trim() || one.getAttribute("aria-label")))
      .map((one) => one.outerHTML));
    assert.deepEqual(unnamed, [], "every control has a name");
  },

  async "the finished frame is offered"(page) {
    await page.locator("#finish").click();
    await page.waitForFunction(() => !document.getElementById("download").hidden, null, waits);
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#download").click()]);
    const frame = await page.locator("#frame").inputValue();
    assert.equal(download.suggestedFilename(), `ball_${frame.padStart(5, "0")}.png`);
    assert.deepEqual([...readFileSync(await download.path()).subarray(0, 4)], [0x89, 0x50, 0x4e, 0x47]);
  },

  async "pages from elsewhere get nothing"(page, url) {
    const server = createServer((_, answer) => answer.end("<!doctype html><title>elsewhere</title>"));
    await new Promise((done) => server.listen(0, "127.0.0.1", done));
    const other = await browser.newPage();
    await other.goto(`http://127.0.0.1:${server.address().port}/`);
    const tried = await other.evaluate(async (url) => {
      const tries = [
        fetch(`${url}state`).then((answer) => answer.text()),
        fetch(`${url}do`, { method: "POST", mode: "no-cors", body: '{"do":"remove","name":"ball"}' }).then((answer) => answer.type),
        new Promise((done, failed) => {
          const image = new Image();
          [image.onload, image.onerror] = [() => done("seen"), () => failed(new Error("not seen"))];
          image.src = `${url}picture`;
        }),
        import(`${url}main.js`).then(() => "run"),
      ];
      return (await Promise.allSettled(tries)).map(({ status, value }) => (status === "fulfilled" ? value : "refused"));
    }, url);
    assert.deepEqual(tried, tried.map(() => "refused"));
    const state = await page.evaluate(() => fetch("state").then((answer) => answer.json()));
    assert(!JSON.stringify(state.scene.text.differences).includes("sphere ball"), "the ball is still there");
    await other.close();
    server.close();
  },
};

/** Seconds of processor time that a process has taken. */
function processor(child) {
  const fields = readFileSync(`/proc/${child.pid}/stat`, "utf8").replace(/^.*\) /, "").split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

const loads = () => readFileSync("/proc/loadavg", "utf8").split(" ").slice(0, 1).join(" ");

/** Milliseconds from a change to its first picture at 640x360, and pictures a second at 320x180 while the camera moves. */
async function measure(url, shown) {
  const page = await open(url);
  await page.waitForFunction(() => Number(document.body.dataset.number) > 4, null, waits);
  console.log(`load of the machine: ${loads()}`);
  const times = await page.evaluate(async () => {
    const times = [];
    for (let i = 0; i < 60; i += 1) {
      const begin = performance.now();
      const answer = await fetch("do", { method: "POST", body: JSON.stringify({ do: "orbit", by: [i % 2 ? 0.05 : -0.05, 0] }) });
      const { picture } = await answer.json();
      while (Number(document.body.dataset.picture) < picture) await new Promise(requestAnimationFrame);
      times.push([performance.now() - begin, Number(document.body.dataset.ms)]);
      await new Promise((done) => setTimeout(done, 500));
    }
    return times;
  });
  const at = (all, share) => Math.round(all.toSorted((a, b) => a - b)[Math.floor(share * (all.length - 1))]);
  const [seen, made] = [0, 1].map((i) => times.map((time) => time[i]));
  console.log(`first picture after a change: median ${at(seen, 0.5)} ms, 95 % within ${at(seen, 0.95)} ms; ` +
    `in the program ${at(made, 0.5)} and ${at(made, 0.95)} ms`);
  await page.evaluate(() => fetch("do", { method: "POST", body: JSON.stringify({ do: "show", share: 0.5 }) }));
  const before = processor(shown);
  const { pictures, sizes, seconds } = await page.evaluate(async () => {
    const begin = performance.now();
    const pictures = new Set();
    const sizes = new Set();
    let last = begin;
    let moves = true;
    const watch = new MutationObserver(() => {
      pictures.add(document.body.dataset.picture);
      sizes.add(document.getElementById("fact-size").textContent);
      last = performance.now();
    });
    watch.observe(document.body, { attributes: true });
    // As in a drag: a move for each frame of the screen, when the last one was answered.
    while (moves) {
      const answer = await fetch("do", { method: "POST", body: JSON.stringify({ do: "orbit", by: [0.01, 0] }) });
      await answer.json();
      await new Promise(requestAnimationFrame);
      moves = performance.now() - begin < 8000;
    }
    watch.disconnect();
    return { pictures: pictures.size, sizes: [...sizes], seconds: (last - begin) / 1000 };
  });
  const took = ((processor(shown) - before) / pictures) * 1000;
  console.log(`${(pictures / seconds).toFixed(1)} drafts a second while orbiting, each ${took.toFixed(1)} ms of processor time; load ${loads()}; ${sizes.join("; ")}`);
}

/** Memory of a process, in MB. */
function memory(child) {
  const status = readFileSync(`/proc/${child.pid}/status`, "utf8");
  return Number(status.match(/VmRSS:\s+(\d+)/)[1]) / 1024;
}

/** Clicks, drags, types and saves at random for some minutes; then the scene must be one, and memory small. */
async function random(url, minutes) {
  let seed = 1;
  const next = (most) => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor((seed / 2 ** 32) * most);
  };
  const page = await open(url);
  page.setDefaultTimeout(3000);
  const counts = { actions: 0, saves: 0, vertices: 0 };
  const somewhere = () => point(page, next(100) / 100, next(100) / 100);
  const of = async (selector) => {
    const all = await page.locator(selector).all();
    return all.length ? all[next(all.length)] : null;
  };
  const drag = async (from, to) => {
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...to, { steps: 1 + next(6) });
    await page.mouse.up();
  };
  const values = ["0", "1", "0.5", "2", "-1", "x", "1 2 3", ".2 .4 .8", "", "1e9", "{", "matte"];
  const save = async () => {
    await page.keyboard.press("Control+s");
    counts.saves += 1;
    // A text with errors is not saved.
    if (await page.locator("#save-dialog[open]").count()) {
      await page.keyboard.press("Escape");
      await page.locator("#undo").click();
    }
  };
  const acts = [
    async () => drag(await somewhere(), await somewhere()),
    async () => page.mouse.click(...(await somewhere())),
    async () => page.keyboard.press([..."wasdqexyzrmtco,.+-01f?", "ArrowLeft", "ArrowUp", "Shift+ArrowRight", "Enter", " "][next(28)]),
    async () => (await of("aside button:visible:not(#save):not(:disabled)"))?.click(),
    async () => {
      const select = await of("aside select:visible, #thing");
      const all = await select.locator("option").all();
      await select.selectOption({ index: next(all.length) });
    },
    async () => {
      const field = await of("#parts input[type=text]");
      await field?.fill(values[next(values.length)]);
      await field?.press("Enter");
    },
    async () => {
      const slider = await of("input[type=range]:visible");
      await slider?.focus();
      await slider?.press(["ArrowLeft", "ArrowRight", "PageUp", "PageDown"][next(4)]);
    },
    async () => {
      const tip = await (await of(".handle circle:visible, .handle.square .thin"))?.boundingBox();
      if (tip) await drag([tip.x + tip.width / 2, tip.y + tip.height / 2], await somewhere());
    },
    async () => {
      // Things of another scene; not without end.
      if ((await page.locator("#thing option").count()) > 40) return;
      await page.locator("#other-file").fill("other.txt");
      await page.locator("#other-open").click();
      for (const box of await page.locator("#other input[type=checkbox]").all()) if (next(2)) await box.check();
      await page.locator("#other-take").click();
      await page.locator("#other-close").click();
    },
    async () => {
      // A vertex of a mesh.
      const meshes = await page.locator("#thing option").evaluateAll((all) => all.map(({ value }) => value).filter((value) => value.startsWith("flag")));
      if (meshes.length === 0) return;
      await page.locator("#thing").selectOption(meshes[next(meshes.length)]);
      if (!(await page.locator("[data-vertex]").count())) await page.locator("#vertices-button").click();
      await (await of("[data-vertex]"))?.click();
      await (await of("[data-handle]"))?.focus();
      await page.keyboard.press(["Shift+ArrowUp", "ArrowDown"][next(2)]);
      counts.vertices += 1;
    },
    save,
    async () => page.keyboard.press(next(3) ? "Control+z" : "Control+Shift+z"),
    async () => page.mouse.wheel(0, next(400) - 200),
  ];
  const begin = Date.now();
  const until = begin + minutes * 60_000;
  let before = null;
  while (Date.now() < until) {
    counts.actions += 1;
    // What can't be done just now is not done.
    await acts[next(acts.length)]().catch(() => {});
    // As somebody does who saves often.
    if (next(8) === 0) await save().catch(() => {});
    if (before === null && Date.now() - begin > Math.min(60_000, minutes * 12_000)) before = memory(child);
  }
  assert.deepEqual(page.wrong.filter((wrong) => !/40[0-9]|429/.test(wrong)), [], "the page does not complain");
  const state = await page.evaluate(() => fetch("state").then((answer) => answer.json()));
  assert(state.scene.stage, "the program still shows a scene");
  const check = spawnSync(resolve(program), ["--check", "-s", file], { encoding: "utf8" });
  assert.equal(check.status, 0, check.stderr);
  const grown = memory(child) - before;
  console.log(`${counts.actions} actions, ${counts.vertices} on vertices, and ${counts.saves} saves in ${minutes} minutes; memory ${before.toFixed(0)} MB, grown by ${grown.toFixed(1)} MB`);
  assert(grown < 50, "memory does not grow");
}

let failed = 0;
try {
  const url = await address;
  if (soak) {
    await random(url, soak);
  } else if (latency) {
    const { child: shown, address } = start(null, "--size", "640x360", "--threads", "2");
    await measure(await address, shown).finally(() => shown.kill());
  } else if (pictures) {
    const { child: shown, address } = start(null);
    const page = await open(await address, { width: 1180, height: 620 });
    await page.waitForFunction(() => Number(document.body.dataset.number) > 5, null, waits);
    await page.mouse.click(...(await point(page, 0.5, 0.45)));
    await page.waitForFunction(() => document.getElementById("parts").textContent !== "", null, waits);
    await page.waitForFunction(() => /[1-9][0-9]?(\.\d+)? samples/.test(document.getElementById("facts").textContent), null, waits);
    await page.screenshot({ path: join(pictures, "view.png") });
    shown.kill();
  } else {
    const page = await open(url);
    for (const [name, test] of Object.entries(tests)) {
      try {
        await test(page, url);
        console.log(`ok: ${name}`);
      } catch (error) {
        failed += 1;
        console.log(`FAILED: ${name}\n${error.stack}`);
        break;
      }
    }
    if (page.wrong.length > 0) {
      failed += 1;
      console.log(`FAILED: the page complains\n${page.wrong.join("\n")}`);
    }
  }
} finally {
  await browser.close();
  child.kill();
  rmSync(folder, { recursive: true });
}
process.exitCode = failed > 0 ? 1 : 0;
