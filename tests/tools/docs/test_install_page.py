"""The page on installing lists the packages of pyproject.toml, with their measured megabytes."""

from __future__ import annotations

import pytest
from tools.docs.generated import install_page
from tools.docs.generated.install_page import CLIENT, USES, install, sizes
from tools.docs.pages import LANGUAGES
from tools.package.sizes import closure, dependencies, size_of

from mikas.catalog import shipped


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_package_and_the_sums_are_on_the_page(language):
    page, found = install(shipped(), language), sizes()
    for name in dependencies():
        assert f"| `{name}` | {USES[name].to(language)} |" in page
    between = {"en": "MB, with all exports", "ru": "МБ, со всеми форматами экспорта"}[language]
    assert f"{found.total} {between} {found.with_exports} " in page


def test_the_list_is_that_of_pyproject():
    assert sorted(USES) == sorted(sizes().packages) == dependencies()
    assert set(CLIENT) < set(dependencies())
    assert {"asammdf", "duckdb"} == set(dependencies("export")) - set(dependencies())
    assert {"fsspec", "duckdb"} <= set(dependencies("fleet"))


def test_a_dependency_that_was_not_measured_is_an_error(monkeypatch):
    monkeypatch.setattr(install_page, "dependencies", lambda: ["click", "pandas"])
    with pytest.raises(ValueError, match=r"python -m tools\.package\.sizes"):
        sizes()


def test_the_figures_are_near_what_is_installed_here():
    found = sizes()
    assert closure(["fastapi"]) > {"fastapi", "starlette", "pydantic", "pydantic-core"}
    here = sum(map(size_of, closure(dependencies()))) / 1_000_000 + found.mikas
    assert here == pytest.approx(found.total, rel=0.25)
