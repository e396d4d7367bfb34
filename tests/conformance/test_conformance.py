"""`conformance/run.py`: right codecs pass, wrong ones are found; the vectors fit their schema."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from mikas.catalog import shipped

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "conformance"
CODEC = [sys.executable, str(Path(__file__).parent / "mikas_codec.py")]
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


@pytest.fixture(scope="module")
def runner():
    """The runner as a module: it is no package, and knows nothing of mikas."""
    spec = importlib.util.spec_from_file_location("conformance_run", FOLDER / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def checked(runner, capfd):
    def check(*command):
        status = runner.main([str(part) for part in command])
        return status, capfd.readouterr().out

    return check


def test_the_codec_of_mikas_passes(checked):
    status, said = checked(*CODEC)
    assert (status, said.splitlines()[-1]) == (0, "1384 questions, 0 wrong")
    assert "1,384 questions" in (FOLDER / "README.md").read_text("utf-8")


@pytest.mark.skipif(
    COMPILER is None and not os.environ.get("MIKAS_REQUIRE_CC"), reason="no C compiler here"
)
def test_the_codec_in_c_passes(checked, tmp_path):
    sources = sorted((ROOT / "examples" / "c").glob("*.c"))
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"]
    program = tmp_path / "codec"
    subprocess.run([COMPILER, *strict, "-o", program, *sources], check=True)
    status, said = checked(program)
    assert status == 0, said
    assert "values" not in said


@pytest.mark.parametrize(
    "mistake",
    [
        "unstuffed-checksum", "stuffed-always", "no-stuffing", "wrong-sum", "cuts-at-0d",
        "forgets-chunks", "hides-damage", "hides-rest", "ends", "short-buffer",
        "hides-waiting-0d", "escapes-again", "high-byte-first", "decimal-mask", "literal",
    ],
)  # fmt: skip
def test_each_wrong_codec_is_found(checked, mistake):
    status, said = checked(*CODEC, mistake)
    assert status == 1
    assert not said.endswith(" 0 wrong\n")
    assert "asked:" in said or "The codec ended" in said
    assert max(len(line) for line in said.splitlines()) < 400


def test_a_codec_of_messages_alone_passes_and_that_is_said(checked):
    status, said = checked(*CODEC, "messages-alone")
    assert (status, said.splitlines()) == (
        0, ["The codec gives no values: not checked", "1324 questions, 0 wrong"]
    )  # fmt: skip


def test_the_values_are_of_every_parameter_of_section_4():
    vectors = json.loads((FOLDER / "values.json").read_text("utf-8"))
    known = {each.name: each.code for each in shipped().parameters if each.source == "§4"}
    assert {each["parameter"]: int(each["code"], 16) for each in vectors} == known


def test_a_silent_codec_is_given_up(checked, runner, monkeypatch):
    monkeypatch.setattr(runner, "PATIENCE", 0.2)
    status, said = checked(*CODEC, "hangs")
    assert (status, "silent" in said) == (1, True)


def test_a_missing_program_is_said(checked):
    assert checked("./no-such-codec")[0] == 2


@pytest.mark.parametrize("name", ["frames", "streams", "exchanges", "values"])
def test_the_vectors_fit_their_schema(name):
    schema = json.loads((FOLDER / "schema.json").read_text("utf-8"))
    vectors = json.loads((FOLDER / f"{name}.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(vectors, {"type": "array", "items": {"$ref": f"#/$defs/{name[:-1]}"},
                                  "$defs": schema["$defs"]})  # fmt: skip
    assert "mikas" not in (FOLDER / "run.py").read_text("utf-8").replace("Mikas", "").split()
