import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  title: { en: "Car details", ru: "Машина" },
  whose: { en: "Whose car is this?", ru: "Чья это машина?" },
  asked: {
    en: "Asked once for this control unit. The details stand in its recordings, in their list and on reports; change them there later.",
    ru: "Спрашиваем один раз для этого блока. Данные будут в записях, в их списке и в отчётах; там же их можно изменить позже.",
  },
  of_unit: { en: "Kept for this control unit and offered for its next recordings.", ru: "Запоминаются для этого блока и подставляются в следующие записи." },
  of_recording: { en: "Of the recording {name}.", ru: "Запись {name}." },
  car: { en: "Car", ru: "Машина" },
  car_example: { en: "Volga 3110, 2004", ru: "Волга 3110, 2004" },
  plate: { en: "Number plate", ru: "Госномер" },
  mileage: { en: "Mileage now, km", ru: "Пробег сейчас, км" },
  last: { en: "last: {km}", ru: "в прошлый раз: {km}" },
  mileage_bad: { en: "A whole number of kilometres", ru: "Целое число километров" },
  workshop: { en: "Workshop", ru: "Мастерская" },
  workshop_all: { en: "Workshop (common to all cars)", ru: "Мастерская (общая для всех машин)" },
  privacy: {
    en: "Kept on this computer only, in the recording and on its report. Who gets the file can read them.",
    ru: "Хранятся только на этом компьютере, в записи и в отчёте по ней. Кому отправлен файл, тот их прочитает.",
  },
  km: { en: "{km} km", ru: "{km} км" },
  later: { en: "Later", ru: "Позже" },
  cancel: { en: "Cancel", ru: "Отмена" },
  save: { en: "Save", ru: "Сохранить" },
  none: { en: "No car details yet", ru: "Машина не указана" },
  edit: { en: "Car details…", ru: "Машина…" },
  edit_of: { en: "Car details of {name}", ru: "Машина в записи {name}" },
});
