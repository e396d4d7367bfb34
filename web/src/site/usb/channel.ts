// Where a device has its serial port: the interfaces to claim, and the endpoints of the bytes and of the notices.
import type { UsbConfiguration, UsbEndpoint, UsbInterface } from "./webUsb";

const COMMUNICATION = 0x02;
const ACM = 0x02;

export interface Channel {
  /** Of the interfaces that are claimed, the one of the requests comes first. */
  readonly interfaces: readonly number[];
  readonly input: UsbEndpoint;
  readonly output: UsbEndpoint;
  /** The interrupt endpoint; null: there is none. */
  readonly notices: UsbEndpoint | null;
}

/** Whether an interface takes the requests of CDC-ACM. */
const isAcm = ({ alternate }: UsbInterface): boolean => alternate.interfaceClass === COMMUNICATION && alternate.interfaceSubclass === ACM;

/** The control interface of a CDC-ACM device; undefined: it is none. */
export const acmOf = (configuration: UsbConfiguration | undefined): UsbInterface | undefined => configuration?.interfaces.find(isAcm);

/** The first serial port of a device; null: it has none. A chip with several ports has its K-Line on the first. */
export function channelOf(configuration: UsbConfiguration | undefined): Channel | null {
  const data = configuration?.interfaces.find((it) => bulk(it, "in") && bulk(it, "out"));
  const [input, output] = [data && bulk(data, "in"), data && bulk(data, "out")];
  if (!data || !input || !output) return null;
  const control = acmOf(configuration) ?? data;
  const notices = control.alternate.endpoints.find(({ type, direction }) => type === "interrupt" && direction === "in");
  return { interfaces: [...new Set([control.interfaceNumber, data.interfaceNumber])], input, output, notices: notices ?? null };
}

const bulk = ({ alternate }: UsbInterface, wanted: "in" | "out"): UsbEndpoint | undefined =>
  alternate.endpoints.find(({ type, direction }) => type === "bulk" && direction === wanted);
