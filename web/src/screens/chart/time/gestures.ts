// Mouse, wheel, pen and touch on the panes. Wheel: zoom time; Shift-wheel: zoom values; drag: pan (with Shift: values); two fingers: zoom
// and pan; double click: fit. Moving sets the cursor; a click or touch selects the moment.

export interface Actions {
  time(x: number, width: number): number;
  seconds(pixels: number, width: number): number;
  cursor(time: number): void;
  choose(time: number): void;
  pan(seconds: number): void;
  zoom(factor: number, around: number): void;
  stretch(pane: number, factor: number): void;
  shift(pane: number, share: number): void;
  fit(): void;
}

interface Finger {
  x: number;
  y: number;
}

const MOVED = 5;

export function gestures(area: HTMLElement, act: Actions): () => void {
  const fingers = new Map<number, Finger>();
  let plot: HTMLElement | null = null;
  let dragged = false;
  let began = { x: 0, y: 0 };

  const plotAt = (event: Event): HTMLElement | null =>
    event.target instanceof Element ? event.target.closest<HTMLElement>(".plot") : null;
  const x = (event: MouseEvent, over: HTMLElement) => event.clientX - over.getBoundingClientRect().left;

  function down(event: PointerEvent): void {
    const over = plotAt(event);
    if (!over || event.button !== 0) return;
    plot = over;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (fingers.size > 1) {
      dragged = true;
      return;
    }
    dragged = false;
    began = { x: event.clientX, y: event.clientY };
  }

  function move(event: PointerEvent): void {
    const before = fingers.get(event.pointerId);
    if (!before) {
      const over = plotAt(event);
      if (over && event.pointerType !== "touch") act.cursor(act.time(x(event, over), over.clientWidth));
      return;
    }
    if (!plot) return;
    const now = { x: event.clientX, y: event.clientY };
    if (!dragged && Math.hypot(now.x - began.x, now.y - began.y) < MOVED) return;
    if (!dragged) {
      dragged = true;
      area.setPointerCapture(event.pointerId);
    }
    if (fingers.size === 2) pinch(event.pointerId, before, now, plot);
    else if (event.shiftKey) act.shift(Number(plot.dataset.pane), (now.y - before.y) / plot.clientHeight);
    else act.pan(-act.seconds(now.x - before.x, plot.clientWidth));
    fingers.set(event.pointerId, now);
  }

  function pinch(id: number, before: Finger, now: Finger, over: HTMLElement): void {
    const other = [...fingers].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const was = Math.max(20, Math.abs(before.x - other.x));
    const is = Math.max(20, Math.abs(now.x - other.x));
    const middle = (now.x + other.x) / 2 - over.getBoundingClientRect().left;
    act.zoom(was / is, act.time(middle, over.clientWidth));
    act.pan(-act.seconds((now.x - before.x) / 2, over.clientWidth));
  }

  function up(event: PointerEvent): void {
    if (!fingers.delete(event.pointerId) || dragged || !plot) return;
    act.choose(act.time(x(event, plot), plot.clientWidth));
  }

  function cancel(event: PointerEvent): void {
    fingers.delete(event.pointerId);
  }

  function wheel(event: WheelEvent): void {
    const over = plotAt(event);
    if (!over) return;
    event.preventDefault();
    // Some browsers turn the wheel sideways while Shift is held.
    const turn = Math.abs(event.deltaY) > Math.abs(event.deltaX) ? event.deltaY : event.deltaX;
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? turn * 33 : turn;
    const factor = Math.exp(Math.max(-200, Math.min(200, lines)) * 0.002);
    if (event.shiftKey) act.stretch(Number(over.dataset.pane), factor);
    else act.zoom(factor, act.time(x(event, over), over.clientWidth));
  }

  function double(event: MouseEvent): void {
    if (plotAt(event)) act.fit();
  }

  const over = new AbortController();
  const { signal } = over;
  area.addEventListener("pointerdown", down, { signal });
  area.addEventListener("pointermove", move, { signal });
  area.addEventListener("pointerup", up, { signal });
  area.addEventListener("pointercancel", cancel, { signal });
  area.addEventListener("wheel", wheel, { passive: false, signal });
  area.addEventListener("dblclick", double, { signal });
  return () => over.abort();
}
