// What the page stands on. On a desktop that is the program that served it, reached by HTTP. On the site (src/site) it is the same program
// in workers of this page. Whatever differs between the two is a field here; the site has others.
import type { Component } from "svelte";
import type { ExportFormat, Text } from "../api/types";
import { words } from "./words";

/** What the page needs of a WebSocket. */
export interface LiveSocket {
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  close(): void;
}

export interface Host {
  /** Both take addresses of the API, relative to the page. */
  fetch(address: string, init?: RequestInit): Promise<Response>;
  connect(address: string): LiveSocket;
  /** ms without a message after which a socket is dead, though nothing says so: before its first message, and later. */
  patience: { first: number; next: number };
  /** Whether the program runs in this page, and ends when the computer sleeps. */
  runsHere: boolean;
  /**
   * Let the user choose an adapter in the browser's own list; called in a click. Returns the port; null: none was chosen. Without this function the program finds all adapters by itself.
   */
  choosePort: (() => Promise<string | null>) | null;
  /** Whether adapters can be used at all. */
  reachesAdapters: boolean;
  /** Whether adapters are fed by the one socket of the device on which this page is, which is not charged meanwhile: a phone. */
  feedsAdapters: boolean;
  /** Whether the browser itself can load addresses of the API: links, frames. */
  opensAddresses: boolean;
  /** Whether the program can let phones and other computers in. */
  sharesNetwork: boolean;
  exports: readonly ExportFormat[];
  /** Parts of the Connection screen: below the situation, and a card beside the adapters. */
  connectionNotices: Component | null;
  connectionCard: Component | null;
  words: {
    /** The program does not answer: to a request, in the band, on an empty screen. */
    unreachable: Text;
    ended: Text;
    returns: Text;
    /** What can be typed as another port. */
    otherPort: Text;
    /** Where the recordings are; null: in the folder that the program names. */
    kept: Text | null;
    /** What to do for a format that is not among the `exports`. */
    otherExports: Text | null;
  };
}

/** The program that has served the page. */
export const served: Host = {
  fetch: (address, init) => fetch(address, init),
  connect(address) {
    const url = new URL(address, document.baseURI);
    url.protocol = url.protocol.replace("http", "ws");
    return new WebSocket(url);
  },
  // The state comes twice a second. A network that is gone says nothing, for minutes.
  patience: { first: 4000, next: 2750 },
  runsHere: false,
  choosePort: null,
  reachesAdapters: true,
  feedsAdapters: false,
  opensAddresses: true,
  sharesNetwork: true,
  exports: ["csv", "msl", "mlg", "mf4", "parquet", "gpx", "geojson"],
  connectionNotices: null,
  connectionCard: null,
  words,
};
