// What is kept on this computer between visits. A browser that forbids it (private window) forgets, nothing more.

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
    // Forgotten on reload; the page works.
  }
}
