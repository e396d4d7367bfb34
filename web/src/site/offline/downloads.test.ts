import { expect, it, vi } from "vitest";
import { askPages, type Page } from "./asking";
import { answer } from "./downloads";

type Fetch = Parameters<typeof answer>[2];

/** A page with the program. */
const page = (fetch: Fetch): Page => ({ postMessage: ({ address }, [port]) => void answer(port as MessagePort, address, fetch) });
/** A page that shows that another tab has the program: it does not answer. */
const idle: Page = { postMessage: () => undefined };

const bytes = (text: string) => new TextEncoder().encode(text);

it("the page with the program answers a download, head and bytes", async () => {
  const headers = { "Content-Disposition": 'attachment; filename="a.pcapng"' };
  const fetch = vi.fn(() => Promise.resolve(new Response("recorded", { status: 200, headers })));
  const { response, over } = await askPages([idle, page(fetch)], "api/recordings/a/file?x=1");
  expect(fetch).toHaveBeenCalledExactlyOnceWith("api/recordings/a/file?x=1", { signal: expect.any(AbortSignal) });
  expect([response.status, response.headers.get("Content-Disposition")]).toEqual([200, headers["Content-Disposition"]]);
  expect(await response.text()).toBe("recorded");
  await over;
});

it("a part is read when the browser wants more, not before", async () => {
  let made = 0;
  const endless = new ReadableStream(
    {
      pull(controller) {
        made += 1;
        controller.enqueue(bytes(`${made} `));
      },
    },
    { highWaterMark: 0 },
  );
  const { response, over } = await askPages([page(() => Promise.resolve(new Response(endless)))], "api/x");
  const reader = response.body!.getReader();
  const read = async () => new TextDecoder().decode((await reader.read()).value);
  expect([await read(), await read(), await read()]).toEqual(["1 ", "2 ", "3 "]);
  expect(made).toBeLessThan(7);
  await reader.cancel();
  await over;
});

it("a download that the user cancels ends in the program", async () => {
  const signals: (AbortSignal | null | undefined)[] = [];
  const fetch: Fetch = (_, init) => {
    signals.push(init?.signal);
    return Promise.resolve(new Response(new ReadableStream({ pull: (controller) => controller.enqueue(bytes("x")) })));
  };
  const { response, over } = await askPages([page(fetch)], "api/x");
  await response.body!.cancel();
  await over;
  await vi.waitFor(() => expect(signals[0]!.aborted).toBe(true));
});

it("a program that ends amid the bytes breaks the download, before them it says so", async () => {
  const broken = new ReadableStream({ start: (controller) => controller.error(new TypeError("ended")) });
  const { response } = await askPages([page(() => Promise.resolve(new Response(broken)))], "api/x");
  await expect(response.text()).rejects.toThrow(TypeError);
  const none = await askPages([page(() => Promise.reject(new TypeError("ended")))], "api/x");
  expect([none.response.status, await none.response.text()]).toEqual([502, expect.stringContaining("has ended")]);
});

it("without a page that has the program there is none", async () => {
  expect((await askPages([], "api/x")).response.status).toBe(503);
  vi.useFakeTimers();
  const asked = askPages([idle], "api/x");
  await vi.advanceTimersByTimeAsync(10_000);
  vi.useRealTimers();
  expect((await asked).response.status).toBe(503);
});
