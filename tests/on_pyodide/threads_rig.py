"""What the tests of the site's threads share.

Order is made by locks and events; a time limit is only waited for where it is what is tested.
"""

from __future__ import annotations

import threading

SHORT = 0.01  # s; what is waited for never comes
LONG = 60


def run(*functions):
    """Each on a thread of its own, until all have ended; what they return."""
    results = [None] * len(functions)

    def into(place, function):
        results[place] = function()

    threads = [
        threading.Thread(target=into, args=(place, function))
        for place, function in enumerate(functions)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results
