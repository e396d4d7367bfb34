import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  title: { en: "Passport", ru: "Паспорт" },
  reading: { en: "Asking the unit who it is…", ru: "Спрашиваем у блока, кто он…" },
  again: { en: "Read again", ru: "Прочитать снова" },
  copy: { en: "Copy", ru: "Скопировать" },
  copied: { en: "Copied.", ru: "Скопировано." },
  save_text: { en: "Save as text", ru: "Сохранить текстом" },
  save_json: { en: "Save as JSON", ru: "Сохранить JSON" },
  sheet: { en: "Passport of a control unit", ru: "Паспорт блока управления" },

  needs_line: {
    en: "The passport is read from the unit itself.",
    ru: "Паспорт читается из самого блока.",
  },
  unit: { en: "Control unit", ru: "Блок управления" },
  model: { en: "Model", ru: "Модель" },
  version_code: { en: "Answer to request 01", ru: "Ответ на запрос 01" },
  program: { en: "Program passport", ru: "Паспорт программы" },
  data: { en: "Data passport", ru: "Паспорт данных" },
  not_filled: { en: "not filled in", ru: "не заполнен" },
  not_told: { en: "this unit does not tell", ru: "блок не сообщает" },
  parameters: { en: "Parameters", ru: "Параметров" },
  private_note: {
    en: "A passport can hold numbers of this very unit. Look before you publish it.",
    ru: "В паспорте могут быть номера именно этого блока. Посмотрите, прежде чем публиковать.",
  },

  line: { en: "Adapter and line", ru: "Адаптер и линия" },
  adapter: { en: "Adapter", ru: "Адаптер" },
  unread: { en: "Nobody has read the passport yet", ru: "Паспорт ещё никто не читал" },
  unread_more: {
    en: "You are watching. It appears here when it has been read at the computer with the cable: its Passport screen.",
    ru: "Вы наблюдаете. Он появится здесь, когда его прочитают за компьютером с кабелем: там же, на экране «Паспорт».",
  },
  virtual: { en: "virtual ECU", ru: "виртуальный блок" },
  port: { en: "Port", ru: "Порт" },
  echo: { en: "Echo", ru: "Эхо" },
  echo_yes: { en: "comes back, every byte is checked", ru: "есть, каждый байт сверяется" },
  echo_no: {
    en: "the adapter keeps it to itself",
    ru: "адаптер его не возвращает",
  },
  baud: { en: "Speed", ru: "Скорость" },
  baud_value: { en: "{n} bit/s", ru: "{n} бит/с" },
  latency: { en: "Adapter's latency timer", ru: "Таймер задержки адаптера" },
  latency_value: { en: "{n} ms", ru: "{n} мс" },
  latency_slow: {
    en: "The adapter hands bytes over in lumps. It works, but slower; an FT232's latency timer can be set to 1 ms (in Windows: Device Manager, the port, Port Settings, Advanced).",
    ru: "Адаптер отдаёт байты порциями. Работает, но медленнее; таймер задержки FT232 можно поставить на 1 мс (в Windows: Диспетчер устройств, порт, Параметры порта, Дополнительно).",
  },
  not_measured: { en: "the system does not tell", ru: "система не сообщает" },

  learnt: { en: "What was learnt about this unit", ru: "Что выяснено об этом блоке" },
  learnt_more: {
    en: "Found by trying, kept for the next session, and used at once when this unit is met again.",
    ru: "Найдено пробами, запомнено и применяется сразу, когда этот блок встретится снова.",
  },
  method: { en: "Way of reading in use", ru: "Способ чтения сейчас" },
  rate_value: { en: "{n} sets/s", ru: "{n} наб/с" },
  rate_none: { en: "does not work", ru: "не работает" },
  max_list: { en: "Longest list in one request", ru: "Самый длинный список в запросе" },
  max_list_value: {
    en: { one: "{n} parameter", other: "{n} parameters" },
    ru: { one: "{n} параметр", few: "{n} параметра", many: "{n} параметров" },
  },
  max_block: { en: "Largest block of {space}", ru: "Самый большой блок {space}" },
  bytes: {
    en: { one: "{n} byte", other: "{n} bytes" },
    ru: { one: "{n} байт", few: "{n} байта", many: "{n} байтов" },
  },
  refused: { en: "Parameters it does not know", ru: "Параметры, которых он не знает" },
  none: { en: "none", ru: "нет" },
  relearn: { en: "Forget and measure again", ru: "Забыть и измерить заново" },
  relearn_more: {
    en: "Takes a few seconds; the values on the screen pause meanwhile. Worth it after changing the cable.",
    ru: "Займёт несколько секунд, значения на экране замрут. Полезно после смены кабеля.",
  },
  relearning: { en: "Measuring anew…", ru: "Измеряем заново…" },
  relearnt: { en: "Forgotten; being measured anew.", ru: "Забыто; измеряется заново." },

  commands: { en: "Commands", ru: "Команды" },
  commands_more: {
    en: "Every harmless command is tried once. It takes a second for each that the unit leaves unanswered; nothing is changed.",
    ru: "Каждая безвредная команда пробуется один раз. На каждую, что осталась без ответа, уходит секунда; ничего не меняется.",
  },
  probe: { en: "Try the commands", ru: "Проверить команды" },
  probe_again: { en: "Try again", ru: "Проверить снова" },
  probing: { en: "Trying one after another…", ru: "Пробуем одну за другой…" },
  knows: { en: "knows", ru: "знает" },
  knows_not: { en: "does not know", ru: "не знает" },
  not_tried: { en: "not known", ru: "неизвестно" },
  knows_count: { en: "{n} of {all} work", ru: "работают {n} из {all}" },
  code: { en: "Code", ru: "Код" },
  command: { en: "Command", ru: "Команда" },
  source: { en: "Name", ru: "Имя" },
  answer: { en: "This unit", ru: "Этот блок" },
  not_tried_more: {
    en: "“Not known”: what could change or upset something is not tried, and not every answer settles it.",
    ru: "«Неизвестно»: то, что могло бы что-то изменить или сбить, не пробуется, и не всякий ответ решает вопрос.",
  },
});

export const methods = dictionary({
  stream: { en: "stream (71): the unit sends by itself", ru: "поток (71): блок шлёт сам" },
  list: { en: "stored list (64, 63)", ru: "список в блоке (64, 63)" },
  batch: { en: "many parameters a request (61)", ru: "много параметров в запросе (61)" },
  single: { en: "one parameter a request (61)", ru: "по одному параметру (61)" },
});
