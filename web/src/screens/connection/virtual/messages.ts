// Texts of the virtual cars.
import { dictionary } from "../../../lib/i18n";

export const t = dictionary({
  choose: { en: "Choose a car and its defect", ru: "Выбрать машину и неисправность" },
  kind: { en: "Car", ru: "Машина" },
  sound: { en: "Sound", ru: "Исправная" },
  defect: { en: "With a defect", ru: "С неисправностью" },
  blind: { en: "Find out what is wrong", ru: "Найти, что с ней" },
  carburettor: { en: "Carburettor", ru: "Карбюраторная" },
  carburettor_more: { en: "A Mikas 5.4 that controls the ignition alone: no injectors, air meter or idle valve.", ru: "Микас 5.4, который управляет только зажиганием: форсунок, ДМРВ и РДВ (РХХ) нет." },
  sound_more: { en: "Worn as cars are, within what is normal.", ru: "С обычным износом, в пределах нормы." },
  blind_more: { en: "The number decides what is wrong, or whether anything is. Write it down: the same number is the same car.", ru: "Номер решает, что с ней и есть ли что-нибудь. Запомните его: тот же номер — та же машина." },
  which: { en: "Defect", ru: "Неисправность" },
  amount: { en: "Amount", ru: "Величина" },
  number: { en: "Number", ru: "Номер" },
  another: { en: "Another", ru: "Другой" },
  wrong: { en: "A whole number from 0 to 999,999,999", ru: "Целое число от 0 до 999 999 999" },
  drive: { en: "Drive", ru: "Поездка" },
  start: { en: "Start this car", ru: "Запустить эту машину" },
  find: { en: "Car {car}: find out what is wrong with it.", ru: "Машина {car}: найдите, что с ней." },
  show: { en: "Show the answer", ru: "Показать ответ" },
  nothing: { en: "Nothing: this car is sound.", ru: "Ничего: машина исправна." },
});
