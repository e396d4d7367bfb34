// Who this tab is for the server: a random name of its own that outlives a reload, but is not shared with a duplicate of the tab.
// A duplicate copies sessionStorage; so the name stands there only while the page is being left.

const KEY = "mikas.client";

function first(): string {
  try {
    const before = sessionStorage.getItem(KEY);
    sessionStorage.removeItem(KEY);
    if (before && /^[A-Za-z0-9-]{8,64}$/.test(before)) return before;
  } catch {
    // No storage: a new name each time.
  }
  const bytes = crypto.getRandomValues(new Uint8Array(12));
  return `page-${[...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}

export const client = globalThis.window ? first() : "page-test";

/** What the other clients read when this one holds control. */
export const clientName = (): string => {
  const agent = globalThis.navigator?.userAgent ?? "";
  const system = /Android|iPhone|iPad|Windows|Mac OS|Linux/.exec(agent)?.[0] ?? "";
  const browser = /Firefox|Edg|YaBrowser|Chrome|Safari/.exec(agent)?.[0]?.replace("Edg", "Edge") ?? "";
  return [browser, system].filter(Boolean).join(", ");
};

globalThis.window?.addEventListener("pagehide", () => {
  try {
    sessionStorage.setItem(KEY, client);
  } catch {
    // As above.
  }
});
globalThis.window?.addEventListener("pageshow", () => {
  try {
    sessionStorage.removeItem(KEY);
  } catch {
    // As above.
  }
});
