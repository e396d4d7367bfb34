// Dragging a trace from the legend to another pane, by mouse, pen or touch. A finger drags by the colour sign; elsewhere it scrolls.
import type { View } from "./view.svelte";

/** Drop target: a new pane. */
export const NEW = -1;
/** Pixels before a press becomes a drag. */
const MOVED = 6;

export class TraceDrag {
  /** The trace being dragged and the pointer's position. */
  now = $state.raw<{ name: string; x: number; y: number } | null>(null);
  /** The pane under the pointer; null: none. */
  over = $state<number | null>(null);
  private pressed: { name: string; x: number; y: number } | null = null;
  private dragged = false;

  constructor(private readonly view: View) {}

  down(event: PointerEvent, name: string): void {
    this.dragged = false;
    const sign = event.target instanceof Element && event.target.closest(".line");
    if (event.button !== 0 || (event.pointerType === "touch" && !sign)) return;
    this.pressed = { name, x: event.clientX, y: event.clientY };
  }

  move(event: PointerEvent): void {
    if (!this.pressed) return;
    const { clientX: x, clientY: y } = event;
    if (!this.now && Math.hypot(x - this.pressed.x, y - this.pressed.y) < MOVED) return;
    if (!this.now && event.currentTarget instanceof Element) event.currentTarget.setPointerCapture(event.pointerId);
    this.now = { name: this.pressed.name, x, y };
    const into = document.elementFromPoint(x, y)?.closest<HTMLElement>("[data-into]");
    this.over = into ? Number(into.dataset.into) : null;
  }

  up(): void {
    const { now, over } = this;
    this.dragged = now !== null;
    this.cancel();
    if (now && over !== null) this.view.move(now.name, over);
  }

  cancel(): void {
    this.pressed = this.now = this.over = null;
  }

  /** Whether the click that follows belongs to a drag. */
  wasDragged(): boolean {
    const was = this.dragged;
    this.dragged = false;
    return was;
  }
}
