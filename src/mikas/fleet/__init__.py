"""Many recordings as one dataset of Parquet files, and questions to it (docs/how-to/fleet.md).

    recordings ──► adding ──► an executor: interpreting, one file at a time ──► writing
                     └──► ledger: what was added, from which content          samples, drives …
    dataset ──► sql, report

A dataset is a folder or a URL. Its ledger says which files of it count; `sql` and `report` read
those. duckdb and fsspec are imported on use.
"""
