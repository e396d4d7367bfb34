"""A walker of the layouts in `mikas.dissectors.tables`: what a decoder outside Python has to do.

It takes the plain form of the tables only, so all that it needs is in the data.
"""

from __future__ import annotations

REFUSAL = b"\x01"
ONE_BYTE = ("count", "value", "code", "model", "result")


class Walker:
    def __init__(self, tables, interpretation="corrected"):
        self.tables = tables
        self.interpretation = interpretation
        self.parameters = {}
        for row in tables["parameters"]:
            self.parameters.setdefault(row["code"], []).append(row)

    def request(self, body):
        """Return the fields of a request, or None if it is none."""
        row = self.tables["commands"].get(body[0]) if body else None
        if row is None:
            return None
        found = self._fields(row, row["request"], body[1:], {})
        if found is None:
            return None
        end = found.get("address", 0) + found.get("count", 0)
        if "count" in found and (found["count"] < 1 or end > 256 ** row["address_bytes"]):
            return None
        if any(code not in self.parameters for code in found.get("codes", ())):
            return None
        return {"row": row, **found}

    def response(self, asked, body, listed=b""):
        """Return the fields of a response, or the name of a message and its fields."""
        row = asked["row"]
        codes = listed if row["code"] == 0x63 else asked.get("codes", b"")
        asked = {**asked, "codes": codes}
        layouts = [layout for layout in row["responses"] if self._fits(row, layout, body, asked)]
        if not layouts:
            return self._unfit(row, body, asked)
        if layouts[0] == ["faults"] and body == REFUSAL:
            return "not_supported", {"command": row["shown"]}
        found = self._fields(row, layouts[0], body, asked)
        if "address" in found and found["address"] != asked["address"]:
            size = row["address_bytes"] * 2
            got, sent = (f"{each['address']:0{size}X}" for each in (found, asked))
            return "wrong_address", {"got": got, "asked": sent}
        if found.get("count", asked.get("count")) != asked.get("count"):
            return "other_count", {"announced": found["count"], "asked": asked["count"]}
        if "result" in found and found["result"] == 1:
            return "refused", {}
        if "result" in found and found["result"] != 0:
            return "no_completion_code", {"code": f"{found['result']:02X}"}
        if "faults" in found and body[0] != len(found["faults"]):
            held = len(found["faults"])
            return "other_number_of_faults", {"announced": body[0], "held": held}
        if "faults" in found and any(byte != 0xE0 for byte in body[2::2]):
            return "no_separator", {}
        return found

    def meaning(self, request, response=None, listed=b"", *, first=True):
        """Return what `mikas decode` says."""
        asked = self.request(request)
        if asked is None or (asked["row"]["code"] == 0x63 and not listed):
            return None
        row = asked["row"]
        if response is None:
            names = " ".join(self._named(code) for code in asked.get("codes", b""))
            return f"{row['title']}: {names}" if names else row["title"]
        found = self.response(asked, response, listed)
        if isinstance(found, tuple):
            return self.tables["messages"][found[0]].format(**found[1])
        if row["request"] == ["codes"] and row["responses"] == [["values"]]:
            first = first or not row["stream"]
            if first and len(request) == 2 and response == REFUSAL:
                return self.tables["messages"]["value_or_refusal"]
        return self._said(found)

    def _said(self, found):
        messages = self.tables["messages"]
        match found:
            case {"model": code}:
                unknown = messages["unknown_model"].format(code=f"{code:02X}")
                return self.tables["models"].get(code, unknown)
            case {"faults": numbers}:
                return messages["faults"].format(numbers=" ".join(map(str, numbers)) or "0")
            case {"text": text}:
                return messages["text"].format(text=text)
            case {"result": 0}:
                return messages["done"]
            case {"values": values}:
                return " ".join(self._value(code, raw) for code, raw in values)
            case {"any": data} | {"bytes": data}:
                return data.hex(" ").upper()
        return f"{found['value']:02X}"

    def _named(self, code):
        return "/".join(each["name"] for each in self.parameters[code])

    def _value(self, code, raw):
        said = []
        for each in self.parameters[code]:
            row = each["interpretations"][self.interpretation]
            value = self.value(row, raw)
            digits = f"{value:d}" if row["mask"] else f"{value:.{each['decimals']}f}{row['unit']}"
            said.append(f"{each['name']}={digits}")
        return " ".join(said)

    @staticmethod
    def value(row, raw):
        number = int.from_bytes(raw, "little", signed=row["signed"])
        if row["mask"]:
            return number & row["mask"] != 0
        return (number * row["numerator"] + row["constant"]) / row["denominator"]

    def _length(self, row, layout, asked):
        """Return the length of a response, None if it has many."""
        length = 0
        for part in layout:
            if part in ("faults", "any"):
                return None
            if part == "values":
                length += sum(self.parameters[code][0]["size"] for code in asked["codes"])
            else:
                sizes = {"address": row["address_bytes"], "bytes": asked.get("count"), "text": 16}
                length += sizes.get(part, 1)
        return length

    def _fits(self, row, layout, body, asked):
        if layout == ["any"]:
            return True
        if layout == ["faults"]:
            return len(body) % 2 == 1 and len(body) <= 511
        return len(body) == self._length(row, layout, asked)

    def _unfit(self, row, body, asked):
        if body == REFUSAL:
            return "not_supported", {"command": row["shown"]}
        lengths = [self._length(row, layout, asked) for layout in row["responses"]]
        expected = "1, 3, 5 …" if lengths == [None] else " / ".join(map(str, lengths))
        return "wrong_length", {"length": len(body), "expected": expected}

    def _fields(self, row, layout, body, asked):
        """Return each part by its name; None if `body` has another length."""
        found, at = {}, 0
        for part in layout:
            size = 1
            if part in ("codes", "datum", "any", "faults", "values"):
                size = len(body) - at
                if size < 1 and part in ("codes", "datum"):
                    return None
            elif part == "address":
                size = row["address_bytes"]
            elif part == "bytes":
                size = asked.get("count", found.get("count"))
            elif part == "text":
                size = 16
            data, at = body[at : at + size], at + size
            if len(data) < size:
                return None
            found[part] = self._part(part, data, asked)
        return found if at == len(body) else None

    def _part(self, part, data, asked):
        if part in ONE_BYTE or part == "address":
            return int.from_bytes(data, "little")
        if part == "faults":
            return tuple(data[1::2])
        if part == "text":
            shown = {code: 0x2400 + code for code in range(32)} | {127: 0x2421}
            return data.rstrip(b"\0").decode("cp866").translate(shown)
        if part == "values":
            values, at = [], 0
            for code in asked["codes"]:
                size = self.parameters[code][0]["size"]
                values.append((code, data[at : at + size]))
                at += size
            return values
        return data
