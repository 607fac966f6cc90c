// What the page asks of the program. Answers of commands say what is done; what becomes of it comes by the stream.

async function post(path, body) {
  const answer = await fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
  });
  const text = await answer.text();
  try {
    return { answer, told: JSON.parse(text) };
  } catch {
    return { answer, told: { failed: text.trim() } };
  }
}

const why = (told, status) => [told.failed, told.help].filter(Boolean).join(". ") || `refused (${status})`;

/** A command to the bench: whether it is done, and what is said of it. */
export async function command(body) {
  const { answer, told } = await post("/api/command", body);
  return told.done ? { ok: true, words: told.done } : { ok: false, words: why(told, answer.status) };
}

/** What is worked out of the run that is shown; fails with a sentence. */
export async function study(body) {
  const { answer, told } = await post("/api/study", body);
  if (!answer.ok) throw new Error(why(told, answer.status));
  return told;
}

/** What is said of a file that was dropped. */
export async function inspect(body) {
  const { answer, told } = await post("/api/inspect", body);
  if (!answer.ok) throw new Error(why(told, answer.status));
  return told;
}

/** Calls `work` for the newest request alone: one at a time, those in between are left out. */
export function latest(work) {
  let [busy, wanted] = [false, null];
  return async function ask(request) {
    wanted = { request };
    if (busy) return;
    busy = true;
    while (wanted) {
      const { request: now } = wanted;
      wanted = null;
      await work(now);
    }
    busy = false;
  };
}
