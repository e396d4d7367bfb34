// Texts of the site on the Connection screen.
import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  insecure: { en: "Opened over http from another computer: no cable, no kept recordings", ru: "Страница открыта по http с другого компьютера: без кабеля и без хранения записей" },
  insecure_do: {
    en: "Browsers allow the cable and storage only to pages over https, and to this computer's own. Open the address with https://, or serve the folder on this computer (http://localhost). The virtual car works here.",
    ru: "Кабель и хранилище браузеры дают только страницам по https и с этого же компьютера. Откройте адрес с https:// или запустите сайт на этом компьютере (http://localhost). Виртуальный автомобиль работает и так.",
  },
  no_serial: { en: "This browser can't use the cable", ru: "Этот браузер не умеет работать с кабелем" },
  no_serial_do: {
    en: "It has no Web Serial, or it was switched off. On a computer open this page in Chrome, Edge, Opera, Yandex Browser or Firefox (153 or newer), on an Android phone in Chrome or a browser made of it. Safari, iPhones and iPads don't have it. Here the virtual car works, and recordings from elsewhere can be opened (Recordings, Add…).",
    ru: "В нём нет Web Serial, или он выключен. Откройте эту страницу на компьютере в Chrome, Edge, Opera, Яндекс Браузере или Firefox (153 или новее), на телефоне с Android — в Chrome или браузере на его основе. В Safari, на iPhone и iPad этого нет. Здесь работает виртуальный автомобиль и открываются чужие записи («Записи», «Добавить…»).",
  },
  no_storage: { en: "This browser keeps no recordings", ru: "Этот браузер не хранит записи" },
  no_storage_do: {
    en: "In a private window, or with cookies blocked, recordings are lost when the page is closed. Download them before, or open this page in an ordinary window.",
    ru: "В приватном окне или при запрете cookie записи пропадут, когда страница закроется. Скачайте их до этого или откройте страницу в обычном окне.",
  },
  little: { en: "Little room for recordings: {left} left", ru: "Мало места для записей: осталось {left}" },
  little_do: { en: "Download old recordings and delete them here, or free space on the disk.", ru: "Скачайте старые записи и удалите их здесь или освободите место на диске." },
  battery: { en: "Battery {percent} %: the phone does not charge while the cable is in it", ru: "Заряд {percent} %: пока вставлен кабель, телефон не заряжается" },
  battery_do: {
    en: "Its one socket feeds the cable. At 20 % a warning comes, at 10 % a running recording is closed, so that it is whole. A phone that charges without a wire can lie on its charger meanwhile.",
    ru: "Единственный разъём питает кабель. При 20 % придёт предупреждение, при 10 % запись будет закрыта, чтобы файл остался целым. Телефон с беспроводной зарядкой можно пока положить на неё.",
  },
  not_listed: { en: "The cable was not in the list?", ru: "Кабеля в списке не было?" },
  not_listed_plug: {
    en: "Plug it in, wait for a few seconds, and press “Choose the cable…” again. It is called by its chip: FT232R, USB-SERIAL CH340, CP2102. Try another USB socket, without a hub.",
    ru: "Вставьте его, подождите несколько секунд и снова нажмите «Выбрать кабель…». В списке он назван по микросхеме: FT232R, USB-SERIAL CH340, CP2102. Попробуйте другой разъём USB, без хаба.",
  },
  not_listed_android: {
    en: "Android: nothing in the list means that the phone sees no cable. Plug the OTG plug in firmly (a plain USB-C cable is no OTG), and see whether the cable's lamp is on. Some phones (Oppo, OnePlus, Realme, vivo) have OTG switched off: Settings, OTG connection; they switch it off again after some minutes. No lamp: the phone gives no power, as some do with little charge or to save energy; charge it, or try another plug. Without a hub: most phones can't feed it.",
    ru: "Android: пустой список значит, что телефон не видит кабель. Вставьте переходник OTG до упора (обычный шнур USB-C — не OTG) и посмотрите, горит ли лампочка кабеля. На некоторых телефонах (Oppo, OnePlus, Realme, vivo) OTG выключен: «Настройки», «Подключение OTG»; через несколько минут он выключается снова. Лампочка не горит — телефон не даёт питания: так бывает при малом заряде и в режиме экономии; зарядите его или возьмите другой переходник. Без хаба: большинству телефонов его не запитать.",
  },
  not_known: { en: "That device is no cable that is known here", ru: "Это устройство — не кабель, который здесь известен" },
  not_known_do: {
    en: "Choose the cable itself. A cable has one of these chips: FT232R, CH340, CP2102, PL2303. Known are FTDI, CH340 and CH341 in serial mode, CP210x, PL2303, and devices of the class CDC-ACM.",
    ru: "Выберите сам кабель. В кабеле стоит одна из микросхем: FT232R, CH340, CP2102, PL2303. Здесь известны FTDI, CH340 и CH341 в режиме порта, CP210x, PL2303 и устройства класса CDC-ACM.",
  },
  not_listed_windows: {
    en: "Windows: open Device Manager. A yellow mark at “USB Serial”, “USB2.0-Serial” or “FT232R USB UART” means that the driver is missing: FTDI's VCP driver for FT232, WCH's CH341SER for CH340. Windows Update often finds it by itself. Then plug the cable in again.",
    ru: "Windows: откройте «Диспетчер устройств». Жёлтый знак у «USB Serial», «USB2.0-Serial» или «FT232R USB UART» означает, что нет драйвера: для FT232 это VCP от FTDI, для CH340 — CH341SER от WCH. Часто его находит сам Центр обновления Windows. Затем вставьте кабель снова.",
  },
  not_listed_linux: {
    en: "Linux: brltty, the program for braille displays, takes CH340 cables on some systems: sudo apt remove brltty, then plug the cable in again. To open the port you have to be in the group dialout: sudo usermod -aG dialout $USER, then log out and in. On an Android tablet switch “Desktop site” off in the browser's menu.",
    ru: "Linux: на некоторых системах кабели CH340 забирает brltty, программа для дисплеев Брайля: sudo apt remove brltty, затем вставьте кабель снова. Чтобы порт открывался, нужна группа dialout: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова. На планшете с Android выключите в меню браузера «Версию для ПК».",
  },

  here: { en: "mikas in this browser", ru: "mikas в этом браузере" },
  private: { en: "Nothing leaves this computer.", ru: "Ничего не уходит с этого компьютера." },
  private_more: { en: "The whole program runs in this tab; the server only handed out its files.", ru: "Вся программа работает в этой вкладке; сервер лишь отдал её файлы." },
  kept: {
    en: "Recordings are kept in this browser, on this computer. Clearing the browser's data of this page deletes them, and so does closing a private window: download what matters.",
    ru: "Записи хранятся в этом браузере, на этом компьютере. Очистка данных браузера для этой страницы удалит их, закрытие приватного окна тоже: важное скачайте.",
  },
  left: { en: "Room for recordings: {left}.", ru: "Место для записей: {left}." },
  offline: { en: "mikas is kept in this browser: it starts without a network, too.", ru: "mikas сохранён в этом браузере: запустится и без сети." },
  new_version: { en: "It is loaded already. The page reloads; not while the car is connected.", ru: "Она уже загружена. Страница обновится; при подключённой машине этого не будет." },
  new_ready: { en: "A new version of mikas is ready.", ru: "Готова новая версия mikas." },
  use: { en: "Use it now", ru: "Перейти на неё" },
  install: { en: "Install", ru: "Установить" },
  install_more: { en: "mikas then has an icon and a window of its own. Removed like any program.", ru: "У mikas появятся свой значок и своё окно. Удаляется как любая программа." },
  documentation: { en: "Documentation: first steps, how-tos, the protocol", ru: "Документация: первые шаги, как сделать, протокол" },
});
