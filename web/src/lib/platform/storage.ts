// Settings stored in this browser. Where the browser forbids it (private window) they last until the page is reloaded.

/** What the browser does not store. */
const unstored = new Map<string, string>();

export function loadSetting(name: string): string | null {
  try {
    return unstored.get(name) ?? localStorage.getItem(`mikas.${name}`);
  } catch {
    return null;
  }
}

export function saveSetting(name: string, value: string): void {
  try {
    localStorage.setItem(`mikas.${name}`, value);
    unstored.delete(name);
  } catch {
    unstored.set(name, value);
  }
}
