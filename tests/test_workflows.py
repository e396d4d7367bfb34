"""The hosted workflows can't run here: what they call must be there, their rights must be few."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import yaml
from tools.package.notes import notes
from tools.package.project import Failed, check_tag, version

ROOT = Path(__file__).parent.parent
FILES = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")
# Whoever owns an action can move its tags; a commit's hash is its content.
PINNED = re.compile(r"uses: ([\w-]+/[\w./-]+)@([0-9a-f]{40}) # v\d+\.\d+\.\d+")


def workflow(name):
    text = (ROOT / ".github" / "workflows" / name).read_text("utf-8")
    return yaml.safe_load(text.replace("\non:", "\n'on':", 1))  # for YAML 1.1, `on` is a truth


def steps(file):
    for job in workflow(file.name)["jobs"].values():
        yield from job.get("steps", [])


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_each_need_is_a_job_and_each_step_an_action_or_a_command(file):
    jobs = workflow(file.name)["jobs"]
    for job in jobs.values():
        needed = job.get("needs", [])
        assert set([needed] if isinstance(needed, str) else needed) <= set(jobs)
        assert "uses" in job or job["timeout-minutes"]
        if "uses" in job:
            assert (ROOT / job["uses"]).is_file()
    for step in steps(file):
        assert ("uses" in step) != ("run" in step)


def test_each_action_is_pinned_by_a_commit_with_its_tag_beside_it():
    found: dict[str, set[str]] = {}
    for file in FILES:
        lines = [line.strip().removeprefix("- ") for line in file.read_text("utf-8").splitlines()]
        for line in (line for line in lines if line.startswith("uses:")):
            if line.startswith("uses: ./"):
                continue
            pinned = PINNED.fullmatch(line)
            assert pinned, f"{file.name}: {line}"
            found.setdefault(pinned[1], set()).add(pinned[2])
        assert sum("uses" in step for step in steps(file)) == sum(
            PINNED.fullmatch(line) is not None for line in lines
        )
    assert {action for action, commits in found.items() if len(commits) > 1} == set()


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_no_checkout_leaves_a_token_behind_for_what_runs_after_it(file):
    for step in steps(file):
        if step.get("uses", "").startswith("actions/checkout@"):
            assert step["with"]["persist-credentials"] is False, step


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_workflow_may_read_only_unless_a_job_says_more(file):
    assert workflow(file.name)["permissions"] == {"contents": "read"}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_each_command_of_a_workflow_exists(file):
    for line in (line for step in steps(file) for line in step.get("run", "").splitlines()):
        words = shlex.split(line.replace("&&", " && "))
        if words[:1] == ["make"]:
            assert f"\n{words[1]}:" in MAKEFILE, line
        elif words and words[0].endswith("python") and words[1] == "-m" and words[2] != "pytest":
            module = ROOT.joinpath(*words[2].split("."))
            assert module.is_dir() or module.with_suffix(".py").is_file(), line
            if words[2] == "tools.package":
                assert re.search(rf"^{words[3]}\b", package_help(), re.MULTILINE), line
        elif words and words[0].endswith("python"):
            assert words[1:2] == ["-m"] or (ROOT / words[1]).is_file(), line
        elif words and words[0].startswith("."):
            assert (ROOT / words[0]).is_file(), line


def package_help():
    return (ROOT / "tools" / "package" / "__main__.py").read_text("utf-8").split('"""')[1]


def test_a_release_comes_of_a_tag_after_all_tests():
    release = workflow("release.yml")
    assert release["on"]["push"] == {"tags": ["v*"]}
    assert release["permissions"] == {"contents": "read"}
    rights = {
        name: job["permissions"] for name, job in release["jobs"].items() if "permissions" in job
    }
    assert rights == {
        "release": {"contents": "write", "id-token": "write", "attestations": "write"},
        "pypi": {"id-token": "write"},
        "pages": {"pages": "write", "id-token": "write"},
    }
    for name in rights:
        job = release["jobs"][name]
        assert job["if"] == "github.event_name == 'push'"  # never by hand, not even at a tag
        assert name == "release" or "release" in job["needs"]
    assert set(release["jobs"]["release"]["needs"]) == {"tests", "packages", "programs"}
    assert "workflow_call" in workflow("ci.yml")["on"]
    assert release["jobs"]["pypi"]["environment"]["name"] == "pypi"


def test_the_newest_packages_are_tried_each_week_and_a_failure_is_written_down():
    newest = workflow("newest.yml")
    assert newest["on"]["schedule"]
    tests, issue = newest["jobs"]["tests"], newest["jobs"]["issue"]
    assert tests["steps"][-1]["run"] == "make unlocked PRE=${{ matrix.pre }}"
    assert "permissions" not in tests
    assert issue["permissions"] == {"issues": "write"}
    assert (issue["needs"], issue["if"]) == ("tests", "failure()")
    assert not [it for it in issue["steps"] if "uses" in it]  # no foreign code beside its token


def test_a_job_that_has_failed_can_be_run_again():
    """What an earlier attempt has uploaded is still there: it is replaced, or has another name."""
    for file in FILES:
        for step in steps(file):
            action, given = step.get("uses", "").partition("@")[0], step.get("with", {})
            if action == "actions/upload-artifact":
                assert given["overwrite"] is True, step
            elif action == "actions/upload-pages-artifact":
                assert "github.run_attempt" in given["name"], step
    jobs = workflow("release.yml")["jobs"]
    name = jobs["packages"]["outputs"]["pages"]
    assert name in [step.get("with", {}).get("name") for step in jobs["packages"]["steps"]]
    (deploy,) = jobs["pages"]["steps"]
    assert "packages" in jobs["pages"]["needs"]
    assert deploy["with"]["artifact_name"] == "${{ needs.packages.outputs.pages }}"


def test_the_tag_is_that_of_the_version():
    check_tag(f"v{version()}")
    for tag in ("v9.9.9", version(), ""):
        with pytest.raises(Failed, match=re.escape(version())):
            check_tag(tag)


def test_the_notes_are_those_of_the_version(monkeypatch):
    assert notes().startswith("The first version: ")
    assert "## [" not in notes()
    monkeypatch.setattr("tools.package.notes.version", lambda: "9.9.9")
    with pytest.raises(Failed, match=r"towncrier build --version 9\.9\.9"):
        notes()


def test_the_citation_is_of_this_version_on_its_day():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert cited["version"] == version()
    released = f"## [{version()}] – {cited['date-released']}"
    assert released in (ROOT / "CHANGELOG.md").read_text("utf-8")
