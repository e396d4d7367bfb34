"""The steps of a survey: each measures, and adds its figures to those measured so far.

No step judges: that is `mikas.survey.concluding`, which can be done again years later.
"""
