// What a pixel is made of.

import { element, showPairs } from "./panel.js";

const $ = (id) => document.getElementById(id);
const percent = (share) => `${(share * 100).toFixed(1)} %`;

/** Shows the answer of the server, or nothing. */
export function showWhy(why) {
  $("why").hidden = !why;
  if (!why || $("why").dataset.shown === JSON.stringify(why)) return;
  $("why").dataset.shown = JSON.stringify(why);
  showPairs($("why-facts"), [
    ["Pixel", `${why.pixel.join(", ")} of frame ${why.frame}`],
    ["Radiance", why.mean.map((part) => part.toFixed(4)).join(" ")],
    ["Samples", `${why.samples}${why.error === null ? "" : `, standard error ${percent(why.error)}`}`],
    ["Rays", `${why.rays}, of which ${why.bringing} brought light`],
  ]);
  $("why-tables").replaceChildren(...why.tables.filter((one) => one.shares.length > 0).map(table));
  const ways = why.brightest.map((one) => element("li", `${percent(one.share)}, ${often(one)}: ${one.way}`));
  $("why-ways").replaceChildren(...ways);
  $("why-replay").textContent = why.replay;
}

const often = ({ times, sample }) => (times === 1 ? `sample ${sample}` : `${times} times, most in sample ${sample}`);

function table({ title, shares }) {
  const head = ["", "light", "noise"].map((text) => {
    const cell = element("th", text);
    cell.scope = "col";
    return cell;
  });
  const row = ({ name, share, noise }) => {
    const first = element("th", name);
    first.scope = "row";
    return element("tr", undefined, first, element("td", percent(share)), element("td", percent(noise)));
  };
  return element("table", undefined, element("caption", title),
    element("thead", undefined, element("tr", undefined, ...head)), element("tbody", undefined, ...shares.map(row)));
}
