// Which driver a device has, by vendor, product and class. The names that a user reads are Python's (`mikas.link.chips`).
import { acmOf, channelOf, type Channel } from "./channel";
import { CdcAcm } from "./chips/cdcAcm";
import { Ch34x } from "./chips/ch34x";
import type { Chip } from "./chips/chip";
import { Cp210x } from "./chips/cp210x";
import { Ftdi } from "./chips/ftdi";
import { Pl2303 } from "./chips/pl2303";
import type { UsbDevice, UsbFilter } from "./webUsb";

export type Family = "ftdi" | "ch34x" | "cp210x" | "pl2303" | "cdc-acm";

const FTDI = 0x0403;
const SILICON_LABS = 0x10c4;
const PROLIFIC = 0x067b;
/** CH34x by vendor and product: the makers' other products are no serial ports, or CDC-ACM. */
const CH34X: readonly (readonly [vendor: number, product: number])[] = [
  [0x1a86, 0x7523],
  [0x1a86, 0x7522],
  [0x1a86, 0x5523],
  [0x4348, 0x5523],
  [0x2184, 0x0057],
  [0x9986, 0x7523],
];

/** What the browser lists when the user chooses: whatever may be a serial port. */
export const FILTERS: readonly UsbFilter[] = [
  ...[FTDI, SILICON_LABS, PROLIFIC].map((vendorId) => ({ vendorId })),
  ...CH34X.map(([vendorId, productId]) => ({ vendorId, productId })),
  { classCode: 0x02, subclassCode: 0x02 },
];

const configurationOf = ({ configuration, configurations }: UsbDevice) => configuration ?? configurations[0];

/** The family of a device's chip; null: it is no serial port that is known here. */
export function familyOf(device: UsbDevice): Family | null {
  const configuration = configurationOf(device);
  if (channelOf(configuration) === null) return null;
  if (acmOf(configuration)) return "cdc-acm";
  const { vendorId, productId } = device;
  if (vendorId === FTDI) return "ftdi";
  if (vendorId === SILICON_LABS) return "cp210x";
  if (vendorId === PROLIFIC) return "pl2303";
  return CH34X.some(([vendor, product]) => vendor === vendorId && product === productId) ? "ch34x" : null;
}

/** The driver of a device, of whose configuration `channel` is the port. `write`: send bytes to the wire. */
export function driverOf(device: UsbDevice, channel: Channel, write: (bytes: Uint8Array<ArrayBuffer>) => Promise<void>): Chip {
  const [first] = channel.interfaces;
  const { input, output } = channel;
  switch (familyOf(device)) {
    case "ftdi":
      return new Ftdi(device, first!, input.packetSize);
    case "ch34x":
      return new Ch34x(device, write);
    case "cp210x":
      return new Cp210x(device, first!);
    case "pl2303":
      return new Pl2303(device, async () => {
        await device.clearHalt("out", output.endpointNumber);
        await device.clearHalt("in", input.endpointNumber);
      });
    default:
      return new CdcAcm(device, first!);
  }
}
