import { expect, it, vi } from "vitest";
import { address } from "../api/http";
import { served } from "./host";

it("the program is reached beside the page, wherever that is", () => {
  const opened: string[] = [];
  vi.stubGlobal(
    "WebSocket",
    class {
      constructor(url: URL) {
        opened.push(url.href);
      }
    },
  );
  for (const page of ["http://127.0.0.1:8071/#/live", "https://host.example/tools/mikas/"]) {
    vi.stubGlobal("document", { baseURI: page });
    served.connect(address("/live", { client: "page-1 a" }));
  }
  expect(opened).toEqual(["ws://127.0.0.1:8071/api/live?client=page-1%20a", "wss://host.example/tools/mikas/api/live?client=page-1%20a"]);
});
