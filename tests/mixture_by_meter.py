"""A guided test of a person's own: the mixture at idle, by a λ meter beside the unit."""

MIXTURE = """\
title = { en = "Mixture", ru = "Смесь" }
finds = { en = "a lean mixture", ru = "бедную смесь" }

[step.idle]
text = { en = "Let it idle", ru = "Дайте поработать" }
until = "LAMBDA > 0.5 and FREQ > 500"
hold = 2
watch = ["LAMBDA", "FREQ"]

[measure.mixture]
text = { en = "mixture", ru = "смесь" }
step = "idle"
of = "LAMBDA"
statistic = "mean"

[rule.lean]
when = "MIXTURE > 1.1"
verdict = "attention"
text = { en = "lean: {MIXTURE}", ru = "бедная: {MIXTURE}" }
"""
