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
    assert (status, said.splitlines()[-1]) == (0, "1268 questions, 0 wrong")
    assert "1,268 questions" in (FOLDER / "README.md").read_text("utf-8")


@pytest.mark.skipif(
    COMPILER is None and not os.environ.get("MIKAS_REQUIRE_CC"), reason="no C compiler here"
)
def test_the_codec_in_c_passes(checked, tmp_path):
    sources = [ROOT / "examples" / "c" / name for name in ("codec.c", "mikas_frames.c")]
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"]
    program = tmp_path / "codec"
    subprocess.run([COMPILER, *strict, "-o", program, *sources], check=True)
    status, said = checked(program)
    assert status == 0, said


@pytest.mark.parametrize(
    "mistake",
    [
        "unstuffed-checksum", "stuffed-always", "no-stuffing", "wrong-sum", "cuts-at-0d",
        "forgets-chunks", "hides-damage", "hides-rest", "ends",
    ],
)  # fmt: skip
def test_each_wrong_codec_is_found(checked, mistake):
    status, said = checked(*CODEC, mistake)
    assert status == 1
    assert not said.endswith(" 0 wrong\n")
    assert "asked:" in said or "The codec ended" in said


def test_a_silent_codec_is_given_up(checked, runner, monkeypatch):
    monkeypatch.setattr(runner, "PATIENCE", 0.2)
    status, said = checked(*CODEC, "hangs")
    assert (status, "silent" in said) == (1, True)


def test_a_missing_program_is_said(checked):
    assert checked("./no-such-codec")[0] == 2


@pytest.mark.parametrize("name", ["frames", "streams", "exchanges"])
def test_the_vectors_fit_their_schema(name):
    schema = json.loads((FOLDER / "schema.json").read_text("utf-8"))
    vectors = json.loads((FOLDER / f"{name}.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(vectors, {"type": "array", "items": {"$ref": f"#/$defs/{name[:-1]}"},
                                  "$defs": schema["$defs"]})  # fmt: skip
    assert "mikas" not in (FOLDER / "run.py").read_text("utf-8").replace("Mikas", "").split()
