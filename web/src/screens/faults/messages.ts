import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  title: { en: "Faults", ru: "Ошибки" },
  reading: { en: "Reading the stored faults…", ru: "Читаем запомненные ошибки…" },
  again: { en: "Read again", ru: "Прочитать снова" },
  erase: { en: "Erase…", ru: "Стереть…" },
  copy: { en: "Copy as text", ru: "Скопировать текстом" },
  copied: {
    en: "Copied. Paste it into a message.",
    ru: "Скопировано. Вставьте в сообщение.",
  },
  read_at: { en: "Read at {time}", ru: "Прочитано в {time}" },
  count: {
    en: { one: "{n} fault stored", other: "{n} faults stored" },
    ru: {
      one: "{n} ошибка в памяти",
      few: "{n} ошибки в памяти",
      many: "{n} ошибок в памяти",
    },
  },
  none: { en: "No faults are stored", ru: "Ошибок в памяти нет" },
  none_more: {
    en: "The unit forgets codes after about two hours, and when the battery is disconnected. A fault that comes and goes may leave nothing: read again right after it happened.",
    ru: "Блок забывает коды примерно через два часа и при отключении аккумулятора. Плавающая неисправность может не оставить следа: читайте сразу, как она проявилась.",
  },
  unknown: {
    en: "What this number means is not known",
    ru: "Что означает этот номер, неизвестно",
  },
  informational: { en: "A message, not a fault", ru: "Сообщение, а не неисправность" },
  unknown_more: {
    en: "No public source explains it. Other makers' tables number differently, so nothing was borrowed from them.",
    ru: "Открытых объяснений нет. У других изготовителей нумерация иная, поэтому чужие таблицы не подставляем.",
  },
  sure_confirmed: {
    en: "Meaning confirmed by two sources",
    ru: "Значение подтверждено двумя источниками",
  },
  sure_reported: {
    en: "Meaning from one source; check before buying parts",
    ru: "Значение из одного источника; проверьте, прежде чем покупать детали",
  },
  sure_unconfirmed: {
    en: "Meaning unconfirmed: printed in service literature, no source seen",
    ru: "Значение не подтверждено: встречается в литературе, источника нет",
  },
  sure_unknown: { en: "Meaning unknown", ru: "Значение неизвестно" },
  since: { en: "Seen since {time} in this session", ru: "В этом сеансе замечена в {time}" },
  check: { en: "Check first", ru: "Проверить сначала" },
  related: { en: "Now", ru: "Сейчас" },
  needs_line: {
    en: "The faults are read from the unit itself.",
    ru: "Ошибки читаются из самого блока.",
  },
  watch: { en: "Read these too", ru: "Читать и эти" },
  fresh_none: { en: "not being read", ru: "не читается" },
  message_title: { en: "Stored faults", ru: "Запомненные ошибки" },
  message_none: { en: "No faults are stored.", ru: "Ошибок в памяти нет." },
  message_read: { en: "Read {time} with mikas", ru: "Прочитано {time}, mikas" },

  erase_title: { en: "Erase the stored faults?", ru: "Стереть запомненные ошибки?" },
  erase_lost: { en: "This will be lost in the unit", ru: "Из памяти блока пропадёт" },
  erase_kept: {
    en: "The list stays in the journal here. A fault whose cause is still there comes back, some at once, some only on the next drive.",
    ru: "Список останется здесь в журнале. Если причина не устранена, неисправность появится снова: сразу или в следующей поездке.",
  },
  erase_still: {
    en: "Only with the car limitState still.",
    ru: "Только на стоящей машине.",
  },
  erase_again: {
    en: "The list has changed meanwhile, so nothing was erased. This is what is stored now.",
    ru: "Список тем временем изменился, поэтому ничего не стёрто. Вот что в памяти сейчас.",
  },
  erase_yes: { en: "Erase", ru: "Стереть" },
  erasing: { en: "Erasing and reading back…", ru: "Стираем и перечитываем…" },
  erased: { en: "Erased. No faults are stored.", ru: "Стёрто. Ошибок в памяти нет." },
  came_back: {
    en: "These came back at once, so their cause is still there: {codes}",
    ru: "Эти появились сразу же, значит, причина не устранена: {codes}",
  },

  recorded_title: { en: "Of the recording {file}, not of the car now", ru: "Из записи {file}, не с машины сейчас" },
  recorded_live: { en: "Back to live", ru: "К живым данным" },
  recorded_report: { en: "Report on it", ru: "Отчёт по ней" },
  recorded_unread: { en: "This recording holds no faults", ru: "В этой записи нет ошибок" },
  recorded_unread_more: {
    en: "The faults were not read while it was made, so nothing is known of them.",
    ru: "Пока она шла, ошибки не читали, поэтому о них ничего не известно.",
  },
  recorded_none: { en: "Read in it: no faults were stored", ru: "Прочитано в ней: ошибок в памяти не было" },
  recorded_count: {
    en: { one: "{n} fault stored, as last read in it", other: "{n} faults stored, as last read in it" },
    ru: {
      one: "{n} ошибка в памяти, как прочитано в ней последний раз",
      few: "{n} ошибки в памяти, как прочитано в ней последний раз",
      many: "{n} ошибок в памяти, как прочитано в ней последний раз",
    },
  },
  recorded_more: {
    en: "What they mean and what to check stands in its report.",
    ru: "Что они значат и что проверить, сказано в отчёте.",
  },
  not_now: { en: "As last read, {time}: not of now", ru: "Как прочитано в {time}, не сейчас" },
  not_now_more: {
    en: "There is no connection to the unit. When it answers, the faults are read again.",
    ru: "Связи с блоком нет. Когда он ответит, ошибки прочитаются снова.",
  },

  journal: { en: "Journal of changes", ru: "Журнал изменений" },
  journal_none: { en: "Nothing has been changed yet.", ru: "Изменений ещё не было." },
  journal_erased: { en: "Faults erased", ru: "Стёрты ошибки" },
  journal_codes: { en: "were stored: {codes}", ru: "были в памяти: {codes}" },
  journal_before: { en: "before", ru: "было" },
  journal_after: { en: "after", ru: "стало" },
  state_done: { en: "done", ru: "сделано" },
  state_failed: { en: "failed", ru: "не удалось" },
  state_started: { en: "outcome not seen", ru: "исход неизвестен" },
  state_interrupted: { en: "interrupted", ru: "прервано" },
});

const SURE = ["confirmed", "reported", "unconfirmed", "unknown"] as const;

/** The confidence of a fault's text, as a sentence. */
export function sure(confidence: string): string {
  const known = SURE.find((it) => it === confidence);
  return t(`sure_${known ?? "unknown"}`);
}
