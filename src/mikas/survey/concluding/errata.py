"""Conclusions on the source's errata E1–E4 and on VALF, by raw bytes and a person's instruments."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from mikas.survey.concluding.conclusion import (
    Conclusion,
    found,
    is_open,
    ru,
    unmeasured,
)
from mikas.survey.steps.codes import known_sizes
from mikas.survey.steps.engine import RUNNING
from mikas.survey.steps.step import CarState, Measured

_CRANKING = (80.0, 450.0)  # rpm that a starter turns an engine with
_BY_HAND = 0.25  # of a speed that was timed by hand
_TURNS_A_PUFF = 0.5  # of an engine with four cylinders
_DIAL = 0.15  # of the tachometer's figure: what a dial and a needle are worth
_VOLTS = 0.35  # V between a voltmeter at the battery and the unit's own measurement
_NEUTRAL = range(108, 149)  # raw bytes near 128: a factor that corrects little
_STEP = 40  # rpm (E1)
_WITNESSES = ("3F", "21")  # INJ, JAIR: both zero at idle, the unit controls the ignition alone
_TWELVE_VOLTS = 0x80  # from here on a signed byte is negative (E2)


def freq(measured: Measured) -> Conclusion:
    """Conclude on E1: by the starter's speed, also timed by hand, and by the tachometer."""
    turning = [
        int(data["29"], 16)
        for _, data in measured.get("cranking", ())
        if len(data.get("29", "")) == 2
    ]
    cranked = [raw for raw in turning if 0 < raw * _STEP < RUNNING]
    dial = measured.get("tachometer") or {}
    raw, shown = _middle(dial.get("raw", ())), dial.get("shown")
    en, russian = [], []
    fits: list[bool] = []
    if cranked:
        speed = median(cranked) * _STEP
        fits.append(_CRANKING[0] <= speed <= _CRANKING[1])
        en.append(f"{speed:.0f} rpm while the starter turned")
        russian.append(f"{speed:.0f} об/мин при работе стартёра")
    puffs = (measured.get("starter") or {}).get("puffs")
    by_hand = None if puffs is None else round(puffs * _TURNS_A_PUFF * 60)
    if cranked and by_hand is not None:
        fits.append(abs(speed - by_hand) <= max(_STEP, _BY_HAND * by_hand))
        en.append(f"{by_hand} rpm of it timed by hand")
        russian.append(f"вручную насчитано {by_hand} об/мин")
    if shown is not None and raw is not None:
        fits.append(abs(raw * _STEP - shown) <= _DIAL * shown)
        en.append(f"{raw * _STEP:.0f} rpm where the tachometer shows {shown:.0f}")
        russian.append(f"{raw * _STEP:.0f} об/мин при {shown:.0f} на тахометре")
    value = {
        "cranking": cranked,
        "by_hand": by_hand,
        "tachometer": shown,
        "raw": raw,
        "unit": "min-1" if fits else None,
    }
    if not fits:
        return unmeasured(measured, CarState.STARTING)
    if not all(fits):
        return is_open(
            f"b · 40 min⁻¹ does not fit: {'; '.join(en)}",
            f"b · 40 мин⁻¹ не подходит: {'; '.join(russian)}",
            value | {"unit": None},
        )
    return found(
        value, f"b · 40 is in min⁻¹: {'; '.join(en)}", f"b · 40 — это мин⁻¹: {'; '.join(russian)}"
    )


def uacc_sign(measured: Measured) -> Conclusion:
    """Conclude on E2's sign: a running engine charges with more than a signed byte can hold."""
    raws = [
        int(raw, 16)
        for each in measured.get("samples", {}).values()
        for raw in each.get("1E", ())
        if len(raw) == 2
    ]
    if not raws:
        return unmeasured(measured, CarState.STANDING)
    if max(raws) >= _TWELVE_VOLTS:
        return found(
            {"signed": False, "highest": max(raws)},
            f"unsigned: raw {max(raws):02X} was seen, negative volts if signed",
            f"без знака: встретился байт {max(raws):02X}, со знаком это минус",
        )
    return is_open(
        f"raw {max(raws):02X} was the highest; below 80 both are alike: above 12.8 V they differ",
        f"выше {max(raws):02X} не было, до 80 оба чтения одинаковы: нужна зарядка выше 12,8 В",
        {"signed": None, "highest": max(raws)},
    )


def uacc_scale(measured: Measured) -> Conclusion:
    """Conclude on E2's formula: b/10, or the siblings' 5.2 + b/20, by a voltmeter."""
    figures = measured.get("voltage")
    raw = _middle(figures["raw"]) if figures else None
    if not figures or raw is None:
        return unmeasured(measured, CarState.STANDING)
    meter = figures["meter"]
    readings = {"b/10": raw / 10, "5.2+b/20": 5.2 + raw / 20}
    value = {"raw": raw, "meter": meter, "formula": None}
    listed = ", ".join(f"{name}: {volts:.1f}" for name, volts in readings.items())
    if meter is None:
        return is_open(
            f"no voltmeter's figure was given ({listed} V)",
            f"показание вольтметра не введено ({ru(listed)} В)",
            value,
        )
    near = [name for name, volts in readings.items() if abs(volts - meter) <= _VOLTS]
    if len(near) != 1:
        return is_open(
            f"{meter:g} V decides for none or for both: {listed} V",
            f"{ru(f'{meter:g}')} В не подходит ни к одному или подходит к обоим: {ru(listed)} В",
            value,
        )
    return found(
        value | {"formula": near[0]},
        f"{near[0]}: voltmeter {meter:g} V, {listed} V",
        f"{ru(near[0])}: вольтметр {ru(f'{meter:g}')} В, {ru(listed)} В",
    )


def fuel_factors(measured: Measured) -> Conclusion:
    """Conclude on E3: the raw bytes of RCOK and RCOD at warm idle, and which reading they fit."""
    factors = measured.get("factors")
    if factors is None:
        return unmeasured(measured, CarState.WARM)
    raws = {code: _middle(factors.get(code, ())) for code in ("42", "41")}
    known = {code: raw for code, raw in raws.items() if raw is not None}
    if not known:
        return is_open(
            "the unit has neither RCOK (42) nor RCOD (41)",
            "у блока нет ни RCOK (42), ни RCOD (41)",
        )
    if _controls_ignition_alone(measured):
        return _DEAD
    value, en, russian = {}, [], []
    for code, raw in known.items():
        letter, other = (raw - 128) / 256 - 0.5, (raw - 128) / 256
        value[code] = {"raw": raw, "neutral": raw in _NEUTRAL}
        name = {"42": "RCOK", "41": "RCOD"}[code]
        family = f", family {(raw + 128) / 256:.3f}" if code == "42" else ""
        text = f"{name} {raw:02X}: letter {letter:.3f}, alternative {other:.3f}{family}"
        en.append(text)
        words = text.replace("letter", "буквально").replace("alternative", "иначе")
        russian.append(ru(words.replace("family", "как у родственных")))
    if all(each["neutral"] for each in value.values()):
        return found(
            value,
            f"near 128 when little is corrected, against the letter: {'; '.join(en)}",
            f"около 128, когда поправка мала, — против буквы: {'; '.join(russian)}",
        )
    return is_open(
        f"not near 128, so several readings stay possible: {'; '.join(en)}",
        f"не около 128, возможны разные чтения: {'; '.join(russian)}",
        value,
    )


def tair(measured: Measured) -> Conclusion:
    """Conclude on E4: the size of TAIR's datum."""
    if "codes" not in measured:
        return unmeasured(measured, CarState.STANDING)
    size = known_sizes(measured).get(0x1C)
    if size is None:
        return is_open("the unit has no TAIR (1C)", "у блока нет TAIR (1C)")
    return found(size, f"bytes of TAIR (1C): {size}", f"байтов в TAIR (1C): {size}")


def valf(measured: Measured) -> Conclusion:
    """Conclude on VALF: at warm idle λ is near 1 if 0.5 + b/256 is it."""
    factors = measured.get("factors")
    if factors is None:
        return unmeasured(measured, CarState.WARM)
    raw = _middle(factors.get("39", ()))
    if raw is None:
        return is_open("the unit has no VALF (39)", "у блока нет VALF (39)")
    if _controls_ignition_alone(measured):
        return _DEAD
    value = 0.5 + raw / 256
    texts = (
        f"raw {raw:02X}, {value:.3f} by §4",
        f"байт {raw:02X}, по §4 {ru(f'{value:.3f}')}",
    )
    if 0.85 <= value <= 1.15:
        return found(
            {"raw": raw, "value": round(value, 3)},
            f"{texts[0]}: λ at warm idle",
            f"{texts[1]}: λ прогретого холостого хода",
        )
    return is_open(
        f"{texts[0]}: no λ of a warm idle; a λ meter decides",
        f"{texts[1]}: не похоже на λ прогретого холостого хода; решит λ-метр",
        {"raw": raw, "value": round(value, 3)},
    )


def _controls_ignition_alone(measured: Measured) -> bool:
    """Whether injection and air flow are zero at idle: bytes of the mixture mean nothing then."""
    samples = measured.get("samples", {})
    states = [samples.get(state.value, {}) for state in (CarState.IDLE, CarState.WARM)]
    raws = [raw for each in states for code in _WITNESSES for raw in each.get(code, ())]
    return bool(raws) and not any(int(raw, 16) for raw in raws)


_DEAD = is_open(
    "injection and air flow are zero while the engine runs: the unit controls the ignition alone, "
    "and its bytes of the mixture mean nothing",
    "впрыск и расход воздуха на работающем двигателе нулевые: блок управляет только зажиганием, "
    "его байты смеси ничего не значат",
)


def _middle(raws: Sequence[str]) -> int | None:
    numbers = sorted(int(raw, 16) for raw in raws if len(raw) == 2)
    return numbers[len(numbers) // 2] if numbers else None
