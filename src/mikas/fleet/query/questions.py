"""Which SQL is a question to a dataset: one statement that only reads.

duckdb's own parser decides. The type of a statement is not enough: since duckdb 2.0 a SELECT may
have a COPY, an INSERT or a DELETE in its WITH, and `query()` has SQL in a text. So the tree of the
whole statement is looked through: only the kinds listed here may be in it. The database has,
besides, no file that it could write (`database`).
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any, Final

import duckdb

_QUERIES: Final = frozenset(
    ("SELECT_NODE", "SET_OPERATION_NODE", "RECURSIVE_CTE_NODE", "CTE_NODE", "STATEMENT_NODE")
)
_FUNCTIONS: Final = frozenset((
    "range", "generate_series", "unnest", "repeat", "repeat_row", "json_each", "json_tree",
    "histogram", "histogram_values", "duckdb_columns", "duckdb_functions", "duckdb_keywords",
    "duckdb_tables", "duckdb_types", "duckdb_views", "pragma_table_info", "pragma_version",
))  # fmt: skip
"""Functions that may stand for a table: they compute, or describe the views."""
_OPTION: Final = r"(?:ANALYZE|FORMAT\s+'?\w+'?)"
_COMMENT: Final = r"(?:--[^\r\n]*\n|/\*(?:(?!/\*|\*/).)*\*/|\s)"  # that no parser takes otherwise
_EXPLAIN: Final = re.compile(
    rf"{_COMMENT}*EXPLAIN\s+(?:ANALYZE\b\s*)?(?:\(\s*{_OPTION}(?:\s*,\s*{_OPTION})*\s*\)\s*)?",
    re.IGNORECASE | re.DOTALL,
)
"""The words before the explained statement, which hide no other text. Since duckdb 2.0.1 comments
before the statement belong to it."""


def is_question(connection: duckdb.DuckDBPyConnection, sql: str) -> bool:
    """Return whether `sql` is one statement that only reads. Raises `duckdb.Error` for a mistake
    in it.
    """
    if "\0" in sql:
        return False  # some parsers end there
    statements = connection.extract_statements(sql)
    if len(statements) != 1:
        return False
    (statement,) = statements
    if statement.type == duckdb.StatementType.EXPLAIN:  # ANALYZE executes what is explained
        words = _EXPLAIN.match(text := statement.query.strip())
        return words is not None and _only_reads(connection, text[words.end() :])
    return statement.type == duckdb.StatementType.SELECT and _only_reads(connection, sql)


def _only_reads(connection: duckdb.DuckDBPyConnection, sql: str) -> bool:
    """Return whether all of `sql` is one SELECT, DESCRIBE, SUMMARIZE or SHOW."""
    asked = connection.execute("SELECT json_serialize_sql(?::VARCHAR)", [sql]).fetchone()
    try:
        tree = json.loads(asked[0] if asked else '{"error": true}')
    except RecursionError:
        raise duckdb.ParserException("Parser Error: the expression is nested too deep") from None
    statements = tree.get("statements", ())
    return not tree["error"] and len(statements) == 1 and all(map(_is_allowed, _nodes(statements)))


def _nodes(tree: object) -> Iterator[dict[str, Any]]:
    """Yield every object of a JSON tree, however deep."""
    waiting = [tree]
    while waiting:
        match waiting.pop():
            case dict() as node:
                yield node
                waiting += node.values()
            case list() as items:
                waiting += items


def _is_allowed(node: dict[str, Any]) -> bool:
    kind = str(node.get("type", ""))
    if kind == "TABLE_FUNCTION":
        function = node.get("function") or {}
        return function.get("function_name", "").casefold() in _FUNCTIONS
    return kind in _QUERIES or not kind.endswith("_NODE")
