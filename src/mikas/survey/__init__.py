"""The survey of a real unit: what the protocol's source leaves open, found out by reading alone.

A survey leads a person from ignition on, engine off, to warm idle and raised speed. Its steps
measure (`steps`), its conclusions make an answer of the measured figures for each open clause
(`concluding`), and one ZIP keeps all of it (`archive`). Nothing is written to the unit but the list
of 64, which a power cycle ends.
"""

from mikas.survey.answers import SurveyAnswer as SurveyAnswer
from mikas.survey.answers import SurveyVerdict as SurveyVerdict
from mikas.survey.archive import SurveyFile as SurveyFile
from mikas.survey.archive import read_survey as read_survey
from mikas.survey.concluding import conclude as conclude
from mikas.survey.person import Prompter as Prompter
from mikas.survey.person import Unattended as Unattended
from mikas.survey.survey import Survey as Survey
from mikas.survey.survey import SurveyOptions as SurveyOptions

__all__ = [
    "Prompter",
    "Survey",
    "SurveyAnswer",
    "SurveyFile",
    "SurveyOptions",
    "SurveyVerdict",
    "Unattended",
    "conclude",
    "read_survey",
]
