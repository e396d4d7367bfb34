// The operating system, for advice on drivers and rights.

export type System = "windows" | "linux" | "android" | "other";

export function systemOf(agent: string): System {
  if (/Windows/.test(agent)) return "windows";
  if (/Android/.test(agent)) return "android";
  return /Linux|CrOS/.test(agent) ? "linux" : "other";
}
