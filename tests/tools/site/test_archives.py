"""Archives of the site: the same bytes for the same contents, and nothing lost in them."""

from __future__ import annotations

import gzip

from hypothesis import given
from hypothesis import strategies as st
from tools.site.archives import compressed, files_of, sizes_of, zip_of

names = st.lists(st.text("abc_", min_size=1, max_size=4), min_size=1, max_size=3).map("/".join)
contents = st.dictionaries(names, st.binary(max_size=200), max_size=6)


@given(contents, st.randoms())
def test_an_archive_depends_on_its_contents_alone(files, random):
    shuffled = list(files.items())
    random.shuffle(shuffled)
    archive = zip_of(files)
    assert zip_of(dict(shuffled)) == archive
    assert files_of(archive) == files


@given(st.binary(max_size=500))
def test_what_is_compressed_holds_no_time(content):
    assert compressed(content) == compressed(content)
    assert compressed(content)[4:8] == bytes(4)
    assert gzip.decompress(compressed(content)) == content
    assert sizes_of(content)["compressed"] <= sizes_of(content)["bytes"] == len(content)
