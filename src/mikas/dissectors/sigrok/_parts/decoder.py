"""The diagnostic line (K-Line) of Mikas 5.4 and 7.1 engine control units.

Stack this decoder on UART with 9600 baud, 8 data bits, no parity, 1 stop bit. One channel on the
K-Line shows both directions; whose turn it is follows from the messages. With two channels of an
adapter, TX is what the adapter sends, RX what it receives, with or without its echo.

Only messages whose checksum is right, whose request is known and whose length fits give values. A
value of one message under two possible requests is not shown: the message is then "unclear".

OUTPUT_PYTHON, for stacked decoders: [kind, ...] with
 - 'REQUEST', body, name: the name is None for an unknown command;
 - 'RESPONSE', body, body of its request: the latter is None where it is not known;
 - 'VALUE', name, value, unit: a parameter in a response; flags are True or False;
 - 'ECHO', body: a request that the line returned; 'UNCLEAR', body: a request or a response;
 - 'DAMAGE', reason, bytes: 'checksum', 'stop bit', 'unfinished', 'too long' or 'break'.
Bodies are without stuffing and checksum.
"""

import sigrokdecode as srd

from .commands import READ_LIST, Commands
from .framing import Byte, Framer, WireMessage
from .tables import DEFAULTS, INTERPRETATIONS, LANGUAGES
from .turns import OneWire, TwoWires, is_noise

WIRE_BYTES = 960.0  # a second (§1)
RX, TX = 0, 1

FRAME, DAMAGE, ASKING, ANSWERING, ECHOING, DOUBTFUL, VALUE, FLAG, FAULT, TEXT, WARNING = range(11)
FRAMES, REQUESTS, RESPONSES = range(3)

WORDS = {
    "checksum": ("wrong checksum", "неверная контрольная сумма"),
    "stop bit": ("a byte without its stop bit", "байт без стоп-бита"),
    "unfinished": ("unfinished", "не закончено"),
    "too long": ("no end in sight", "слишком длинно"),
    "break": ("line break", "обрыв (break) на линии"),
    "noise": ("noise", "помеха"),
    "raw": ("raw checksum", "контрольная сумма без замены"),
    "stuffed": ("stuffed checksum", "контрольная сумма с заменой"),
    "irregular": ("irregular escape", "необычная замена байта"),
    "echo": ("echo", "эхо"),
    "other echo": ("the echo differs: collision?", "эхо отличается: столкновение?"),
    "silent": ("no response", "нет ответа"),
    "unclear": ("request or response?", "запрос или ответ?"),
    "orphan": ("response, its request is not known", "ответ, запрос неизвестен"),
    "no list": ("response, its list (64) is not known", "ответ, список (64) неизвестен"),
    "unknown": ("unknown request", "неизвестный запрос"),
    "bytes": ("bytes", "байт"),
}


def by_default(english, russian):
    """Return the text in the language in which this file was made."""
    return (english, russian)[LANGUAGES.index(DEFAULTS["language"])]


class Decoder(srd.Decoder):
    api_version = 3
    id = "mikas"
    name = "Mikas"
    longname = by_default("Mikas 5.4 / 7.1 engine control unit", "Блок управления Микас 5.4 / 7.1")
    desc = by_default(
        "Diagnostics of GAZ engine control units over K-Line.",
        "Диагностика блоков управления двигателем ГАЗ по K-Line.",
    )
    license = "mit"
    inputs = ["uart"]
    outputs = ["mikas"]
    tags = ["Automotive"]
    options = (
        {
            "id": "interpretation",
            "desc": by_default("Interpretation of odd formulas", "Толкование спорных формул"),
            "default": DEFAULTS["interpretation"],
            "values": INTERPRETATIONS,
        },
        {
            "id": "checksum",
            "desc": by_default("Usual form of the checksum", "Обычный вид контрольной суммы"),
            "default": DEFAULTS["checksum"],
            "values": ("stuffed", "raw"),
        },
        {
            "id": "language",
            "desc": by_default("Language", "Язык"),
            "default": DEFAULTS["language"],
            "values": LANGUAGES,
        },
    )
    annotations = (
        ("frame", by_default("Frame", "Кадр")),
        ("damage", by_default("Damage", "Повреждение")),
        ("request", by_default("Request", "Запрос")),
        ("response", by_default("Response", "Ответ")),
        ("echo", by_default("Echo", "Эхо")),
        ("unclear", by_default("Unclear", "Неясно")),
        ("value", by_default("Value", "Значение")),
        ("flag", by_default("Flag", "Признак")),
        ("fault", by_default("Fault", "Ошибка")),
        ("text", by_default("Text", "Текст")),
        ("warning", by_default("Warning", "Предупреждение")),
    )
    annotation_rows = (
        ("frames", by_default("Frames", "Кадры"), (FRAME, DAMAGE)),
        (
            "exchanges",
            by_default("Requests and responses", "Запросы и ответы"),
            (ASKING, ANSWERING, ECHOING, DOUBTFUL),
        ),
        ("values", by_default("Values", "Значения"), (VALUE, FLAG, FAULT, TEXT)),
        ("warnings", by_default("Warnings", "Предупреждения"), (WARNING,)),
    )
    binary = (
        ("frames", by_default("All frames, as on the wire", "Все кадры, как на линии")),
        ("requests", by_default("Requests, as on the wire", "Запросы, как на линии")),
        ("responses", by_default("Responses, as on the wire", "Ответы, как на линии")),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None
        self._framers = [Framer(), Framer()]
        self._ends = [None, None]  # of the last byte of each channel
        self._glitch = [False, False]
        self._wires = None  # where both channels carry bytes
        self._waiting = []  # received while a request is being sent
        self._silent = None  # the last request, while it has no response
        self._heard = -1  # first sample of the last damage that may be a response
        self._started = False  # a stream, without a response yet

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def start(self):
        self._out_ann = self.register(srd.OUTPUT_ANN)
        self._out_binary = self.register(srd.OUTPUT_BINARY)
        self._out_python = self.register(srd.OUTPUT_PYTHON)
        self._commands = Commands(self.options["language"], self.options["interpretation"])
        self._line = OneWire(self._commands)

    def decode(self, ss, es, data):
        kind, channel, value = data
        if kind == "STARTBIT":
            self._glitch[channel] = False
        elif kind == "INVALID STARTBIT":  # a FRAME may follow it, which is none
            self._glitch[channel] = True
            self._warn(ss, es, self._word("noise"))
        elif kind == "BREAK":
            self._broken(channel, ss, es)
        elif kind == "FRAME" and not self._glitch[channel]:
            pause = 0.0
            if self._ends[channel] is not None:
                rate = self.samplerate or (es - ss) * WIRE_BYTES
                pause = max(0, ss - self._ends[channel]) / float(rate)
            self._ends[channel] = es
            if self._wires is None and self._ends[1 - channel] is not None:
                self._wires = TwoWires(self._commands, self.samplerate or (es - ss) * WIRE_BYTES)
                for message in self._line.held:
                    self._take_of_two(message, channel != TX)
            for message in self._framers[channel].feed(Byte(value[0], ss, es, value[1], pause)):
                self._found(channel, message)

    # Messages

    def _broken(self, channel, ss, es):
        framer = self._framers[channel]
        framer.drop(ss)
        self._ends[channel] = es
        for message in framer.abandon() + [WireMessage([Byte(0, ss, es, False)], "break")]:
            self._found(channel, message)

    def _found(self, channel, message):
        """Show a frame or damage at once, and its role as soon as that is certain."""
        if message.body is None:
            self._show_damage(message)
            if (self._wires is None or channel == RX) and not is_noise(message):
                self._heard = message.ss
        else:
            self._show_frame(message)
        if self._wires is None:
            for each, role in self._line.assign_role(message):
                self._show_role(each, role)
            return
        sending = self._framers[TX].begin
        if channel == RX and sending is not None and sending < message.es:
            self._waiting.append(message)  # its echo comes with its last bit
            return
        self._take_of_two(message, channel == TX)
        if channel == TX:
            waiting, self._waiting = self._waiting, []
            for each in waiting:
                self._take_of_two(each, False)

    def _take_of_two(self, message, is_sent):
        for each, role in self._wires.assign_role(message, is_sent):
            self._show_role(each, role)

    def _show_damage(self, damage):
        word = self._word(damage.reason)
        texts = [word, "!"]
        if damage.reason != "break":
            texts.insert(0, "%s: %s" % (word, hexadecimal(damage.data())))
        self._put(damage, DAMAGE, texts)
        self._warn(damage.ss, damage.es, word)
        self._pass(damage, ["DAMAGE", damage.reason, damage.data()])

    def _show_frame(self, frame):
        data = frame.data()
        size = "%d %s" % (len(data), self._word("bytes"))
        self._put(frame, FRAME, [hexadecimal(data), size, "%d" % len(data)])
        self._dump(frame, FRAMES)
        if frame.irregular:
            self._warn(frame.ss, frame.es, self._word("irregular"))
        is_special = -sum(frame.body) & 0xFF in (0x0D, 0x40)
        form = "raw" if frame.raw_checksum else "stuffed"
        if is_special and form != self.options["checksum"]:
            self._warn(frame.ss, frame.es, self._word(form))

    # Roles

    def _show_role(self, message, role):
        kind, request, listed = role
        if kind == "request":
            self._show_request(message)
        elif kind == "response":
            self._silent = None
            self._show_response(message, request, listed)
            self._started = False
        elif kind == "echo":
            self._put(message, ECHOING, [self._word("echo"), "="])
            if message.body != request:
                self._warn(message.ss, message.es, self._word("other echo"))
            self._pass(message, ["ECHO", message.body])
        else:
            self._silent = None  # this may be its response
            word = self._word("unclear")
            self._put(message, DOUBTFUL, [word, "?"])
            self._warn(message.ss, message.es, word)
            self._pass(message, ["UNCLEAR", message.body])

    def _show_request(self, message):
        body = message.body
        if self._silent is not None and self._is_without_response(self._silent, message.ss):
            self._warn(self._silent.ss, self._silent.es, self._word("silent"))
        self._silent = message
        self._started = True
        name = self._commands.name(body)
        texts = [self._commands.request_meaning(body), name, "%02X" % body[0] if body else ""]
        if name is None:
            texts[1] = self._word("unknown")
        self._put(message, ASKING, [text for text in texts if text])
        self._dump(message, REQUESTS)
        self._pass(message, ["REQUEST", body, name])

    def _is_without_response(self, request, end):
        """Return whether a response is missing: also no damage before `end` can have been one."""
        if self._commands.is_unanswered(request.body) or self._heard >= request.es:
            return False
        left = self._framers[RX].left()  # of two wires: on one, the next request has ended it
        return left is None or not request.es <= left.ss < end or is_noise(left)

    def _show_response(self, message, request, listed):
        self._dump(message, RESPONSES)
        self._pass(message, ["RESPONSE", message.body, request])
        parts, problem = self._commands.response_parts(request, listed, message.body, self._started)
        if parts:
            said = self._commands.meaning(parts)
            self._put(message, ANSWERING, [said, hexadecimal(message.body)])
            for same in by_place(parts):
                self._show_parts(message, same)
            return
        if problem is None and not self._commands.is_known(request):
            problem = self._word("orphan")
        if problem is None and request[0] == READ_LIST and not listed:
            problem = self._word("no list")
        data = hexadecimal(message.body)
        if problem is None:  # of a parameter that the catalog does not have
            self._put(message, ANSWERING, [data])
        else:
            self._put(message, ANSWERING, [problem, data])
            self._warn(message.ss, message.es, problem)

    def _show_parts(self, message, parts):
        """Show the parts that some bytes have in common: flags share a byte."""
        first = parts[0]
        if first.kind == "done":
            return
        ss = message.places[first.begin][0]
        es = message.places[first.end - 1][1]
        kinds = {"value": VALUE, "flag": FLAG, "fault": FAULT, "text": TEXT}
        said = " ".join(part.said for part in parts)
        texts = [said, said.split("=", 1)[-1]] if len(parts) == 1 else [said]
        titles = ", ".join(part.title for part in parts if part.title)
        if titles:
            texts.insert(0, "%s: %s" % (titles, said))
        self.put(ss, es, self._out_ann, [kinds[first.kind], texts])
        for part in parts:
            if part.reading:
                self.put(ss, es, self._out_python, ["VALUE"] + list(part.reading))

    # Output

    def _word(self, key):
        return WORDS[key][LANGUAGES.index(self.options["language"])]

    def _put(self, message, kind, texts):
        self.put(message.ss, message.es, self._out_ann, [kind, texts])

    def _warn(self, ss, es, text):
        self.put(ss, es, self._out_ann, [WARNING, [text, "!"]])

    def _dump(self, message, kind):
        self.put(message.ss, message.es, self._out_binary, [kind, message.data()])

    def _pass(self, message, data):
        self.put(message.ss, message.es, self._out_python, data)


def by_place(parts):
    """Return the parts in groups that stand in the same bytes."""
    groups = []
    for part in parts:
        if groups and groups[-1][0].begin == part.begin:
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def hexadecimal(data):
    """Return `61 1A`."""
    return " ".join("%02X" % byte for byte in data)
