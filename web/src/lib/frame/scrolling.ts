// Where each screen is scrolled to. A screen that is opened starts at its top; Back and Forward return to the position that was left. Each
// entry of the browser's history has a number, so that the two can be told apart; positions of entries are kept until the page is reloaded.
import { tick } from "svelte";
import type { Route } from "./router.svelte";

/** What a person does to scroll; it ends the return to a position. */
const OWN = ["wheel", "touchstart", "pointerdown", "keydown"] as const;

/** ms in which a screen has loaded. Scrolling at each change of a value would cost a layout each time. */
const PATIENCE = 5000;

const positions = new Map<number, number>();

/** The number of the present entry; `isNew`: it was not visited before. */
function entry(): { number: number; isNew: boolean } {
  const state: unknown = history.state;
  const number = typeof state === "object" && state !== null && "entry" in state ? state.entry : null;
  if (typeof number === "number" && positions.has(number)) return { number, isNew: false };
  const next = Math.max(0, ...positions.keys()) + 1;
  positions.set(next, 0);
  history.replaceState({ entry: next }, "");
  return { number: next, isNew: true };
}

/** Keep the positions of the element that scrolls the screens. Returns what ends that. */
export function keepPositions(route: Route, box: HTMLElement): () => void {
  let present = entry().number;
  let { screen } = route;
  let stop = () => {};

  async function moved() {
    stop();
    const { number, isNew } = entry();
    present = number;
    if (route.screen === screen) return; // the same screen shows something else
    screen = route.screen;
    const wanted = isNew ? 0 : (positions.get(number) ?? 0);
    await tick();
    if (present === number) stop = returnTo(wanted);
  }

  const kept = () => positions.set(present, box.scrollTop);

  /** Scroll there, again and again while the screen grows by what it loads. A shorter screen than before has its end in view then. */
  function returnTo(wanted: number): () => void {
    const scroll = () => {
      box.scrollTop = wanted;
      if (box.scrollTop >= wanted - 1) end();
    };
    const growth = new MutationObserver(scroll);
    const patience = setTimeout(() => end(), PATIENCE);
    const end = () => {
      clearTimeout(patience);
      growth.disconnect();
      for (const kind of OWN) removeEventListener(kind, end, true);
    };
    growth.observe(box, { childList: true, subtree: true, characterData: true });
    for (const kind of OWN) addEventListener(kind, end, true);
    scroll();
    return end;
  }

  addEventListener("hashchange", moved);
  box.addEventListener("scroll", kept, { passive: true });
  return () => {
    stop();
    removeEventListener("hashchange", moved);
    box.removeEventListener("scroll", kept);
  };
}
