// Requests to the server. Moves wait for one another: those that come meanwhile are added up.

/** Asks the server for something; returns its answer, or null if there is none. */
export async function ask(command) {
  try {
    const answer = await fetch("do", { method: "POST", body: JSON.stringify(command) });
    return answer.ok ? await answer.json() : null;
  } catch {
    return null;
  }
}

/**
 * Asks for news for ever, at most once in `least` milliseconds. `read` turns an answer into an object with the `number`
 * of the news. `use` gets this object while the page already waits for the next news.
 */
export async function follow(path, least, { read, use, lost }) {
  let after = 0;
  let used = Promise.resolve();
  for (;;) {
    try {
      const asked = performance.now();
      const answer = await fetch(`${path}?after=${after}`);
      if (answer.status === 200) {
        const news = await read(answer);
        after = news.number;
        await used;
        used = (async () => use(news))().catch(console.error);
        await pause(least - (performance.now() - asked));
      } else if (answer.status !== 204) {
        await pause(500);
      }
    } catch {
      lost();
      await pause(1000);
    }
  }
}

/** Sends moves one after the other. `add` joins a move that waits with the next one of its kind. */
export class Moves {
  #waiting = new Map();
  #busy = false;

  constructor(answered) {
    this.answered = answered;
  }

  send(command, add) {
    // Of what sets the same thing, the last one counts.
    const key = command.do === "set" ? JSON.stringify({ ...command, value: "" }) : `${command.do} ${command.drag ?? ""}`;
    const before = this.#waiting.get(key);
    this.#waiting.set(key, before && add ? add(before, command) : command);
    this.#run();
  }

  async #run() {
    if (this.#busy) return;
    this.#busy = true;
    while (this.#waiting.size > 0) {
      const [kind, command] = this.#waiting.entries().next().value;
      this.#waiting.delete(kind);
      this.answered(await ask(command), command);
    }
    this.#busy = false;
  }
}

async function pause(ms) {
  if (ms > 0) await new Promise((resolve) => setTimeout(resolve, ms));
}
