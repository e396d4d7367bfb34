import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  compare: { en: "Compare with…", ru: "Сравнить с…" },
  compare_of: { en: "Compare {name} with…", ru: "Сравнить {name} с…" },
  compare_to: { en: "Compare {first} with {name}", ru: "Сравнить {first} с {name}" },
  verb: { en: "Compare", ru: "Сравнить" },
  title: { en: "Compare {name} with", ru: "Сравнить {name} с записью" },
  lead: {
    en: "Both are drawn in the chart on a common clock: seconds from the start of each.",
    ru: "Обе записи рисуются на одном графике: секунды от начала каждой.",
  },
  search: { en: "Search: car, note, fault", ru: "Поиск: машина, заметка, ошибка" },
  nothing: {
    en: "There is no other recording yet. Record another drive, or copy another car’s file into the folder of recordings.",
    ru: "Другой записи пока нет. Запишите ещё одну поездку или скопируйте файл другой машины в папку записей.",
  },
  none_found: { en: "Nothing matches “{text}”.", ru: "По запросу «{text}» ничего нет." },
  unreadable: { en: "no values", ru: "нет значений" },
  unknown_car: { en: "unknown unit", ru: "блок неизвестен" },

  bar: { en: "Comparison", ru: "Сравнение" },
  solid: { en: "solid:", ru: "сплошная:" },
  dashed: { en: "dashed:", ru: "пунктир:" },
  offset: { en: "Offset of the second recording, seconds", ru: "Сдвиг второй записи, секунд" },
  moved: { en: "moved by {seconds} s", ru: "сдвиг {seconds} с" },
  earlier: { en: "Second one {seconds} s to the left", ru: "Вторую на {seconds} с влево" },
  later: { en: "Second one {seconds} s to the right", ru: "Вторую на {seconds} с вправо" },
  zero: { en: "Both from their start", ru: "Обе от начала" },
  align: { en: "Align…", ru: "Совместить…" },
  align_long: {
    en: "Align by a moment: first on the dashed line, then on the solid one",
    ru: "Совместить по моменту: сначала на пунктире, потом на сплошной",
  },
  align_stop: { en: "Cancel aligning", ru: "Не совмещать" },
  end: { en: "End the comparison", ru: "Закончить сравнение" },
  in_chart: { en: "The comparison is in the chart", ru: "Сравнение на графике" },
  loaded: { en: "{n} % loaded", ru: "загружено {n} %" },
});
