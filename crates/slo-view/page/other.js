// Another scene, of which things are taken over.

import { element } from "./panel.js";

const $ = (id) => document.getElementById(id);

export class Other {
  /** `request` sends a command and returns the answer. */
  constructor(request) {
    this.request = request;
    $("other-open").addEventListener("click", () => this.#open());
    $("other-file").addEventListener("keydown", (event) => event.key === "Enter" && this.#open());
    $("other-close").addEventListener("click", async () => {
      await this.request({ do: "close" });
      $("other-file").focus();
    });
    $("other").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#take();
    });
  }

  /** Shows the lists of a scene, or nothing. */
  show(other) {
    $("other").hidden = !other;
    if (!other) return void delete $("other").dataset.shown;
    const wanted = JSON.stringify([other.path, other.lists]);
    if ($("other").dataset.shown !== wanted) {
      $("other").dataset.shown = wanted;
      $("other-title").textContent = other.path;
      $("other-lists").replaceChildren(...other.lists.filter(({ things }) => things.length > 0).map(list));
    }
    const more = other.unlisted ? `${other.unlisted} more are not listed.` : "";
    $("other-note").textContent = other.note ?? more;
  }

  #open() {
    return this.request({ do: "open", file: $("other-file").value });
  }

  async #take() {
    const chosen = [...$("other-lists").querySelectorAll("input:checked")];
    const things = chosen.filter((box) => box.value !== "all").map((box) => Number(box.value));
    const answer = await this.request({ do: "take", things });
    if (answer && !answer.refused) for (const box of chosen) box.checked = false;
  }
}

/** A list of things with check boxes; the first one checks all. */
function list({ title, things }) {
  const boxes = things.map(({ index, keyword, name }) => box(index, `${name} (${keyword.replace(/^material_/, "")})`));
  const all = things.length > 1 ? [box("all", `all ${things.length}`)] : [];
  const fieldset = element("fieldset", undefined, element("legend", title), ...all, ...boxes);
  fieldset.addEventListener("change", (event) => {
    const inputs = [...fieldset.querySelectorAll("input")];
    const [first, ...rest] = inputs;
    if (event.target.value === "all") for (const input of rest) input.checked = event.target.checked;
    else if (all.length) first.checked = rest.every((input) => input.checked);
  });
  return fieldset;
}

function box(value, text) {
  const input = element("input");
  Object.assign(input, { type: "checkbox", value });
  return element("label", undefined, input, ` ${text}`);
}
