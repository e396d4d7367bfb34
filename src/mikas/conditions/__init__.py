"""Actions on conditions: when a formula of the catalog holds for so long, something is done.

    actions.toml ──► ActionRule ──► ConditionWatch.follow(event) ──► Fired ──► performing

`evaluation` is pure: samples in, moments out. `performing` hands each moment to what the program
has: a marker, the recording, a sound, a voice, MQTT, a webhook on this computer. Nothing here
writes to a unit, and nothing can: no action has access to it.
"""

from mikas.conditions.definition import ActionRule, RecordAction
from mikas.conditions.evaluation import ConditionWatch, Fired
from mikas.conditions.loading import LoadedActions, load_actions, read_actions
from mikas.conditions.writing import actions_toml

__all__ = [
    "ActionRule",
    "ConditionWatch",
    "Fired",
    "LoadedActions",
    "RecordAction",
    "actions_toml",
    "load_actions",
    "read_actions",
]
