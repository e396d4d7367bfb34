"""These tests are of what `make package` has built, and are collected by it alone."""

import os

collect_ignore_glob = [] if os.environ.get("MIKAS_REQUIRE_PACKAGE") else ["test_*"]
