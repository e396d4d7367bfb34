"""The Debian package: checked by lintian, installed and removed on a copy of this computer."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess

import pytest
from tools.package.project import version

from installing.computer_rig import ROOT, built
from mikas.link.udev_rules import rules

REQUIRED = bool(os.environ.get("MIKAS_REQUIRE_LINTIAN"))
JUDGES = ("lintian", "desktop-file-validate", "appstreamcli")
needs_lintian = pytest.mark.skipif(
    not REQUIRED and not all(map(shutil.which, JUDGES)),
    reason=f"one of these is not installed: {', '.join(JUDGES)}",
)
AS_ROOT = [] if os.geteuid() == 0 else ["sudo", "--non-interactive"]
needs_root = pytest.mark.skipif(
    not REQUIRED and os.system(shlex.join([*AS_ROOT, "true"])) != 0,
    reason="mounting a copy of this computer needs root, or sudo without a password",
)
# What is written goes to memory, and is gone with the process.
COPY = """\
set -eu
mount -t tmpfs none "$1"
mkdir "$1/upper" "$1/work" "$1/copy"
mount -t overlay overlay -o "lowerdir=/,upperdir=$1/upper,workdir=$1/work" "$1/copy"
mount -t proc proc "$1/copy/proc"
mount --rbind /dev "$1/copy/dev"
ip link set lo up
cp "$2" "$1/copy/root/mikas.deb"
path=/usr/bin:/bin:/usr/sbin:/sbin
exec chroot "$1/copy" env -i PATH=$path HOME=/root LC_ALL=C.UTF-8 sh -eu -c "$3"
"""


@pytest.fixture(scope="module")
def deb():
    return built("mikas_*.deb")


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.fixture
def on_a_copy(deb, tmp_path):
    """Runs a script as root on a copy of this computer that has the package as /root/mikas.deb."""

    def run(script):
        enter = [*AS_ROOT, "unshare", "--mount", "--net"]
        command = [*enter, "sh", "-c", COPY, "sh", tmp_path, deb, script]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


def test_the_package_has_its_version_and_dependencies(deb):
    fields = dict(
        line.split(": ", 1)
        for line in output("dpkg-deb", "--field", deb).splitlines()
        if ": " in line
    )
    assert (fields["Package"], fields["Version"]) == ("mikas", version())
    assert fields["Depends"].startswith("libc6 (>= 2.")
    assert fields["Architecture"] == output("dpkg", "--print-architecture").strip()
    assert 50_000 < int(fields["Installed-Size"]) < 300_000


@needs_lintian
def test_lintian_finds_nothing(deb):
    found = subprocess.run(
        ["lintian", "--allow-root", "--fail-on=error,warning", "--tag-display-limit=0", deb],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stdout
    assert not found.stdout.strip(), found.stdout


@needs_lintian
def test_the_desktop_entry_is_valid(tmp_path, deb):
    subprocess.run(["dpkg-deb", "--extract", deb, tmp_path], check=True)
    entry = tmp_path / "usr/share/applications/mikas.desktop"
    assert not output("desktop-file-validate", "--warn-kde", entry)
    text = entry.read_text("utf-8")
    for key in ("GenericName", "Comment", "Keywords"):
        assert f"\n{key}=" in text
        assert f"\n{key}[ru]=" in text


@needs_lintian
def test_what_software_centres_show_is_valid_in_both_languages(tmp_path, deb):
    subprocess.run(["dpkg-deb", "--extract", deb, tmp_path], check=True)
    judge = ["appstreamcli", "validate-tree", "--no-net", "--pedantic", "--no-color", tmp_path]
    found = subprocess.run(judge, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
    (file,) = (tmp_path / "usr/share/metainfo").iterdir()
    text = file.read_text("utf-8")
    elements = re.findall('<(summary|p|li|caption|image)( xml:lang="ru")?>', text)
    assert elements[0::2] == [(name, "") for name, _ in elements[1::2]]
    assert all(russian for _, russian in elements[1::2])
    assert f'<release version="{version()}" ' in text
    for picture in re.findall(r"/docs/pictures/(?:en|ru)/[\w.]+", text):
        assert (ROOT / picture[1:]).is_file(), picture


@needs_root
def test_it_is_installed_works_and_is_removed(on_a_copy):
    script = """
    dpkg -i /root/mikas.deb >/dev/null
    command -v mikas
    mikas --version
    mikas read TWAT --port 'sim:?clock=simulated' >/dev/null
    cat /usr/lib/udev/rules.d/70-mikas.rules
    mikas ports --install-rules --json >/root/rules
    grep -q '"written": false' /root/rules
    grep -q '/usr/lib/udev/rules.d/70-mikas.rules' /root/rules
    test ! -e /etc/udev/rules.d/70-mikas.rules
    cd /usr/share/icons/hicolor
    for size in 16 22 24 32 48 64 128 256 512; do test -f ${size}x$size/apps/mikas.png; done
    test -f scalable/apps/mikas.svg
    grep -q 'complete .* mikas' /usr/share/bash-completion/completions/mikas
    grep -q '^#compdef mikas' /usr/share/zsh/vendor-completions/_mikas
    grep -q 'complete --command mikas' /usr/share/fish/vendor_completions.d/mikas.fish
    _MIKAS_COMPLETE=bash_complete COMP_LINE='mikas wat' mikas | grep -q 'watch'
    gunzip -c /usr/share/man/man1/mikas.1.gz | grep -q '^.SH NAME'
    gunzip -c /usr/share/man/ru/man1/mikas.1.gz | grep -q 'НАЗВАНИЕ'
    test $(ls /usr/share/man/man1/mikas*.1.gz | wc -l) -gt 40
    gunzip -c /usr/share/man/man1/mikas-mem-dump.1.gz | grep -q 'memory space'
    gunzip -c /usr/share/man/ru/man1/mikas-read.1.gz | grep -q 'прочитать'
    rm -r /root/rules /root/.[a-z]* 2>/dev/null || true
    dpkg -r mikas >/dev/null
    test ! -e /usr/bin/mikas
    dpkg -P mikas >/dev/null
    find /usr /etc /var/lib/dpkg/info -name '*mikas*'
    """
    shown = on_a_copy(script)
    first, second, rest = shown.split("\n", 2)
    assert (first, second) == ("/usr/bin/mikas", f"mikas {version()}")
    assert rest == rules()
