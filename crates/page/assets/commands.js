// What the page asks of the bench. Answers say what is done; what becomes of it comes by the stream.

export async function command(body) {
  const answer = await fetch("/api/command", {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
  });
  const text = await answer.text();
  let told = {};
  try {
    told = JSON.parse(text);
  } catch {
    told = { failed: text.trim() };
  }
  if (told.done) return { ok: true, words: told.done };
  return { ok: false, words: [told.failed, told.help].filter(Boolean).join(". ") || `refused (${answer.status})` };
}
