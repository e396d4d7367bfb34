import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  reading: { en: "Reading the stored faults…", ru: "Читаем ошибки…" },
  again: { en: "Read again", ru: "Прочитать снова" },
  erase: { en: "Erase…", ru: "Сбросить ошибки…" },
  copy: { en: "Copy as text", ru: "Скопировать текстом" },
  copied: { en: "Copied. Paste it into a message.", ru: "Скопировано. Вставьте в сообщение." },
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
    en: "The unit clears its faults after about two hours and when the battery is disconnected. An intermittent fault may leave no trace: read again right after it happens.",
    ru: "Блок стирает ошибки примерно через два часа и при отключении аккумулятора. Плавающая неисправность может не оставить следа: читайте сразу после её появления.",
  },
  unknown: { en: "The meaning of this number is unknown", ru: "Расшифровка этого номера неизвестна" },
  informational: { en: "A message, not a fault", ru: "Сообщение, а не ошибка" },
  unknown_more: {
    en: "No public source explains it. Tables of other makers number differently, so they are not used here.",
    ru: "Открытых источников нет. У других изготовителей нумерация иная, поэтому их таблицы не используются.",
  },
  sure_confirmed: { en: "Meaning confirmed by two sources", ru: "Расшифровка подтверждена двумя источниками" },
  sure_reported: {
    en: "Meaning from one source; check before buying parts",
    ru: "Расшифровка из одного источника; проверьте, прежде чем покупать детали",
  },
  sure_unconfirmed: {
    en: "Meaning unconfirmed: printed in service literature, original source not found",
    ru: "Расшифровка не подтверждена: есть в литературе по ремонту, первоисточник не найден",
  },
  sure_unknown: { en: "Meaning unknown", ru: "Расшифровка неизвестна" },
  since: { en: "First seen in this session at {time}", ru: "В этом сеансе впервые: {time}" },
  check: { en: "Check first", ru: "Проверить сначала" },
  related: { en: "Now", ru: "Сейчас" },
  substitute: {
    en: "The sensor's circuit is faulty, so the unit may use a substitute value: {names}.",
    ru: "Неисправна цепь датчика, поэтому блок может подставлять расчётное значение: {names}.",
  },
  frame: { en: "Freeze frame: {time}", ru: "Стоп-кадр: {time}" },
  frame_sharp: {
    en: "The unit stored the fault at {to}; the moment is known to {s} s.",
    ru: "Блок запомнил ошибку в {to}; момент известен с точностью до {s} с.",
  },
  frame_between: {
    en: "The unit does not say when. At {from} the fault was not stored, at {to} it was: the moment is uncertain by {s} s. The values are those of the later time; below them, the range in between.",
    ru: "Точное время блок не сообщает. В {from} ошибки не было, в {to} она уже была: момент известен с точностью до {s} с. Значения — на более позднее время, под ними — пределы за этот промежуток.",
  },
  frame_value: { en: "Value", ru: "Параметр" },
  frame_then: { en: "Then", ru: "Тогда" },
  frame_around: { en: "Five seconds before and after", ru: "Пять секунд до и после" },
  frame_band: { en: "The fault was stored within the shaded band.", ru: "Ошибка записана в пределах закрашенной полосы." },
  frame_all: { en: "All values", ru: "Все параметры" },
  frame_fewer: { en: "Fewer values", ru: "Меньше параметров" },
  frame_delete: { en: "Delete freeze frame", ru: "Удалить стоп-кадр" },
  frame_delete_ask: { en: "Delete this freeze frame?", ru: "Удалить этот стоп-кадр?" },
  frame_delete_lost: {
    en: "Unless a recording was running, the values of that moment are kept nowhere else.",
    ru: "Если в тот момент не шла запись, эти значения больше нигде не хранятся.",
  },
  frame_delete_yes: { en: "Delete", ru: "Удалить" },
  frame_none: {
    en: "No freeze frame: the fault was stored before the first reading here, or while nothing was sampled.",
    ru: "Стоп-кадра нет: ошибка записана до первого чтения здесь или когда опрос не шёл.",
  },
  frame_before: {
    en: "No freeze frame: the fault was stored before the recording's first reading of the faults.",
    ru: "Стоп-кадра нет: ошибка была в памяти ещё до первого чтения ошибок в записи.",
  },
  frame_unknown: {
    en: "No freeze frame: the moment is not known to a minute, or its values are not known.",
    ru: "Стоп-кадра нет: момент не известен с точностью до минуты, или неизвестны значения.",
  },
  frame_chart: { en: "Show in chart", ru: "Показать на графике" },
  frame_moment: { en: "Fault {code} stored", ru: "Записана ошибка {code}" },
  frames_earlier: { en: "Earlier freeze frames", ru: "Прежние стоп-кадры" },
  needs_line: { en: "The faults are read from the ECU itself.", ru: "Ошибки читаются из самого блока." },
  watch: { en: "Add to live values", ru: "Добавить в опрос" },
  not_sampled: { en: "not sampled", ru: "не опрашивается" },
  message_title: { en: "Stored faults", ru: "Ошибки в памяти блока" },
  message_none: { en: "No faults are stored.", ru: "Ошибок в памяти нет." },
  message_read: { en: "Read {time} with mikas", ru: "Прочитано {time}, mikas" },

  erase_title: { en: "Erase the stored faults?", ru: "Сбросить ошибки?" },
  erase_lost: { en: "This will be erased from the unit", ru: "Будет стёрто из памяти блока" },
  erase_kept: {
    en: "The list stays in the journal here. A fault whose cause remains comes back: some at once, some only on the next drive.",
    ru: "Список останется в журнале. Если причина не устранена, ошибка появится снова: сразу или в следующей поездке.",
  },
  erase_still: {
    en: "Only while the car stands still.",
    ru: "Только на стоящей машине.",
  },
  erase_again: {
    en: "The list has changed meanwhile, so nothing was erased. This is what is stored now.",
    ru: "Список изменился, поэтому ничего не стёрто. Вот что в памяти сейчас.",
  },
  erase_yes: { en: "Erase", ru: "Сбросить" },
  erasing: { en: "Erasing and reading back…", ru: "Сбрасываем и перечитываем…" },
  erased: { en: "Erased. No faults are stored.", ru: "Сброшены. Ошибок в памяти нет." },
  came_back: {
    en: "These faults came back at once, so their cause remains: {codes}",
    ru: "Эти ошибки сразу появились снова, значит, причина не устранена: {codes}",
  },

  recorded_title: { en: "From the recording {file}, not from the connected car", ru: "Из записи {file}, а не с подключённой машины" },
  recorded_live: { en: "Back to live", ru: "К текущим данным" },
  recorded_report: { en: "Report on the recording", ru: "Отчёт по записи" },
  recorded_unread: { en: "This recording holds no faults", ru: "В этой записи нет ошибок" },
  recorded_unread_more: {
    en: "The faults were not read during the recording, so nothing is known about them.",
    ru: "Во время записи ошибки не читали, поэтому сведений о них нет.",
  },
  recorded_none: { en: "Faults were read: none were stored", ru: "Ошибки прочитаны: в памяти их не было" },
  recorded_count: {
    en: { one: "{n} fault stored, as last read in the recording", other: "{n} faults stored, as last read in the recording" },
    ru: { one: "{n} ошибка в памяти при последнем чтении в записи", few: "{n} ошибки в памяти при последнем чтении в записи", many: "{n} ошибок в памяти при последнем чтении в записи" },
  },
  recorded_since: { en: "First read in the recording at {time}", ru: "В записи впервые прочитана: {time}" },
  not_now: { en: "As last read at {time}, not current", ru: "Прочитано {time}, не текущие данные" },
  not_now_more: {
    en: "There is no connection to the ECU. The faults are read again when it answers.",
    ru: "Связи с блоком нет. Когда он ответит, ошибки прочитаются снова.",
  },

  journal: { en: "Journal of changes", ru: "Журнал изменений" },
  journal_none: { en: "Nothing has been changed yet.", ru: "Изменений ещё не было." },
  journal_erased: { en: "Faults erased", ru: "Ошибки сброшены" },
  journal_codes: { en: "were stored: {codes}", ru: "были в памяти: {codes}" },
  journal_before: { en: "before", ru: "было" },
  journal_after: { en: "after", ru: "стало" },
  state_done: { en: "done", ru: "сделано" },
  state_failed: { en: "failed", ru: "не удалось" },
  state_started: { en: "result unknown", ru: "результат неизвестен" },
  state_interrupted: { en: "interrupted", ru: "прервано" },
});

const SURE = ["confirmed", "reported", "unconfirmed", "unknown"] as const;

/** The confidence of a fault's text, as a sentence. */
export function sure(confidence: string): string {
  const known = SURE.find((it) => it === confidence);
  return t(`sure_${known ?? "unknown"}`);
}
