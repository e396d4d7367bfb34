"""What the site's archive of the program holds, and that the program needs no more."""

from __future__ import annotations

import subprocess
import sys

from tools.site import licences, packages

# Not for browsers, or not needed in one.
ABSENT = ("click", "cryptography", "h11", "platformdirs", "pygments", "rich", "serial", "uvicorn",
          "websockets")  # fmt: skip
IMPORT = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {names}:
            raise ModuleNotFoundError(f"not in the site: {{name}}", name=name)

sys.meta_path.insert(0, Absent())
import mikas.dashboard.app, mikas.report.page, mikas.replay.port, mikas.link.virtual
"""


def test_the_application_needs_no_package_that_the_site_lacks():
    code = IMPORT.format(names=ABSENT)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_it_has_mikas_with_its_data_and_its_links_without_the_command_line():
    files = packages.own()
    assert {"mikas/__init__.py", "mikas/catalog/parameters.toml", "mikas/report/page.html"} <= {
        *files
    }
    assert not [name for name in files if name.startswith(("mikas/cli/", "mikas/dashboard/page/"))]
    (entries,) = (files[name] for name in files if name.endswith("entry_points.txt"))
    assert entries.decode().splitlines() == [
        "[mikas.links]",
        "sim = mikas.link.virtual:open_sim",
        "replay = mikas.replay.port:open_replay",
        "webserial = mikas.browser.web_serial:open_web_serial",
        "webusb = mikas.browser.web_serial:open_web_serial",
    ]


def test_it_has_the_packages_as_they_were_installed():
    files = packages.third_party()
    assert {"fastapi/applications.py", "pydantic/main.py", "typing_extensions.py"} <= {*files}
    assert "opentelemetry_api-" in next(name for name in files if name.endswith("METADATA"))
    assert not [name for name in files if name.endswith((".so", ".pyi", ".pyd"))]


def test_every_package_has_its_licence(tmp_path):
    for name in ("pyodide", "svelte", "uplot"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.json").write_text('{"version": "1.2.3"}')
        (tmp_path / name / "LICENSE").write_text("Permission is hereby granted")
    text = licences.text(tmp_path)
    for name in ("mikas", "Pyodide 1.2.3", "svelte 1.2.3", *packages.PURE, packages.BUILT):
        assert f"\n{name}" in f"\n{text}", name
