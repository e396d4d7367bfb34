// What is said of recordings that another app has shared with the page, or that were opened with it.
import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  some: { en: "What you shared or opened is added to the recordings there.", ru: "То, чем вы поделились или что открыли, добавляется к записям там." },
  none: { en: "No file came with that share. Share the recording itself: a file .pcapng or .pcapng.txt, or one that packs it (.zip, .gz).", ru: "Файла в том, чем вы поделились, не было. Поделитесь самой записью: файлом .pcapng или .pcapng.txt, можно в архиве (.zip, .gz)." },
  full: { en: "There is no room for the shared recording: delete recordings that are no longer needed, or free space on the phone, and share it again.", ru: "Для полученной записи нет места: удалите ненужные записи или освободите память телефона и поделитесь ею ещё раз." },
  failed: { en: "The browser could not hand the shared file over. Save it on the phone, then Recordings, “Add…”.", ru: "Браузер не смог передать файл. Сохраните его на телефоне, затем «Записи», «Добавить…»." },
});
