// The operating system, for advice on drivers and rights.

export type System = "windows" | "linux" | "other";

export function systemOf(agent: string): System {
  if (/Windows/.test(agent)) return "windows";
  return /Linux|CrOS/.test(agent) && !/Android/.test(agent) ? "linux" : "other";
}
