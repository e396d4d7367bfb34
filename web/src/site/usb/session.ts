// The transfers of a port that is open: several are under way ahead of the bytes, so that none waits for the next request of the worker.
//
// Each asks for exactly one packet: a chip that has less sends less, and one that has more would be a babble. Transfers of a closed session are
// rejected after the port is open again: a session that has ended hears nothing any more.
import { within } from "../within";
import type { Channel } from "./channel";
import type { Chip } from "./chips/chip";
import type { Incoming } from "./incoming";
import type { UsbDevice, UsbEndpoint, UsbInResult } from "./webUsb";

/**
 * Transfers ahead, of which one is in hand: the others are 7 ms of an FTDI's packets where its timer is at 1 ms, 0.1 s where it is at 16, and
 * half a second of the line's bytes otherwise.
 */
const AHEAD = 8;
/** Transfers in a row that may fail before the port counts as lost. */
const MOST_FAILURES = 3;
/** ms in which an endpoint is cleared. */
const PATIENCE = 1000;
/** ms between two questions for errors, of a chip that must be asked. */
const EACH = 1000;

/** The name of the error of an endpoint that refuses transfers for good. */
export const STALLS = "StallError";

/** A transfer, and after how many stalls it was begun: those that were under way at one stall with it, and count with it. */
interface Ahead {
  readonly result: Promise<UsbInResult>;
  readonly turn: number;
}

export class Session {
  private ended = false;
  private turn = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** `lost`: called once when the port is gone, with the reason. */
  constructor(
    private readonly device: UsbDevice,
    private readonly channel: Channel,
    private readonly chip: Chip,
    private readonly incoming: Incoming,
    private readonly lost: (error: DOMException) => void,
  ) {}

  begin(): void {
    void this.receive();
    if (this.chip.readNotice && this.channel.notices) void this.listen(this.channel.notices);
    if (this.chip.askError) this.askLater();
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
  }

  /** The port is gone; called by whoever sees it first. */
  lose(error: unknown): void {
    if (this.ended) return;
    this.end();
    // Whatever a device that was pulled makes of a transfer: AbortError, NotFoundError, InvalidStateError, NetworkError.
    const fatal = error instanceof DOMException && error.name === STALLS ? error : unplugged(error);
    this.incoming.lose(fatal);
    this.lost(fatal);
  }

  private async receive(): Promise<void> {
    const { input } = this.channel;
    const under = Array.from({ length: AHEAD }, () => this.ahead(input));
    let failures = 0;
    try {
      while (!this.ended) {
        const { result, turn } = under.shift()!;
        const { status, data } = await result;
        if (this.ended) return;
        if (isOk(status)) failures = 0;
        else if (turn === this.turn) failures += 1;
        if (failures > MOST_FAILURES) throw new DOMException(`The chip gives no bytes: ${status}.`, STALLS);
        if (status === "stall" && turn === this.turn) {
          await within(PATIENCE, this.device.clearHalt("in", input.endpointNumber));
          this.turn += 1;
        }
        // The transfer for the packet before: what answers that one has gone to the chip first.
        while (under.length < AHEAD - 1) under.push(this.ahead(input));
        if (status === "babble") this.incoming.fail("BufferOverrunError");
        else if (isOk(status) && data?.byteLength) this.take(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
      }
    } catch (error) {
      this.lose(error);
    }
  }

  private take(packet: Uint8Array): void {
    const { bytes, error } = this.chip.unpack(packet);
    this.incoming.add(bytes.slice()); // its own memory: Python reads it as a whole
    if (error) this.incoming.fail(error);
  }

  /** Hear what the chip reports of the wire. Whether the port is lost is for the bulk endpoint to say. */
  private async listen(notices: UsbEndpoint): Promise<void> {
    try {
      while (!this.ended) {
        const { status, data } = await this.transfer(notices);
        if (this.ended || !isOk(status)) return;
        const error = data && this.chip.readNotice!(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
        if (error) this.incoming.fail(error);
      }
    } catch {
      // Unplugged, or an endpoint that this copy of the chip lacks.
    }
  }

  private askLater(): void {
    this.timer = setTimeout(() => void this.askError(), EACH);
  }

  private async askError(): Promise<void> {
    try {
      const error = await this.chip.askError!();
      if (this.ended) return;
      if (error) this.incoming.fail(error);
      this.askLater();
    } catch {
      // The chip can't be asked, or is gone.
    }
  }

  private ahead(endpoint: UsbEndpoint): Ahead {
    return { result: this.transfer(endpoint), turn: this.turn };
  }

  private transfer({ endpointNumber, packetSize }: UsbEndpoint): Promise<UsbInResult> {
    const transfer = this.device.transferIn(endpointNumber, packetSize);
    transfer.catch(() => undefined); // those behind the first one that fails are not waited for
    return transfer;
  }
}

const isOk = (status: UsbInResult["status"]): boolean => (status ?? "ok") === "ok";

/** The error of a port that is gone, as Web Serial has it. */
export const unplugged = (error: unknown): DOMException =>
  new DOMException(error instanceof Error ? error.message : String(error), "NetworkError");
