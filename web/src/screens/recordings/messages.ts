import { dictionary } from "../../lib/i18n";
import type { Recording } from "../../lib/api/types";

export const t = dictionary({
  title: { en: "Recordings", ru: "Записи" },
  loading: { en: "Looking through the recordings…", ru: "Просматриваем записи…" },
  refresh: { en: "Refresh", ru: "Обновить" },
  search: { en: "Search: car, note, fault", ru: "Поиск: машина, заметка, код" },
  count: {
    en: { one: "{n} recording", other: "{n} recordings" },
    ru: { one: "{n} запись", few: "{n} записи", many: "{n} записей" },
  },
  folder: { en: "kept in {folder}", ru: "лежат в {folder}" },
  none: { en: "No recordings yet", ru: "Записей пока нет" },
  none_more: {
    en: "Press R or the round button at the top while the ECU answers. Everything on the wire is kept, so formulas corrected later correct old recordings too.",
    ru: "Нажмите R или круглую кнопку вверху, когда блок отвечает. Сохраняется всё, что прошло по линии, поэтому исправленные формулы исправят и старые записи.",
  },
  none_watching: {
    en: "Recordings are made at the computer with the cable; they appear here then.",
    ru: "Записи делают за компьютером с кабелем; здесь они тогда появятся.",
  },
  none_found: { en: "Nothing matches “{text}”.", ru: "По запросу «{text}» ничего нет." },

  car: { en: "Car", ru: "Машина" },
  date: { en: "Date", ru: "Дата" },
  length: { en: "Length", ru: "Длина" },
  rate: { en: "Sets/s", ru: "Наб/с" },
  gaps: { en: "Gaps", ru: "Разрывы" },
  faults: { en: "Faults", ru: "Коды" },
  note: { en: "Note", ru: "Заметка" },
  actions: { en: "Actions", ru: "Действия" },
  unknown_car: { en: "unknown unit", ru: "блок неизвестен" },
  not_read: { en: "not read", ru: "не читались" },
  no_faults: { en: "none", ru: "нет" },
  now: { en: "being recorded", ru: "идёт запись" },
  note_empty: { en: "Add a note", ru: "Добавить заметку" },
  note_of: { en: "Note of {name}", ru: "Заметка к {name}" },
  note_save: { en: "Save the note", ru: "Сохранить заметку" },
  note_saved: { en: "Note saved.", ru: "Заметка сохранена." },
  open: { en: "Open", ru: "Открыть" },
  export: { en: "Export", ru: "Экспорт" },
  report: { en: "Report", ru: "Отчёт" },
  delete: { en: "Delete", ru: "Удалить" },
  export_of: { en: "Export {name}", ru: "Экспорт {name}" },
  report_of: { en: "Report on {name}", ru: "Отчёт по {name}" },
  delete_of: { en: "Delete {name}", ru: "Удалить {name}" },

  export_title: { en: "Export {name}", ru: "Экспорт: {name}" },
  export_some: { en: "Channels, all if none is chosen", ru: "Каналы; если не выбрано, все" },
  csv: {
    en: "for spreadsheets and simple tools; one row a sample, header with units",
    ru: "для таблиц и простых программ: строка на замер, единицы в заголовке",
  },
  excel: {
    en: "the same for Excel by double click where it writes decimal commas",
    ru: "то же для русского Excel: открывается двойным щелчком, с десятичной запятой",
  },
  mf4: {
    en: "for asammdf, CANape, MATLAB; keeps units, texts and exact times",
    ru: "для asammdf, CANape, MATLAB; сохраняет единицы, тексты и точное время",
  },
  parquet: {
    en: "for Python, duckdb, R; small and fast, even for hours",
    ru: "для Python, duckdb, R; компактно и быстро даже для многих часов",
  },
  msl: {
    en: "for MegaLogViewer and TunerStudio, as text",
    ru: "для MegaLogViewer и TunerStudio, текстом",
  },
  mlg: {
    en: "for MegaLogViewer, binary: smaller, opens faster",
    ru: "для MegaLogViewer, двоичный: меньше и открывается быстрее",
  },
  pcapng: {
    en: "the recording itself, every byte on the wire: to keep, to send to a developer, for Wireshark",
    ru: "сама запись, каждый байт на линии: хранить, послать разработчику, для Wireshark",
  },
  close: { en: "Close", ru: "Закрыть" },

  delete_title: { en: "Delete this recording?", ru: "Удалить эту запись?" },
  delete_lost: { en: "This will be lost for good", ru: "Пропадёт навсегда" },
  delete_yes: { en: "Delete", ru: "Удалить" },
  deleted: { en: "Deleted {name}.", ru: "Удалено: {name}." },

  player: { en: "Player", ru: "Проигрыватель" },
  play: { en: "Play", ru: "Играть" },
  pause: { en: "Pause", ru: "Пауза" },
  step_back: { en: "A sample back", ru: "На замер назад" },
  step: { en: "A sample forward", ru: "На замер вперёд" },
  speed: { en: "Speed", ru: "Скорость" },
  place: { en: "Place in the recording", ru: "Место в записи" },
  loop_from: { en: "Loop from here", ru: "Повтор отсюда" },
  loop_to: { en: "Loop to here", ru: "Повтор досюда" },
  loop_cursors: { en: "Loop between the cursors", ru: "Повтор между курсорами" },
  loaded: { en: "read {n} %", ru: "прочитано {n} %" },
  coarse: {
    en: "very long: shown coarsely, peaks stay",
    ru: "очень длинная: показана грубо, пики сохранены",
  },
  loop_off: { en: "End the loop", ru: "Убрать повтор" },
  loop_told: { en: "repeats {from} to {to}", ru: "повторяется {from} – {to}" },
  loop_begun: {
    en: "loop from {from}: go on to its end and mark it",
    ru: "повтор с {from}: дойдите до конца и отметьте",
  },
  close_player: { en: "Back to now", ru: "Вернуться к текущему" },
  place_text: { en: "{at} of {length}", ru: "{at} из {length}" },
  key_faster: { en: "Faster", ru: "Быстрее" },
  key_slower: { en: "Slower", ru: "Медленнее" },
  key_loop: { en: "Loop: from, to, off", ru: "Повтор: отсюда, досюда, убрать" },
});

/** The faults read during a recording, as one line. */
export function faultsOf(recording: Recording): string {
  if (recording.faults === null) return t("not_read");
  return recording.faults.join(", ") || t("no_faults");
}
