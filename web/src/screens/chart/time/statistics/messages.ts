import { dictionary } from "../../../../lib/i18n";

export const t = dictionary({
  menu: { en: "Statistics…", ru: "Статистика…" },
  title: { en: "Statistics", ru: "Статистика" },
  between: { en: "Between the cursors: {seconds} s", ru: "Между курсорами: {seconds} с" },
  whole: { en: "All data: {seconds} s. Set a second cursor for a part of it.", ru: "Все данные: {seconds} с. Для части поставьте второй курсор." },
  weighted: {
    en: "Weighted by time: a value counts until the next one; gaps count for nothing.",
    ru: "Взвешено по времени: значение действует до следующего; пропуски не учитываются.",
  },
  coarse: {
    en: "Only an overview is loaded: lowest and highest are exact, the rest is approximate.",
    ru: "Загружен только обзор: наименьшее и наибольшее точны, остальное приблизительно.",
  },
  coarseLive: {
    en: "From before this page was opened only an overview is loaded: lowest and highest are exact, the rest is approximate.",
    ru: "До открытия этой страницы загружен только обзор: наименьшее и наибольшее точны, остальное приблизительно.",
  },
  none: { en: "no values", ru: "нет значений" },
  min: { en: "Lowest", ru: "Наименьшее" },
  max: { en: "Highest", ru: "Наибольшее" },
  mean: { en: "Mean", ru: "Среднее" },
  deviation: { en: "σ", ru: "σ" },
  p5: { en: "5 %", ru: "5 %" },
  p50: { en: "Median", ru: "Медиана" },
  p95: { en: "95 %", ru: "95 %" },
  count: { en: "Values", ru: "Значений" },
  covered: { en: "Covered", ru: "Охвачено" },
  seconds: { en: "{n} s", ru: "{n} с" },
  above: { en: "Above {limit}", ru: "Выше {limit}" },
  below: { en: "Below {limit}", ru: "Ниже {limit}" },
  limit: { en: "Own limit", ru: "Свой предел" },
  limit_of: { en: "Own limit for {name}", ru: "Свой предел: {name}" },
  channel: { en: "Channel", ru: "Параметр" },
  unit: { en: "Unit", ru: "Единица" },
  copy: { en: "Copy as a table", ru: "Скопировать таблицей" },
  copied: { en: "Copied. Paste it into a spreadsheet.", ru: "Скопировано. Вставьте в таблицу." },
});
