import { dictionary } from "../../../../lib/i18n";

export const t = dictionary({
  menu: { en: "Range of a reference", ru: "Диапазон образца" },
  bar: { en: "Reference", ru: "Образец" },
  lead: { en: "Stripes: from the lowest to the highest value of", ru: "Полосы: от наименьшего до наибольшего значения образца" },
  stripes: { en: "stripes: range of {title}", ru: "полосы: диапазон образца {title}" },
  virtual: { en: "Virtual car, warm idle", ru: "Виртуальный автомобиль, холостой ход" },
  computed: { en: "computed, not measured on an engine", ru: "рассчитано, не измерено на двигателе" },
  making: { en: "being read, some seconds", ru: "читается, несколько секунд" },
  off: { en: "Remove the stripes", ru: "Убрать полосы" },
});
