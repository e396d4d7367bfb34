"""SQL that would write, or read what is not of the dataset: nothing of it does."""

from __future__ import annotations

from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import duckdb
import pytest

from fleet_rig import add_here, ask, make
from mikas.errors import FleetError, UsageError
from mikas.fleet.query import database as module
from mikas.fleet.query.database import opened
from sql_attacks import READS, WRITES, attack


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("fleet")
    add_here(make(home / "in" / "drive.pcapng"), to=home / "set")
    (home / "set" / "beside.csv").write_text("a\n1\n")
    return home / "set"


def hashes(folder: Path) -> dict[str, str]:
    """The bytes of all files in a folder and below it."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {str(path): sha256(path.read_bytes()).hexdigest() for path in found}


@pytest.mark.parametrize("named", ["path", "dataset://"])
@pytest.mark.parametrize("sql", WRITES + READS)
def test_a_question_changes_and_reaches_nothing(dataset, sql, named, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (table,) = dataset.rglob("samples/*/*/*.parquet")
    place = str(table) if named == "path" else f"dataset://{table.relative_to(dataset)}"
    before = hashes(dataset)
    with opened(str(dataset)) as database:
        with pytest.raises(UsageError):
            list(database.ask(attack(sql, str(dataset), place)).rows)
        assert list(database.ask("SELECT count(*) FROM samples").rows) == [(239,)]
    assert hashes(dataset) == before
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("sql", WRITES)
def test_what_the_parser_lets_pass_finds_no_file_that_it_could_write(
    dataset, sql, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "is_question", lambda _, __: True)
    (table,) = dataset.rglob("samples/*/*/*.parquet")
    before = hashes(dataset)
    for place in (str(table), f"dataset://{table.relative_to(dataset)}"):
        with opened(str(dataset)) as database, suppress(UsageError, FleetError):
            list(database.ask(attack(sql, str(dataset), place)).rows)
    assert hashes(dataset) == before
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "sql",
    [
        "EXPLAIN (SELECT 1) UNION SELECT 2",
        "EXPLAIN (ANALYZE, FORMAT json) FROM drives",
        "EXPLAIN ANALYZE (FORMAT 'json') FROM drives",
        "EXPLAIN /* a plan */ FROM drives",
        "-- of all\nEXPLAIN FROM drives",
        "SELECT ';', 'COPY', \"car\" FROM drives -- ; COPY",
        "FROM range(3)",
        "SELECT unnest([1, 2])",
        "FROM (PIVOT statistics ON state IN ('all') USING max(median) GROUP BY channel)",
        "PIVOT statistics ON state IN ('all') USING max(median) GROUP BY channel",
        "FROM statistics UNPIVOT (value FOR name IN (low, high))",
        "WITH RECURSIVE t(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM t WHERE n < 5) FROM t",
        "WITH a AS MATERIALIZED (FROM drives) FROM a",
        "SELECT 1 UNION SELECT 2 EXCEPT SELECT 3",
        "FROM samples s ASOF JOIN statistics t ON s.utc >= t.began LIMIT 1",
        "SELECT [x + 1 FOR x IN [1, 2]], {'a': 1}.a, MAP {'a': 1}",
        "SHOW TABLES",
        "SHOW ALL TABLES",
        "FROM (DESCRIBE samples)",
        "FROM duckdb_columns()",
        "FROM information_schema.tables",
        "FROM pg_settings",
        f"SELECT {'(' * 200}1{')' * 200}",
    ],
)
def test_a_question_of_any_form_is_answered(dataset, sql) -> None:
    assert ask(dataset, sql)


def test_a_comment_before_explain_hides_no_statement(dataset) -> None:
    """Comments nest: what stands behind the inner one may still be comment, or a statement."""
    for before in ("/* a */ ", "-- a\n/* b */\n", "\n-- a /* b\n"):
        assert ask(dataset, f"{before}EXPLAIN FROM drives"), before
    for sql in (
        "/* a /* b */ EXPLAIN FROM drives -- */ */ EXPLAIN ANALYZE COPY drives TO 'out.csv'",
        "/* a /* b */ */ EXPLAIN ANALYZE DELETE FROM drives",
        "-- a\rEXPLAIN FROM drives -- \nEXPLAIN ANALYZE DELETE FROM drives",
        "-- a\nEXPLAIN ANALYZE DELETE FROM drives",
    ):
        with pytest.raises(UsageError):
            ask(dataset, sql)


def test_settings_show_no_password_of_this_computer(dataset, monkeypatch) -> None:
    monkeypatch.setenv("HTTP_PROXY", "http://me:hunter2@proxy:8080")
    monkeypatch.setenv("HOME", "/home/hunter3")
    rows = ask(dataset, "FROM pg_settings") + ask(dataset, "FROM duckdb_views()")
    rows += ask(dataset, "SELECT current_setting('http_proxy')")
    assert "hunter" not in str(rows)
    assert str(dataset) not in str(rows)


def test_a_deeply_nested_expression_is_an_error_in_words(dataset) -> None:
    for depth in (900, 3000):
        with pytest.raises(UsageError, match="SQL"):
            ask(dataset, f"SELECT {'-(' * depth}1{')' * depth}")


def test_this_duckdb_writes_from_a_select_where_nothing_prevents_it(tmp_path) -> None:
    """Why the type of a statement does not decide: if this fails, the tree may."""
    file = tmp_path / "x.parquet"
    connection = duckdb.connect()
    sql = f"WITH mine AS (COPY (SELECT 1) TO '{file}') FROM mine"
    try:
        (statement,) = connection.extract_statements(sql)
        connection.execute(sql)
    except duckdb.ParserException:
        pytest.skip("a duckdb before 2.0")
    assert statement.type == duckdb.StatementType.SELECT
    assert file.exists()
