"""The page of the causes: those that are known, and the features that they move."""

from __future__ import annotations

from mikas.catalog import Catalog, Confidence
from mikas.causes.features.words import feature_texts
from mikas.causes.knowledge import COMPLAINTS, HandTest, KnownCause, load
from mikas.i18n import Language, Text
from tools.docs.generated.tables import CONFIDENCE, code, page, table

_SEEN = {
    "start": Text("a start", "пуск"),
    "cold-start": Text("a cold start", "пуск холодного двигателя"),
    "cold-idle": Text("cold idle", "ХХ непрогретого двигателя"),
    "idle": Text("warm idle", "ХХ прогретого двигателя"),
    "drive": Text("a drive", "движение"),
    "pull": Text("full load", "полная нагрузка"),
    "long-drive": Text("a long warm drive", "долгая езда на прогретом двигателе"),
}


def causes(_: Catalog, language: Language) -> str:
    """Return the page of the causes."""
    known = sorted(load().causes.values(), key=lambda each: each.name)
    return page(
        "causes",
        language,
        complaints=table(
            language,
            ("word|complaint", "слово|жалоба"),
            ((code(each), words.to(language)) for each, words in COMPLAINTS.items()),
        ),
        causes=table(
            language,
            ("id|cause|looks like|confidence", "id|причина|похоже на|достоверность"),
            (_cause(each, language) for each in known),
        ),
        apart=table(
            language,
            ("cause|or|what to do|the cause|the other", "причина|или|что сделать|эта|другая"),
            (
                (code(each.name), code(other), *(it.to(language) for it in _texts(test)))
                for each in known
                if each.name == _first_of(each.id, known)
                for other, test in each.apart.items()
            ),
        ),
        features=table(
            language,
            ("name|what it is|unit|seen in", "имя|что это|единица|когда виден"),
            (
                (
                    code(name),
                    words.text.to(language),
                    words.unit.to(language),
                    _SEEN[words.seen].to(language),
                )
                for name, words in feature_texts().items()
            ),
        ),
    )


def _first_of(identity: str, known: list[KnownCause]) -> str:
    """Return the first direction of a cause: all have the same tests by hand."""
    return next(each.name for each in known if each.id == identity)


def _texts(test: HandTest) -> tuple[Text, Text, Text]:
    return test.do, test.this, test.other


def _cause(cause: KnownCause, language: Language) -> tuple[str, ...]:
    like = ", ".join(code(each) for each in cause.looks_like)
    sure = CONFIDENCE[Confidence(cause.confidence)]
    return code(cause.id), cause.text.to(language), like, sure.to(language)
