// The line below the picture: what is known of it.

const $ = (id) => document.getElementById(id);
const number = new Intl.NumberFormat("en", { maximumSignificantDigits: 3 });
const MAPS = { error: "error", samples: "samples a pixel", cost: "steps and tests a sample" };

/** Shows the facts about the picture; `noise` is what the person waits for. */
export function showFacts(facts, noise) {
  const set = (id, text) => ($(id).textContent = text);
  const [width, height] = facts.pixels;
  const coarse = width < facts.width ? `, now ${width} x ${height}` : "";
  set("fact-size", `${facts.width} x ${facts.height}${coarse}`);
  set("fact-samples", facts.samples === null ? "draft" : `${number.format(facts.samples)} samples a pixel${facts.done ? ", all" : ""}`);
  set("fact-noise", facts.error === null ? "" : `noise ${number.format(facts.error)}${until(facts, noise)}`);
  const [camera, shadow, bounce] = facts.rays.map((rays) => number.format(rays / 1e6));
  set("fact-rays", `Mrays/s: ${camera} camera, ${shadow} shadow, ${bounce} bounce`);
  set("fact-time", `${duration(facts.ms / 1000)} after the change`);
  $("legend").hidden = !facts.map;
  if (facts.map) {
    const { overlay, least, most } = facts.map;
    set("legend-text", `${MAPS[overlay]}: ${number.format(least)} to ${number.format(most)}`);
  }
}

/** When a noise is reached: the noise falls with the root of the time. */
function until({ error, seconds, done }, noise) {
  if (!(noise > 0) || !(error > 0) || !(seconds > 0)) return "";
  if (error <= noise) return `, ${noise} reached`;
  const more = seconds * ((error / noise) ** 2 - 1);
  return `, ${noise} ${done ? "would take" : "in about"} ${duration(more)}${done ? " more" : ""}`;
}

function duration(seconds) {
  if (seconds < 1) return `${Math.round(seconds * 1000)} ms`;
  if (seconds < 120) return `${seconds.toFixed(seconds < 10 ? 1 : 0)} s`;
  return seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds / 3600)} h`;
}
