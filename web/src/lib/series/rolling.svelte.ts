// The attachment of a canvas with lines of the last seconds.
import type { Attachment } from "svelte/attachments";
import { frameClock } from "../platform/frameClock.svelte";
import { RollingTraces, type Look } from "./rollingTraces";

/** Draw with the slow clock and after a change of the size; `look` is called with the height. */
export function rolling(look: (height: number) => Look): Attachment<HTMLCanvasElement> {
  return (canvas) => {
    let resized = $state(0);
    const picture = new RollingTraces(canvas, () => (resized += 1));
    $effect(() => {
      if (resized > 0) frameClock.slowly(() => picture.draw(look(picture.height)));
    });
    return () => picture.close();
  };
}
