// Whether a lamp that is on means trouble: the level at which it alarms, or the colour that the catalog gives it without an alarm.
import type { Channel, Level } from "../../../lib/api/types";

export function lampLevel(channel: Pick<Channel, "alarm_when_true" | "lamp"> | undefined, value: number | null): Level | null {
  if (!channel || !value) return null;
  if (channel.alarm_when_true !== "none") return channel.alarm_when_true;
  const trouble = channel.lamp?.trouble ?? "none";
  return trouble === "none" ? null : trouble;
}
