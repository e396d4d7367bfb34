// What the page says where the program is one on this computer, which has served it.
import type { Host } from "./host";

export const words: Host["words"] = {
  unreachable: { en: "The mikas program does not answer. Is it still running? Click its icon, or look at the window it was started from.", ru: "Программа mikas не отвечает. Она ещё запущена? Нажмите её значок или посмотрите в окно, из которого её запускали." },
  ended: { en: "The mikas program on the computer has ended or can't be reached. Start it again; this page reconnects by itself.", ru: "Программа mikas на компьютере завершена или недоступна. Запустите её снова: страница подключится сама." },
  returns: { en: "The page reconnects when mikas runs again. Click its icon, or look at the window it was started from.", ru: "Страница подключится сама, когда mikas снова заработает. Нажмите её значок или посмотрите в окно, из которого её запускали." },
  otherPort: { en: "for example socket://192.168.1.5:2000, /dev/ttyUSB0, COM3, sim:", ru: "например socket://192.168.1.5:2000, /dev/ttyUSB0, COM3, sim:" },
  kept: null,
  otherExports: null,
};
