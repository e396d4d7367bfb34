// The texts of the Causes screen.
import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  of_live: { en: "live car", ru: "подключённая машина" },
  of_recording: { en: "recording {name}", ru: "запись {name}" },
  of_several: { en: { one: "{name} and {n} more", other: "{name} and {n} more" }, ru: { one: "{name} и ещё {n} запись", few: "{name} и ещё {n} записи", many: "{name} и ещё {n} записей" } },
  session: { en: "live car, last 2 hours", ru: "машина, последние 2 часа" },
  complaint: { en: "What is wrong with the car?", ru: "На что жалуются?" },
  refresh: { en: "Rank again", ru: "Обновить" },
  ranking: { en: "Reading the values…", ru: "Читаем данные…" },
  without: { en: "Causes are looked for in the values of a car, or of a recording.", ru: "Причины ищутся по данным машины или по записи." },
  seen: { en: "From {time} of data", ru: "По данным за {time}" },
  speaks_for: { en: "Speaks for it", ru: "За" },
  speaks_against: { en: "Speaks against it", ru: "Против" },
  nothing_for: { en: "Nothing that was seen speaks for it by itself.", ru: "Само по себе ничто из увиденного за неё не говорит." },
  show: { en: "Show in the chart: {text}", ru: "Показать на графике: {text}" },
  moments: { en: { one: "{n} moment", other: "{n} moments" }, ru: { one: "{n} момент", few: "{n} момента", many: "{n} моментов" } },
  check: { en: "Check", ru: "Проверить" },
  next: { en: "Measure next", ru: "Что измерить дальше" },
  start: { en: "Start the test", ru: "Начать проверку" },
  start_needs: { en: "The test needs the connected car.", ru: "Для проверки нужна подключённая машина." },
  not_seen: { en: "Not seen", ru: "Не видно" },
  doubts: { en: "How sure this is", ru: "Насколько это надёжно" },
  wrong_file: { en: "A cause of your own could not be loaded", ru: "Своя причина не загружена" },
});
