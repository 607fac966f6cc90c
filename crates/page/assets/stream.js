// Messages of the server, in order, none twice and none left out, through whatever connection there is.

/** Calls `onMessage` with each part of the events and `onConnection` with true or false. */
export function subscribe(onMessage, onConnection) {
  let [session, next] = [0, 0];
  let queue = Promise.resolve();

  async function fetchFrom() {
    const answer = await fetch(`/api/events?session=${session}&from=${next}`, { cache: "no-store" });
    if (!answer.ok) throw new Error(await answer.text());
    return answer.json();
  }

  function take(message) {
    const fresh = message.session !== session;
    if (fresh && message.first !== 0) return false;
    if (!fresh && message.first > next) return false;
    const events = message.events.slice(fresh ? 0 : next - message.first);
    [session, next] = [message.session, Math.max(fresh ? 0 : next, message.first + message.events.length)];
    onMessage({ fresh, outline: message.outline, events, status: message.status });
    return true;
  }

  /** Everything that this tab lacks. */
  async function catchUp() {
    for (;;) {
      const before = [session, next];
      const message = await fetchFrom();
      take(message);
      if (message.events.length === 0 || (before[0] === session && before[1] === next)) return;
    }
  }

  function told({ state, text }) {
    if (state) {
      onConnection(state === "open");
      if (state === "open") queue = queue.then(catchUp).catch(() => {});
    }
    if (text) {
      queue = queue.then(async () => {
        if (!take(JSON.parse(text))) await catchUp();
      }).catch(() => {});
    }
  }

  queue = queue.then(catchUp).catch(() => onConnection(false));
  if (typeof SharedWorker === "function") {
    const worker = new SharedWorker("/stream-worker.js");
    worker.port.onmessage = (event) => told(event.data);
    worker.port.start();
    addEventListener("pagehide", () => worker.port.postMessage("gone"));
    addEventListener("pageshow", (event) => { if (event.persisted) location.reload(); });
    return;
  }
  // No shared worker (some tablets): a stream of its own while the tab can be seen.
  let source = null;
  const follow = () => {
    if (document.hidden) {
      source?.close();
      source = null;
    } else if (!source) {
      source = new EventSource(`/api/stream?session=${session}&from=${next}`);
      source.onopen = () => told({ state: "open" });
      source.onmessage = (event) => told({ text: event.data });
      source.onerror = () => {
        told({ state: "lost" });
        if (source?.readyState === EventSource.CLOSED) {
          source = null;
          setTimeout(follow, 2000);
        }
      };
    }
  };
  document.addEventListener("visibilitychange", follow);
  follow();
}
