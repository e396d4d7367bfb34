// Titles of tiles. The catalog's full Russian names of these channels are too long for a tile; the full name is the tile's tooltip.
import { language } from "../../../lib/i18n";

const SHORT_RUSSIAN: Record<string, string> = {
  FREQ: "Обороты",
  FREQX: "Обороты ХХ",
  RCOD: "Коррекция СО на ХХ",
  SSM: "РДВ (РХХ), задание",
  FSM: "РДВ (РХХ), положение",
};

/** The title of a channel on a tile; `full` is its name in the catalog. */
export function tileTitle(name: string, full: string): string {
  return (language.code === "ru" && SHORT_RUSSIAN[name]) || full;
}
