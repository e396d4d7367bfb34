import { dictionary } from "../../lib/i18n";

export const t = dictionary({ source: { en: "Source", ru: "По данным" }, together: { en: "With other recordings of this car: {n}", ru: "Вместе с другими записями этой машины: {n}" }, most: { en: "At most {n} at once.", ru: "Не больше {n} сразу." } });
