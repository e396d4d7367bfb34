// Who this tab is for the server: a random name of its own that outlives a reload, but is not shared with a duplicate of the tab.
// A duplicate copies sessionStorage; so the name stands there only while the page is being left.

// A tab that is closed while it holds the controls leaves its name to the next one opened in this browser, which then holds them.

const KEY = "mikas.client";
const LEFT = "mikas.client.left";
const TAKEN = "mikas.client.taken";
const INHERITED = "inherited";
/** ms that a closed tab's name waits for the next: after that its seat is free anyway. */
const INHERIT_MS = 15_000;
let inherited = false;

/** Told by the live line: whether this tab holds the controls. */
export const controlLease = { held: false };

function first(): string {
  try {
    const left = leftName();
    const [own, how] = (sessionStorage.getItem(KEY) ?? "").split(" ");
    inherited = how === INHERITED;
    // Another tab inherited it while this one was elsewhere: it is no longer this one's.
    const mine = own && (inherited || localStorage.getItem(TAKEN) !== own) ? own : null;
    const before = mine ?? left;
    sessionStorage.removeItem(KEY);
    if (before === left) localStorage.removeItem(LEFT);
    if (left && !mine) {
      localStorage.setItem(TAKEN, left);
      inherited = true;
    }
    if (before && /^[A-Za-z0-9-]{8,64}$/.test(before)) return before;
  } catch {
    // No storage: a new name each time.
  }
  const bytes = crypto.getRandomValues(new Uint8Array(12));
  return `page-${[...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}

function leftName(): string | null {
  const [name, time] = (localStorage.getItem(LEFT) ?? "").split(" ");
  return name && Date.now() - Number(time) < INHERIT_MS ? name : null;
}

export const clientId = globalThis.window ? first() : "page-test";

/** What the other clients read when this one holds control. */
export const clientName = (): string => {
  const agent = globalThis.navigator?.userAgent ?? "";
  const system = /Android|iPhone|iPad|Windows|Mac OS|Linux/.exec(agent)?.[0] ?? "";
  const browser = /Firefox|Edg|YaBrowser|Chrome|Safari/.exec(agent)?.[0]?.replace("Edg", "Edge") ?? "";
  return [browser, system].filter(Boolean).join(", ") + ` (${tabLabel})`;
};

/** Tells this tab from another of the same browser; stays over a reload. */
export const tabLabel = clientId.slice(-3).toUpperCase();

globalThis.window?.addEventListener("pagehide", () => {
  try {
    sessionStorage.setItem(KEY, inherited ? `${clientId} ${INHERITED}` : clientId);
    if (controlLease.held) localStorage.setItem(LEFT, `${clientId} ${Date.now()}`);
  } catch {
    // As above.
  }
});
globalThis.window?.addEventListener("pageshow", (event) => {
  try {
    // Back from the browser's store of pages, and another tab has taken the name meanwhile: a new one.
    const lent = event.persisted && controlLease.held && leftName() !== clientId;
    sessionStorage.removeItem(KEY);
    if (leftName() === clientId) localStorage.removeItem(LEFT);
    if (lent) location.reload();
  } catch {
    // As above.
  }
});
