"""The broker's address and credentials; the password is never shown."""

from __future__ import annotations

from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import UsageError
from mikas.publish.broker import PASSWORD, USER, parse_address, with_credentials, with_tls

SECRET = "s3cret-WORD"


@pytest.mark.parametrize(
    ("text", "host", "port", "encrypted", "url"),
    [
        ("mqtt://localhost", "localhost", 1883, False, "mqtt://localhost:1883"),
        ("mqtts://broker.example/", "broker.example", 8883, True, "mqtts://broker.example:8883"),
        ("mqtt://192.168.1.10:1884", "192.168.1.10", 1884, False, "mqtt://192.168.1.10:1884"),
        ("mqtt://[fe80::1]:1", "fe80::1", 1, False, "mqtt://[fe80::1]:1"),
        ("MQTT://Pi.local", "pi.local", 1883, False, "mqtt://pi.local:1883"),
    ],
)
def test_an_address_has_host_port_and_encryption(text, host, port, encrypted, url):
    broker = parse_address(text)
    assert (broker.host, broker.port, broker.encrypted, broker.url) == (host, port, encrypted, url)
    assert (broker.user, broker.password) == (None, None)


@pytest.mark.parametrize(
    "text",
    [
        "", "localhost", "localhost:1883", "http://h", "mqtt://", "mqtt://:1883", "mqtt://h:0",
        "mqtt://h:99999", "mqtt://h:x", "mqtt://h/topic", "mqtt://h?x=1", "mqtt://[fe80::1",
        f"mqtt://u:{SECRET}/x@h", f"mqtt://u:{SECRET}#1@h", f"tcp://u:{SECRET}@h", "mqtt://h\x1b[2J",
    ],
)  # fmt: skip
def test_a_wrong_address_is_refused_without_showing_it(text):
    with pytest.raises(UsageError) as caught:
        parse_address(text)
    for words in caught.value.text:
        assert SECRET not in words
        assert "mqtts://broker.example" in words
    assert caught.value.__cause__ is None


def test_signs_of_a_password_that_end_the_address_are_named():
    for sign in "/?#[]":
        with pytest.raises(UsageError) as caught:
            parse_address(f"mqtt://u:{SECRET}{sign}1@host")
        for words in caught.value.text:
            assert quote(sign, safe="") in words
            assert SECRET not in words


@given(st.text(min_size=1), st.text(min_size=1))
def test_any_user_and_password_can_be_written_in_the_address(user, password):
    if any("\ud800" <= sign <= "\udfff" for sign in user + password):
        return
    broker = parse_address(f"mqtt://{quote(user, safe='')}:{quote(password, safe='')}@host")
    assert (broker.user, broker.password) == (user, password)


def test_a_password_is_in_no_repr_and_in_no_url():
    broker = parse_address(f"mqtt://u:{SECRET}@host")
    assert SECRET not in repr(broker) + str(broker) + broker.url
    assert broker.password == SECRET


def test_an_option_comes_before_the_address_before_the_environment(tmp_path):
    file = tmp_path / "pw.txt"
    file.write_text("from file\nsecond line\n", "utf-8")
    named, bare = parse_address("mqtt://u:p@h"), parse_address("mqtt://h")
    around = {USER: "env", PASSWORD: "env password"}

    def who(broker, **options):
        got = with_credentials(broker, **options)
        return got.user, got.password

    assert who(bare, environment={}) == (None, None)
    assert who(bare, environment=around) == ("env", "env password")
    assert who(named, environment=around) == ("u", "p")
    assert who(named, user="o", environment=around) == ("o", "p")
    assert who(named, password_file=file, environment=around) == ("u", "from file")
    assert who(bare, user="o", environment={}) == ("o", None)


def test_a_password_without_a_user_or_in_no_file_is_refused(tmp_path):
    bare, empty = parse_address("mqtt://h"), tmp_path / "empty"
    empty.write_text("\nnot here\n", "utf-8")
    with pytest.raises(UsageError, match="no user name"):
        with_credentials(bare, environment={PASSWORD: SECRET})
    for file in (empty, tmp_path / "none", tmp_path):
        with pytest.raises(UsageError, match=file.name):
            with_credentials(bare, user="u", password_file=file)


def test_a_password_file_of_windows_is_read_too(tmp_path):
    """Its editor puts a mark before the text, and its shell writes two bytes a character."""
    file, bare = tmp_path / "pw.txt", parse_address("mqtt://h")
    for encoding in ("utf-8", "utf-8-sig", "utf-16"):
        file.write_bytes("пароль\r\nsecond line\r\n".encode(encoding))
        assert with_credentials(bare, user="u", password_file=file).password == "пароль"
    file.write_bytes("пароль".encode("cp1251"))
    with pytest.raises(UsageError, match=r"pw\.txt.*UTF-8") as caught:
        with_credentials(bare, user="u", password_file=file)
    assert caught.value.__cause__ is None  # it would have the bytes


@pytest.mark.parametrize("word", ["\udcff", "x" * 65536, "ж" * 32768])
def test_credentials_that_mqtt_can_not_carry_are_refused_without_showing_them(word):
    """Half a character comes from an argument in another encoding."""
    bare, secret = parse_address("mqtt://h"), f"{SECRET}{word}"
    for options, environment, what in (
        ({"user": secret}, {}, "user name"),
        ({"user": "u"}, {PASSWORD: secret}, "password"),
    ):
        with pytest.raises(UsageError, match=what) as caught:
            with_credentials(bare, **options, environment=environment)
        assert SECRET not in "".join(caught.value.text)


def test_files_of_tls_have_to_fit(tmp_path):
    plain, secure = parse_address("mqtt://h"), parse_address("mqtts://h")
    wrong = tmp_path / "wrong.pem"
    wrong.write_text("no certificate", "utf-8")
    assert with_tls(plain).tls is None
    assert with_tls(secure).tls.check_hostname  # the name is verified, always
    for broker, files, words in (
        (plain, {"ca": wrong}, "mqtts://"),
        (secure, {"ca": wrong}, "no certificate"),
        (secure, {"ca": tmp_path / "none.pem"}, "none.pem"),
        (secure, {"cert": wrong}, "belong together"),
        (secure, {"cert": wrong, "key": wrong}, "private key"),
        (secure, {"cert": tmp_path / "none.pem", "key": wrong}, "none.pem"),
    ):
        with pytest.raises(UsageError, match=words):
            with_tls(broker, **files)
