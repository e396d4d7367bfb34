"""Whose turn it is: which message is a request, and which request a response answers (D13).

Neither is in a message. Where two wires are tapped, the channel shows it. One wire carries both
directions, so `OneWire` follows every course of the exchange that the bytes and the pauses allow. A
message gets its role as soon as all courses agree about it; one about which they never agree is
unclear, and so is what it says. So a value is shown under a parameter only if it can be no other's.
"""

LATEST = 0.51  # s: no tester waits longer for a response (D14), but one that is set to
KNOWN_VERSIONS = (b"\x09", b"\x0a")  # versions that need no second 01
PATIENCE = 0.1  # s: no tester gives a request up earlier, and sends another one
MOST_HELD = 12  # messages

STOP = b"\x01"  # ends a stream (D12)
REFUSED = b"\x01"  # D10
WRITE_LIST = 0x64
LIST_IS_SET = b"\x00"
NOISE = b"\xff"  # a start bit in a silent line; no message is so short

FREE, ASKED, ENDING = "free", "asked", "ending"
STREAMS = ("stream", "stream, 1 to fit", "stream, 2 to fit", "stream, 3 to fit")
STREAM, DOUBTED = STREAMS[0], STREAMS[1:]

REQUEST = ("request", None, None)
UNCLEAR = ("unclear", None, None)
NO_ANSWER = ("response", None, None)


def response(request, listed):
    """Return the role of a response to `request`, whose body is None if it is not known. `listed`:
    the codes of the unit's list, which a response to 63 consists of; None: not known.
    """
    return ("response", request, listed)


class OneWire(object):
    """All courses that the messages on one wire allow.

    A course is (mode, request, listed, size): a request comes next (FREE), or the response to
    `request` (ASKED), or `request` is a stream (STREAM), or 01 was sent while responses to
    `request` may still come (ENDING); `size`: of these responses. One message in a stream may be
    none of it; the next ones have to fit (DOUBTED). Each course has the roles that it gives to
    `held`, the messages whose roles are not certain yet.
    """

    def __init__(self, commands):
        self._commands = commands
        self.held = []
        self._courses = dict((course, ()) for course in unknown(None))

    def assign_role(self, message):
        """Return the messages whose role is certain now, each with it."""
        if message.body is None:
            self._interrupt(message)
            return self._certain()
        moves = self._all(self._moves, message) or self._all(self._odd_moves, message)
        self.held.append(message)
        self._courses = merged(moves)
        return self._certain()

    def _all(self, moves_of, message):
        return [
            (course, roles + (role,))
            for before, roles in self._courses.items()
            for course, role in moves_of(before, message)
        ]

    def _moves(self, before, message):
        """Return the courses that regular traffic can take by this message, with its role."""
        mode, request, listed, size = before
        body = message.body
        asks = self._commands.is_request(body) and not self._commands.is_odd_stream(body)
        gave_up = message.pause >= PATIENCE
        found = []
        if mode == FREE:
            return [asked(body, listed)] if asks else []
        if mode == ASKED:
            again = body == request  # or an echo of it (D1): no value comes of that
            if self._commands.fits(request, listed, body):
                answered = self._answered(before, body)
                found += [(it, UNCLEAR) for it, _ in answered] if again else answered
            if asks and (gave_up or again or self._commands.is_unanswered(request)):
                found.append(self._asked_again(before, body))
            return found
        if mode == ENDING and len(body) == 1:
            found.append((free(listed), response(STOP, listed)))
        if len(body) == size:  # behind a 01: late, or the unit did not hear that
            same = ENDING if mode == ENDING else STREAMS[max(STREAMS.index(mode) - 1, 0)]
            role = response(STOP if mode == ENDING else request, listed)
            found.append(((same, request, listed, size), role))
        elif mode == STREAM and body != STOP:
            found.append(((DOUBTED[-1], request, listed, size), UNCLEAR))
        if body == STOP:
            found.append(((ENDING, request, listed, size), REQUEST))
        elif asks and gave_up:
            found.append(asked(body, listed))
        return found

    def _asked_again(self, before, body):
        """Return the course behind a request while another one has no response."""
        _, request, listed, _ = before
        if request is None:
            return asked(body, None)
        size = self._commands.size(request, listed)
        if body == STOP and size is not None:  # D13: the tester synchronizes
            return ((ENDING, request, listed, size), REQUEST)
        return asked(body, listed)

    def _answered(self, before, body):
        """Return the courses behind a response that fits, or may be a refusal."""
        _, request, listed, _ = before
        role = response(request, listed)
        if request is None:
            # It may have been a 64: then the unit has another list now.
            return [(free(None if body == LIST_IS_SET else listed), role)]
        if self._commands.is_stream(request):
            streams = self._commands.has_data(request, listed, body)
            found = [((STREAM, request, listed, len(body)), role)] if streams else []
            return found + ([(free(listed), role)] if body == REFUSED else [])
        if request[0] == WRITE_LIST and body == LIST_IS_SET:
            listed = request[1:]
        return [(free(listed), role)]

    def _odd_moves(self, before, message):
        """Return courses for a message that regular traffic does not have."""
        mode, request, listed, _ = before
        body = message.body
        found = []
        if mode in (FREE, ASKED) and self._commands.is_request(body):
            again = self._asked_again(before, body) if mode == ASKED else asked(body, listed)
            found.append(again)
        if mode == ASKED and message.pause < PATIENCE:
            found.append((free(listed), response(request, listed)))
            if request is not None and self._commands.is_stream(request):
                size = self._commands.size(request, listed)
                found.append(((STREAM, request, listed, size), response(request, listed)))
        if found:
            return found
        kept = [before] if mode in DOUBTED or mode == ENDING else []
        return [(course, UNCLEAR) for course in unknown(listed) + kept]

    def _interrupt(self, damage):
        """Continue behind damage, which may have been a request, a response, or both."""
        if is_noise(damage):
            return
        courses = []
        for before, roles in self._courses.items():
            mode, request, listed, _ = before
            if damage.wire[0].value == WRITE_LIST:
                listed = None
            courses += [(course, roles) for course in unknown(listed)]
            if mode in STREAMS or mode == ENDING:
                courses.append((before, roles))
            elif request is not None and self._commands.is_stream(request):
                size = self._commands.size(request, listed)
                courses.append(((STREAM, request, listed, size), roles))
        self._courses = merged(courses)

    def _certain(self):
        """Return the first messages about whose roles all courses agree."""
        found = []
        while self.held:
            roles = set(roles[0] for roles in self._courses.values())
            if len(roles) > 1 and len(self.held) <= MOST_HELD:
                break
            found.append((self.held.pop(0), roles.pop() if len(roles) == 1 else UNCLEAR))
            self._courses = merged([(each, roles[1:]) for each, roles in self._courses.items()])
        return found


def is_noise(damage):
    """Return whether damage is one byte of a glitch, and no part of a message."""
    return damage.reason == "unfinished" and damage.data() == NOISE


def unknown(listed):
    """Return the courses where it is not known whose turn it is."""
    return [free(listed), (ASKED, None, listed, 0)]


def free(listed):
    """Return the course on which a request comes next."""
    return (FREE, None, listed, 0)


def asked(body, listed):
    """Return the course behind a request, and the request's role."""
    return ((ASKED, body, None if body[0] == WRITE_LIST else listed, 0), REQUEST)


def merged(courses):
    """Return the roles by course. Where one course gives two roles to a message, it is unclear."""
    result = {}
    for course, roles in courses:
        known = result.get(course, roles)
        result[course] = tuple(one if one == other else UNCLEAR for one, other in zip(known, roles))
    return result


class TwoWires(object):
    """The channels of an adapter: what it sends, and what it receives, perhaps with its echo.

    The rules are those of `mikas decode`: the echo is the first thing behind a request, and one
    response comes behind it; after anything else no response counts until 01 has been answered by
    one byte, the unit's version, twice or as it was before.
    """

    def __init__(self, commands, rate):
        self._commands = commands
        self._late = LATEST * rate
        self._sent = None
        self._request = None
        self._listed = None
        self._echoes = None
        self._phase = None  # "asked", "echoed", "answered", "stream" or "void"
        self._trusted = True
        self._answer = None  # to the present 01
        self._version = None
        self._last_version = None

    def assign_role(self, message, is_sent):
        """Return the message with its role."""
        if is_sent:
            self._begin(message)
            return [] if message.body is None else [(message, REQUEST)]
        role = self._role(message)
        return [] if message.body is None else [(message, role)]

    def is_echo(self, message):
        """Return whether the message was received while another one was sent (D1)."""
        sent = self._sent
        return sent is not None and message.ss < sent.es and sent.ss < message.es

    def _begin(self, message):
        """End the exchange before, and begin that of a sent message."""
        if self._phase == "answered" and self._request == STOP:
            self._confirm()
        elif self._phase not in (None, "answered"):
            self._trusted = False
        self._sent, self._request = message, message.body
        self._phase = "asked" if message.body else None
        # Damage may have been a 64.
        if message.body is None or message.body[:1] == bytes([WRITE_LIST]):
            self._listed = None

    def _confirm(self):
        before, self._last_version = self._last_version, self._answer
        is_own = self._version is None and self._answer in KNOWN_VERSIONS
        if is_own or self._answer in (self._version, before):
            self._version, self._trusted = self._answer, True
        elif self._version is not None:
            self._trusted = False

    def _role(self, message):
        """Return the role of what was received."""
        if self.is_echo(message):
            is_first, is_same = self._phase == "asked", message.body == self._sent.body
            if is_same:
                self._echoes = True
            self._phase = "echoed" if is_first and is_same else "void"
            return ("echo", self._sent.body, None)
        if is_noise(message) or self._phase is None:
            return self._unasked(message)
        if (self._phase == "asked" and self._echoes) or self._phase in ("answered", "void"):
            self._phase = "void"
            return self._unasked(message)
        if self._commands.is_known(self._request) and self._commands.is_stream(self._request):
            self._phase = "stream"
            return self._answered()
        self._phase = "void"
        if message.body is None or message.ss - self._sent.es > self._late:
            return NO_ANSWER
        if self._commands.is_known(self._request) and not self._commands.fits(
            self._request, self._listed, message.body
        ):
            return self._answered()  # shown as what it is; no value comes of it
        self._phase = "answered"
        if self._request == STOP:
            self._answer = message.body
            if self._echoes is None:
                self._echoes = False
            return response(STOP, None)
        if self._trusted and self._request[0] == WRITE_LIST and message.body == LIST_IS_SET:
            self._listed = self._request[1:]
        return self._answered()

    def _unasked(self, message):
        """Take what answers no request: it may be all that is left of a 64."""
        body = message.body or b""
        if body == LIST_IS_SET or body[:1] == bytes([WRITE_LIST]):
            self._listed = None
        return NO_ANSWER

    def _answered(self):
        return response(self._request, self._listed) if self._trusted else NO_ANSWER
