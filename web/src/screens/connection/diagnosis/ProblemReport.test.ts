import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { afterEach, expect, it, vi } from "vitest";
import type { DoctorStep, Port } from "../../../lib/api/types";
import { thisBrowser } from "../../../lib/platform/thisBrowser";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import ProblemReport from "./ProblemReport.svelte";
import { formFor, problemReport } from "./reportText";

eachOnItsOwnPage();
afterEach(() => vi.unstubAllGlobals());

const CH340 = { url: "webusb:1a86:7523", chip: "CH340", description: "CH340", likely: true, quirks: [] } as Port;
const both = (text: string) => ({ en: text, ru: text });
const PORT_STEP = {
  name: "port",
  ok: false,
  detail: both("It is in use."),
  to_try: both("Close other apps."),
  code: null,
} as unknown as DoctorStep;

it("chip, browser, what the page says and the check are in the report", () => {
  const said = {
    version: "1.2",
    browser: "Google Chrome 150, Android 15, Pixel 7",
    ports: [CH340],
    port: CH340.url,
    unit: "",
    steps: [PORT_STEP],
  };
  const text = problemReport({ ...said, says: ["The port can't be opened", "In use.", "In use.", ""] });
  expect(text.split("\n").slice(0, 8)).toEqual([
    "mikas 1.2",
    "Browser and system: Google Chrome 150, Android 15, Pixel 7",
    "Cables found: CH340 (webusb:1a86:7523)",
    "Port: webusb:1a86:7523",
    "The page says: The port can't be opened / In use.",
    "ECU: none",
    "Connection check:",
    "- Port: failed. It is in use. Close other apps.",
  ]);
});

it("a phone has a form of its own", () => {
  expect(formFor("Mozilla/5.0 (Linux; Android 10; K)")).toContain("template=phone.yml");
  expect(formFor("Mozilla/5.0 (X11; Linux x86_64)")).toContain("template=car.yml");
});

it("the browser's own details name the phone, which its usual name hides", async () => {
  const userAgent = "Mozilla/5.0 (Linux; Android 10; K) Chrome/150.0.0.0";
  const brands = ["Not;A=Brand", "Chromium", "Google Chrome"].map((brand) => ({ brand, version: "150.0.7300.12" }));
  const getHighEntropyValues = () =>
    Promise.resolve({ platform: "Android", platformVersion: "15.0.0", model: "Pixel 7", fullVersionList: brands });
  expect(await thisBrowser({ userAgent, userAgentData: { brands, getHighEntropyValues } } as never)).toBe(
    "Google Chrome 150.0.7300.12, Android 15.0.0, Pixel 7",
  );
  expect(await thisBrowser({ userAgent })).toBe(userAgent);
  const refused = () => Promise.reject(new DOMException("", "NotAllowedError"));
  expect(await thisBrowser({ userAgent, userAgentData: { brands, getHighEntropyValues: refused } } as never)).toBe(userAgent);
});

it("what is copied is what stands on the screen", async () => {
  const writeText = vi.fn(() => Promise.resolve());
  vi.stubGlobal("navigator", { userAgent: "Firefox 153", clipboard: { writeText } });
  const shown = page({ "/ports": { ports: [CH340] } });
  shown.say({ line: "no-port", port: CH340.url });
  await shown.stores.connection.ports.reload();
  shown.show(ProblemReport, { says: ["The port can't be opened"] });
  flushSync();
  expect(document.querySelector("pre")?.textContent).toBe(""); // it repeats what is elsewhere on the screen
  const details = document.querySelector("details")!;
  details.open = true;
  await fireEvent(details, new Event("toggle"));
  screen.getByRole("button", { name: "Copy the report", hidden: true }).click();
  const [text] = writeText.mock.calls[0] as unknown as [string];
  expect(text).toContain("Browser and system: Firefox 153");
  expect(text).toBe(document.querySelector("pre")?.textContent);
  expect(screen.getByRole("link", { name: "The form, on GitHub", hidden: true }).getAttribute("href")).toContain("car.yml");
});
