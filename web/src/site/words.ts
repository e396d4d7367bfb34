// What the page says otherwise than on a desktop: the program runs in this tab, and what is kept is in this browser.
import type { Text } from "../lib/api/types";
import type { Host } from "../lib/platform/host";

export const words: Host["words"] = {
  unreachable: { en: "The program in this page has stopped. Reload the page; recordings are kept.", ru: "Программа на этой странице остановилась. Обновите страницу; записи сохранены." },
  ended: { en: "The program in this page has stopped. Reload the page: recordings are kept, at most the last second of one is missing.", ru: "Программа на этой странице остановилась. Обновите страницу: записи сохранены, не хватать может только последней секунды." },
  returns: { en: "Reload the page. Recordings are kept.", ru: "Обновите страницу. Записи сохранены." },
  otherPort: { en: "for example sim:?scenario=city, webserial:0403:6001 (on a phone webusb:0403:6001)", ru: "например sim:?scenario=city, webserial:0403:6001 (на телефоне webusb:0403:6001)" },
  kept: { en: "kept in this browser; download what matters", ru: "в этом браузере; важное скачайте" },
  otherExports: { en: "MDF4 (.mf4) and Parquet are made by mikas installed on a computer: take the .pcapng there.", ru: "MDF4 (.mf4) и Parquet делает mikas, установленный на компьютере: перенесите туда .pcapng." },
};

/** Where the browser keeps nothing. */
export const unkept: Text = { en: "kept until this page is closed; download what matters", ru: "только пока открыта эта страница; важное скачайте" };
