import { expect, it } from "vitest";
import { whoAnswers } from "./whoAnswers";
import { served } from "../../lib/platform/host";
import { Stores } from "../../stores";

const { api } = new Stores(served);

it("the reader answers what only reads recordings", () => {
  const read = [
    "api/recordings",
    "api/recordings/a%2Fb.pcapng",
    "api/recordings/a/rows?points=2",
    "api/recordings/a/find?expression=FREQ",
    "api/recordings/a/faults",
    "api/recordings/a/causes?complaint=high_idle",
    "api/recordings/a/tests/charging",
    "api/channels/FREQ/value?recording=a&at=1",
    api.recordingFile("a b"),
    api.exportFile("a", "csv"),
    api.report("a", "ru", true),
  ];
  for (const address of read) expect([address, whoAnswers("GET", address)]).toEqual([address, "reader"]);
  expect(whoAnswers("POST", "api/channels/try", '{"recording":"a"}')).toBe("reader");
  expect(whoAnswers("POST", "api/foreign-logs/values?name=a.csv", new Blob(["t"]))).toBe("reader");
});

it("the line's worker answers all else, and every change", () => {
  const live = [
    "api/state",
    "api/report?lang=ru",
    "api/channels/FREQ/value?at=1",
    "api/history/find?expression=api/recordings",
    "api/references",
    api.dumpFile("1"),
    "api/recordings/a/unknown",
    "api/recording/start",
  ];
  for (const address of live) expect([address, whoAnswers("GET", address)]).toEqual([address, "line"]);
  for (const method of ["PUT", "DELETE", "POST"]) expect(whoAnswers(method, "api/recordings/a/marker")).toBe("line");
  expect(whoAnswers("PUT", "api/recordings/a")).toBe("line");
  for (const body of ['{"recording":null}', "{", undefined]) expect(whoAnswers("POST", "api/channels/try", body)).toBe("line");
});
