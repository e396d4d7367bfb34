// The car's 12-pin block as far as it is known (docs/how-to/wiring.md): pins in the order of their numbers, not of their places. Unconfirmed pins
// are marked wherever they are drawn.

export type Confidence = "reported" | "unconfirmed" | "unknown";

export interface Pin {
  number: number;
  /** Key of the name in the dictionary; null: another circuit, not connected. */
  signal: "ground" | "request" | "supply" | "kline" | null;
  confidence: Confidence;
  /** Pins of the adapter's 16-pin plug; null: leave it free. */
  plug: string | null;
}

const KNOWN: Record<number, Omit<Pin, "number">> = {
  2: { signal: "supply", confidence: "unconfirmed", plug: "16" },
  10: { signal: "request", confidence: "reported", plug: null },
  11: { signal: "kline", confidence: "unconfirmed", plug: "7" },
  12: { signal: "ground", confidence: "reported", plug: "4, 5" },
};

export const PINS: readonly Pin[] = Array.from({ length: 12 }, (_, at) => ({
  number: at + 1,
  ...(KNOWN[at + 1] ?? { signal: null, confidence: "unknown" as const, plug: null }),
}));
