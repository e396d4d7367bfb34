// Keys that mean something on this screen. By the key's place, not its letter: M works with the Russian layout on.
//
//   $effect(() => shortcuts.bind({ code: "KeyF", show: "F", text: () => t("read"), run: read }));

import { untrack } from "svelte";

export interface Binding {
  /** KeyboardEvent.code: KeyR, Digit1, Space, ArrowLeft… */
  code: string;
  shift?: boolean;
  /** A sign that is typed otherwise with another layout: `?` is Shift and 7 on a Russian one. By what is typed as well. */
  key?: string;
  /** As it stands in the help. */
  show: string;
  text: () => string;
  run: (event: KeyboardEvent) => void;
  /** Works everywhere (the frame's keys), shown after the screen's own. */
  everywhere?: boolean;
}

class Shortcuts {
  bindings = $state.raw<Binding[]>([]);

  /** Gives back what undoes it; the binding made last wins. */
  bind(...added: Binding[]): () => void {
    // Not a dependency of the effect that binds.
    untrack(() => (this.bindings = [...this.bindings, ...added]));
    return () => {
      untrack(() => (this.bindings = this.bindings.filter((binding) => !added.includes(binding))));
    };
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

/** The key belongs to what has the focus: a field, a sheet, a button under Space or Enter. */
function belongsToFocus(event: KeyboardEvent): boolean {
  if (document.querySelector("dialog[open]")) return true;
  const at = event.target;
  if (!(at instanceof HTMLElement)) return false;
  if (at.isContentEditable || at.closest("input:not([type=checkbox]):not([type=radio]), select, textarea")) {
    return true;
  }
  // The chosen tab does nothing more when pressed.
  if (event.code === "Space" && at.closest("button:not([role=tab][aria-selected=true]), summary, input")) return true;
  if (event.code === "Enter" && at.closest("button, a, summary, input")) return true;
  return event.code.startsWith("Arrow") && at.closest("[role=slider], [role=tablist], input") !== null;
}

export const shortcuts = new Shortcuts();
