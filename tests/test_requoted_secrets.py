"""Messages of foreign code, which quotes and unquotes an address at will, have no secret of it."""

from __future__ import annotations

import re
from urllib.parse import quote, quote_plus, unquote, unquote_plus

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.cleaning import public_port, public_url, without_secrets
from mikas.errors import BadPortUrl, FleetError
from mikas.fleet.interpreting import InterpretingSettings
from mikas.fleet.job import work
from mikas.fleet.places import FoundFile, reason_in_store
from mikas.i18n import Text

SIGNATURE = "sv=2022-11-02&sig=S3CR3TyU1%2BoP%2Fq8%3D"
ODD = "".join(map(chr, range(0x20, 0x7F))) + "+%/:@\\\u00e4\u044f\u20ac\U0001f511"
SECRETS = st.text(ODD, min_size=3, max_size=30) | st.text(
    st.characters(exclude_categories=["Cs"]), min_size=3, max_size=12
)
WRITTEN = st.sampled_from([str, quote, quote_plus, lambda it: quote(it, safe="")])
OF_PLACES = {
    "ftp://me:{}@host/x": "ftp://host/x",
    "zip://in.pcapng::ftp://:{}@host/all.zip": "zip://in.pcapng::ftp://host/all.zip",
    "http://host/x.pcapng?{}": "http://host/x.pcapng",
    "https://host/x?sv=2022&sig={}": "https://host/x",
    "abfs://c/x#{}": "abfs://c/x",
}
OF_PORTS = ("socket://me:{}@host:9", "rfc2217://:{}@host:9", "own:me:{}@host", "me:{}@host:9")


def _by_yarl(address: str) -> str:
    yarl = pytest.importorskip("yarl")
    try:
        return str(yarl.URL(address))
    except ValueError:
        return address


def _in_lower_case(address: str) -> str:
    return re.sub("%[0-9A-F]{2}", lambda it: it[0].lower(), quote(address))


def _each_sign(address: str) -> str:
    return "".join(f"%{byte:02X}" for byte in address.encode())


FORMS = (str, quote, quote_plus, unquote, unquote_plus, _by_yarl, _in_lower_case, _each_sign, repr)
CHANGES = st.lists(st.sampled_from(FORMS), max_size=3)


def unquoted(text: str) -> str:
    """Return the bytes of the text, as characters, with all percent signs undone."""
    before, text = "", text.encode("utf-8", "replace").decode("latin-1")
    while text != before:
        before, text = text, unquote(text, "latin-1")
    return text.replace("+", " ").encode("latin-1").lower().decode("latin-1")


def pieces_of(secret: str, *, escaped: bool = False) -> set[str]:
    """Return what no message may have: each run of eight bytes, of three letters and digits, and
    all of a shorter one. `escaped`: of one with other escapes, no more than letters and digits.
    """
    whole = unquoted(secret)
    pieces = {*re.findall("[a-z0-9]{3,}", whole), *([] if escaped else [whole])}
    return {it[at : at + 8] for it in pieces for at in range(max(1, len(it) - 7)) if len(it) > 2}


def left_of(secret: str, address: str, changes, **known: str) -> list[str]:
    """Return the pieces of `secret` in what is said of an address that foreign code has changed."""
    for change in changes:
        address = change(address)
    said = unquoted(without_secrets(f"403, message='no', url='{address}'", **known))
    return [it for it in pieces_of(secret, escaped=repr in changes) if it in said]


@example("S3CR3TyU1+oP/q8=", lambda it: quote(it, safe=""), [_by_yarl])
@example("a b+c d%20e", quote_plus, [unquote, quote])
@example("ä/я?€#@:zq1", quote, [_in_lower_case])
@example("100%zq1", str, [quote, quote])
@given(SECRETS, WRITTEN, CHANGES)
def test_no_piece_of_a_secret_of_a_place_is_left_in_any_quoting(secret, written, changes) -> None:
    assume(not re.search("::[A-Za-z][A-Za-z0-9+.-]*://", written(secret)))  # one more place
    for form, public in OF_PLACES.items():
        place = form.format(written(secret))
        assert not left_of(secret, place, changes, place=place)
        assert public_url(place) == public


@example("S3CR3T/q8=", lambda it: quote(it, safe=""), [unquote])
@given(SECRETS, WRITTEN, CHANGES)
def test_no_piece_of_a_secret_of_a_port_is_left_in_any_quoting(secret, written, changes) -> None:
    assume(not re.match(r"//|\?\w+=", written(secret)))  # another kind of address
    addresses = [form.format(written(secret)) for form in OF_PORTS]
    addresses.append(f"own://host:9?token={quote(secret, safe=';/')}&baud=9600")
    for port in addresses:
        assert not left_of(secret, port, changes, port=port)


@given(st.integers(8, 40))
def test_a_message_that_was_cut_off_has_no_piece_of_a_signature(length) -> None:
    place = f"http://host/x.pcapng?{SIGNATURE}"
    said = without_secrets(f"no answer from {place}"[: length + 20], place=place)
    assert "s3c" not in said.lower()


def test_the_message_of_a_signed_url_keeps_all_else() -> None:
    place = f"http://host/x.pcapng?{SIGNATURE}"
    shown = f"403, message='no', url='{unquote(place)}'."
    error = FleetError(place, Text(shown, shown))
    said = "http://host/x.pcapng: 403, message='no', url='http://host/x.pcapng?…'."
    assert error.reason.en == said == error.reason.ru


def test_an_option_with_a_semicolon_is_hidden_whole() -> None:
    port = "own://host:9?token=zq1;zq2&baud=9600"
    assert public_port(port) == "own://host:9?token=…&baud=9600"
    assert "zq" not in str(BadPortUrl(url=port, problem=Text(port, port)))


def test_a_password_with_two_colons_is_no_chain() -> None:
    assert public_url("ftp://me:zq1::zq2@host/x") == "ftp://host/x"
    assert public_url("zip://in::ftp://me:zq1::zq2@host/x") == "zip://in::ftp://host/x"


def test_a_key_of_the_environment_is_in_no_message_however_it_is_quoted(monkeypatch) -> None:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "zq1/zq2+zq3")
    for shown in ("key zq1/zq2+zq3", "key=zq1%2fzq2%2Bzq3", "key zq1/zq2 zq3"):
        assert "zq" not in "".join(reason_in_store(ValueError(shown)))


def test_a_bug_in_the_work_on_a_file_says_no_secret_of_it_or_of_the_dataset(monkeypatch) -> None:
    file, dataset = "http://host/x.pcapng?sig=zq0000001%2B", "s3://K:zq0000002@bucket/set"
    long = f"{'x' * 270} {file}"

    def fail(*_: object, **__: object) -> None:
        raise RuntimeError(f"{unquote(file)} {dataset} {long}")

    monkeypatch.setattr("mikas.fleet.job._work", fail)
    shown = "".join(work(FoundFile(file, 1, ""), dataset, InterpretingSettings(shipped())).bad)
    assert "RuntimeError" in shown
    assert "zq" not in shown
