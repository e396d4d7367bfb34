"""Features: one number each about a drive, in the regime where it says most.

    view ─ starting, electric, idle, mixture, air, throttle, ignition, cooling ─ table

Each has its rows, so that a person can look at the moments. What was not seen long enough has no
value. What the engine should breathe is the engine model's (`mikas.virtual.model.physics`): known
from the model and from service literature, not from cars.
"""

from mikas.causes.features.table import BY_NAME, FEATURES, context_of, features_of
from mikas.causes.features.view import Feature, Seen, View

__all__ = ("BY_NAME", "FEATURES", "Feature", "Seen", "View", "context_of", "features_of")
