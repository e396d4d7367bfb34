import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  title: { en: "Report", ru: "Отчёт" },
  what: {
    en: "One page for the car's owner: the unit, the faults in plain words, values at warm idle against their reference with a mark each, three charts. Prints on two A4 sides.",
    ru: "Одна страница для владельца: блок, неисправности простыми словами, значения на прогретом холостом ходу рядом с нормой и оценкой, три графика. Печатается на двух листах A4.",
  },
  source: { en: "About", ru: "По данным" },
  session: { en: "this session (the last minutes)", ru: "этого сеанса (последние минуты)" },
  language: { en: "Language", ru: "Язык" },
  preview_of: { en: "The report, as it will be printed", ru: "Отчёт, каким он будет напечатан" },
  is_made: { en: "The report is made", ru: "Отчёт составлен" },
  is_made_more: {
    en: "Open it in a new tab; there Ctrl+P prints it or saves it as PDF.",
    ru: "Откройте его в новой вкладке; там Ctrl+P печатает его или сохраняет в PDF.",
  },
  making: { en: "Making the report…", ru: "Составляем отчёт…" },
  open: { en: "Open in a new tab", ru: "Открыть в новой вкладке" },
  save: { en: "Save HTML", ru: "Сохранить HTML" },
  print: { en: "Print or save as PDF", ru: "Печать или PDF" },
  refresh: { en: "Make it anew", ru: "Составить заново" },
  no_session: {
    en: "Nothing was read in this session yet. Connect to the car, or choose a recording.",
    ru: "В этом сеансе ещё ничего не прочитано. Подключитесь к машине или выберите запись.",
  },
  idle_hint: {
    en: "For a verdict on the values: engine warm, idling for a minute, faults read.",
    ru: "Чтобы была оценка значений: двигатель прогрет, минута на холостом ходу, коды прочитаны.",
  },
});
