// The workers of the site without its page: `begin(url, role, access)`, then `ask`. `access`: "serial" or "usb".
const workers = {};
let last = 0;
const waiting = new Map();

window.begin = (url, role, access) =>
  new Promise((ready, fail) => {
    const worker = (workers[role] = new Worker(url, { type: "module", name: `${role} ${access}` }));
    worker.onerror = (event) => fail(event.message);
    worker.onmessage = ({ data }) => {
      if (data.kind === "ready") ready();
      else if (data.kind === "broken") fail(data.message);
      else waiting.get(data.id)?.(data);
    };
  });

window.end = (role) => workers[role].terminate();

/** The text of the answer, its status, and the ms that it took. */
window.ask = (role, method, path, body = null) =>
  new Promise((resolve, fail) => {
    const id = ++last;
    const began = performance.now();
    const parts = [];
    let status = 0;
    waiting.set(id, async (message) => {
      if (message.kind === "head") status = message.status;
      else if (message.kind === "body") parts.push(message.data);
      else {
        waiting.delete(id);
        if (message.kind !== "end" || status >= 400) return fail(`${status} ${message.message} ${await new Blob(parts).text()}`);
        resolve({ text: await new Blob(parts).text(), ms: performance.now() - began });
      }
    });
    const bytes = body && new TextEncoder().encode(JSON.stringify(body)).buffer;
    const headers = [["x-mikas-client", "benchmark-1"], ["content-type", "application/json"]];
    workers[role].postMessage({ kind: "request", id, method, path, headers, body: bytes });
  });

/** The bytes of the answer, in base64. */
window.file = async (role, path) => {
  const bytes = await new Promise((resolve) => {
    const id = ++last;
    const parts = [];
    waiting.set(id, (message) => {
      if (message.kind === "body") parts.push(message.data);
      else if (message.kind === "end") resolve(new Blob(parts));
    });
    workers[role].postMessage({ kind: "request", id, method: "GET", path, headers: [["x-mikas-client", "benchmark-1"]], body: null });
  });
  return new Promise((resolve) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.split(",")[1]);
    reader.readAsDataURL(bytes);
  });
};

/** What a request and its answer take without Python: how many there were in so many seconds, and what was carried. */
window.alone = (access, request, seconds) =>
  new Promise((done, fail) => {
    const worker = new Worker("exchange.js", { type: "module" });
    worker.onerror = (event) => fail(event.message);
    worker.onmessage = ({ data }) => done(data);
    worker.postMessage({ access, request, seconds });
  });

/** Put the file at `url` among what is kept, as `path`, by the pool of the site. */
window.keep = (url, path) =>
  new Promise((done, fail) => {
    const worker = new Worker("keep.js", { type: "module" });
    worker.onerror = (event) => fail(event.message);
    worker.onmessage = ({ data }) => {
      worker.terminate();
      done(data);
    };
    worker.postMessage({ url, path });
  });
