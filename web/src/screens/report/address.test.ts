import { expect, it } from "vitest";
import { mayFrame, reportFile } from "./address";
import { served } from "../../lib/platform/host";
import { Stores } from "../../stores";

const { api } = new Stores(served);

it("the address contains recording and language", () => {
  expect(api.report(null, "ru", true)).toBe("api/report?lang=ru&inline=1");
  expect(api.report("a b.pcapng", "en")).toBe("api/recordings/a%20b.pcapng/report?lang=en");
  expect(reportFile("a b.pcapng", "en")).toBe("a b-report-en.html");
});

it("a report is framed only where the server allows it", () => {
  const of = (policy: string | null, options: string | null) => {
    const headers = new Headers();
    if (policy) headers.set("Content-Security-Policy", policy);
    if (options) headers.set("X-Frame-Options", options);
    return mayFrame(headers);
  };
  expect(of("default-src 'none'; frame-ancestors 'none'; sandbox", "DENY")).toBe(false);
  expect(of("default-src 'none'; frame-ancestors 'self'; sandbox", "SAMEORIGIN")).toBe(true);
  expect(of(null, "DENY")).toBe(false);
  expect(of(null, null)).toBe(true);
});
