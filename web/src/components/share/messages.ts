import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  verb: { en: "Share", ru: "Поделиться" },
  now: { en: "Share now", ru: "Готово: поделиться" },
  share: { en: "Share {name}", ru: "Поделиться: {name}" },
  share_now: { en: "Share now: {name}", ru: "Готово: поделиться {name}" },
  large: { en: "Browsers share no file over 50 MB. {name} was saved to the downloads instead: share it from there.", ru: "Файлы больше 50 МБ браузер не передаёт. {name} сохранён в загрузках: поделитесь им оттуда." },
  refused: { en: "The browser did not hand {name} over. It was saved to the downloads instead: share it from there.", ru: "Браузер не передал {name}. Файл сохранён в загрузках: поделитесь им оттуда." },
  as_text: { en: "Shared, a recording is called .pcapng.txt, for browsers hand over no .pcapng. mikas takes it as it is; for Wireshark remove “.txt”.", ru: "Когда вы делитесь записью, она называется .pcapng.txt: файлы .pcapng браузеры не передают. mikas примет её так; для Wireshark уберите «.txt»." },
});
