import { expect, it } from "vitest";
import { served } from "../platform/host";
import { createApi } from "./api";
import { ApiError } from "./http";

const SECOND = 1000;

/** A program whose answers the test gives. */
function program() {
  const asked: { answer: (response: Response) => void; signal: AbortSignal }[] = [];
  const fetch = (_: string, init: RequestInit = {}) =>
    new Promise<Response>((answer, fail) => {
      const signal = init.signal!;
      asked.push({ answer, signal });

      signal.addEventListener("abort", () => fail(signal.reason));
    });
  const api = createApi({ ...served, fetch });
  const pass = (lost: boolean, seconds: number) => {
    for (let second = 0; second < seconds; second += 1) api.waiting.look(lost, SECOND);
  };
  return { api, asked, pass };
}

const failure = (promise: Promise<unknown>) => promise.then(() => null).catch((error: unknown) => error);
const settled = () => new Promise((resolve) => setTimeout(resolve));

it("a request without an answer ends after the connection was lost, and says so", async () => {
  const { api, pass } = program();
  const [before, changed] = [failure(api.ports()), failure(api.startRecording())];
  pass(false, 600); // it may take as long as it likes
  pass(true, 3);
  pass(false, 12);
  for (const error of [await before, await changed]) {
    expect(error).toBeInstanceOf(ApiError);
    expect((error as ApiError).text).toEqual(served.words.unreachable);
  }
});

it("one that is only late has its answer, and what is asked after the loss is as ever", async () => {
  const { api, asked, pass } = program();
  const late = api.state();
  pass(true, 3);
  pass(false, 10);
  asked[0]!.answer(Response.json({ line: "off" }));
  expect((await late).line).toBe("off");
  void api.state();
  pass(false, 600);
  expect(asked[1]!.signal.aborted).toBe(false);
});

it("a file, or one that is added, has longer while the connection is there, and ends without it", async () => {
  const { api, asked, pass } = program();
  const made = [failure(api.file("api/report")), failure(api.addRecording("a.pcapng", new Blob(["a"])))];
  pass(true, 3);
  pass(false, 600);
  expect(asked.map(({ signal }) => signal.aborted)).toEqual([false, false]);
  pass(true, 15);
  for (const error of await Promise.all(made)) expect((error as ApiError).code).toBe("Unreachable");
});

it("an answer in parts goes on as long as parts come, and ends when none does", async () => {
  const { api, asked, pass } = program();
  const steps: unknown[] = [];
  const checked = failure(api.doctor(null, (step) => steps.push(step)));
  let body!: ReadableStreamDefaultController<Uint8Array>;
  const stream = new ReadableStream<Uint8Array>({ start: (controller) => void (body = controller) });
  asked[0]!.signal.addEventListener("abort", () => body.error(asked[0]!.signal.reason));
  asked[0]!.answer(new Response(stream));
  for (const step of [1, 2]) {
    pass(true, 3);
    pass(false, 10);
    body.enqueue(new TextEncoder().encode(`{"step":${step}}\n`));
    await settled();
  }
  expect(steps).toEqual([{ step: 1 }, { step: 2 }]);
  pass(true, 15);
  expect(((await checked) as ApiError).code).toBe("Unreachable");
});

it("whoever asked can still stop it, and that is no error of the program", async () => {
  const { api } = program();
  const stop = new AbortController();
  const file = failure(api.file("api/report", stop.signal));
  stop.abort();
  expect(((await file) as DOMException).name).toBe("AbortError");
});
