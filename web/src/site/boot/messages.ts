// Texts of the start.
import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  language: { en: "Русский", ru: "English" },
  download: { en: "Loading the program: {loaded} of {total} MB", ru: "Загружается программа: {loaded} из {total} МБ" },
  once: { en: "Only the first visit loads it. Later it starts without a network, too.", ru: "Так долго только в первый раз. Потом она запускается и без сети." },
  start: { en: "Starting…", ru: "Запускаем…" },
  private: { en: "Nothing leaves this computer.", ru: "Ничего не уходит с этого компьютера." },

  "no-wasm": { en: "This browser can't run mikas", ru: "В этом браузере mikas не работает" },
  "no-wasm_do": {
    en: "It has no WebAssembly, or it was switched off (by “enhanced security”, for example). Open this page in Chrome, Edge, Firefox, Opera or Yandex Browser, version of August 2026 or newer.",
    ru: "В нём нет WebAssembly, или она выключена (например, режимом усиленной защиты). Откройте эту страницу в Chrome, Edge, Firefox, Opera или Яндекс Браузере, версии августа 2026 года или новее.",
  },
  "no-jspi": { en: "mikas does not work in this browser: it is too old", ru: "В этом браузере mikas не работает: он слишком старый" },
  "no-jspi_do": {
    en: "Neither the cable nor the virtual car works here: it has no JSPI, by which the program waits. Update it, or open this page in Chrome or Edge 137 or newer (June 2025), Firefox 153 or newer (July 2026), or an Opera or Yandex Browser of that age. For Windows 7 and 8 there is no such Chrome, Edge or Firefox. On an iPhone, iPad or Mac, Safari 27 (September 2026) should run the virtual car, without the cable.",
    ru: "Здесь не работает ни кабель, ни виртуальный автомобиль: в браузере нет JSPI, без которого программа не умеет ждать. Обновите его или откройте эту страницу в Chrome или Edge 137 или новее (июнь 2025 года), Firefox 153 или новее (июль 2026 года), Opera или Яндекс Браузере того же времени. Для Windows 7 и 8 таких Chrome, Edge и Firefox нет. На iPhone, iPad и Mac в Safari 27 (сентябрь 2026 года) должен работать виртуальный автомобиль, без кабеля.",
  },
  installed: { en: "Installed on a computer, mikas works with any browser.", ru: "Если установить mikas на компьютер, подойдёт любой браузер." },

  broken: { en: "mikas could not start", ru: "mikas не запустился" },
  broken_do: {
    en: "Reload the page. If it happens again: load the page anew, for what this browser has of it may be damaged. If that does not help, close other tabs and programs (mikas needs some hundreds of MB of memory) and update the browser. Recordings that were made are kept, unless you clear the browser's data of this page.",
    ru: "Обновите страницу. Если повторится: загрузите её заново с сервера — её файлы в этом браузере могли повредиться. Не поможет — закройте другие вкладки и программы (mikas нужно несколько сотен МБ памяти) и обновите браузер. Сделанные записи сохранены, если не очищать данные браузера для этой страницы.",
  },
  held: { en: "The recordings are in use in another tab or window", ru: "Записи заняты другой вкладкой или окном" },
  held_do: {
    en: "Only one can have them. Close the other tabs of this page, wait for a few seconds, and reload this one. If that does not help, close all windows of the browser and open it again.",
    ru: "Они могут быть открыты только в одной вкладке. Закройте другие вкладки этой страницы, подождите несколько секунд и обновите эту. Если не поможет, закройте все окна браузера и откройте его снова.",
  },
  hangs: { en: "The browser’s storage does not answer", ru: "Хранилище браузера не отвечает" },
  hangs_do: {
    en: "Close all windows of the browser and open this page again. If that does not help, restart the computer, and see whether its disk is full. Recordings that were made are kept.",
    ru: "Закройте все окна браузера и откройте эту страницу снова. Если не поможет, перезагрузите компьютер и проверьте, не заполнен ли диск. Сделанные записи сохранены.",
  },
  newer: { en: "The recordings here are of a newer mikas than this page", ru: "Записи здесь сделаны более новой версией mikas, чем эта страница" },
  newer_do: { en: "This is an older version of the page. Load the page anew to have the latest one. Nothing was changed.", ru: "Это старая версия страницы. Загрузите её заново с сервера, чтобы получить последнюю. Ничего не изменено." },
  anew: { en: "Load the page anew", ru: "Загрузить заново" },
  unreached: { en: "The server of this page can't be reached now: nothing was changed. Check the network.", ru: "Сервер этой страницы сейчас недоступен: ничего не изменено. Проверьте сеть." },
  details: { en: "What the browser said", ru: "Что сообщил браузер" },
  offline: { en: "There is no network, and mikas is not kept in this browser yet", ru: "Сети нет, а в этом браузере mikas ещё не сохранён" },
  offline_do: { en: "Connect to the Internet and reload the page. After the first visit mikas starts without a network.", ru: "Подключитесь к интернету и обновите страницу. После первого посещения mikas запускается и без сети." },
  reload: { en: "Reload the page", ru: "Обновить страницу" },

  elsewhere: { en: "mikas is open in another tab", ru: "mikas открыт в другой вкладке" },
  elsewhere_more: { en: "That tab has the cable and the recordings; only one can have them. Go on there, or close it: mikas then starts here by itself.", ru: "Кабель и записи у той вкладки; одновременно они могут быть только у одной. Работайте там или закройте её: тогда mikas запустится здесь сам." },
  here: { en: "Use it here instead", ru: "Перенести сюда" },
  recording: { en: "The other tab is recording. Stop the recording there (key R), or close that tab: the recording is kept.", ru: "В той вкладке идёт запись. Остановите её там (клавиша R) или закройте вкладку: запись сохранится." },
  sampling: { en: "The other tab is connected to the car. Disconnect it there (Connection, Disconnect), or close that tab.", ru: "Та вкладка подключена к машине. Отключите её там («Связь», «Отключить») или закройте вкладку." },
  silent: { en: "The other tab does not answer. Close it, or all windows of the browser, and open this page again.", ru: "Та вкладка не отвечает. Закройте её или все окна браузера и откройте эту страницу снова." },
});
