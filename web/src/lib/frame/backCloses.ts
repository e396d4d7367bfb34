// Back, a button or a swipe on a phone: it closes the dialog that lies over the screen, and leaves the screen where it is. Chrome on Android does so by
// itself for its own button; this is for Back of the browser, and for browsers that go back all the same: then no dialog stays over another screen.

const openDialogs = (): HTMLDialogElement[] => [...document.querySelectorAll<HTMLDialogElement>("dialog[open]")];

/** From now on. Returns what ends that. */
export function backCloses(): () => void {
  /** Not every browser has it. */
  const navigation: Navigation | undefined = globalThis.navigation;

  const navigate = (event: NavigateEvent) => {
    const { cancelable, destination, navigationType } = event;
    const goesBack = navigationType === "traverse" && destination.index < (navigation?.currentEntry?.index ?? -1);
    const top = openDialogs().at(-1);
    if (!cancelable || !goesBack || !top) return;
    event.preventDefault();
    top.close();
  };
  /** An entry that was there before has a state (`scrolling.ts`); one that is opened has none. */
  const went = ({ state }: PopStateEvent) => {
    if (state !== null) for (const each of openDialogs()) each.close();
  };

  navigation?.addEventListener("navigate", navigate);
  addEventListener("popstate", went);
  return () => {
    navigation?.removeEventListener("navigate", navigate);
    removeEventListener("popstate", went);
  };
}
