// The titles of the screens, in the navigation and on the screens themselves.
import { dictionary } from "../i18n";
import type { ScreenName } from "./router.svelte";

export const screenTitle = dictionary<ScreenName>({
  live: { en: "Live", ru: "Приборы" },
  chart: { en: "Chart", ru: "График" },
  faults: { en: "Faults", ru: "Ошибки" },
  tests: { en: "Tests", ru: "Проверки" },
  causes: { en: "Causes", ru: "Причины" },
  passport: { en: "Passport", ru: "Паспорт" },
  memory: { en: "Memory", ru: "Память" },
  recordings: { en: "Recordings", ru: "Записи" },
  report: { en: "Report", ru: "Отчёт" },
  connection: { en: "Connection", ru: "Связь" },
});
