"""Datasets that a stranger has made, before `mikas fleet add`, `report` and `sql`."""
