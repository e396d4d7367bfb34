// Search of a channel by any name that people use: its mnemonic, its texts, words of a mechanic and of other programs.
import type { Channel } from "../api/types";

/** Letters and digits in small letters, other signs as one space: `Batt_V` and `batt v` are one. */
export const normal = (text: string): string =>
  text
    .toLocaleLowerCase()
    .replaceAll("ё", "е")
    .replaceAll(/[^\p{L}\d]+/gu, " ")
    .trim();

/** The channels found; those that are called so by a whole name come first. */
export function searched(channels: readonly Channel[], typed: string): Channel[] {
  const words = normal(typed);
  if (words === "") return [...channels];
  const rank = (channel: Channel): number => {
    const names = [channel.name, ...channel.names].map(normal);
    if (names.includes(words)) return 2;
    const texts = [channel.text, channel.short].flatMap(({ en, ru }) => [en, ru]).map(normal);
    return [...names, ...texts].some((text) => text.includes(words)) ? 1 : 0;
  };
  return channels
    .map((channel) => ({ channel, rank: rank(channel) }))
    .filter(({ rank }) => rank > 0)
    .sort((one, two) => two.rank - one.rank)
    .map(({ channel }) => channel);
}
