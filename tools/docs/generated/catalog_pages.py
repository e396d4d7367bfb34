"""The shipped catalog as pages: parameters, faults, derived channels, models, errata."""

from __future__ import annotations

from mikas.catalog import (
    AlarmLimits,
    Catalog,
    Derived,
    Erratum,
    Fault,
    Level,
    Model,
    Parameter,
)
from mikas.i18n import Language, Text
from tools.docs.generated.tables import CONFIDENCE, cited, code, interval, number, page, table

_LEVELS = {
    Level.WARNING: Text("warning", "предупреждение"),
    Level.DANGER: Text("danger", "опасно"),
}


def parameters(catalog: Catalog, language: Language) -> str:
    """Return the page of the parameters, with errata and models."""
    every = catalog.parameters
    return page(
        "parameters",
        language,
        wire=table(
            language,
            (
                "code|name|meaning|bytes|value|unit|the bytes can hold|errata|source",
                "код|имя|что это|байт|значение|единица|в байты помещается|сомнительно|источник",
            ),
            (_on_the_wire(each, language) for each in every),
        ),
        values=table(
            language,
            ("name|unit|plausible|warm idle|alarm", "имя|единица|правдоподобно|тёплый ХХ|тревога"),
            (_values(each, language) for each in every if not each.is_flag),
        ),
        flags=table(
            language,
            ("name|while it is set|while it is not", "имя|установлен|не установлен"),
            (
                (code(each.name), lamp.on.to(language), lamp.off.to(language))
                for each in every
                if (lamp := each.lamp)
            ),
        ),
        meanings=table(
            language,
            ("name|too low|too high", "имя|ниже|выше"),
            (
                (code(each.name), meaning.low.to(language), meaning.high.to(language))
                for each in every
                if (meaning := each.meaning)
            ),
        ),
        errata=table(
            language,
            ("|what|why|taken|otherwise|chosen by", "|о чём|почему|принято|иначе|выбирается"),
            (_erratum(each, language) for each in catalog.errata.values()),
        ),
        models=table(
            language,
            ("answer|model|confidence", "ответ|модель|достоверность"),
            (
                (code(f"{each.code:02X}"), each.text.to(language), _sure(each, language))
                for each in catalog.models.values()
            ),
        ),
    )


def faults(catalog: Catalog, language: Language) -> str:
    """Return the page of the faults."""
    headers = (
        "number|fault|confidence|check first|look at",
        "код|неисправность|достоверность|что проверить сначала|смотреть",
    )
    rows = (_fault(each, language) for _, each in sorted(catalog.faults.items()))
    return page("faults", language, faults=table(language, headers, rows))


def channels(catalog: Catalog, language: Language) -> str:
    """Return the page of the derived channels."""
    headers = (
        "name|meaning|formula|with|unit|confidence",
        "имя|что это|формула|где|единица|достоверность",
    )
    rows = (_channel(each, language) for each in catalog.derived.values())
    return page("channels", language, channels=table(language, headers, rows))


def _sure(entry: Parameter | Fault | Derived | Model, language: Language) -> str:
    return CONFIDENCE[entry.confidence].to(language)


def _erratum(erratum: Erratum, language: Language) -> tuple[str, ...]:
    otherwise, chosen = erratum.alternative.to(language), code(erratum.selected_by)
    if third := erratum.family.to(language):
        otherwise, chosen = f"{otherwise} {third}", f"{chosen}, {code('family')}"
    texts = (erratum.title, erratum.reason, erratum.default)
    return (f"**{cited(erratum.name)}**", *(each.to(language) for each in texts), otherwise, chosen)


def _on_the_wire(parameter: Parameter, language: Language) -> tuple[str, ...]:
    corrected = parameter.conversion
    formulas = [code(corrected.formula)]
    for name, each in parameter.interpretations.items():
        if (each.formula, each.unit) != (corrected.formula, corrected.unit):
            unit = f" {each.unit_text.to(language)}" if each.unit != corrected.unit else ""
            formulas.append(f"{name}: {code(each.formula)}{unit}")
    return (
        code(f"{parameter.code:02X}"),
        code(parameter.name),
        parameter.text.to(language),
        str(parameter.size),
        "; ".join(formulas),
        parameter.unit_text.to(language),
        interval(parameter.limits(), language),
        " ".join(map(cited, parameter.errata)),
        f"{cited(parameter.source)}, {_sure(parameter, language)}",
    )


def _values(parameter: Parameter, language: Language) -> tuple[str, ...]:
    reference = interval(parameter.reference, language)
    if reference:
        reference += f" ({CONFIDENCE[parameter.reference_confidence].to(language)})"
    return (
        code(parameter.name),
        parameter.unit_text.to(language),
        interval(parameter.plausible, language),
        reference,
        _alarm(parameter.alarm_limits, language),
    )


def _alarm(limits: AlarmLimits | None, language: Language) -> str:
    if limits is None:
        return ""
    said = [f"< {number(at, language)}: {_LEVELS[level].to(language)}" for level, at in limits.lows]
    said += [
        f"> {number(at, language)}: {_LEVELS[level].to(language)}" for level, at in limits.highs
    ]
    return "; ".join(said)


def _fault(fault: Fault, language: Language) -> tuple[str, ...]:
    return (
        f"**{fault.code}**",
        fault.text.to(language),
        _sure(fault, language) + (f" ({' '.join(fault.sources)})" if fault.sources else ""),
        fault.check.to(language),
        " ".join(map(code, fault.parameters)),
    )


def _channel(channel: Derived, language: Language) -> tuple[str, ...]:
    constants = (f"{name} = {number(value, language)}" for name, value in channel.constants)
    every_second = Text(" (summed each second)", " (сумма по секундам)")
    return (
        code(channel.name),
        channel.text.to(language),
        code(channel.formula) + (every_second.to(language) if channel.accumulates else ""),
        "; ".join(constants),
        channel.unit_text.to(language) or channel.unit,
        _sure(channel, language),
    )
