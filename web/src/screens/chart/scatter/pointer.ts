// Mouse, pen and touch over the cloud: a click or tap, drawing around points, zoom by wheel or two fingers, moving by Shift or two fingers.

export interface Pointing {
  /** A place in CSS pixels of the element; null: the pointer has left. */
  hover: (at: readonly [number, number] | null) => void;
  click: (at: readonly [number, number]) => void;
  /** The line drawn so far; `done`: it is complete; null: cancelled. */
  lasso: (line: readonly (readonly [number, number])[] | null, done: boolean) => void;
  zoom: (factor: number, around: readonly [number, number]) => void;
  pan: (across: number, down: number) => void;
}

/** Pixels before a press becomes a line. */
const MOVED = 6;
const WHEEL = 0.0015;

/** Listens until the returned function is called. */
export function pointing(area: HTMLElement, act: Pointing): () => void {
  const fingers = new Map<number, [number, number]>();
  let line: [number, number][] = [];
  let panning = false;
  let drawing = false;
  /** Two fingers were down: what follows until all are up is no click. */
  let pinched = false;

  const placeOf = (event: MouseEvent): [number, number] => {
    const box = area.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  function down(event: PointerEvent): void {
    if (event.button !== 0 && event.button !== 1) return;
    fingers.set(event.pointerId, placeOf(event));
    area.setPointerCapture(event.pointerId);
    if (fingers.size === 1) {
      panning = event.shiftKey || event.button === 1;
      pinched = false;
      line = [placeOf(event)];
    } else {
      pinched = true;
      stopLine();
    }
    if (event.button === 1) event.preventDefault();
  }

  function move(event: PointerEvent): void {
    const at = placeOf(event);
    const before = fingers.get(event.pointerId);
    if (!before) return act.hover(at);
    if (fingers.size === 2) return pinch(event.pointerId, before, at);
    fingers.set(event.pointerId, at);
    if (pinched) return;
    if (panning) {
      if (line.length > 1 || isFar(line[0]!, at)) {
        act.pan(at[0] - before[0], at[1] - before[1]);
        line.push(at);
      }
      return;
    }
    if (!drawing && !isFar(line[0]!, at)) return;
    drawing = true;
    line.push(at);
    act.lasso(line, false);
  }

  function pinch(id: number, before: [number, number], at: [number, number]): void {
    const [other] = [...fingers].filter(([finger]) => finger !== id).map(([, place]) => place);
    fingers.set(id, at);
    const apart = (one: readonly [number, number]) => Math.max(20, Math.hypot(one[0] - other![0], one[1] - other![1]));
    act.pan((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
    act.zoom(apart(before) / apart(at), [(at[0] + other![0]) / 2, (at[1] + other![1]) / 2]);
  }

  function up(event: PointerEvent): void {
    if (!fingers.delete(event.pointerId)) return;
    if (pinched || fingers.size > 0) return;
    if (drawing) {
      act.lasso(line, true);
      stopLine();
    } else if (line.length === 1) act.click(line[0]!);
    line = [];
  }

  function stopLine(): void {
    drawing = false;
    line = [];
    act.lasso(null, false);
  }

  function cancel(event: PointerEvent): void {
    fingers.delete(event.pointerId);
    stopLine();
  }

  function wheel(event: WheelEvent): void {
    event.preventDefault();
    act.zoom(Math.exp((event.deltaY || event.deltaX) * WHEEL), placeOf(event));
  }

  const over = new AbortController();
  const { signal } = over;
  area.addEventListener("pointerdown", down, { signal });
  area.addEventListener("pointermove", move, { signal });
  area.addEventListener("pointerup", up, { signal });
  area.addEventListener("pointercancel", cancel, { signal });
  area.addEventListener("pointerleave", () => act.hover(null), { signal });
  area.addEventListener("wheel", wheel, { passive: false, signal });
  return () => over.abort();
}

const isFar = (one: readonly [number, number], other: readonly [number, number]) =>
  Math.hypot(one[0] - other[0], one[1] - other[1]) >= MOVED;
