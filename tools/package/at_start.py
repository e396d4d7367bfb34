"""Before the program's first line: programs that it starts are the system's, with their libraries.

PyInstaller's start sets LD_LIBRARY_PATH to the folder of the program. This process has read it by
now; a browser would crash on the libraries there.
"""

import os

if "LD_LIBRARY_PATH" in os.environ:
    if "LD_LIBRARY_PATH_ORIG" in os.environ:
        os.environ["LD_LIBRARY_PATH"] = os.environ.pop("LD_LIBRARY_PATH_ORIG")
    else:
        del os.environ["LD_LIBRARY_PATH"]
