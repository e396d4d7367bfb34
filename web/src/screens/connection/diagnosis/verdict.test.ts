import { describe, expect, it } from "vitest";
import type { DoctorStep, Port, State } from "../../../lib/api/types";
import { t } from "../messages";
import { BY_CODE, LINKS, SITUATIONS, type Mark, type Situation } from "./situations";
import { bestGuess, situationOf, verdictOf, type Check, type LineFacts } from "./verdict";

const port = (url: string, likely: boolean): Port => ({ url, description: url, chip: "", likely, quirks: [] });
const state = (line: State["line"], more: Partial<LineFacts> = {}): LineFacts => ({
  line,
  reason_code: null,
  port: null,
  model: null,
  samples: 0,
  ...more,
});
const USB = "/dev/ttyUSB0";

describe("situationOf", () => {
  it.each([
    ["sampling", "NoEcho", "ok"],
    ["ecu-alive", null, "ok"],
    ["no-echo", null, "no-echo"],
    ["echo-only", null, "echo-only"],
    ["off", "NoEcho", "no-echo"],
    ["off", "EchoOnly", "echo-only"],
    ["off", "NotAKLineAdapter", "elm327"],
    ["off", "PortBusy", "busy"],
    ["off", "PortDenied", "denied"],
    ["off", "LinkLost", "unplugged"],
    ["off", "Busy", "off"],
  ] as const)("%s, %s: %s", (line, code, wanted) => {
    expect(situationOf(state(line), { ports: [port("a", true)], code })).toBe(wanted);
  });
  it("reports that there is no adapter", () => {
    const of = (ports: Port[], code: string | null = null) => situationOf(state("off"), { ports, code });
    expect(of([])).toBe("no-cable");
    expect(of([port("ttyS0", false)])).toBe("no-cable");
    expect(of([port("a", true)])).toBe("off");
    expect(of([port("ttyS0", false)], "NoPortGiven")).toBe("no-cable");
    expect(of([port("a", true), port("b", true)], "NoPortGiven")).toBe("several");
  });
  it("reports that no adapter was chosen where the browser has the list, or none can be", () => {
    const of = (ports: Port[], code: string | null = null) => situationOf(state("off"), { ports, code, adapters: "chosen" });
    expect(of([])).toBe("not-chosen");
    expect(of([], "NoPortGiven")).toBe("not-chosen");
    expect(of([port("a", true)])).toBe("off");
    expect(situationOf(state("off"), { ports: [], code: null, adapters: "out-of-reach" })).toBe("out-of-reach");
  });
  it.each([
    [USB, null, "opening"],
    [USB, "PortBusy", "busy"],
    [USB, "PortDenied", "denied"],
    [USB, "PortNotFound", "no-port"],
    ["/etc/hostname", "PortFailed", "not-openable"],
    ["socket://127.0.0.1:1", "PortFailed", "no-adapter"],
    [USB, "LinkLost", "unplugged"],
    ["socket://127.0.0.1:1", "LinkLost", "closed"],
    ["replay:a.pcapng", "RecordingOver", "recording-ended"],
  ] as const)("%s, %s", (url, reason_code, wanted) => {
    expect(situationOf(state("no-port", { port: url, reason_code }), { ports: [], code: null })).toBe(wanted);
  });
  it.each([
    ["no-port", "PortBusy", "bridge-busy"],
    ["no-port", "PortTaken", "bridge-busy"],
    ["no-port", "OtherService", "no-adapter"],
    ["no-echo", "ConnectionSilent", "bridge-silent"],
    ["no-port", "PortFailed", "no-adapter"],
    ["no-port", "LinkLost", "closed"],
    ["no-echo", null, "bridge-silent"],
    ["no-echo", "NoEcho", "bridge-silent"],
    ["echo-only", null, "bridge-echo-only"],
    ["echo-only", "EchoOnly", "bridge-echo-only"],
    ["echo-only", "DamagedResponse", "damaged"],
    ["no-echo", "NotAKLineAdapter", "elm327"],
  ] as const)("of a bridge in the network: %s, %s", (line, reason_code, wanted) => {
    for (const url of ["socket://10.0.0.5:4001", "rfc2217://[fd00::5]:4001"])
      expect(situationOf(state(line, { port: url, reason_code }), { ports: [], code: null })).toBe(wanted);
  });
  it("names no USB, plug or 12 V first of a bridge", () => {
    for (const { advice, title } of Object.entries(SITUATIONS).flatMap(([name, it]) => (name.startsWith("bridge") ? [it] : [])))
      for (const words of [t(title), advice ? t(advice) : ""]) {
        expect(words).not.toMatch(/USB|[Pp]lug/);
        const car = words.search(/12 V|ground/);
        if (car >= 0) expect(words.slice(0, car)).toMatch(/bridge/);
      }
  });
  it("reports an adapter as unplugged only if it was there", () => {
    const missing = state("no-port", { port: USB, reason_code: "PortNotFound" });
    const of = (facts: LineFacts, worked: string | null = null) => situationOf(facts, { ports: [], code: null, worked });
    expect(of({ ...missing, samples: 9 })).toBe("unplugged");
    expect(of(missing, USB)).toBe("unplugged");
    expect(of(missing, "/dev/ttyUSB1")).toBe("no-port");
  });
  it("says that a browser may have forgotten an adapter that was unplugged", () => {
    const of = (reason_code: string) =>
      situationOf(state("no-port", { port: USB, reason_code, samples: 9 }), { ports: [], code: null, adapters: "chosen" });
    expect([of("PortNotFound"), of("LinkLost"), of("PortBusy")]).toEqual(["unplugged-chosen", "unplugged-chosen", "busy"]);
  });
  it("does not blame the ignition for damaged answers", () => {
    expect(situationOf(state("echo-only", { reason_code: "DamagedResponse" }), { ports: [], code: null })).toBe("damaged");
  });
});

// Every way in which the check can end, as src/mikas/client/doctor.py makes its steps.
const CODES = [...Object.keys(BY_CODE), "DamagedResponse", "EchoDiffers", "WrongEchoSetting", "LineNotQuiet"];
const step = (name: string, ok: boolean | null, code: string | null = null): DoctorStep =>
  ({ name, ok, code, port: USB, title: { en: "", ru: "" }, detail: { en: name, ru: name }, to_try: null }) as DoctorStep;
const good = (...names: string[]) => names.map((name) => step(name, true));
const ENDS: DoctorStep[][] = [
  good("port", "echo", "baud", "latency", "line", "ecu", "commands"),
  good("port", "echo", "latency", "line", "ecu", "commands"), // an adapter that keeps the echo
  [...good("port", "echo"), step("baud", false), ...good("latency", "line", "ecu", "commands")],
  [...good("port", "echo", "baud", "latency"), step("line", false), ...good("ecu", "commands")],
  [...good("port", "echo"), step("baud", false), step("line", false)],
  [...good("port", "echo", "baud"), step("line", false)],
  ...CODES.flatMap((code) => [
    [step("port", false, code)],
    [...good("port"), step("echo", false, code)],
    [...good("port", "echo"), step("ecu", false, code)],
    [...good("port", "echo"), step("baud", false, code)],
    [...good("port", "echo", "baud"), step("line", false, code)],
    [...good("port", "echo", "baud", "latency", "line", "ecu"), step("commands", false, code)],
  ]),
];
const LINES = ["off", "no-port", "no-echo", "echo-only", "ecu-alive", "sampling"] as const satisfies State["line"][];
const PORTS = [null, [], [port(USB, true)], [port(USB, true), port("b", true)]];
const at = (marks: readonly Mark[], link: (typeof LINKS)[number]) => marks[LINKS.indexOf(link)];

describe("the picture", () => {
  it.each(Object.entries(SITUATIONS))("of %s never says “works” of what the text blames", (_, { marks, title, advice }) => {
    const key = (name: string) => t(name as Parameters<typeof t>[0]);
    const words = `${key(title)} ${advice ? key(advice) : ""}`;
    if (/12 V at the adapter|right port|probably|plug|another program|permission|wrong kind/i.test(words))
      expect(at(marks, "adapter")).not.toBe("works");
    if (/K-Line/.test(words) && !/KKL/.test(words)) expect(at(marks, "wire")).not.toBe("works");
    if (/ignition|does not answer/i.test(words)) expect(at(marks, "ecu")).not.toBe("works");
    if (/the adapter works/i.test(words)) expect(at(marks, "adapter")).toBe("works");
    if (/the ECU (answers|answered)/i.test(words)) expect(at(marks, "ecu")).toBe("works");
  });
});

describe("the verdict", () => {
  it("agrees with the steps of the check, in every state of the line", () => {
    const contradictions: unknown[] = [];
    for (const steps of ENDS)
      for (const line of LINES)
        for (const ports of PORTS)
          for (const reason_code of line === "off" || line === "no-port" ? [null, ...CODES] : [null])
            for (const running of [true, false]) {
              const facts = state(line, { port: line === "off" ? null : USB, reason_code });
              const found = verdictOf(facts, { ports, code: null }, { running, port: USB, steps });
              const alone = situationOf(facts, { ports, code: null });
              const own = running ? ["checking"] : [alone, "ok", "reached"];
              const fromLine = found.outdated || found.step === null;
              const agrees =
                (!fromLine || own.includes(found.situation)) &&
                (!(running || found.step) || follows(found.marks, found.situation, steps)) &&
                (running || found.marks === SITUATIONS[found.situation].marks);
              if (!agrees) contradictions.push([line, reason_code, running, steps, found]);
            }
    expect(contradictions.slice(0, 3)).toEqual([]);
  });

  /** Whether what a step has shown is in the picture, and no headline denies it. */
  function follows(marks: readonly Mark[], situation: Situation, steps: DoctorStep[]): boolean {
    const has = (name: string) => steps.some((each) => each.name === name && each.ok);
    const last = steps.at(-1)!;
    const named = BY_CODE[last.code ?? ""];
    if (named && situation !== "checking") return situation === named;
    if (has("port") && ["off", "no-cable", "several", "no-port", "busy"].includes(situation)) return false;
    if (has("port") && last.ok && /missing|shut/.test(at(marks, "adapter")!)) return false;
    if (has("ecu") && !named && at(marks, "ecu") !== "works") return false;
    return has("echo") || at(marks, "wire") !== "works";
  }

  it("is from the check while it runs, though its port is closed", () => {
    const found = verdictOf(
      state("off", { port: USB }),
      { ports: [], code: null },
      { running: true, port: USB, steps: good("port", "echo") },
    );
    expect(found).toMatchObject({ situation: "checking", marks: ["works", "works", "unknown", "unknown"] });
  });
  it("is from the check after it, until the line has a state", () => {
    const check: Check = { running: false, port: USB, steps: [...good("port"), step("echo", false, "NoEcho")] };
    const of = (facts: LineFacts) => verdictOf(facts, { ports: [], code: null }, check);
    expect(of(state("off"))).toMatchObject({ situation: "no-echo", outdated: false });
    expect(of(state("no-port", { port: USB }))).toMatchObject({ situation: "no-echo", outdated: false });
    expect(of(state("no-echo", { port: USB, reason_code: "NoEcho" }))).toMatchObject({ situation: "no-echo", outdated: false });
    expect(of(state("sampling", { port: USB }))).toMatchObject({ situation: "ok", outdated: true });
    expect(of(state("no-port", { port: "/dev/ttyUSB1" }))).toMatchObject({ situation: "opening", outdated: false });
  });
  it("keeps what only the check can tell", () => {
    const check: Check = {
      running: false,
      port: USB,
      steps: [...good("port", "echo", "latency"), step("line", false), ...good("ecu", "commands")],
    };
    const of = (line: State["line"]) => verdictOf(state(line, { port: line === "off" ? null : USB }), { ports: [], code: null }, check);
    expect(of("off")).toMatchObject({ situation: "disturbed", step: { name: "line" } });
    expect(of("sampling")).toMatchObject({ situation: "ok", outdated: false });
    const slow: Check = { ...check, steps: [...good("port", "echo"), step("baud", false), step("line", false)] };
    expect(verdictOf(state("echo-only", { port: USB }), { ports: [], code: null }, slow)).toMatchObject({
      situation: "wrong-speed",
      outdated: false,
    });
  });
  it("is nothing after a check that was stopped, and opening while connecting", () => {
    const check: Check = { running: false, port: USB, steps: good("port", "echo") };
    expect(verdictOf(state("off"), { ports: [], code: null }, check).situation).toBe("no-cable");
    expect(verdictOf(state("off", { reason_code: "LinkLost" }), { ports: [], code: "PortBusy", trying: true }, check).situation).toBe(
      "opening",
    );
  });
});

it("bestGuess returns a likely port only", () => {
  expect(bestGuess([port("ttyS0", false)])).toBeNull();
  expect(bestGuess([port("a", true), port("b", true)])?.url).toBe("a");
});
