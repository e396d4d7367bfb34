"""requirements/: every package is locked with hashes, and no least version has a known advisory."""

import json
import re
import sys
import tomllib
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parent.parent
HERE = ROOT / "requirements"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
ADVISORIES = tomllib.loads((HERE / "advisories.toml").read_text(encoding="utf-8"))["advisory"]
FIXED = {known["package"]: Version(known["fixed"]) for known in ADVISORIES}


def declared() -> dict[str, list[Requirement]]:
    """Requirements by package, of the project, its extras and all groups."""
    texts = list(PROJECT["project"]["dependencies"])
    for group in (PROJECT["project"]["optional-dependencies"], PROJECT["dependency-groups"]):
        texts += [text for texts in group.values() for text in texts]
    texts += PROJECT["build-system"]["requires"]
    found: dict[str, list[Requirement]] = {}
    for requirement in map(Requirement, texts):
        if requirement.name != "mikas":
            found.setdefault(canonicalize_name(requirement.name), []).append(requirement)
    return found


def locked() -> dict[str, list[Version]]:
    """Versions by package: several where they depend on Python or on the system."""
    text = (HERE / "lock.txt").read_text(encoding="utf-8").replace("\\\n", "")
    found: dict[str, list[Version]] = {}
    for line in text.splitlines():
        if line and not line.startswith((" ", "#")):
            assert re.search(r" --hash=sha256:[0-9a-f]{64}\b", line), line
            requirement = Requirement(line.split(" --hash")[0])
            (pin,) = requirement.specifier
            assert pin.operator == "==", line
            found.setdefault(requirement.name, []).append(Version(pin.version))
    return found


def test_the_lock_has_every_declared_package_in_its_range():
    versions = locked()
    for name, requirements in declared().items():
        for requirement in requirements:
            assert all(requirement.specifier.contains(v) for v in versions[name]), requirement


def test_the_lock_names_no_server():
    assert "://" not in (HERE / "lock.txt").read_text(encoding="utf-8")


def test_no_locked_version_has_a_known_advisory():
    versions = locked()
    for name, fixed in FIXED.items():
        assert all(version >= fixed for version in versions[name]), name


def test_no_least_version_has_a_known_advisory():
    for name, requirements in declared().items():
        for requirement in requirements:
            least = [Version(s.version) for s in requirement.specifier if s.operator == ">="]
            assert least or not requirement.specifier, requirement
            if name in FIXED and least:
                assert max(least) >= FIXED[name], requirement


def test_what_a_user_installs_has_a_least_version():
    users = [*PROJECT["project"]["dependencies"]]
    users += [t for ts in PROJECT["project"]["optional-dependencies"].values() for t in ts]
    for requirement in map(Requirement, users):
        assert requirement.name == "mikas" or requirement.specifier, requirement


def program(name):
    spec = spec_from_file_location(name, HERE / f"{name}.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def audit():
    return program("audit")


def test_packages_with_another_version_than_the_lock_are_listed():
    lock = "click==8.1 \\\n    --hash=sha256:0\nnumpy==1.0 ; a\nnumpy==2.0 ; b\n"
    installed = {"click": "8.2", "numpy": "2.0", "other": "3", "mikas": "1"}
    found = list(program("differences").differences(lock, installed))
    assert found == ["click 8.1 -> 8.2", "other 3 (new)"]


@pytest.mark.parametrize("more", [[], ["--pre"]])
def test_the_newest_releases_are_installed_without_the_lock(monkeypatch, more):
    install, commands = program("install"), []

    def called(command, **_):
        commands.append(command)
        return CompletedProcess(command, 0)

    monkeypatch.setattr(install.subprocess, "run", called)
    assert install.main(["mikas", "extras", "test"]) == 0
    assert install.main(["--newest", *more, "mikas", "extras", "test"]) == 0
    _, locked, _, _, newest, project = commands
    assert str(HERE / "lock.txt") in locked
    assert str(HERE / "lock.txt") not in newest
    assert "--upgrade" in newest
    assert ("--pre" in newest) == bool(more)
    assert "--group=test" in newest
    assert project[-2:] == ["--editable", "."]


NPM_CLEAN = json.dumps({"vulnerabilities": {}})
PIP_CLEAN = json.dumps({"dependencies": [{"name": "click", "version": "9", "vulns": []}]})


def outputs(pip: str, npm: str):
    return lambda command: pip if command[0] == sys.executable else npm


SKIPPED = '{"dependencies": [{"name": "a", "skip_reason": "b"}]}'


@pytest.mark.parametrize("nothing", ["", "no JSON", "[]", '{"message": "405"}', SKIPPED])
def test_audit_says_when_nothing_was_audited(audit, capsys, nothing):
    assert audit.main(outputs(nothing, nothing)) == 0
    shown = capsys.readouterr().out
    assert shown.count("can't be reached. Last look by hand: 20") == 2


def test_audit_passes_clean_packages(audit, capsys):
    assert audit.main(outputs(PIP_CLEAN, NPM_CLEAN)) == 0
    assert capsys.readouterr().out == "pip-audit: no known advisory\nnpm audit: no known advisory\n"


def test_audit_fails_on_an_advisory(audit, capsys):
    known = {"id": "CVE-1", "fix_versions": ["10"]}
    found = {"dependencies": [{"name": "click", "version": "9", "vulns": [known]},
                              {"name": "b", "skip_reason": "c"}]}  # fmt: skip
    assert audit.main(outputs(json.dumps(found), NPM_CLEAN)) == 1
    assert "click 9: CVE-1, fixed in 10\nb: not audited\n" in capsys.readouterr().err
    vite = json.dumps({"vulnerabilities": {"vite": {"severity": "high", "range": "<9"}}})
    assert audit.main(outputs(PIP_CLEAN, vite)) == 1
    assert "vite: high, <9\n" in capsys.readouterr().err
