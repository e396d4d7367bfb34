// Keyboard shortcuts of the frame and the current screen. They match the key's place, not its letter, so that M works with the Russian layout.
//
//   shortcuts.use(() => [{ code: "KeyF", show: "F", text: () => t("read"), run: read }]);

import { onDestroy } from "svelte";

export interface Binding {
  /** KeyboardEvent.code: KeyR, Digit1, Space, ArrowLeft… */
  code: string;
  shift?: boolean;
  /** A character whose key depends on the layout (`?` is Shift and 7 on a Russian one): it matches by `key` as well. */
  key?: string;
  /** The name of the key in the help. */
  show: string;
  text: () => string;
  run: (event: KeyboardEvent) => void;
  /** Available on every screen; listed after the screen's own. */
  everywhere?: boolean;
}

export class Shortcuts {
  private readonly sources = new Set<() => readonly Binding[]>();

  get bindings(): Binding[] {
    return [...this.sources].flatMap((source) => source());
  }

  /** For a component while it is initialised: its bindings, as long as it lives. The last binding of a key wins. */
  use(source: () => readonly Binding[]): void {
    this.sources.add(source);
    onDestroy(() => this.sources.delete(source));
  }

  handle(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (belongsToFocus(event)) return;
    const found = this.bindings.findLast((binding) => matches(binding, event));
    if (!found) return;
    event.preventDefault();
    found.run(event);
  }
}

export function matches(binding: Binding, event: Pick<KeyboardEvent, "code" | "key" | "shiftKey">): boolean {
  if (binding.key !== undefined && binding.key === event.key) return true;
  return binding.code === event.code && (binding.shift ?? false) === event.shiftKey;
}

/** Whether the focused element handles the key: a field, a dialog, a button with Space or Enter. */
function belongsToFocus(event: KeyboardEvent): boolean {
  if (document.querySelector("dialog[open]")) return true;
  const at = event.target;
  if (!(at instanceof HTMLElement)) return false;
  if (at.isContentEditable || at.closest("input:not([type=checkbox]):not([type=radio]), select, textarea")) {
    return true;
  }
  // The selected tab has no use for Space.
  if (event.code === "Space" && at.closest("button:not([role=tab][aria-selected=true]), summary, input")) return true;
  if (event.code === "Enter" && at.closest("button, a, summary, input")) return true;
  return event.code.startsWith("Arrow") && at.closest("[role=slider], [role=tablist], input") !== null;
}
