// The passport as text: one line for each name and value, in aligned columns.

export type Line = readonly [name: string, value: string];

export function sheetText(title: string, lines: readonly Line[]): string {
  const width = Math.max(0, ...lines.map(([name]) => name.length));
  const body = lines.map(([name, value]) => `${name.padEnd(width)}  ${value}`.trimEnd());
  return [title, "", ...body, ""].join("\n");
}

/** A file name such as `mikas-7.1-A1234.json`, without characters that file systems reject. */
export function fileName(parts: readonly (string | null | undefined)[], suffix: string): string {
  const clean = parts.map((part) => (part ?? "").replace(/[^\p{L}\p{N}.-]+/gu, "-").replace(/^[-.]+|[-.]+$/g, "")).filter(Boolean);
  return `${clean.join("-") || "mikas"}.${suffix}`;
}
