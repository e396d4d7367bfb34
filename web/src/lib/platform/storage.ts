// Settings stored in this browser. Where the browser forbids it (private window) they last until the page is reloaded.

export function loadSetting(name: string): string | null {
  try {
    return localStorage.getItem(`mikas.${name}`);
  } catch {
    return null;
  }
}

export function saveSetting(name: string, value: string): void {
  try {
    localStorage.setItem(`mikas.${name}`, value);
  } catch {
    // Not stored; the page works without.
  }
}
