import { dictionary } from "../../lib/i18n";
import type { Recording } from "../../lib/api/types";

export const t = dictionary({
  loading: { en: "Loading the recordings…", ru: "Загружаем записи…" },
  refresh: { en: "Refresh", ru: "Обновить" },
  add: { en: "Add…", ru: "Добавить…" },
  added: {
    en: { one: "{n} recording added.", other: "{n} recordings added." },
    ru: { one: "Добавлена {n} запись.", few: "Добавлены {n} записи.", many: "Добавлено {n} записей." },
  },
  search: { en: "Search: car, plate, note, fault", ru: "Машина, номер, заметка, ошибка" },
  count: {
    en: { one: "{n} recording", other: "{n} recordings" },
    ru: { one: "{n} запись", few: "{n} записи", many: "{n} записей" },
  },
  folder: { en: "in {folder}", ru: "в папке {folder}" },
  none: { en: "No recordings yet", ru: "Записей пока нет" },
  none_more: {
    en: "Press R or the Record button at the top while the ECU answers. Every byte on the line is stored, so corrected formulas also correct old recordings. Recordings from elsewhere: press “Add…”.",
    ru: "Нажмите R или кнопку «Запись» вверху, когда блок отвечает. Сохраняется каждый байт линии, поэтому исправленные формулы исправят и старые записи. Чужие записи: нажмите «Добавить…».",
  },
  none_watching: {
    en: "Recordings are made at the computer with the cable and then appear here.",
    ru: "Записи делают на компьютере с кабелем, затем они появляются здесь.",
  },
  none_found: { en: "Nothing matches “{text}”.", ru: "По запросу «{text}» ничего нет." },

  car: { en: "Car", ru: "Машина" },
  date: { en: "Date", ru: "Дата" },
  length: { en: "Length", ru: "Длина" },
  rate: { en: "Readings/s", ru: "Опр/с" },
  gaps: { en: "Gaps", ru: "Пропуски" },
  faults: { en: "Faults", ru: "Ошибки" },
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
  export_some: { en: "Channels (all if none is selected)", ru: "Величины (если не выбраны — все)" },
  csv: {
    en: "for spreadsheets and simple tools; one row a sample, header with units",
    ru: "для таблиц и простых программ: строка на замер, единицы в заголовке",
  },
  excel: {
    en: "for Excel: opens by double click, with decimal commas",
    ru: "для русского Excel: открывается двойным щелчком, с десятичной запятой",
  },
  mf4: {
    en: "for asammdf, CANape, MATLAB; with units, texts and exact times",
    ru: "для asammdf, CANape, MATLAB; с единицами, текстами и точным временем",
  },
  parquet: {
    en: "for Python, duckdb, R; small and fast, even for hours",
    ru: "для Python, duckdb, R; компактно и быстро даже для многих часов",
  },
  msl: { en: "for MegaLogViewer and TunerStudio, as text", ru: "для MegaLogViewer и TunerStudio, текстовый" },
  mlg: {
    en: "for MegaLogViewer, binary: smaller, opens faster",
    ru: "для MegaLogViewer, двоичный: меньше и открывается быстрее",
  },
  pcapng: {
    en: "the recording itself, every byte on the line: to keep, to send to a developer, for Wireshark",
    ru: "сама запись, каждый байт линии: для хранения, для разработчика, для Wireshark",
  },
  close: { en: "Close", ru: "Закрыть" },

  delete_title: { en: "Delete this recording?", ru: "Удалить эту запись?" },
  deleted: { en: "Deleted {name}.", ru: "Удалено: {name}." },

  player: { en: "Player", ru: "Проигрыватель" },
  play: { en: "Play", ru: "Воспроизвести" },
  pause: { en: "Pause", ru: "Пауза" },
  step_back: { en: "One sample back", ru: "На замер назад" },
  step: { en: "One sample forward", ru: "На замер вперёд" },
  speed: { en: "Speed", ru: "Скорость" },
  place: { en: "Position in the recording", ru: "Место в записи" },
  loop_from: { en: "Loop from here", ru: "Повтор отсюда" },
  loop_to: { en: "Loop to here", ru: "Повтор досюда" },
  loop_cursors: { en: "Loop between the cursors", ru: "Повтор между курсорами" },
  loaded: { en: "{n} % loaded", ru: "загружено {n} %" },
  coarse: { en: "very long: shown in reduced detail, peaks are exact", ru: "очень длинная: показана с прореживанием, пики точные" },
  loop_off: { en: "End the loop", ru: "Убрать повтор" },
  loop_range: { en: "loops from {from} to {to}", ru: "повтор {from} – {to}" },
  loop_started: { en: "loop from {from}: move to its end and mark it", ru: "повтор с {from}: перейдите к концу и отметьте его" },
  player_more: { en: "More player controls", ru: "Другие кнопки плеера" },
  close_player: { en: "Close the recording", ru: "Закрыть запись" },
  place_text: { en: "{at} of {length}", ru: "{at} из {length}" },
  key_faster: { en: "Faster", ru: "Быстрее" },
  key_slower: { en: "Slower", ru: "Медленнее" },
  key_loop: { en: "Loop: start, end, remove", ru: "Повтор: начало, конец, убрать" },
});

/** The faults read during a recording, as one line. */
export function faultsOf(recording: Recording): string {
  if (recording.faults === null) return t("not_read");
  return recording.faults.join(", ") || t("no_faults");
}
