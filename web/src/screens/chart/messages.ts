import { dictionary } from "../../lib/i18n";

export const t = dictionary({ views: { en: "Views of the data", ru: "Представления данных" }, time: { en: "Time", ru: "Время" }, scatter: { en: "Scatter", ru: "Облако" }, table: { en: "Table", ru: "Таблица" } });
