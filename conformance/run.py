#!/usr/bin/env python3
"""Check a codec of the Mikas K-Line protocol (docs/protocol.md, §2, §4), in any language.

    python3 conformance/run.py ./my_codec
    python3 conformance/run.py python3 my_codec.py

The codec is a program. It reads lines on standard input and answers each by one line on standard
output (and flushes it); bytes are in hex, with blanks between:

    encode 61 40             61 40 00 5F 0D              the message of this body
    encode-raw C0            C0 40 0D                    the same with its checksum not stuffed (D3)
    decode 01 FF | 0D 0A     frame 01 ; left 0A          the contents of these chunks, in order
    value INJ 6A 02          4.944                       the value of a parameter's bytes

Each `decode` begins with an empty decoder. Its answer has `frame BODY` (`frame` alone: an empty
body), `damaged BYTES` (the bytes before the 0D), and at last `left BYTES`, if the decoder still
holds some. A bare 0D is not mentioned (D5). Without any event the answer is an empty line.
A value is a number, or `yes` or `no` for a flag; a codec of messages alone answers `?`.

Needs Python 3.8 or newer and nothing else; it knows no codec of its own. It ends with 0 if all is
right, with 1 and a line for each mistake if not, with 2 if the program can't be run.
"""

from __future__ import annotations

import argparse
import json
import queue
import random
import subprocess
import sys
import threading
from pathlib import Path
from typing import Iterator

FOLDER = Path(__file__).parent
PATIENCE = 10.0  # s for an answer
MOST_SHOWN = 20  # mistakes
BODIES = 400  # made by chance
LONGEST = 300  # bytes of such a body
NEAR = 0.0005  # of a value: three decimals suffice
END = 150  # characters of a long line that are shown, at both ends
UNKNOWN = "?"  # the answer of a codec of messages alone, asked for a value
# The longest ones that a unit or a tester sends (§2.4), with all stuffed that can be.
LONGEST_MESSAGES = (
    ("26 with 255 data", b"\x26\x0d\x0d\xff" + b"\x0d" * 255),
    ("02 with 255 faults", b"\xff" + b"\x0d\xe0" * 255),
    ("255 data of two bytes", b"\x40" * 510),
)


class Stopped(Exception):
    """The codec ended, or gave no answer."""


class Codec:
    """The program, asked line by line."""

    def __init__(self, command: list[str]) -> None:
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="ascii"
        )
        self.answers: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        try:
            for line in self.process.stdout:
                self.answers.put(line)
        except ValueError:
            self.answers.put("no text in ASCII")
        self.answers.put(None)

    def ask(self, line: str) -> str:
        """Return the answer, with one blank between its words."""
        try:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
            answer = self.answers.get(timeout=PATIENCE)
        except (OSError, queue.Empty):
            answer = None
        if answer is None:
            raise Stopped(f"no answer to: {line}")
        return " ".join(answer.upper().split())

    def close(self) -> None:
        """End the program."""
        try:
            self.process.stdin.close()
            self.process.wait(PATIENCE)
        except (OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()


def vectors(name: str) -> list[dict]:
    """Return the vectors of a file; conformance/schema.json describes each."""
    return json.loads((FOLDER / f"{name}.json").read_text("utf-8"))


def checks(chance: random.Random) -> Iterator[tuple[str, str, str]]:
    """Yield why, the line to ask, and the answer that is right."""
    for each in vectors("frames"):
        yield each["why"], f"encode {each['body']}", each["wire"]
        yield each["why"], f"decode {each['wire']}", frames(each["body"])
        raw = each.get("wire_with_raw_checksum", each["wire"])
        yield f"{each['why']}, checksum as it is", f"encode-raw {each['body']}", raw
        yield f"{each['why']}, checksum as it is", f"decode {raw}", frames(each["body"])
    for each in vectors("streams"):
        right = events(each["events"])
        for chunks in chunkings(each["wire"].split()):
            yield each["why"], f"decode {chunks}", right
    for each in vectors("exchanges"):
        for end in ("request", "answer"):
            if each[end] is not None:
                yield each["why"], f"encode {each[end]}", each[f"{end}_wire"]
                yield each["why"], f"decode {each[f'{end}_wire']}", frames(each[end])
    for why, body in LONGEST_MESSAGES:
        yield from round_trip(why, body, chance)
    for _ in range(BODIES):
        yield from round_trip("a body made by chance", made(chance), chance)
    for each in vectors("values"):
        why = f"{each['parameter']}: {each['why']}"
        yield why, f"value {each['parameter']} {each['raw']}", shown(each["value"])


def round_trip(why: str, body: bytes, chance: random.Random) -> Iterator[tuple[str, str, str]]:
    """Yield the questions of a body that no vector has, both ways."""
    pieces = message(body).hex(" ").upper()
    yield why, f"encode {body.hex(' ').upper()}", pieces
    yield why, f"decode {chunked(pieces.split(), chance)}", frames(body.hex(" ").upper())


def shown(value: float) -> str:
    """Return the answer for a value of a vector."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return repr(value)


def is_right(line: str, answer: str, right: str) -> bool:
    """Return whether an answer is the right one; a value may be rounded."""
    right = " ".join(right.upper().split())
    if answer == right or not line.startswith("value "):
        return answer == right
    try:
        return abs(float(answer) - float(right)) <= NEAR
    except ValueError:
        return False


def shortened(text: str) -> str:
    """Return a text that fits a screen: its ends, and how many words it has."""
    if len(text) <= 2 * END:
        return text
    return f"{text[:END]} … {text[-END:]} ({len(text.split())} words)"


def frames(body: str) -> str:
    """Return the answer for a whole message."""
    return f"FRAME {body}".strip()


def events(listed: list[dict[str, str]]) -> str:
    """Return the answer for the events of a stream's vector."""
    words = {"frame": "FRAME", "damaged": "DAMAGED", "left_in_buffer": "LEFT"}
    return " ; ".join(
        f"{words[kind]} {data}".strip() for each in listed for kind, data in each.items()
    )


def chunkings(pieces: list[str]) -> Iterator[str]:
    """Yield the bytes as one chunk, each by itself, and cut in two at each place."""
    yield " ".join(pieces)
    yield " | ".join(pieces)
    for place in range(1, len(pieces)):
        yield " ".join(pieces[:place]) + " | " + " ".join(pieces[place:])


def chunked(pieces: list[str], chance: random.Random) -> str:
    """Return the bytes in chunks made by chance."""
    return " ".join(it + (" |" if chance.random() < 0.2 else "") for it in pieces).rstrip(" |")


def made(chance: random.Random) -> bytes:
    """Return a body with many of the bytes that are stuffed, or that make the checksum one."""
    length = chance.choice((0, 1, 2, 3, chance.randrange(LONGEST)))
    special = (0x0D, 0x40, 0xCD, 0x00, 0xC0, 0xF3)
    return bytes(
        chance.choice(special) if chance.random() < 0.5 else chance.randrange(256)
        for _ in range(length)
    )


def message(body: bytes) -> bytes:
    """Return a body's message by the letter of §2: checksum, stuffing of both, 0D."""
    whole = body + bytes([-sum(body) % 256])
    stuffed = b"".join({0x0D: b"\x40\xcd", 0x40: b"\x40\x00"}.get(it, bytes([it])) for it in whole)
    return stuffed + b"\x0d"


def main(arguments: list[str] | None = None) -> int:
    """Ask a codec all, and print its mistakes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of the bodies made by chance")
    parser.add_argument("command", nargs=argparse.REMAINDER, help="the codec and its arguments")
    given = parser.parse_args(arguments)
    if not given.command:
        parser.error("name the codec: python3 conformance/run.py ./my_codec")
    try:
        codec = Codec(given.command)
    except OSError as error:
        print(f"{given.command[0]} can't be run: {error.strerror}", file=sys.stderr)
        return 2
    asked, wrong, values = 0, [], True
    try:
        for why, line, right in checks(random.Random(given.seed)):
            is_value = line.startswith("value ")
            if is_value and not values:
                continue
            asked += 1
            answer = codec.ask(line)
            if is_value and answer == UNKNOWN:
                asked, values = asked - 1, False
                continue
            if not is_right(line, answer, right):
                said = {"asked:   ": line, "answered:": answer, "right:   ": right}
                lines = [f"  {word} {shortened(text)}" for word, text in said.items()]
                wrong.append("\n".join([why, *lines]))
    except Stopped as error:
        wrong.append(f"The codec ended, or was silent for {PATIENCE:g} s: {error}")
    finally:
        codec.close()
    for each in wrong[:MOST_SHOWN]:
        print(each)
    if len(wrong) > MOST_SHOWN:
        print(f"… and {len(wrong) - MOST_SHOWN} more")
    if not values:
        print("The codec gives no values: not checked")
    print(f"{asked} questions, {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
