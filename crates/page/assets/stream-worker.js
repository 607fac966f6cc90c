// One stream for all tabs of a browser: HTTP/1.1 allows six connections a host, and a seventh tab would wait for ever.

const ports = new Set();
let source = null;
let state = "lost";

function say(message) {
  for (const port of ports) port.postMessage(message);
}

function open() {
  source = new EventSource("/api/stream?session=0&from=0");
  source.onopen = () => { state = "open"; say({ state }); };
  source.onmessage = (event) => say({ text: event.data });
  source.onerror = () => {
    state = "lost";
    say({ state });
    // A refusal (401 after a restart) closes it for good.
    if (source.readyState === EventSource.CLOSED) setTimeout(open, 2000);
  };
}

self.onconnect = (event) => {
  const port = event.ports[0];
  ports.add(port);
  port.onmessage = (told) => { if (told.data === "gone") ports.delete(port); };
  port.start();
  port.postMessage({ state });
  if (!source) open();
};
