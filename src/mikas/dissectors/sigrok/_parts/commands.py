"""What a request asks and what a response says (§3, §4): the layouts of the tables, walked.

The meaning of a message is that of `mikas decode`, word for word; tests hold both equal.
"""

from .tables import COMMANDS, FAULTS, INTERPRETATIONS, LANGUAGES, MESSAGES, MODELS, PARAMETERS

READ_LIST = 0x63  # its codes are those of the last 64
PASSPORT = 16  # bytes
SEPARATOR = 0xE0
REFUSAL = b"\x01"
UNCONFIRMED = ("unconfirmed", "не подтверждено")
# Control characters of a passport are shown as their pictures.
PICTURES = dict((code, 0x2400 + code) for code in range(0x20))
PICTURES[0x7F] = 0x2421


class Part(object):
    """What the bytes from `begin` to `end` of a body say. `kind`: value, flag, fault, text or done;
    `said`: as text; `title`: what that is; `reading`: (name, value, unit) of a parameter.
    """

    def __init__(self, kind, place, said, title="", reading=None):
        self.kind = kind
        self.begin, self.end = place
        self.said = said
        self.title = title
        self.reading = reading


class Commands(object):
    """The tables in one language and interpretation. Bodies of requests are remembered."""

    def __init__(self, language, interpretation):
        self._language = LANGUAGES.index(language)
        self._interpretation = INTERPRETATIONS.index(interpretation)
        self._known = {}

    # What `OneWire` must know.

    def is_request(self, body):
        """Return whether a body has the form of a request, perhaps for unknown parameters."""
        return self._asked(body) is not None

    def is_known(self, request):
        """Return whether the table of commands has the command of a request, None being unknown."""
        return bool(request) and request[0] in COMMANDS

    def is_unanswered(self, request):
        """Return whether no response to a request is expected (D9)."""
        return self.is_known(request) and COMMANDS[request[0]]["responses"] == [["any"]]

    def is_odd_stream(self, request):
        """Return whether a request is a stream of unknown parameters: texts look like that."""
        return self.is_stream(request) and not self._asked(request)["valid"]

    def is_stream(self, request):
        """Return whether a request is answered again and again (D12)."""
        return COMMANDS[request[0]]["stream"]

    def size(self, request, listed):
        """Return the length of a response, the usual one; None: not known."""
        codes = self._codes(request, listed)
        if codes == b"" or any(code not in PARAMETERS for code in codes or b""):
            return None
        row = COMMANDS[request[0]]
        return self._length(row, row["responses"][0], self._asked(request), codes)

    def fits(self, request, listed, body):
        """Return whether `body` may answer `request`: sound data, or a refusal (D10)."""
        if request is None or body == REFUSAL:
            return True
        return self.has_data(request, listed, body)

    def has_data(self, request, listed, body):
        """Return whether `body` has a length and contents that data for `request` have."""
        found = self._response(request, listed, body)
        return found is None or not isinstance(found, str)

    # What a person reads.

    def name(self, request):
        """Return the command's name in the source, and its code."""
        return self._to(COMMANDS[request[0]]["shown"]) if self.is_known(request) else None

    def request_meaning(self, request):
        """Return what a request asks; None for no valid one."""
        asked = self._asked(request)
        if asked is None or not asked["valid"]:
            return None
        title = self._to(COMMANDS[request[0]]["title"])
        names = " ".join(
            "/".join(each["name"] for each in PARAMETERS[code]) for code in asked.get("codes", b"")
        )
        return "%s: %s" % (title, names) if names else title

    def response_parts(self, request, listed, body, is_first):
        """Return the parts of a response, and None; or nothing, and the remark that stands instead.

        Both are empty where the request, or the list that it needs, is not known. `is_first`: the
        first response of a stream.
        """
        asked = self._asked(request) if request else None
        if asked is None or not asked["valid"]:
            return [], None
        found = self._response(request, listed, body)
        if found is None or isinstance(found, str):
            return [], found
        may_refuse = len(request) == 2 and "codes" in asked and found == ["values"] and is_first
        if may_refuse and body == REFUSAL:
            return [], self._to(MESSAGES["value_or_refusal"])
        return self._parts(request, listed, body, found), None

    def meaning(self, parts):
        """Return what the parts of a response say together."""
        kinds = set(part.kind for part in parts)
        said = " ".join(part.said for part in parts)
        return self._say("faults", numbers=said) if "fault" in kinds else said

    # The layouts.

    def _to(self, text):
        return text[self._language]

    def _say(self, message, **filled):
        return self._to(MESSAGES[message]).format(**filled)

    def _asked(self, body):
        """Return the fields of a request, `valid` among them; None for another form."""
        if body not in self._known:
            if len(self._known) > 4096:
                self._known.clear()
            self._known[body] = self._read_request(body)
        return self._known[body]

    def _read_request(self, body):
        row = COMMANDS.get(body[0]) if body else None
        found = None if row is None else fields(row, row["request"], body[1:], None)
        if found is None:
            return None
        end = found.get("address", 0) + found.get("count", 0)
        found["valid"] = (
            found.get("count", 1) > 0
            and ("count" not in found or end <= 256 ** row["address_bytes"])
            and all(code in PARAMETERS for code in found.get("codes", b""))
        )
        return found

    def _codes(self, request, listed):
        """Return the codes of the data in a response: b"": not known; None: it has no such data."""
        if request[0] == READ_LIST:
            return listed or b""
        row = COMMANDS[request[0]]
        return request[1:] if row["responses"] == [["values"]] else None

    def _response(self, request, listed, body):
        """Return the layout that a response fits, or why none; None: that can't be known."""
        row, asked = COMMANDS[request[0]], self._asked(request)
        codes = self._codes(request, listed)
        if asked is None or codes == b"" or any(code not in PARAMETERS for code in codes or b""):
            return None
        lengths = [self._length(row, layout, asked, codes) for layout in row["responses"]]
        for layout, length in zip(row["responses"], lengths):
            is_odd = len(body) % 2 == 1 and len(body) < 512  # a count, and two bytes a fault
            if length == len(body) or layout == ["any"] or (layout == ["faults"] and is_odd):
                break
        else:
            if body == REFUSAL:
                return self._say("not_supported", command=self._to(row["shown"]))
            expected = "1, 3, 5 …" if lengths == [None] else " / ".join(map(str, lengths))
            return self._say("wrong_length", length=len(body), expected=expected)
        problem = self._problem(row, layout, body, asked)
        return layout if problem is None else self._say(problem[0], **problem[1])

    def _length(self, row, layout, asked, codes):
        """Return the length of a response; None if it may have many."""
        length = 0
        for part in layout:
            if part in ("faults", "any"):
                return None
            if part == "values":
                length += sum(PARAMETERS[code][0]["size"] for code in codes)
            else:
                sizes = {"address": row["address_bytes"], "text": PASSPORT}
                length += asked["count"] if part == "bytes" else sizes.get(part, 1)
        return length

    def _problem(self, row, layout, body, asked):
        """Return why a response of the right length is none: a message and its fields."""
        if layout == ["faults"]:
            if body == REFUSAL:
                return "not_supported", {"command": self._to(row["shown"])}
            held = len(body) // 2
            if body[0] != held:
                return "other_number_of_faults", {"announced": body[0], "held": held}
            return None if body[2::2] == bytes([SEPARATOR] * held) else ("no_separator", {})
        found = fields(row, layout, body, asked)
        if found.get("address", asked.get("address")) != asked.get("address"):
            size = 2 * row["address_bytes"]
            got, sent = ("%0*X" % (size, each["address"]) for each in (found, asked))
            return "wrong_address", {"got": got, "asked": sent}
        if found.get("count", asked.get("count")) != asked.get("count"):
            return "other_count", {"announced": found["count"], "asked": asked["count"]}
        if found.get("result", 0) == 1:
            return "refused", {}
        if found.get("result", 0) != 0:
            return "no_completion_code", {"code": "%02X" % found["result"]}
        return None

    # The parts.

    def _parts(self, request, listed, body, layout):
        last = layout[-1]
        if last == "values":
            return self._values(self._codes(request, listed), body)
        if last == "faults":
            found = [self._fault(body[at], at) for at in range(1, len(body), 2)]
            return found or [Part("fault", (0, 1), "0")]
        if last == "model":
            model = MODELS.get(body[0])
            if model is None:
                return [Part("text", (0, 1), self._say("unknown_model", code="%02X" % body[0]))]
            return [Part("text", (0, 1), self._to(model))]
        if last == "text":
            text = body.rstrip(b"\0").decode("cp866").translate(PICTURES)
            return [Part("text", (0, len(body)), self._say("text", text=text))]
        if last == "result":
            return [Part("done", (0, 1), self._say("done"))]
        row, asked = COMMANDS[request[0]], self._asked(request)
        begin = len(body) - {"value": 1, "bytes": asked.get("count")}.get(last, len(body))
        said = " ".join("%02X" % byte for byte in body[begin:])
        address = "%0*X" % (2 * row["address_bytes"], asked["address"]) if begin else ""
        return [Part("text", (begin, len(body)), said, address)]

    def _fault(self, number, at):
        title = ""
        if number in FAULTS:
            text, confidence = FAULTS[number]["text"], FAULTS[number]["confidence"]
            title = self._to(text)
            if confidence == "unconfirmed":
                title = "%s (%s)" % (title, self._to(UNCONFIRMED))
        return Part("fault", (at, at + 2), str(number), title)

    def _values(self, codes, body):
        parts = []
        at = 0
        for code in codes:
            rows = PARAMETERS[code]
            end = at + rows[0]["size"]
            parts += [self._value(row, body[at:end], (at, end)) for row in rows]
            at = end
        return parts

    def _value(self, row, raw, place):
        conversion = row["interpretations"][self._interpretation]
        number = int.from_bytes(raw, "little", signed=conversion["signed"])
        unit = self._to(conversion["unit"])
        if conversion["mask"]:
            kind, value = "flag", number & conversion["mask"] != 0
            digits = "%d" % value
        else:
            kind, value = "value", number * conversion["numerator"] + conversion["constant"]
            if conversion["denominator"] != 1:
                value = value / conversion["denominator"]
            digits = "%.*f%s" % (row["decimals"], value, unit)
        said = "%s=%s" % (row["name"], digits)
        return Part(kind, place, said, self._to(row["text"]), (row["name"], value, unit))


def fields(row, layout, body, asked):
    """Return each part of a body by its name; None if the body has another length."""
    found = {}
    at = 0
    for part in layout:
        size = 1
        if part in ("codes", "datum", "any", "values"):
            size = len(body) - at
            if size < 1 and part in ("codes", "datum"):
                return None
        elif part == "address":
            size = row["address_bytes"]
        elif part == "bytes":
            size = (asked or found)["count"]
        elif part == "text":
            size = PASSPORT
        data = body[at : at + size]
        at += size
        if len(data) < size:
            return None
        is_number = part in ("address", "count", "value", "code", "model", "result")
        found[part] = int.from_bytes(data, "little") if is_number else data
    return found if at == len(body) else None
