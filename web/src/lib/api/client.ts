// The client identity of this tab: a random name that survives a reload but is not shared with a duplicate of the tab. A duplicate copies
// sessionStorage, so the name is stored there only while the page is being left. The name is a secret: who knows it has the rights of this
// tab. Others see three of its digits, the tab's label; 100 random bits remain.

// A tab that is closed while it holds control leaves its name for the next tab opened in this browser, which then holds control.

const KEY = "mikas.client";
const LEFT = "mikas.client.left";
const TAKEN = "mikas.client.taken";
const INHERITED = "inherited";
/** ms for which a closed tab's name can be inherited; after that the server releases control anyway. */
const INHERIT_MS = 15_000;
let inherited = false;

/** Set by the live connection: whether this tab holds control. */
export const controlLease = { held: false };

function first(): string {
  try {
    const left = leftName();
    const [own, how] = (sessionStorage.getItem(KEY) ?? "").split(" ");
    inherited = how === INHERITED;
    // Another tab inherited the name while this one was elsewhere.
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
    // No storage: a new name for each page load.
  }
  return `page-${randomDigits(14)}`;
}

function randomDigits(bytes: number): string {
  return [...crypto.getRandomValues(new Uint8Array(bytes))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

function leftName(): string | null {
  const [name, time] = (localStorage.getItem(LEFT) ?? "").split(" ");
  return name && Date.now() - Number(time) < INHERIT_MS ? name : null;
}

export const clientId = globalThis.window ? first() : "page-test";

/** This load of the page: its next connection continues the one that was lost, and keeps control, where another tab's would not. */
export const pageId = randomDigits(8);

/** The name that other clients see while this one holds control. */
export const clientName = (): string => {
  const agent = globalThis.navigator?.userAgent ?? "";
  const system = /Android|iPhone|iPad|Windows|Mac OS|Linux/.exec(agent)?.[0] ?? "";
  const browser = /Firefox|Edg|YaBrowser|Chrome|Safari/.exec(agent)?.[0]?.replace("Edg", "Edge") ?? "";
  return [browser, system].filter(Boolean).join(", ") + ` (${tabLabel})`;
};

/** A short label that distinguishes this tab from others of the same browser; it survives a reload. */
export const tabLabel = clientId.slice(5, 8).toUpperCase();

globalThis.window?.addEventListener("pagehide", () => {
  try {
    sessionStorage.setItem(KEY, inherited ? `${clientId} ${INHERITED}` : clientId);
    if (controlLease.held) localStorage.setItem(LEFT, `${clientId} ${Date.now()}`);
  } catch {
    // No storage.
  }
});
globalThis.window?.addEventListener("pageshow", (event) => {
  try {
    // Restored from the back/forward cache after another tab inherited the name: reload to get a new one.
    const lent = event.persisted && controlLease.held && leftName() !== clientId;
    sessionStorage.removeItem(KEY);
    if (leftName() === clientId) localStorage.removeItem(LEFT);
    if (lent) location.reload();
  } catch {
    // No storage.
  }
});
