import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  what: {
    en: "One page for the car's owner: the ECU, the faults in plain words, values at warm idle with reference and mark, three charts. Prints on two A4 pages; with causes, sometimes on three.",
    ru: "Одна страница для владельца: блок, ошибки простыми словами, значения на прогретом ХХ с нормой и оценкой, три графика. Печатается на двух листах A4, с причинами — иногда на трёх.",
  },
  session: { en: "live car (the last quarter of an hour)", ru: "подключённая машина (последние 15 минут)" },
  of_live: { en: "live car", ru: "подключённая машина" },
  of_recording: { en: "recording {name}", ru: "запись {name}" },
  language: { en: "Language", ru: "Язык" },
  preview_of: { en: "Preview of the printed report", ru: "Предпросмотр отчёта" },
  is_made: { en: "The report is ready", ru: "Отчёт готов" },
  is_made_more: { en: "Open it in a new tab; Ctrl+P there prints it or saves it as PDF.", ru: "Откройте его в новой вкладке; там Ctrl+P печатает его или сохраняет в PDF." },
  is_made_file: { en: "Save it and open the file; Ctrl+P there prints it or saves it as PDF.", ru: "Сохраните его и откройте файл; там Ctrl+P печатает его или сохраняет в PDF." },
  making: { en: "Building the report…", ru: "Составляем отчёт…" },
  open: { en: "Open in a new tab", ru: "Открыть в новой вкладке" },
  save: { en: "Save HTML", ru: "Сохранить HTML" },
  print: { en: "Print or save as PDF", ru: "Печать или PDF" },
  refresh: { en: "Rebuild", ru: "Составить заново" },
  no_session: { en: "Nothing has been read in this session yet. Connect to the car, or choose a recording.", ru: "В этом сеансе ещё ничего не прочитано. Подключитесь к машине или выберите запись." },
  idle_hint: { en: "For a verdict on the values: warm engine, one minute at idle, faults read.", ru: "Чтобы была оценка значений: двигатель прогрет, минута на холостом ходу, ошибки прочитаны." },
});
